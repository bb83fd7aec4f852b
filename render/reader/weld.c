/* Corners with one position and one normal become one vertex, found again by a table of hashes. */
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "base/reader/reader.h"
#include "render/reader/input.h"
#include "render/reader/mesh_build.h"
#include "render/reader/soup.h"
#include "render/scene/vec_double.h"

#define NO_VERTEX UINT32_MAX
#define LEAST_TABLE 64

/* What makes a vertex: compared byte by byte, so that what is no number equals itself. */
typedef struct vertex_key {
    double position[3];
    float normal[3];
    float zero;
} vertex_key;

/* The vertices so far. Those of the part at hand are in the table, at their hash or behind it. */
typedef struct welding {
    const lf_soup *soup;
    bool normals; /* the file's are wanted, and there are some */
    vertex_key *vertices;
    size_t n_vertices, vertices_room;
    uint32_t *table; /* a power of two, at most half full */
    size_t table_size, n_in_table;
} welding;

static vertex_key key_of(const welding *w, size_t triangle, int corner)
{
    const lf_soup *soup = w->soup;
    size_t at = 3 * triangle + (size_t)corner;
    vertex_key key = {.zero = 0};
    for (int i = 0; i < 3; i++) /* -0 is 0 */
        key.position[i] = soup->points[3 * (size_t)soup->corners[at] + (size_t)i] + 0.0;
    if (!w->normals)
        return key;
    uint32_t number = soup->has_own_normals ? soup->corners[at]
                      : soup->normals_of    ? soup->normals_of[at]
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

/* Where a key stands in the table, or may. */
static uint32_t *slot_of(const welding *w, const vertex_key *key)
{
    size_t at = (size_t)XXH3_64bits(key, sizeof *key) & (w->table_size - 1);
    while (w->table[at] != NO_VERTEX && memcmp(&w->vertices[w->table[at]], key, sizeof *key) != 0)
        at = (at + 1) & (w->table_size - 1);
    return &w->table[at];
}

/* A table of another size with what is in it. */
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
        *slot_of(w, &w->vertices[v]) = (uint32_t)v;
    return true;
}

static bool find_vertex(welding *w, const vertex_key *key, uint32_t *out)
{
    if (2 * (w->n_in_table + 1) > w->table_size && !make_table(w, 2 * w->table_size))
        return false;
    uint32_t *slot = slot_of(w, key);
    if (*slot == NO_VERTEX) {
        if (!lf_grow(&w->vertices, &w->vertices_room, w->n_vertices + 1, sizeof *key))
            return false;
        w->vertices[w->n_vertices] = *key;
        *slot = (uint32_t)w->n_vertices++;
        w->n_in_table++;
    }
    *out = *slot;
    return true;
}

/* Nothing before a part is found from there on. A table that the last one left nearly empty is made
 * anew, so that many small parts do not clear a large one each. */
static bool begin_part(welding *w)
{
    bool sparse = 8 * w->n_in_table < w->table_size;
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
    return true;
}

static lf_status take_materials(lf_soup *soup, lf_mesh_data *out, lf_error *err)
{
    bool used[LF_MAX_MATERIALS] = {false};
    lf_said none = lf_said_begin("");
    none.is_none = true;
    if (soup->n_said == 0) {
        lf_status status = lf_soup_say(soup, none, err);
        if (status != LF_OK)
            return status;
    } else {
        lf_free(none.name);
    }
    for (size_t t = 0; t < soup->n_triangles; t++)
        used[soup->choices ? soup->choices[t] : 0] = true;
    lf_status status = lf_said_convert(soup->said, soup->n_said, used, out, err);
    if (status == LF_OK && soup->has_library)
        lf_said_warn_of_missing(soup->said, soup->n_said, used, &out->warnings);
    return status;
}

static lf_status fill_mesh(const welding *w, const lf_soup *soup, const lf_mesh_desc *desc,
                           lf_mesh_data *out, lf_error *err)
{
    lf_mesh_place place = lf_mesh_place_of(&desc->transform);
    lf_status status = lf_mesh_allocate(out, (int64_t)w->n_vertices, (int64_t)soup->n_triangles,
                                        w->normals || desc->normals == LF_NORMALS_SMOOTH, err);
    if (status != LF_OK)
        return status;
    for (size_t v = 0; v < w->n_vertices; v++)
        lf_mesh_put_vertex(out, &place, w->vertices[v].position,
                           w->normals ? w->vertices[v].normal : NULL);
    for (size_t t = 0; t < soup->n_triangles; t++)
        lf_mesh_put_triangle(out, &place, soup->corners + 3 * t,
                             soup->choices ? soup->choices[t] : 0);
    return lf_mesh_complete(out, desc, (int64_t)soup->n_triangles, err);
}

static void warn_of_rest(const lf_soup *soup, const lf_mesh_desc *desc, lf_mesh_data *out)
{
    lf_warnings_add_all(&out->warnings, &soup->warnings);
    if (desc->material < 0 && soup->n_coloured > 0)
        lf_warnings_add(&out->warnings, LF_HERE,
                        "%zu parts have colours a vertex, which are not used", soup->n_coloured);
    if (soup->n_beside > 0)
        lf_warnings_add(&out->warnings, LF_HERE, "%zu points and lines are left out",
                        soup->n_beside);
}

lf_status lf_weld(lf_soup *soup, const lf_mesh_desc *desc, lf_mesh_data *out, lf_error *err)
{
    welding w = {.soup = soup, .normals = desc->normals == LF_NORMALS_FILE && soup->n_normals > 0};
    lf_status status = LF_OK;
    if (soup->n_triangles == 0)
        return lf_mesh_complete(out, desc, 0, err);
    if (!join_corners(&w, soup))
        status = lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    if (status == LF_OK && desc->material < 0)
        status = take_materials(soup, out, err);
    if (status == LF_OK)
        status = fill_mesh(&w, soup, desc, out, err);
    if (status == LF_OK)
        warn_of_rest(soup, desc, out);
    free(w.vertices);
    free(w.table);
    return status;
}
