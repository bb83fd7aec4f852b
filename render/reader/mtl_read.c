/* MTL: Phong's model as Wavefront had it, and the metallic one that exporters have added to it
 * (Pr, Pm and so on). */
#include "render/reader/mtl_read.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#include "base/reader/reader.h"
#include "render/reader/input.h"
#include "render/reader/words.h"
#include "render/scene/vec_double.h"

/* What is not said: as grey as other programs make it. */
#define UNSAID 0.6f

typedef struct mtl {
    lf_soup *soup;
    const char *folder;
    unsigned choice; /* the material at hand */
    bool in_material, has_opacity, has_filter;
} mtl;

lf_status lf_mtl_find(lf_soup *soup, const char *name, unsigned *out, lf_error *err)
{
    for (size_t i = 0; i < soup->n_said; i++) {
        if (!soup->said[i].is_none && strcmp(soup->said[i].name, name) == 0) {
            *out = (unsigned)i;
            return LF_OK;
        }
    }
    lf_said said = lf_said_begin(name);
    said.is_missing = true;
    said.diffuse = lf_v3(UNSAID, UNSAID, UNSAID);
    *out = (unsigned)soup->n_said;
    return lf_soup_say(soup, said, err);
}

/* ------------------------------------------------------------------------------------- values --
 */

/* Red alone is grey. Spectra and CIE's XYZ are neither. */
static bool take_colour(const char *at, lf_vec3 *out)
{
    double c[3];
    if (!lf_number(&at, &c[0]))
        return false;
    if (!lf_numbers(&at, 2, c + 1))
        c[1] = c[2] = c[0];
    *out = lf_to_vec3(c);
    return true;
}

static bool take_number(const char *at, float *out)
{
    double v;
    if (!lf_number(&at, &v))
        return false;
    *out = (float)v;
    return true;
}

static void lose(lf_said *said, lf_lost what, bool lost)
{
    if (lost)
        said->lost |= 1u << what;
}

/* d, or Tr as 1 - d. Nothing at all is what no file means: programs disagree on which way Tr runs.
 */
static void take_opacity(const char *at, bool reversed, mtl *m)
{
    float v;
    size_t n;
    const char *rest = at, *word = lf_word(&rest, &n);
    lf_said *said = &m->soup->said[m->choice];
    if (lf_word_is(word, n, "-halo"))
        at = rest;
    if ((reversed && m->has_opacity) || !take_number(at, &v))
        return;
    v = reversed ? 1 - v : v;
    m->has_opacity = m->has_opacity || !reversed;
    said->alpha = v > 0 && v < 1 ? v : 1;
    said->cover = said->alpha < 1 ? LF_COVER_BLEND : LF_COVER_OPAQUE;
    said->lost &= ~(1u << LF_LOST_TRANSPARENCY); /* of another line */
    lose(said, LF_LOST_TRANSPARENCY, v <= 0 || m->has_filter);
}

/* Light that is let through whole is what a file says that has no word for opaque. */
static void take_filter(const char *at, mtl *m)
{
    lf_vec3 c = lf_v3(1, 1, 1);
    (void)take_colour(at, &c);
    m->has_filter = c.x != 1 || c.y != 1 || c.z != 1;
    lose(&m->soup->said[m->choice], LF_LOST_TRANSPARENCY, m->has_filter);
}

/* glTF's model takes the place of Phong's; a roughness alone does not. */
static void take_metallic(const char *at, lf_said *said)
{
    if (!take_number(at, &said->metallic))
        return;
    said->is_metallic = true;
}

static void take_other(const char *at, lf_lost what, lf_said *said)
{
    float v;
    if (take_number(at, &v))
        lose(said, what, v > 0);
}

/* --------------------------------------------------------------------------------- pictures -- */

static bool begins(const char *word, size_t n, const char *with)
{
    size_t length = strlen(with);
    return n >= length && strncasecmp(word, with, length) == 0;
}

static const struct {
    const char *key;
    lf_map_use use;
} map_keys[] = {{"map_Kd", LF_MAP_BASE},       {"map_Ke", LF_MAP_GLOW},
                {"map_emissive", LF_MAP_GLOW}, {"norm", LF_MAP_NORMAL},
                {"map_norm", LF_MAP_NORMAL},   {"map_Kn", LF_MAP_NORMAL},
                {"bump", LF_MAP_BUMP},         {"map_bump", LF_MAP_BUMP},
                {"map_d", LF_MAP_COVER},       {"map_opacity", LF_MAP_COVER}};

