/* Corners with the same position, normal and attributes become one vertex, found by a hash table.
 */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "base/sandbox/reader.h"
#include "render/import/reader/input.h"
#include "render/import/reader/mesh_build.h"
#include "render/import/reader/soup.h"
#include "render/import/scene/tangents.h"
#include "render/scene/vec_double.h"

#define NO_VERTEX UINT32_MAX
#define LEAST_TABLE 64

/* The data of a vertex, compared byte by byte, so that NaN equals itself. For most meshes the first
 * five and a half numbers are all. */
typedef struct vertex_key {
    double position[3];
    float normal[3];
    float uv[2];
    float zero;
    float colour[4];
} vertex_key;

#define PLAIN_SIZE 40
#define UV_SIZE offsetof(vertex_key, colour)

/* The vertices so far. Vertices of the current part are in the table, at their hash or after it. */
typedef struct welding {
    const lf_soup *soup;
    const lf_mesh_data *mesh; /* its materials are set */
    bool normals;             /* normals are required: the file's, or face normals */
    bool faces;               /* the faces' */
    bool uvs, colours;
    bool wants_uvs;          /* of every triangle, for materials of the scene's own */
    size_t key_size;         /* used size of vertex_key */
    unsigned char *vertices; /* [n_vertices][key_size] */
    size_t n_vertices, vertices_room;
    uint32_t *table; /* a power of two, at most half full */
    size_t table_size, n_in_table;
    uint32_t *twins; /* [n_twins]: the first vertex with the same position in its part */
    size_t n_twins, twins_room;
    bool wants_twins;
} welding;

static const vertex_key *vertex_at(const welding *w, size_t v)
{
    return (const vertex_key *)(const void *)(w->vertices + v * w->key_size);
}

static bool has_textures(const lf_mesh_data *mesh, unsigned material)
{
    for (int s = 0; mesh->textures && s < LF_SLOTS; s++)
        if (mesh->textures[material].slot[s].picture > 0)
            return true;
    return false;
}

/* Attributes besides a normal; no texture coordinates for a material without images. */
static void put_look(const welding *w, size_t triangle, int corner, vertex_key *key)
{
    const lf_soup *soup = w->soup;
    size_t at = 3 * triangle + (size_t)corner;
    uint32_t uv = LF_NO_UV;
    if (w->colours)
        memcpy(key->colour, soup->colours.values + 4 * (size_t)soup->corners[at],
               sizeof key->colour);
    if (w->uvs &&
        (w->wants_uvs || has_textures(w->mesh, soup->choices ? soup->choices[triangle] : 0)))
        uv = soup->uvs.are_own ? soup->corners[at] : soup->uvs.of ? soup->uvs.of[at] : LF_NO_UV;
    for (size_t i = 0; i < 2 && uv != LF_NO_UV; i++)
        key->uv[i] = soup->uvs.values[2 * (size_t)uv + i] + 0.0f;
}

static vertex_key key_of(const welding *w, size_t triangle, int corner)
{
    const lf_soup *soup = w->soup;
    size_t at = 3 * triangle + (size_t)corner;
    vertex_key key = {.zero = 0};
    for (int i = 0; i < 3; i++) /* -0 is 0 */
        key.position[i] = soup->points[3 * (size_t)soup->corners[at] + (size_t)i] + 0.0;
    put_look(w, triangle, corner, &key);
    if (!w->normals)
        return key;
    uint32_t number = w->faces                ? LF_NO_NORMAL
                      : soup->has_own_normals ? soup->corners[at]
                      : soup->normals_of      ? soup->normals_of[at]
                                              : LF_NO_NORMAL;
    if (number != LF_NO_NORMAL) {
        memcpy(key.normal, soup->normals + 3 * (size_t)number, sizeof key.normal);
        return key;
    }
    const uint32_t *c = soup->corners + 3 * triangle;
    double a[3], b[3], n[3];
    lf_sub_double(soup->points + 3 * (size_t)c[1], soup->points + 3 * (size_t)c[0], a);
    lf_sub_double(soup->points + 3 * (size_t)c[2], soup->points + 3 * (size_t)c[0], b);
    lf_cross_double(a, b, n);
    double length = lf_length_double(n);
    for (int i = 0; i < 3; i++)
        key.normal[i] = length > 0 ? (float)(n[i] / length) : 0.0f;
    return key;
}

