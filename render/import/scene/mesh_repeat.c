#include "render/import/scene/mesh_repeat.h"

#include <string.h>

#include "base/alloc.h"

/* The arrays of all copies. */
typedef struct copies {
    size_t vertices, triangles; /* of all */
    size_t at_vertex, at_triangle;
    double *positions;
    float *normals, *tangents, *uvs, *colours;
    uint32_t *corners;
    uint16_t *choices;
} copies;

static bool allocate(const lf_mesh_data *data, copies *out)
{
    const size_t v = out->vertices, t = out->triangles;
    out->positions = lf_calloc(v, 3 * sizeof *out->positions);
    out->corners = lf_calloc(t, 3 * sizeof *out->corners);
    out->normals = data->normals ? lf_calloc(v, 3 * sizeof(float)) : NULL;
    out->tangents = data->tangents ? lf_calloc(v, 4 * sizeof(float)) : NULL;
    out->uvs = data->uvs ? lf_calloc(v * (size_t)data->n_uv_sets, 2 * sizeof(float)) : NULL;
    out->colours = data->colours ? lf_calloc(v, 4 * sizeof(float)) : NULL;
    out->choices = data->triangle_material ? lf_calloc(t, sizeof *out->choices) : NULL;
    return out->positions && out->corners && !data->normals == !out->normals &&
           !data->tangents == !out->tangents && !data->uvs == !out->uvs &&
           !data->colours == !out->colours && !data->triangle_material == !out->choices;
}

static void release(copies *c)
{
    lf_free(c->positions);
    lf_free(c->normals);
    lf_free(c->tangents);
    lf_free(c->uvs);
    lf_free(c->colours);
    lf_free(c->corners);
    lf_free(c->choices);
}

/* Unit length; zero stays zero. */
static void turn(double by[3][3], const float *from, float *out)
{
    double v[3], length = 0.0;
    for (int i = 0; i < 3; i++) {
        v[i] = by[i][0] * (double)from[0] + by[i][1] * (double)from[1] + by[i][2] * (double)from[2];
        length += v[i] * v[i];
    }
    length = sqrt(length);
    for (int i = 0; i < 3; i++)
        out[i] = length > 0.0 ? (float)(v[i] / length) : 0.0f;
}

static void put_vertices(const lf_mesh_data *data, const lf_affine *place, const lf_mesh_part *part,
                         copies *out)
{
    const size_t n = part->n_vertices, first = part->first_vertex, at = out->at_vertex;
    const bool mirrored = lf_affine_determinant(place) < 0.0;
    double normals[3][3], along[3][3];
    lf_affine_normals(place, normals);
    for (int i = 0; i < 3; i++)
        memcpy(along[i], place->m[i], sizeof along[i]);
    for (size_t v = 0; v < n; v++) {
        const size_t from = first + v, to = at + v;
        lf_affine_point(place, data->positions + 3 * from, out->positions + 3 * to);
        if (data->normals)
            turn(normals, data->normals + 3 * from, out->normals + 3 * to);
        if (!data->tangents)
            continue;
        turn(along, data->tangents + 4 * from, out->tangents + 4 * to);
        out->tangents[4 * to + 3] =
            mirrored ? -data->tangents[4 * from + 3] : data->tangents[4 * from + 3];
    }
    if (data->colours)
        memcpy(out->colours + 4 * at, data->colours + 4 * first, 4 * n * sizeof(float));
    for (size_t set = 0; set < (size_t)data->n_uv_sets; set++)
        memcpy(out->uvs + 2 * (set * out->vertices + at),
               data->uvs + 2 * (set * (size_t)data->n_vertices + first), 2 * n * sizeof(float));
}

static void put_triangles(const lf_mesh_data *data, const lf_affine *place,
                          const lf_mesh_part *part, copies *out)
{
    const bool mirrored = lf_affine_determinant(place) < 0.0;
    const uint32_t moved = (uint32_t)out->at_vertex - part->first_vertex;
    for (size_t t = 0; t < part->n_triangles; t++) {
        const uint32_t *from = data->triangles + 3 * (part->first_triangle + t);
        uint32_t *to = out->corners + 3 * (out->at_triangle + t);
        to[0] = from[0] + moved;
        to[1] = from[mirrored ? 2 : 1] + moved;
        to[2] = from[mirrored ? 1 : 2] + moved;
    }
    if (data->triangle_material)
        memcpy(out->choices + out->at_triangle, data->triangle_material + part->first_triangle,
               part->n_triangles * sizeof *out->choices);
}

static lf_mesh_part part_at(const lf_mesh_data *data, int place)
{
    return lf_mesh_data_part(data, data->n_parts > 0 ? (int)data->part_of[place] : 0);
}

static void *swap(void *from, void *to)
{
    lf_free(from);
    return to;
}

lf_status lf_mesh_repeat(lf_mesh_data *data)
{
    copies c = {0};
    for (int i = 0; i < data->n_instances; i++) {
        const lf_mesh_part part = part_at(data, i);
        c.vertices += part.n_vertices;
        c.triangles += part.n_triangles;
    }
    if (c.triangles > LF_MAX_REPEATED || c.vertices > 3 * (size_t)LF_MAX_REPEATED)
        return LF_E_NOMEM;
    if (!allocate(data, &c)) {
        release(&c);
        return LF_E_NOMEM;
    }
    for (int i = 0; i < data->n_instances; i++) {
        const lf_mesh_part part = part_at(data, i);
        put_vertices(data, &data->places[i], &part, &c);
        put_triangles(data, &data->places[i], &part, &c);
        c.at_vertex += part.n_vertices;
        c.at_triangle += part.n_triangles;
    }
    data->positions = swap(data->positions, c.positions);
    data->normals = swap(data->normals, c.normals);
    data->tangents = swap(data->tangents, c.tangents);
    data->uvs = swap(data->uvs, c.uvs);
    data->colours = swap(data->colours, c.colours);
    data->triangles = swap(data->triangles, c.corners);
    data->triangle_material = swap(data->triangle_material, c.choices);
    data->n_vertices = (int)c.vertices;
    data->n_triangles = (int)c.triangles;
    data->places = swap(data->places, NULL);
    data->parts = swap(data->parts, NULL);
    data->part_of = swap(data->part_of, NULL);
    data->n_instances = data->n_parts = 0;
    return LF_OK;
}