/* What a map is for; LF_MAP_USES: for nothing of ours. */
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

/* Up to three numbers; those that are not said stay. */
static void take_numbers(const char **at, double out[3])
{
    for (int i = 0; i < 3 && lf_number(at, &out[i]);)
        i++;
}

/* Options in front of a name: -s and -o (size and place), -clamp, -bm (of normals). Those that say
 * how a picture is filtered or kept are nothing to us; of the others it is told. Returns what is
 * behind them. */
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

/* map_Kd -s 2 2 2 file.png; the name goes to the end of the line, blanks and all. */
static lf_status take_texture(mtl *m, const char *key, size_t n, const char *at, lf_error *err)
{
    lf_said *said = &m->soup->said[m->choice];
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
    if (length == 0 || lf_word_reads(key, n, "map_Ka")) /* ambient light is nothing of ours */
        return LF_OK;
    lose(said, LF_LOST_MAPS, use_of(key, n) == LF_MAP_USES || length >= sizeof name);
    if (use_of(key, n) == LF_MAP_USES || length >= sizeof name)
        return LF_OK;
    lose(said, LF_LOST_MAP_OPTIONS, lost || !is_sane(&how));
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

/* -------------------------------------------------------------------------------------- lines --
 */

/* A line about a material, behind its key. */
static void take_key(mtl *m, const char *key, size_t n, const char *at)
{
    lf_said *said = &m->soup->said[m->choice];
    if (lf_word_reads(key, n, "Kd"))
        said->has_diffuse = take_colour(at, &said->diffuse) || said->has_diffuse;
    else if (lf_word_reads(key, n, "Ks"))
        (void)take_colour(at, &said->highlight);
    else if (lf_word_reads(key, n, "Ke"))
        (void)take_colour(at, &said->emission);
    else if (lf_word_reads(key, n, "Ns"))
        (void)take_number(at, &said->exponent);
    else if (lf_word_reads(key, n, "Ni"))
        (void)take_number(at, &said->ior);
    else if (lf_word_reads(key, n, "d"))
        take_opacity(at, false, m);
    else if (lf_word_reads(key, n, "Tr"))
        take_opacity(at, true, m);
    else if (lf_word_reads(key, n, "Tf"))
        take_filter(at, m);
    else if (lf_word_reads(key, n, "Pm"))
        take_metallic(at, said);
    else if (lf_word_reads(key, n, "Pr"))
        (void)take_number(at, &said->roughness);
    else if (lf_word_reads(key, n, "Pc"))
        take_other(at, LF_LOST_COAT, said);
    else if (lf_word_reads(key, n, "Ps"))
        take_other(at, LF_LOST_SHEEN, said);
    else if (lf_word_reads(key, n, "aniso"))
        take_other(at, LF_LOST_BRUSHED, said);
    else if (lf_word_reads(key, n, "illum"))
        lose(said, LF_LOST_UNLIT, strcmp(lf_skip_blanks(at), "0") == 0);
}

static lf_status take_line(mtl *m, char *line, lf_error *err)
{
    size_t n;
    const char *at = lf_rest(line), *key = lf_word(&at, &n);
    if (lf_word_reads(key, n, "newmtl")) {
        lf_status status = lf_mtl_find(m->soup, lf_skip_blanks(at), &m->choice, err);
        if (status == LF_OK)
            m->soup->said[m->choice].is_missing = false;
        m->in_material = true;
        m->has_opacity = m->has_filter = false;
        return status;
    }
    if (!m->in_material || n == 0 || key[0] == '#')
        return LF_OK;
    if (is_texture(key, n))
        return take_texture(m, key, n, at, err);
    take_key(m, key, n, at);
    return LF_OK;
}

lf_status lf_mtl_read(int fd, const char *folder, lf_soup *soup, lf_error *err)
{
    lf_input in = {.fd = -1};
    mtl m = {.soup = soup, .folder = folder};
    char *line;
    lf_status status = lf_input_open(&in, fd, err);
    while (status == LF_OK && (line = lf_input_line(&in, true)))
        status = take_line(&m, line, err);
    if (status == LF_OK && in.status != LF_OK)
        status = lf_input_ended(&in, "more lines", err);
    if (status == LF_OK)
        soup->has_library = true;
    lf_input_close(&in);
    return status;
}