/* The slot of a key in the table, or the free slot for it. */
static uint32_t *slot_of(const welding *w, const vertex_key *key)
{
    size_t at = (size_t)XXH3_64bits(key, w->key_size) & (w->table_size - 1);
    while (w->table[at] != NO_VERTEX && memcmp(vertex_at(w, w->table[at]), key, w->key_size) != 0)
        at = (at + 1) & (w->table_size - 1);
    return &w->table[at];
}

/* Replaces the table by one of another size with the same content. */
static bool make_table(welding *w, size_t size)
{
    uint32_t *table = malloc(size * sizeof *table);
    if (!table)
        return false;
    memset(table, 0xff, size * sizeof *table);
    free(w->table);
    w->table = table;
    w->table_size = size;
    for (size_t v = w->n_vertices - w->n_in_table; v < w->n_vertices; v++)
        *slot_of(w, vertex_at(w, v)) = (uint32_t)v;
    return true;
}

static bool find_vertex(welding *w, const vertex_key *key, uint32_t *out)
{
    if (2 * (w->n_in_table + 1) > w->table_size && !make_table(w, 2 * w->table_size))
        return false;
    uint32_t *slot = slot_of(w, key);
    if (*slot == NO_VERTEX) {
        if (!lf_grow(&w->vertices, &w->vertices_room, w->n_vertices + 1, w->key_size))
            return false;
        memcpy(w->vertices + w->n_vertices * w->key_size, key, w->key_size);
        *slot = (uint32_t)w->n_vertices++;
        w->n_in_table++;
    }
    *out = *slot;
    return true;
}

/* Finds the vertices with equal positions in the finished part, by reusing the table. */
static bool find_twins(welding *w)
{
    if (!w->wants_twins)
        return true;
    if (!lf_grow(&w->twins, &w->twins_room, w->n_vertices, sizeof *w->twins))
        return false;
    memset(w->table, 0xff, w->table_size * sizeof *w->table);
    for (size_t v = w->n_twins; v < w->n_vertices; v++) {
        const double *place = vertex_at(w, v)->position;
        size_t at = (size_t)XXH3_64bits(place, 3 * sizeof *place) & (w->table_size - 1);
        while (w->table[at] != NO_VERTEX &&
               memcmp(vertex_at(w, w->table[at])->position, place, 3 * sizeof *place) != 0)
            at = (at + 1) & (w->table_size - 1);
        if (w->table[at] == NO_VERTEX)
            w->table[at] = (uint32_t)v;
        w->twins[v] = w->table[at];
    }
    w->n_twins = w->n_vertices;
    return true;
}

/* Later parts do not find vertices of earlier ones. A table that the last part left nearly empty is
 * replaced, so that many small parts do not each clear a large table. */
static bool begin_part(welding *w)
{
    bool sparse = 8 * w->n_in_table < w->table_size;
    if (!find_twins(w))
        return false;
    w->n_in_table = 0;
    return make_table(w, sparse ? LEAST_TABLE : w->table_size);
}

/* Makes the soup's corners vertices. */
static bool join_corners(welding *w, lf_soup *soup)
{
    size_t part = 0;
    if (!make_table(w, LEAST_TABLE))
        return false;
    for (size_t t = 0; t < soup->n_triangles; t++) {
        uint32_t vertices[3];
        if (part < soup->n_parts && soup->parts[part] == t) {
            part++;
            if (!begin_part(w))
                return false;
        }
        for (int c = 0; c < 3; c++) {
            vertex_key key = key_of(w, t, c);
            if (!find_vertex(w, &key, &vertices[c]))
                return false;
        }
        memcpy(soup->corners + 3 * t, vertices, sizeof vertices);
    }
    return find_twins(w);
}

static bool says_materials(const lf_soup *soup)
{
    for (size_t i = 0; i < soup->n_sources; i++)
        if (!soup->source[i].is_none)
            return true;
    return false;
}

