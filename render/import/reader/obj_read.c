/* Wavefront OBJ: points, normals, texture coordinates, faces, and materials by name from MTL
 * libraries. All other statements are ignored and reported. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/sandbox/reader.h"
#include "render/import/reader/input.h"
#include "render/import/reader/mesh_read.h"
#include "render/import/reader/mtl_read.h"
#include "render/import/reader/words.h"

typedef struct obj {
    const lf_mesh_desc *desc;
    lf_input in;
    lf_soup *soup;
    bool has_choice; /* a usemtl was read */
    unsigned choice;
    int n_libraries;
    char *group, *material;            /* the current ones; material is NULL if the scene sets it */
    uint32_t *corners, *normals, *uvs; /* of the face at hand */
    size_t n_corners, corners_room, normals_room, uvs_room;
    /* corners whose texture coordinate or normal does not exist */
    size_t n_no_uv, n_no_normal;
    bool has_wrong_normal;  /* the current face names a vertex that does not exist */
    bool is_smooth;         /* a smoothing group is on */
    size_t n_smooth;        /* faces of a smoothing group without normals */
    size_t n_more;          /* lines with more numbers than are known */
    lf_left_out statements; /* ignored statements */
} obj;

static lf_status bad_line(const obj *o, const char *what, lf_error *err)
{
    return lf_error_set(err, LF_E_FORMAT, LF_HERE, "line %lld: %s", (long long)o->in.line, what);
}

/* Error for a line in which a word is not a number. */
static lf_status bad_number(const obj *o, const char *at, const char *expected, lf_error *err)
{
    size_t n;
    const char *word = lf_word(&at, &n);
    if (n == 0)
        return bad_line(o, expected, err);
    return lf_error_set(err, LF_E_FORMAT, LF_HERE, "line %lld: %s, found \"%.*s\"",
                        (long long)o->in.line, expected, (int)(n < 40 ? n : 40), word);
}

/* At least `least` and up to `most` numbers, and nothing else; further ones are counted. */
static lf_status take_numbers(obj *o, const char *at, int least, int most, double *out, int *out_n,
                              const char *expected, lf_error *err)
{
    double more;
    int n = 0;
    while (n < most && lf_number(&at, &out[n]))
        n++;
    *out_n = n;
    if (n == most && !lf_line_ends(at))
        o->n_more++;
    while (n == most && lf_number(&at, &more))
        ;
    return n >= least && lf_line_ends(at) ? LF_OK : bad_number(o, at, expected, err);
}

/* ------------------------------------------------------------------------------------ points -- */

/* Colour of the next point. Colours count only if all points have one. */
static lf_status take_point_colour(obj *o, const double c[3], lf_error *err)
{
    o->soup->n_coloured = 1;
    if (o->soup->colours.n != o->soup->n_points)
        return LF_OK;
    return lf_soup_colour(
        o->soup, (float[4]){lf_soup_light(c[0]), lf_soup_light(c[1]), lf_soup_light(c[2]), 1.0f},
        err);
}

/* v x y z, then the end, a weight, or a colour. */
static lf_status take_point(obj *o, const char *at, lf_error *err)
{
    double v[6];
    int n;
    lf_status status = take_numbers(o, at, 3, 6, v, &n, "expected three numbers after v", err);
    if (status != LF_OK)
        return status;
    o->n_more += n == 5;
    status = n == 6 ? take_point_colour(o, v + 3, err) : LF_OK;
    if (status != LF_OK)
        return status;
    if (n == 4 && v[3] != 0)
        for (int i = 0; i < 3; i++)
            v[i] /= v[3];
    return lf_soup_point(o->soup, v, err);
}

static lf_status take_normal(obj *o, const char *at, lf_error *err)
{
    double v[3];
    int n;
    lf_status status = take_numbers(o, at, 3, 3, v, &n, "expected three numbers after vn", err);
    if (status != LF_OK)
        return status;
    return lf_soup_normal(o->soup, (float[3]){(float)v[0], (float)v[1], (float)v[2]}, err);
}

