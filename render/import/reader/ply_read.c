/* PLY: text, and binary in either order of bytes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/sandbox/reader.h"
#include "render/import/reader/mesh_read.h"
#include "render/import/reader/ply_header.h"
#include "render/import/reader/words.h"

typedef struct ply {
    const lf_mesh_desc *desc;
    lf_input in;
    lf_ply_header header;
    lf_soup *soup;
    const char *rest; /* text: of the line at hand */
    bool has_vertices;
    double values[LF_PLY_ROLES]; /* of the element at hand */
    uint32_t *indices;           /* of its index list */
    size_t n_indices, indices_room;
    double *coordinates; /* of its other list: texture coordinates, two per corner */
    size_t n_coordinates, coordinates_room;
    uint32_t *uvs; /* their numbers in the soup */
    size_t uvs_room;
    bool has_colours;
    double full; /* what a whole colour of a vertex is; 0: it is linear */
} ply;

/* Error with the current position. */
static lf_status bad_place(const ply *p, const char *what, lf_error *err)
{
    return p->header.encoding == LF_PLY_TEXT
               ? lf_error_set(err, LF_E_FORMAT, LF_HERE, "line %lld: %s", (long long)p->in.line,
                              what)
               : lf_error_set(err, LF_E_FORMAT, LF_HERE, "byte %llu: %s",
                              (unsigned long long)lf_input_offset(&p->in), what);
}

/* ------------------------------------------------------------------------------------ values -- */

static uint64_t whole_bytes(const unsigned char *bytes, int n, bool big)
{
    uint64_t value = 0;
    for (int i = 0; i < n; i++)
        value = value << 8 | bytes[big ? i : n - 1 - i];
    return value;
}

static double value_of(lf_ply_type type, const unsigned char *bytes, bool big)
{
    uint64_t bits = whole_bytes(bytes, lf_ply_sizes[type], big);
    uint32_t half = (uint32_t)bits;
    float single;
    double number;
    switch (type) {
    case LF_PLY_INT8:
        return (int8_t)bits;
    case LF_PLY_INT16:
        return (int16_t)bits;
    case LF_PLY_INT32:
        return (int32_t)bits;
    case LF_PLY_FLOAT:
        memcpy(&single, &half, sizeof single);
        return (double)single;
    case LF_PLY_DOUBLE:
        memcpy(&number, &bits, sizeof number);
        return number;
    default:
        return (double)bits;
    }
}

/* In text files a number may be on the next line. */
static lf_status text_value(ply *p, double *out, lf_error *err)
{
    while (*(p->rest = lf_skip_blanks(p->rest)) == '\0') {
        p->rest = lf_input_line(&p->in, false);
        if (!p->rest) {
            p->rest = "";
            return lf_input_ended(&p->in, "a number", err);
        }
    }
    return lf_number(&p->rest, out) ? LF_OK : bad_place(p, "not a number", err);
}

static lf_status next_value(ply *p, lf_ply_type type, double *out, lf_error *err)
{
    if (p->header.encoding == LF_PLY_TEXT)
        return text_value(p, out, err);
    const unsigned char *bytes = lf_input_bytes(&p->in, lf_ply_sizes[type]);
    if (!bytes)
        return lf_input_ended(&p->in, "a number", err);
    *out = value_of(type, bytes, p->header.encoding == LF_PLY_BIG);
    return LF_OK;
}

static lf_status put_coordinate(ply *p, double value, lf_error *err)
{
    if (!lf_grow(&p->coordinates, &p->coordinates_room, p->n_coordinates + 1,
                 sizeof *p->coordinates))
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    p->coordinates[p->n_coordinates++] = value;
    return LF_OK;
}

#define NO_POINT (UINT32_MAX - 1) /* index for a point that does not exist */

/* -1, which ends a strip, is UINT32_MAX. */
static lf_status put_index(ply *p, double value, lf_error *err)
{
    if (!(value >= -1 && value < NO_POINT) || value != floor(value))
        value = NO_POINT;
    if (!lf_grow(&p->indices, &p->indices_room, p->n_indices + 1, sizeof *p->indices))
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    p->indices[p->n_indices++] = value < 0 ? UINT32_MAX : (uint32_t)value;
    return LF_OK;
}