/* Whether the file has no material, or one without values. */
static bool colours_count(const lf_soup *soup)
{
    return !says_materials(soup) && soup->colours.n > 0 && soup->colours.n == soup->n_points;
}

/* White, which the colours multiply; some programs write a coverage of 0 everywhere. */
static void whiten(lf_soup *soup)
{
    bool holes = false, some = false;
    for (size_t i = 0; i < soup->colours.n; i++) {
        holes = holes || soup->colours.values[4 * i + 3] < 1.0f;
        some = some || soup->colours.values[4 * i + 3] > 0.0f;
    }
    for (size_t i = 0; i < soup->colours.n && !some; i++)
        soup->colours.values[4 * i + 3] = 1.0f;
    for (size_t i = 0; i < soup->n_sources; i++) {
        soup->source[i].is_none = false;
        soup->source[i].albedo = lf_v3(1, 1, 1);
        soup->source[i].cover = holes && some ? LF_COVER_BLEND : LF_COVER_OPAQUE;
    }
}

static lf_status take_materials(lf_soup *soup, bool colours, lf_mesh_data *out, lf_error *err)
{
    bool used[LF_MAX_MATERIALS] = {false};
    lf_status status = LF_OK;
    if (soup->n_sources == 0) {
        lf_source_material none = lf_source_material_begin("");
        none.is_none = true;
        status = lf_soup_say(soup, none, err);
    }
    if (status != LF_OK)
        return status;
    if (colours)
        whiten(soup);
    for (size_t t = 0; t < soup->n_triangles; t++)
        used[soup->choices ? soup->choices[t] : 0] = true;
    if (soup->uvs.n > 0)
        status = lf_maps_read(soup->maps, soup->n_maps, soup->source, used, out, err);
    else
        lf_maps_drop(soup->maps, soup->n_maps, soup->source, used, &out->warnings);
    if (status == LF_OK)
        status = lf_source_materials_convert(soup->source, soup->n_sources, used, out, err);
    if (status == LF_OK && soup->tells_missing)
        lf_source_materials_warn_of_missing(soup->source, soup->n_sources, used, &out->warnings);
    return status;
}

/* [n_vertices] as the parcel has them. */
static lf_status fill_looks(const welding *w, lf_mesh_data *out, lf_error *err)
{
    if (w->uvs)
        out->uvs = lf_calloc(w->n_vertices, 2 * sizeof *out->uvs);
    if (w->colours)
        out->colours = lf_calloc(w->n_vertices, 4 * sizeof *out->colours);
    if ((w->uvs && !out->uvs) || (w->colours && !out->colours))
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    out->n_uv_sets = w->uvs;
    for (size_t v = 0; v < w->n_vertices && w->uvs; v++)
        memcpy(out->uvs + 2 * v, vertex_at(w, v)->uv, 2 * sizeof *out->uvs);
    for (size_t v = 0; v < w->n_vertices && w->colours; v++)
        memcpy(out->colours + 4 * v, vertex_at(w, v)->colour, 4 * sizeof *out->colours);
    return LF_OK;
}

/* Texture coordinates of these files point up, coordinates for the scene's materials down, as in
 * glTF; the mapping of the file's own images does not change. */
static void turn_uvs(lf_mesh_data *out)
{
    for (size_t v = 0; v < (size_t)out->n_vertices; v++)
        out->uvs[2 * v + 1] = fminf(1.0f - out->uvs[2 * v + 1], LF_MAX_UV);
    for (int i = 0; i < LF_SLOTS * out->n_materials && out->textures; i++)
        for (int row = 0; row < 2; row++) {
            float *map = out->textures[i / LF_SLOTS].slot[i % LF_SLOTS].map[row];
            map[2] = fmaxf(-LF_MAX_UV, fminf(map[2] + map[1], LF_MAX_UV));
            map[1] = -map[1];
        }
}