/* vt u, with or without v and w */
static lf_status take_uv(obj *o, const char *at, lf_error *err)
{
    double uv[3] = {0, 0, 0};
    int n;
    lf_status status = take_numbers(o, at, 1, 3, uv, &n, "expected numbers after vt", err);
    return status == LF_OK ? lf_soup_uv(o->soup, uv, err) : status;
}

/* ------------------------------------------------------------------------------------- faces -- */

/* Counted from 1, or backwards from the last one. */
static bool to_number(int64_t written, size_t n, uint32_t *out)
{
    int64_t number = written < 0 ? (int64_t)n + written : written - 1;
    *out = (uint32_t)number;
    return written != 0 && number >= 0 && number < (int64_t)n;
}

/* An index after a slash, if there is one: false if there is another word. */
static bool index_behind_slash(const char **at, bool *there, int64_t *out)
{
    *there = false;
    if (**at != '/')
        return true;
    *at += 1;
    if (**at == '\0' || **at == '/' || lf_is_blank(**at))
        return true;
    *there = true;
    return lf_integer(at, out);
}

static bool takes_uvs(const obj *o)
{
    return o->desc->material < 0 || o->desc->wants.uvs;
}

/* v, v/t, v//n, v/t/n */
static lf_status take_corner(obj *o, const char **at, lf_error *err)
{
    int64_t point, texture, normal;
    bool textured, smooth;
    uint32_t *corner, *own, *uv;
    if (!lf_grow(&o->corners, &o->corners_room, o->n_corners + 1, sizeof *o->corners) ||
        !lf_grow(&o->normals, &o->normals_room, o->n_corners + 1, sizeof *o->normals) ||
        !lf_grow(&o->uvs, &o->uvs_room, o->n_corners + 1, sizeof *o->uvs))
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    corner = &o->corners[o->n_corners];
    own = &o->normals[o->n_corners];
    uv = &o->uvs[o->n_corners++];
    if (!lf_integer(at, &point) || !index_behind_slash(at, &textured, &texture) ||
        !index_behind_slash(at, &smooth, &normal) || (**at && !lf_is_blank(**at)))
        return bad_line(o, "expected numbers such as 1, 1/2, 1//3 or 1/2/3", err);
    if (!to_number(point, o->soup->n_points, corner))
        o->has_wrong_normal = true;
    *own = LF_NO_NORMAL;
    *uv = LF_NO_UV;
    if (textured && takes_uvs(o) && !to_number(texture, o->soup->uvs.n, uv)) {
        *uv = LF_NO_UV;
        o->n_no_uv++;
    }
    if (smooth && !to_number(normal, o->soup->n_normals, own)) {
        *own = LF_NO_NORMAL;
        o->n_no_normal++;
    }
    return LF_OK;
}

static lf_status take_corners(obj *o, const char *at, lf_error *err)
{
    lf_status status = LF_OK;
    o->n_corners = 0;
    o->has_wrong_normal = false;
    while (status == LF_OK && *(at = lf_skip_blanks(at)) && *at != '#')
        status = take_corner(o, &at, err);
    return status;
}

/* Faces without a material use the unnamed one. */
static lf_status choose_none(obj *o, lf_error *err)
{
    lf_source_material none = lf_source_material_begin("");
    none.is_none = true;
    o->has_choice = true;
    o->choice = (unsigned)o->soup->n_sources;
    return lf_soup_say(o->soup, none, err);
}

static lf_status take_face(obj *o, const char *at, lf_error *err)
{
    lf_status status = take_corners(o, at, err);
    if (status == LF_OK && o->has_wrong_normal) {
        o->soup->n_wrong_normals++;
        return LF_OK;
    }
    if (status == LF_OK && !o->has_choice && o->desc->material < 0)
        status = choose_none(o, err);
    o->n_smooth += o->is_smooth && o->n_corners > 0 && o->normals[0] == LF_NO_NORMAL;
    const lf_soup_face face = {o->corners, o->normals, o->soup->uvs.n > 0 ? o->uvs : NULL,
                               o->choice};
    return status == LF_OK ? lf_soup_polygon(o->soup, o->n_corners, &face, err) : status;
}

static lf_status take_beside(obj *o, const char *at, bool line, lf_error *err)
{
    lf_status status = take_corners(o, at, err);
    o->soup->n_beside += line && o->n_corners > 0 ? o->n_corners - 1 : o->n_corners;
    return status;
}