static lf_status read_list(ply *p, const lf_ply_property *property, lf_error *err)
{
    double length = 0, value = 0;
    lf_status status = next_value(p, property->count_type, &length, err);
    if (status == LF_OK && (!(length >= 0 && length <= UINT32_MAX) || length != floor(length)))
        return bad_place(p, "expected the length of a list", err);
    if (status == LF_OK && property->role == LF_PLY_UNUSED && p->header.encoding != LF_PLY_TEXT)
        return lf_input_skip(&p->in, (uint64_t)length * lf_ply_sizes[property->type])
                   ? LF_OK
                   : lf_input_ended(&p->in, "the rest of a list", err);
    for (uint64_t i = 0; status == LF_OK && i < (uint64_t)length; i++) {
        status = next_value(p, property->type, &value, err);
        if (status == LF_OK && property->role == LF_PLY_INDICES)
            status = put_index(p, value, err);
        if (status == LF_OK && property->role == LF_PLY_UVS)
            status = put_coordinate(p, value, err);
    }
    return status;
}

/* All values of one element. The rest of a text line is ignored. */
static lf_status read_element_values(ply *p, const lf_ply_element *element, lf_error *err)
{
    lf_status status = LF_OK;
    p->n_indices = p->n_coordinates = 0;
    p->rest = "";
    for (int i = 0; i < element->n_properties && status == LF_OK; i++) {
        const lf_ply_property *property = &p->header.properties[element->first + i];
        status = property->is_list ? read_list(p, property, err)
                                   : next_value(p, property->type, &p->values[property->role], err);
    }
    return status;
}

/* ---------------------------------------------------------------------------------- elements -- */

/* Whole numbers are display encoded, others are not. */
static lf_status take_colour(ply *p, lf_error *err)
{
    const double *v = p->values + LF_PLY_RED;
    float rgba[4];
    for (int i = 0; i < 3; i++)
        rgba[i] = p->full > 0 ? lf_soup_light(v[i] / p->full) : (float)v[i];
    rgba[3] = (float)(p->full > 0 ? v[3] / p->full : v[3]);
    return lf_soup_colour(p->soup, rgba, err);
}

static lf_status take_vertex(ply *p, lf_error *err)
{
    const double *v = p->values;
    lf_status status = lf_soup_point(p->soup, v + LF_PLY_X, err);
    if (status == LF_OK && p->soup->has_own_normals)
        status = lf_soup_normal(
            p->soup, (float[3]){(float)v[LF_PLY_NX], (float)v[LF_PLY_NY], (float)v[LF_PLY_NZ]},
            err);
    if (status == LF_OK && p->has_colours)
        status = take_colour(p, err);
    if (status == LF_OK && p->soup->uvs.are_own)
        status = lf_soup_uv(p->soup, v + LF_PLY_U, err);
    return status;
}

static bool takes_uvs(const ply *p)
{
    return (p->header.n_textures > 0 && p->desc->material < 0) || p->desc->wants.uvs;
}

/* Texture coordinates of a face with two per corner; *out: NULL if it has none, or points have
 * their own. */
static lf_status take_uvs(ply *p, const uint32_t **out, lf_error *err)
{
    lf_status status = LF_OK;
    *out = NULL;
    if (!takes_uvs(p) || p->soup->uvs.are_own || p->n_indices == 0 ||
        p->n_coordinates != 2 * p->n_indices)
        return LF_OK;
    if (!lf_grow(&p->uvs, &p->uvs_room, p->n_indices, sizeof *p->uvs))
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    for (size_t i = 0; i < p->n_indices && status == LF_OK; i++) {
        p->uvs[i] = (uint32_t)p->soup->uvs.n;
        status = lf_soup_uv(p->soup, p->coordinates + 2 * i, err);
    }
    *out = p->uvs;
    return status;
}

/* Whether all indices exist; faces with others are counted. */
static bool are_there(const ply *p, bool strip)
{
    for (size_t i = 0; i < p->n_indices; i++)
        if (p->indices[i] >= p->soup->n_points && !(strip && p->indices[i] == UINT32_MAX)) {
            p->soup->n_wrong_normals++;
            return false;
        }
    return true;
}

