/* MTL: Wavefront's Phong model, and the metallic model that exporters have added (Pr, Pm and so
 * on). */
#include "render/import/reader/mtl_read.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "base/number.h"
#include "base/sandbox/reader.h"
#include "render/import/reader/input.h"
#include "render/import/reader/words.h"
#include "render/scene/vec_double.h"

/* Default grey, as in other programs. */
#define UNSAID 0.6f

typedef struct mtl {
    lf_soup *soup;
    const char *folder;
    unsigned choice; /* the material at hand */
    bool in_material, has_opacity, has_filter, has_roughness;
    lf_left_out statements; /* unsupported ones */
    lf_left_out wrong;      /* with invalid numbers */
    lf_left_out nameless;   /* textures without an image */
    int64_t wrong_line;     /* the first of those */
    int64_t n_more;         /* lines with more numbers than belong there */
    const lf_input *in;
} mtl;

lf_status lf_mtl_find(lf_soup *soup, const char *name, unsigned *out, lf_error *err)
{
    for (size_t i = 0; i < soup->n_sources; i++) {
        if (!soup->source[i].is_none && strcmp(soup->source[i].name, name) == 0) {
            *out = (unsigned)i;
            return LF_OK;
        }
    }
    lf_source_material source = lf_source_material_begin(name);
    source.is_missing = true;
    source.albedo = lf_v3(UNSAID, UNSAID, UNSAID);
    *out = (unsigned)soup->n_sources;
    return lf_soup_say(soup, source, err);
}

/* ------------------------------------------------------------------------------------ values -- */

/* Whether a line's numbers end there. Further ones are ignored, and counted. */
static bool ends(mtl *m, const char *at)
{
    double more;
    bool has_more = false;
    while (lf_number(&at, &more))
        has_more = true;
    if (!lf_line_ends(at))
        return false;
    m->n_more += has_more;
    return true;
}

/* A single number is grey. Spectra and CIE XYZ are not supported. */
static bool take_colour(mtl *m, const char *at, lf_vec3 *out)
{
    double c[3];
    if (!lf_number(&at, &c[0]))
        return false;
    if (!lf_numbers(&at, 2, c + 1))
        c[1] = c[2] = c[0];
    if (!isfinite(c[0] + c[1] + c[2]) || !ends(m, at))
        return false;
    *out = lf_to_vec3(c);
    return true;
}

static bool take_number(mtl *m, const char *at, float *out)
{
    double v;
    if (!lf_number(&at, &v) || !isfinite(v) || !ends(m, at))
        return false;
    *out = (float)v;
    return true;
}

static void lose(lf_source_material *source, lf_lost what, bool lost)
{
    if (lost)
        source->lost |= 1u << what;
}

/* d, or Tr as 1 - d. Fully transparent is not plausible: programs disagree on the direction of Tr.
 */
static bool take_opacity(const char *at, bool reversed, mtl *m)
{
    float v;
    size_t n;
    const char *rest = at, *word = lf_word(&rest, &n);
    lf_source_material *source = &m->soup->source[m->choice];
    bool halo = lf_word_is(word, n, "-halo");
    if (halo)
        at = rest;
    if (!take_number(m, at, &v))
        return false;
    if (halo)
        lf_leave_out(&m->statements, "d -halo", strlen("d -halo"));
    if (reversed && m->has_opacity)
        return true;
    v = reversed ? 1 - v : v;
    m->has_opacity = m->has_opacity || !reversed;
    source->alpha = v > 0 && v < 1 ? v : 1;
    source->cover = source->alpha < 1 ? LF_COVER_BLEND : LF_COVER_OPAQUE;
    source->lost &= ~(1u << LF_LOST_TRANSPARENCY); /* of another line */
    lose(source, LF_LOST_TRANSPARENCY, v <= 0 || m->has_filter);
    return true;
}

/* Full transmission is written by programs that cannot express opaque. */
static bool take_filter(const char *at, mtl *m)
{
    lf_vec3 c = lf_v3(1, 1, 1);
    bool read = take_colour(m, at, &c);
    m->has_filter = !read || c.x != 1 || c.y != 1 || c.z != 1;
    lose(&m->soup->source[m->choice], LF_LOST_TRANSPARENCY, m->has_filter);
    return true;
}