/* --------------------------------------------------------------------------------- materials -- */

/* Exporters repeat names: only a different one begins a part. */
static lf_status take_name(char **now, const char *name, lf_soup *soup, lf_error *err)
{
    if (*now && strcmp(*now, name) == 0)
        return LF_OK;
    lf_free(*now);
    *now = lf_strdup(name);
    return *now ? lf_soup_part(soup, err) : lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
}

static lf_status choose(obj *o, const char *name, lf_error *err)
{
    unsigned before = o->choice;
    bool first = !o->has_choice;
    if (*name == '\0')
        return LF_OK;
    if (o->desc->material >= 0) /* the scene's: the file's only part the mesh */
        return take_name(&o->material, name, o->soup, err);
    lf_status status = lf_mtl_find(o->soup, name, &o->choice, err);
    o->has_choice = true;
    return status == LF_OK && (first || o->choice != before) ? lf_soup_part(o->soup, err) : status;
}

/* LF_OK also if the file does not exist; the asking process reports that. */
static lf_status read_library(obj *o, const char *name, bool *out_read, lf_error *err)
{
    int fd;
    char *folder = lf_path_folder(o->desc->file),
         *path = folder ? lf_path_join(folder, name) : NULL,
         *own_folder = path ? lf_path_folder(path) : NULL;
    lf_status status = LF_OK;
    *out_read = false;
    if (!own_folder) {
        status = lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    } else if (lf_ask_for_file(path, &fd) == LF_OK) {
        *out_read = true;
        lf_error inner;
        status = lf_mtl_read(fd, own_folder, name, o->soup, &inner);
        if (status != LF_OK)
            (void)lf_error_set(err, status, LF_HERE, "%.256s: %s", name, inner.what);
        close(fd);
    }
    lf_free(folder);
    lf_free(path);
    lf_free(own_folder);
    return status;
}

/* If the named library does not exist, one with the OBJ's own name may: people rename both. */
static lf_status read_own_library(obj *o, lf_error *err)
{
    const char *slash = strrchr(o->desc->file, '/'), *name = slash ? slash + 1 : o->desc->file,
               *dot = strrchr(name, '.');
    char own[256];
    bool read;
    size_t n = dot ? (size_t)(dot - name) : strlen(name);
    if (n + sizeof ".mtl" > sizeof own)
        return LF_OK;
    memcpy(own, name, n);
    memcpy(own + n, ".mtl", sizeof ".mtl");
    return read_library(o, own, &read, err);
}

/* Names may contain blanks; if an ending is followed by a blank there are several names. */
static lf_status take_libraries(obj *o, char *names, lf_error *err)
{
    lf_status status = LF_OK;
    for (char *slash = names; (slash = strchr(slash, '\\'));)
        *slash = '/';
    while (*names && status == LF_OK && o->n_libraries++ < LF_IMPORT_MAX_FILES / 2) {
        bool read;
        char *end = names, *next;
        while ((end = strcasestr(end, ".mtl")) && end[4] && !lf_is_blank(end[4]))
            end += 4;
        next = end && end[4] ? end + 5 : names + strlen(names);
        if (end)
            end[4] = '\0';
        status = read_library(o, names, &read, err);
        if (status == LF_OK && !read)
            status = read_own_library(o, err);
        names = next + strspn(next, " \t");
    }
    return status;
}

/* ------------------------------------------------------------------------------------- lines -- */

/* s 1, s on; s off, s 0 */
static void take_smoothing(obj *o, const char *at)
{
    size_t n;
    const char *word = lf_word(&at, &n);
    o->is_smooth = n > 0 && !lf_word_reads(word, n, "off") && !lf_word_is(word, n, "0");
}