static lf_status take_face(ply *p, lf_error *err)
{
    double material = p->values[LF_PLY_MATERIAL_INDEX], texture = p->values[LF_PLY_TEXTURE_INDEX];
    lf_soup_face face = {.corners = p->indices};
    if (!are_there(p, false))
        return LF_OK;
    lf_status status = take_uvs(p, &face.uvs, err);
    if (status != LF_OK)
        return status;
    if (material == 0 && p->header.n_textures > 0)
        material = texture;
    face.choice = material > 0 && material < LF_MAX_MATERIALS ? (unsigned)material : 0;
    return lf_soup_polygon(p->soup, p->n_indices, &face, err);
}

/* Every second triangle is reversed. */
static lf_status take_strip(ply *p, lf_error *err)
{
    lf_status status = LF_OK;
    const uint32_t *c = p->indices;
    if (!are_there(p, true))
        return LF_OK;
    size_t begin = 0;
    for (size_t i = 0; i < p->n_indices && status == LF_OK; i++) {
        bool odd = (i - begin) % 2 == 1;
        if (c[i] == UINT32_MAX)
            begin = i + 1;
        else if (i >= begin + 2)
            status = lf_soup_triangle(
                p->soup,
                &(lf_soup_face){
                    .corners = (uint32_t[3]){c[odd ? i - 1 : i - 2], c[odd ? i - 2 : i - 1], c[i]}},
                err);
    }
    return status;
}

/* Colours in bytes are relative to 255; their type decides. */
static lf_vec3 colour_of(const ply *p, const lf_ply_element *element, lf_ply_role red)
{
    double scale = 1;
    for (int i = 0; i < element->n_properties; i++) {
        const lf_ply_property *property = &p->header.properties[element->first + i];
        if (property->role == red && property->type == LF_PLY_UINT8)
            scale = 1.0 / 255;
    }
    const double *v = p->values + red;
    return lf_v3((float)(scale * v[0]), (float)(scale * v[1]), (float)(scale * v[2]));
}

static lf_status take_material(ply *p, const lf_ply_element *element, lf_error *err)
{
    lf_source_material source = lf_source_material_begin("");
    source.albedo = colour_of(p, element, LF_PLY_DIFFUSE_RED);
    source.highlight = colour_of(p, element, LF_PLY_SPECULAR_RED);
    source.exponent = (float)p->values[LF_PLY_SPECULAR_POWER];
    return lf_soup_say(p->soup, source, err);
}

static lf_status take_element(ply *p, const lf_ply_element *element, lf_error *err)
{
    switch (element->kind) {
    case LF_PLY_VERTEX:
        return take_vertex(p, err);
    case LF_PLY_FACE:
        return take_face(p, err);
    case LF_PLY_STRIPS:
        return take_strip(p, err);
    case LF_PLY_MATERIAL:
        return take_material(p, element, err);
    case LF_PLY_OTHER:
        break;
    }
    return LF_OK;
}

static bool has_role(const ply *p, const lf_ply_element *element, lf_ply_role role)
{
    for (int i = 0; i < element->n_properties; i++)
        if (p->header.properties[element->first + i].role == role)
            return true;
    return false;
}

/* Vertex attributes for the file's own materials. */
static void begin_looks(ply *p, const lf_ply_element *element)
{
    p->has_colours = has_role(p, element, LF_PLY_RED) && has_role(p, element, LF_PLY_GREEN) &&
                     has_role(p, element, LF_PLY_BLUE);
    p->soup->n_coloured = has_role(p, element, LF_PLY_RED);
    for (int i = 0; i < element->n_properties; i++) {
        const lf_ply_property *property = &p->header.properties[element->first + i];
        if (property->role == LF_PLY_RED)
            p->full = property->type == LF_PLY_UINT16 ? 65535
                      : property->type < LF_PLY_FLOAT ? 255
                                                      : 0;
    }
    if (!has_role(p, element, LF_PLY_ALPHA))
        p->values[LF_PLY_ALPHA] = p->full > 0 ? p->full : 1;
}

