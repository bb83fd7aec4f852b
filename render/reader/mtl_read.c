/* MTL: Phong's model as Wavefront had it, and the metallic one that exporters have added to it
 * (Pr, Pm and so on). */
#include "render/reader/mtl_read.h"

#include <string.h>
#include <strings.h>

#include "base/reader/reader.h"
#include "render/reader/input.h"
#include "render/reader/words.h"
#include "render/scene/vec_double.h"

/* What is not said: as grey as other programs make it. */
#define UNSAID 0.6f

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
static void take_colour(const char *at, lf_vec3 *out)
{
    double c[3];
    if (!lf_number(&at, &c[0]))
        return;
    if (!lf_numbers(&at, 2, c + 1))
        c[1] = c[2] = c[0];
    *out = lf_to_vec3(c);
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

static void take_opacity(const char *at, float opaque, lf_said *said)
{
    float v;
    size_t n;
    const char *rest = at, *word = lf_word(&rest, &n);
    if (lf_word_is(word, n, "-halo"))
        at = rest;
    if (take_number(at, &v))
        lose(said, LF_LOST_TRANSPARENCY, opaque > 0 ? v < opaque : v > opaque);
}

/* Light that is let through whole is what a file says that has no word for opaque. */
static void take_filter(const char *at, lf_said *said)
{
    lf_vec3 c = lf_v3(1, 1, 1);
    take_colour(at, &c);
    lose(said, LF_LOST_TRANSPARENCY, c.x != 1 || c.y != 1 || c.z != 1);
}

/* glTF's model takes the place of Phong's; a roughness alone does not. */
static void take_metallic(const char *at, lf_said *said)
{
    if (!take_number(at, &said->metallic))
        return;
    said->is_metallic = true;
    lose(said, LF_LOST_METALLIC, said->metallic > 0 && said->metallic < 1);
}

static void take_other(const char *at, lf_lost what, lf_said *said)
{
    float v;
    if (take_number(at, &v))
        lose(said, what, v > 0);
}

static bool begins(const char *word, size_t n, const char *with)
{
    size_t length = strlen(with);
    return n >= length && strncasecmp(word, with, length) == 0;
}

/* map_Kd -s 2 2 2 file.png, bump, norm, disp, decal, refl. */
static void take_texture(const char *key, size_t n, const char *at, lf_said *said)
{
    size_t length;
    (void)lf_word(&at, &length);
    if (length == 0)
        return;
    lose(said, LF_LOST_TEXTURES, true);
    lose(said, LF_LOST_GLOW, lf_word_reads(key, n, "map_Ke"));
    lose(said, LF_LOST_TRANSPARENCY, lf_word_reads(key, n, "map_d"));
}

static bool is_texture(const char *key, size_t n)
{
    return begins(key, n, "map_") || begins(key, n, "bump") || begins(key, n, "norm") ||
           begins(key, n, "disp") || begins(key, n, "decal") || begins(key, n, "refl");
}

/* -------------------------------------------------------------------------------------- lines --
 */

/* A line about a material, behind its key. */
static void take_key(const char *key, size_t n, const char *at, lf_said *said)
{
    if (lf_word_reads(key, n, "Kd"))
        take_colour(at, &said->diffuse);
    else if (lf_word_reads(key, n, "Ks"))
        take_colour(at, &said->highlight);
    else if (lf_word_reads(key, n, "Ke"))
        take_colour(at, &said->emission);
    else if (lf_word_reads(key, n, "Ns"))
        (void)take_number(at, &said->exponent);
    else if (lf_word_reads(key, n, "Ni"))
        (void)take_number(at, &said->ior);
    else if (lf_word_reads(key, n, "d"))
        take_opacity(at, 1, said);
    else if (lf_word_reads(key, n, "Tr"))
        take_opacity(at, 0, said);
    else if (lf_word_reads(key, n, "Tf"))
        take_filter(at, said);
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
    else if (is_texture(key, n))
        take_texture(key, n, at, said);
}

static lf_status take_line(char *line, bool *in_material, unsigned *choice, lf_soup *soup,
                           lf_error *err)
{
    size_t n;
    const char *at = lf_rest(line), *key = lf_word(&at, &n);
    if (lf_word_reads(key, n, "newmtl")) {
        lf_status status = lf_mtl_find(soup, lf_skip_blanks(at), choice, err);
        if (status == LF_OK)
            soup->said[*choice].is_missing = false;
        *in_material = true;
        return status;
    }
    if (*in_material && n > 0 && key[0] != '#')
        take_key(key, n, at, &soup->said[*choice]);
    return LF_OK;
}

lf_status lf_mtl_read(int fd, lf_soup *soup, lf_error *err)
{
    lf_input in = {.fd = -1};
    bool in_material = false;
    unsigned choice = 0;
    char *line;
    lf_status status = lf_input_open(&in, fd, err);
    while (status == LF_OK && (line = lf_input_line(&in, true)))
        status = take_line(line, &in_material, &choice, soup, err);
    if (status == LF_OK && in.status != LF_OK)
        status = lf_input_ended(&in, "more lines", err);
    if (status == LF_OK)
        soup->has_library = true;
    lf_input_close(&in);
    return status;
}