/* Statements for curves and surfaces only, and those that do not affect the image. */
static bool is_quiet(const char *key, size_t n, const char *rest)
{
    static const char *const with[] = {"vp",   "deg",  "bmat", "step", "cstype", "parm", "trim",
                                       "hole", "scrv", "sp",   "end",  "con",    "mg"};
    static const char *const states[] = {"bevel", "c_interp", "d_interp", "lod"};
    size_t length;
    const char *word = lf_word(&rest, &length);
    bool off = lf_word_reads(word, length, "off") || lf_word_is(word, length, "0");
    for (size_t i = 0; i < sizeof with / sizeof *with; i++)
        if (lf_word_is(key, n, with[i]))
            return true;
    for (size_t i = 0; i < sizeof states / sizeof *states; i++)
        if (lf_word_is(key, n, states[i]))
            return off;
    return n == 0 || key[0] == '#';
}

/* Statements that have no effect if the scene sets the material. */
static lf_status read_looks(obj *o, const char *key, size_t n, char *rest, lf_error *err)
{
    const bool wanted = o->desc->material < 0;
    if (lf_word_is(key, n, "vt"))
        return takes_uvs(o) ? take_uv(o, rest, err) : LF_OK;
    if (lf_word_is(key, n, "mtllib"))
        return wanted ? take_libraries(o, lf_rest(rest), err) : LF_OK;
    if (lf_word_is(key, n, "usemtl"))
        return choose(o, lf_rest(rest), err);
    if (lf_word_is(key, n, "s"))
        take_smoothing(o, rest);
    else if (!is_quiet(key, n, rest))
        lf_leave_out(&o->statements, key, n);
    return LF_OK;
}

static lf_status read_line(obj *o, char *line, lf_error *err)
{
    size_t n;
    const char *at = line, *key = lf_word(&at, &n);
    char *rest = line + (at - line);
    if (lf_word_is(key, n, "v"))
        return take_point(o, at, err);
    if (lf_word_is(key, n, "vn"))
        return take_normal(o, at, err);
    if (lf_word_is(key, n, "f") || lf_word_is(key, n, "fo"))
        return take_face(o, at, err);
    if (lf_word_is(key, n, "l") || lf_word_is(key, n, "p"))
        return take_beside(o, at, key[0] == 'l', err);
    if (lf_word_is(key, n, "o"))
        return lf_soup_part(o->soup, err);
    if (lf_word_is(key, n, "g"))
        return take_name(&o->group, lf_rest(rest), o->soup, err);
    return read_looks(o, key, n, rest, err);
}

static void warn_of_rest(const obj *o)
{
    lf_warnings *warnings = &o->soup->warnings;
    lf_warnings_count(warnings, LF_HERE, (long long)o->n_no_uv,
                      "corner refers to missing texture coordinates",
                      "corners refer to missing texture coordinates");
    if (o->n_no_normal > 0)
        lf_warnings_add(warnings, LF_HERE, "corners that refer to missing normals (%zu) have none",
                        o->n_no_normal);
    if (o->n_more > 0)
        lf_warnings_add(warnings, LF_HERE,
                        "surplus numbers at the end of lines of v, vn or vt (%zu) are ignored",
                        o->n_more);
    if (o->n_smooth > 0 && o->desc->normals == LF_NORMALS_FILE)
        lf_warnings_add(warnings, LF_HERE,
                        "faces of smoothing groups without normals (%zu) are flat; set "
                        "\"normals\": \"smooth\" of the mesh to smooth them",
                        o->n_smooth);
    lf_left_out_warn(&o->statements, "ignored statements", warnings);
}

lf_status lf_obj_read(const lf_mesh_desc *desc, int fd, lf_soup *soup, lf_error *err)
{
    obj o = {.desc = desc, .soup = soup};
    char *line;
    lf_status status = lf_input_open(&o.in, fd, err);
    while (status == LF_OK && (line = lf_input_line(&o.in, true)))
        status = read_line(&o, line, err);
    if (status == LF_OK && o.in.status != LF_OK)
        status = lf_input_ended(&o.in, "more lines", err);
    if (status == LF_OK && soup->n_points == 0)
        status =
            lf_error_set(err, LF_E_FORMAT, LF_HERE,
                         "cannot be read as a mesh: not an OBJ file, because it has no vertices");
    soup->tells_missing = soup->tells_missing || o.n_libraries == 0;
    warn_of_rest(&o);
    lf_input_close(&o.in);
    lf_free(o.group);
    lf_free(o.material);
    free(o.corners);
    free(o.normals);
    free(o.uvs);
    return status;
}