/* glTF's model replaces Phong's; a roughness alone does not. */
static bool take_metallic(mtl *m, const char *at, lf_source_material *source)
{
    bool read = take_number(m, at, &source->metallic);
    source->is_metallic = source->is_metallic || read;
    return read;
}

static bool take_diffuse(mtl *m, const char *at, lf_source_material *source)
{
    bool read = take_colour(m, at, &source->albedo);
    source->has_diffuse = source->has_diffuse || read;
    return read;
}

static bool take_other(mtl *m, const char *at, lf_lost what, lf_source_material *source)
{
    float v;
    if (!take_number(m, at, &v))
        return false;
    lose(source, what, v > 0);
    return true;
}

/* Models with or without a highlight; models for glass and for shadows only are not supported. */
static bool take_model(const char *at, mtl *m)
{
    char name[16] = "illum ";
    uint64_t model;
    const char *rest = lf_whole_read(lf_skip_blanks(at), &model);
    if (!rest || !ends(m, rest))
        return false;
    lose(&m->soup->source[m->choice], LF_LOST_UNLIT, model == 0);
    if (model == 4 || model == 6 || model == 7 || model >= 9) {
        snprintf(name, sizeof name, "illum %d", model < 100 ? (int)model : 100);
        lf_leave_out(&m->statements, name, strlen(name));
    }
    return true;
}

/* ------------------------------------------------------------------------------------ images -- */

static bool begins(const char *word, size_t n, const char *with)
{
    size_t length = strlen(with);
    return n >= length && strncasecmp(word, with, length) == 0;
}

static const struct {
    const char *key;
    lf_map_use use;
} map_keys[] = {
    {"map_Kd", LF_MAP_BASE},      {"map_Ke", LF_MAP_EMISSION}, {"map_emissive", LF_MAP_EMISSION},
    {"norm", LF_MAP_NORMAL},      {"map_norm", LF_MAP_NORMAL}, {"map_Kn", LF_MAP_NORMAL},
    {"bump", LF_MAP_BUMP},        {"map_bump", LF_MAP_BUMP},   {"map_d", LF_MAP_COVER},
    {"map_opacity", LF_MAP_COVER}};

/* The use of a map; LF_MAP_USES: unsupported. */
static lf_map_use use_of(const char *key, size_t n)
{
    for (size_t i = 0; i < sizeof map_keys / sizeof *map_keys; i++)
        if (lf_word_reads(key, n, map_keys[i].key))
            return map_keys[i].use;
    return LF_MAP_USES;
}

static bool is_texture(const char *key, size_t n)
{
    return begins(key, n, "map_") || begins(key, n, "bump") || begins(key, n, "norm") ||
           begins(key, n, "disp") || begins(key, n, "decal") || begins(key, n, "refl");
}

/* Up to three numbers; missing ones keep their values. */
static void take_numbers(const char **at, double out[3])
{
    for (int i = 0; i < 3 && lf_number(at, &out[i]);)
        i++;
}

/* Options before a name: -s and -o (scale and offset), -clamp, -bm (of normals). Options about
 * filtering and storage are ignored; others are reported. Returns the rest of the line. */