static lf_status fill_mesh(const welding *w, const lf_soup *soup, const lf_mesh_desc *desc,
                           lf_mesh_data *out, lf_error *err)
{
    lf_mesh_place place = lf_mesh_place_of(&desc->transform);
    lf_status status = lf_mesh_allocate(out, (int64_t)w->n_vertices, (int64_t)soup->n_triangles,
                                        w->normals || desc->normals == LF_NORMALS_SMOOTH, err);
    if (status == LF_OK)
        status = fill_looks(w, out, err);
    if (status != LF_OK)
        return status;
    for (size_t v = 0; v < w->n_vertices; v++)
        lf_mesh_put_vertex(out, &place, vertex_at(w, v)->position,
                           w->normals ? vertex_at(w, v)->normal : NULL);
    for (size_t t = 0; t < soup->n_triangles; t++)
        lf_mesh_put_triangle(out, &place, soup->corners + 3 * t,
                             soup->choices ? soup->choices[t] : 0);
    status = lf_mesh_complete_twins(out, desc, (int64_t)soup->n_triangles, w->twins, err);
    if (status == LF_OK && w->wants_uvs && out->uvs)
        turn_uvs(out);
    return status == LF_OK ? lf_mesh_tangents(out, err) : status;
}

static void warn_of_rest(const lf_soup *soup, bool coloured, const lf_mesh_desc *desc,
                         lf_mesh_data *out)
{
    lf_warnings_add_all(&out->warnings, &soup->warnings);
    bool lost = desc->material < 0 && soup->n_coloured > 0 && !coloured;
    if (lost && says_materials(soup))
        lf_warnings_count(&out->warnings, LF_HERE, (long long)soup->n_coloured,
                          "part has vertex colours, which are ignored; its material is used",
                          "parts have vertex colours, which are ignored; their materials are used");
    else if (lost)
        lf_warnings_add(&out->warnings, LF_HERE,
                        "vertex colours are ignored because not every vertex has one");
    lf_warnings_count(&out->warnings, LF_HERE, (long long)soup->n_wrong_normals,
                      "face that refers to missing vertices is left out",
                      "faces that refer to missing vertices are left out");
    lf_warnings_count(&out->warnings, LF_HERE, (long long)soup->n_beside,
                      "point or line is left out", "points and lines are left out");
}

/* Vertices that must stay separate, according to the materials. */
static welding begin_welding(const lf_soup *soup, const lf_mesh_desc *desc, bool colours,
                             const lf_mesh_data *out)
{
    /* a normal map on flat faces uses the face normals */
    bool smooth = desc->normals == LF_NORMALS_SMOOTH,
         file = desc->normals == LF_NORMALS_FILE && soup->n_normals > 0,
         faces = !smooth && !file && (desc->wants.tangents || lf_mesh_wants_tangents(out));
    welding w = {.soup = soup,
                 .mesh = out,
                 .normals = file || faces,
                 .faces = faces,
                 .uvs = (out->textures || desc->wants.uvs) && soup->uvs.n > 0,
                 .colours = colours,
                 .wants_uvs = desc->wants.uvs};
    w.key_size = w.colours ? sizeof(vertex_key) : w.uvs ? UV_SIZE : PLAIN_SIZE;
    w.wants_twins = smooth && (w.uvs || w.colours);
    return w;
}

lf_status lf_weld(lf_soup *soup, const lf_mesh_desc *desc, lf_mesh_data *out, lf_error *err)
{
    lf_status status = LF_OK;
    bool colours = desc->material < 0 && colours_count(soup);
    if (soup->n_triangles == 0 && soup->n_wrong_normals > 0)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "no triangles: all faces (%zu) refer to missing vertices",
                            soup->n_wrong_normals);
    if (soup->n_triangles == 0)
        return lf_mesh_complete(out, desc, 0, err);
    if (desc->material < 0)
        status = take_materials(soup, colours, out, err);
    if (status != LF_OK)
        return status;
    welding w = begin_welding(soup, desc, colours, out);
    if (!join_corners(&w, soup))
        status = lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    if (status == LF_OK)
        status = fill_mesh(&w, soup, desc, out, err);
    if (status == LF_OK)
        warn_of_rest(soup, colours, desc, out);
    free(w.vertices);
    free(w.table);
    free(w.twins);
    return status;
}