/* Checks the required properties of an element, before the first one is read. */
static lf_status begin_element(ply *p, const lf_ply_element *element, lf_error *err)
{
    bool is_vertex = element->kind == LF_PLY_VERTEX,
         is_face = element->kind == LF_PLY_FACE || element->kind == LF_PLY_STRIPS;
    memset(p->values, 0, sizeof p->values);
    for (lf_ply_role role = LF_PLY_X; role <= LF_PLY_Z && is_vertex; role++)
        if (!has_role(p, element, role))
            return lf_error_set(err, LF_E_FORMAT, LF_HERE, "the vertices have no property %c",
                                'x' + (int)(role - LF_PLY_X));
    if (is_vertex && p->has_vertices)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "the PLY header has vertices twice");
    if (is_vertex) {
        p->has_vertices = true;
        p->soup->has_own_normals = has_role(p, element, LF_PLY_NX) &&
                                   has_role(p, element, LF_PLY_NY) &&
                                   has_role(p, element, LF_PLY_NZ);
        p->soup->uvs.are_own =
            takes_uvs(p) && has_role(p, element, LF_PLY_U) && has_role(p, element, LF_PLY_V);
        if (p->desc->material < 0)
            begin_looks(p, element);
    }
    if (is_face && element->count > 0 && !has_role(p, element, LF_PLY_INDICES))
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "the faces have no list vertex_indices or vertex_index");
    if (is_face && element->count > 0 && !p->has_vertices)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "the faces come before the vertices");
    return LF_OK;
}

static lf_status read_elements(ply *p, const lf_ply_element *element, lf_error *err)
{
    lf_status status = begin_element(p, element, err);
    for (uint64_t i = 0; i < element->count && element->n_properties > 0 && status == LF_OK; i++) {
        status = read_element_values(p, element, err);
        if (status == LF_OK)
            status = take_element(p, element, err);
    }
    return status;
}

/* Materials may follow the faces that choose them. */
static void check_choices(lf_soup *soup)
{
    for (size_t t = 0; soup->choices && t < soup->n_triangles; t++)
        if (soup->choices[t] >= soup->n_sources)
            soup->choices[t] = 0;
}

static lf_status put_map(ply *p, const char *folder, unsigned source, const char *name,
                         lf_error *err)
{
    lf_map map;
    lf_status status = lf_map_begin(source, LF_MAP_BASE, folder, name, &map, err);
    return status == LF_OK ? lf_soup_map(p->soup, map, err) : status;
}

/* A material a texture, of the file's own if it has any. */
static lf_status put_textures(ply *p, lf_error *err)
{
    int n = p->header.n_textures < LF_PLY_MAX_TEXTURES ? p->header.n_textures : LF_PLY_MAX_TEXTURES;
    lf_status status = LF_OK;
    if (n == 0 || p->desc->material >= 0)
        return LF_OK;
    if (p->header.n_textures > n)
        lf_warnings_add(&p->soup->warnings, LF_HERE, "%d textures, but only %d are used",
                        p->header.n_textures, n);
    while (p->soup->n_sources < (size_t)n && status == LF_OK)
        status = lf_soup_say(p->soup, lf_source_material_begin(""), err);
    char *folder = lf_path_folder(p->desc->file);
    if (!folder)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    for (int i = 0; i < n && status == LF_OK; i++)
        status = put_map(p, folder, (unsigned)i, p->header.textures[i], err);
    lf_free(folder);
    return status;
}

lf_status lf_ply_read(const lf_mesh_desc *desc, int fd, lf_soup *soup, lf_error *err)
{
    ply *p = calloc(1, sizeof *p);
    if (!p)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    p->soup = soup;
    p->desc = desc;
    lf_status status = lf_input_open(&p->in, fd, err);
    if (status == LF_OK)
        status = lf_ply_read_header(&p->in, &p->header, err);
    for (int i = 0; i < p->header.n_elements && status == LF_OK; i++)
        status = read_elements(p, &p->header.elements[i], err);
    if (status == LF_OK)
        status = put_textures(p, err);
    check_choices(soup);
    lf_left_out_warn(&p->header.elements_left, "ignored elements", &soup->warnings);
    lf_left_out_warn(&p->header.properties_left, "ignored properties", &soup->warnings);
    lf_input_close(&p->in);
    free(p->indices);
    free(p->coordinates);
    free(p->uvs);
    free(p);
    return status;
}