static const char *take_options(const char *at, lf_texture *out, bool *lost)
{
    static const char *const quiet[] = {"-blendu", "-blendv",     "-boost", "-cc",
                                        "-texres", "-colorspace", "-type"};
    double size[3] = {1, 1, 1}, place[3] = {0}, other[3] = {0};
    size_t n;
    for (const char *word, *next; next = at, word = lf_word(&next, &n), *word == '-';) {
        bool is_quiet = false;
        at = next;
        for (size_t i = 0; i < sizeof quiet / sizeof *quiet; i++)
            is_quiet = is_quiet || lf_word_reads(word, n, quiet[i]);
        if (lf_word_reads(word, n, "-s")) {
            take_numbers(&at, size);
        } else if (lf_word_reads(word, n, "-o")) {
            take_numbers(&at, place);
        } else if (lf_word_reads(word, n, "-clamp")) {
            word = lf_word(&at, &n);
            out->wrap_u = out->wrap_v =
                lf_word_reads(word, n, "on") ? LF_WRAP_CLAMP : LF_WRAP_REPEAT;
        } else if (lf_word_reads(word, n, "-bm")) {
            if (lf_number(&at, other))
                out->scale = (float)other[0];
        } else if (is_quiet || lf_word_reads(word, n, "-imfchan")) {
            (void)lf_word(&at, &n);
            *lost = *lost || !is_quiet;
        } else {
            take_numbers(&at, other);
            *lost = true;
        }
    }
    for (int i = 0; i < 2; i++) { /* v grows upwards, rows downwards */
        out->map[i][i] = (float)(i == 0 ? size[i] : -size[i]);
        out->map[i][2] = (float)(i == 0 ? place[i] : 1 - place[i]);
    }
    return lf_skip_blanks(at);
}

static bool is_sane(const lf_texture *t)
{
    bool sane = fabsf(t->scale) <= LF_MAX_UV;
    for (int i = 0; i < 2; i++)
        sane = sane && fabsf(t->map[i][i]) <= LF_MAX_UV && fabsf(t->map[i][2]) <= LF_MAX_UV;
    return sane;
}

/* map_Kd -s 2 2 2 file.png; the name extends to the end of the line, including blanks. */
static lf_status take_texture(mtl *m, const char *key, size_t n, const char *at, lf_error *err)
{
    lf_source_material *source = &m->soup->source[m->choice];
    lf_map map;
    lf_texture how = {.scale = 1};
    char name[1024];
    bool lost = false;
    at = take_options(at, &how, &lost);
    size_t length = strlen(at);
    if (length >= 2 && at[0] == '"' && at[length - 1] == '"') {
        at++;
        length -= 2;
    }
    if (lf_word_reads(key, n, "map_Ka") || lf_word_reads(key, n, "map_aat"))
        return LF_OK; /* ambient light and antialiasing are not used */
    if (length == 0) {
        lf_leave_out(&m->nameless, key, n);
        return LF_OK;
    }
    lose(source, LF_LOST_MAPS, use_of(key, n) == LF_MAP_USES || length >= sizeof name);
    if (use_of(key, n) == LF_MAP_USES || length >= sizeof name)
        return LF_OK;
    lose(source, LF_LOST_MAP_OPTIONS, lost || !is_sane(&how));
    memcpy(name, at, length);
    name[length] = '\0';
    for (char *slash = name; (slash = strchr(slash, '\\'));)
        *slash = '/';
    lf_status status = lf_map_begin(m->choice, use_of(key, n), m->folder, name, &map, err);
    if (status != LF_OK)
        return status;
    if (is_sane(&how))
        map.texture = how;
    return lf_soup_map(m->soup, map, err);
}

/* ------------------------------------------------------------------------------------- lines -- */

static bool take_roughness(const char *at, mtl *m)
{
    bool read = take_number(m, at, &m->soup->source[m->choice].roughness);
    m->has_roughness = m->has_roughness || read;
    return read;
}

/* A line about a material, after its key. false: its numbers are invalid. */
static bool take_key(mtl *m, const char *key, size_t n, const char *at)
{
    lf_source_material *source = &m->soup->source[m->choice];
    if (lf_word_reads(key, n, "Kd"))
        return take_diffuse(m, at, source);
    if (lf_word_reads(key, n, "Ks"))
        return take_colour(m, at, &source->highlight);
    if (lf_word_reads(key, n, "Ke"))
        return take_colour(m, at, &source->emission);
    if (lf_word_reads(key, n, "Ns"))
        return take_number(m, at, &source->exponent);
    if (lf_word_reads(key, n, "Ni"))
        return take_number(m, at, &source->ior);
    if (lf_word_reads(key, n, "d") || lf_word_reads(key, n, "Tr"))
        return take_opacity(at, n == 2, m);
    if (lf_word_reads(key, n, "Tf"))
        return take_filter(at, m);
    if (lf_word_reads(key, n, "Pm"))
        return take_metallic(m, at, source);
    if (lf_word_reads(key, n, "Pr"))
        return take_roughness(at, m);
    if (lf_word_reads(key, n, "Pc"))
        return take_other(m, at, LF_LOST_COAT, source);
    if (lf_word_reads(key, n, "Ps"))
        return take_other(m, at, LF_LOST_SHEEN, source);
    if (lf_word_reads(key, n, "aniso"))
        return take_other(m, at, LF_LOST_ANISOTROPY, source);
    if (lf_word_reads(key, n, "illum"))
        return take_model(at, m);
    /* ambient light is not used; the others belong to a lost feature that is reported elsewhere */
    if (!lf_word_reads(key, n, "Ka") && !lf_word_reads(key, n, "Pcr") &&
        !lf_word_reads(key, n, "anisor"))
        lf_leave_out(&m->statements, key, n);
    return true;
}

/* Values that depend on all lines of a material. */
static void end_material(mtl *m)
{
    if (!m->in_material)
        return;
    const lf_source_material *source = &m->soup->source[m->choice];
    if (m->has_roughness && !source->is_metallic)
        lf_leave_out(&m->statements, "Pr without Pm", strlen("Pr without Pm"));
    if (lf_max3(source->highlight) > 0 && !(source->exponent > 0) && !source->is_metallic)
        lf_leave_out(&m->statements, "Ks without Ns", strlen("Ks without Ns"));
}

static lf_status begin_material(mtl *m, const char *name, lf_error *err)
{
    end_material(m);
    lf_status status = lf_mtl_find(m->soup, name, &m->choice, err);
    if (status == LF_OK)
        m->soup->source[m->choice].is_missing = false;
    m->in_material = status == LF_OK;
    m->has_opacity = m->has_filter = m->has_roughness = false;
    return status;
}

static lf_status take_line(mtl *m, char *line, lf_error *err)
{
    size_t n;
    const char *at = lf_rest(line), *key = lf_word(&at, &n);
    if (lf_word_reads(key, n, "newmtl"))
        return begin_material(m, lf_skip_blanks(at), err);
    if (!m->in_material || n == 0 || key[0] == '#')
        return LF_OK;
    if (is_texture(key, n))
        return take_texture(m, key, n, at, err);
    if (!take_key(m, key, n, at)) {
        lf_leave_out(&m->wrong, key, n);
        m->wrong_line = m->wrong_line > 0 ? m->wrong_line : m->in->line;
    }
    return LF_OK;
}

static void warn_of_rest(const mtl *m, const char *name)
{
    char what[160];
    snprintf(what, sizeof what, "%.80s: ignored statements", name);
    lf_left_out_warn(&m->statements, what, &m->soup->warnings);
    snprintf(what, sizeof what,
             "%.80s: ignored statements without their numbers (first in line %lld)", name,
             (long long)m->wrong_line);
    lf_left_out_warn(&m->wrong, what, &m->soup->warnings);
    snprintf(what, sizeof what, "%.80s: ignored textures without a file name", name);
    lf_left_out_warn(&m->nameless, what, &m->soup->warnings);
    if (m->n_more > 0)
        lf_warnings_add(&m->soup->warnings, LF_HERE,
                        "%.80s: surplus numbers at the end of lines (%lld) are ignored", name,
                        (long long)m->n_more);
}

lf_status lf_mtl_read(int fd, const char *folder, const char *name, lf_soup *soup, lf_error *err)
{
    lf_input in = {.fd = -1};
    mtl m = {.soup = soup, .folder = folder, .in = &in};
    char *line;
    lf_status status = lf_input_open(&in, fd, err);
    while (status == LF_OK && (line = lf_input_line(&in, true)))
        status = take_line(&m, line, err);
    if (status == LF_OK && in.status != LF_OK)
        status = lf_input_ended(&in, "more lines", err);
    end_material(&m);
    warn_of_rest(&m, name);
    if (status == LF_OK)
        soup->tells_missing = true;
    lf_input_close(&in);
    return status;
}
