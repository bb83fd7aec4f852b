#include "render/load/mesh_repeat.h"

#include <string.h>

#include "base/alloc.h"

/* The arrays of all copies. */
typedef struct copies {
    size_t n, vertices, triangles; /* of copies; of one copy */
    double *positions;
    float *normals, *tangents, *uvs, *colours;
    uint32_t *corners;
    uint16_t *choices;
} copies;

static bool allocate(const lf_mesh_data *data, copies *out)
{
    const size_t v = out->n * out->vertices, t = out->n * out->triangles;
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

/* Of unit length; zero stays so. */
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

static void put_vertices(const lf_mesh_data *data, size_t copy, copies *out)
{
    const lf_affine *place = &data->places[copy];
    const size_t from = copy * out->vertices;
    const bool mirrored = lf_affine_determinant(place) < 0.0;
    double normals[3][3], along[3][3];
    lf_affine_normals(place, normals);
    for (int i = 0; i < 3; i++)
        memcpy(along[i], place->m[i], sizeof along[i]);
    for (size_t v = 0; v < out->vertices; v++) {
        lf_affine_point(place, data->positions + 3 * v, out->positions + 3 * (from + v));
        if (data->normals)
            turn(normals, data->normals + 3 * v, out->normals + 3 * (from + v));
        if (!data->tangents)
            continue;
        turn(along, data->tangents + 4 * v, out->tangents + 4 * (from + v));
        out->tangents[4 * (from + v) + 3] =
            mirrored ? -data->tangents[4 * v + 3] : data->tangents[4 * v + 3];
    }
    if (data->colours)
        memcpy(out->colours + 4 * from, data->colours, 4 * out->vertices * sizeof(float));
    for (size_t set = 0; set < (size_t)data->n_uv_sets; set++)
        memcpy(out->uvs + 2 * (set * out->n * out->vertices + from),
               data->uvs + 2 * set * out->vertices, 2 * out->vertices * sizeof(float));
}

static void put_triangles(const lf_mesh_data *data, size_t copy, copies *out)
{
    const bool mirrored = lf_affine_determinant(&data->places[copy]) < 0.0;
    const uint32_t first = (uint32_t)(copy * out->vertices);
    for (size_t t = 0; t < out->triangles; t++) {
        const uint32_t *from = data->triangles + 3 * t;
        uint32_t *to = out->corners + 3 * (copy * out->triangles + t);
        to[0] = first + from[0];
        to[1] = first + from[mirrored ? 2 : 1];
        to[2] = first + from[mirrored ? 1 : 2];
    }
    if (data->triangle_material)
        memcpy(out->choices + copy * out->triangles, data->triangle_material,
               out->triangles * sizeof *out->choices);
}

static void *swap(void *from, void *to)
{
    lf_free(from);
    return to;
}

lf_status lf_mesh_repeat(lf_mesh_data *data)
{
    copies c = {.n = (size_t)data->n_places,
                .vertices = (size_t)data->n_vertices,
                .triangles = (size_t)data->n_triangles};
    if (c.n * c.triangles > LF_MAX_REPEATED || c.n * c.vertices > 3 * (size_t)LF_MAX_REPEATED)
        return LF_E_NOMEM;
    if (!allocate(data, &c)) {
        release(&c);
        return LF_E_NOMEM;
    }
    for (size_t copy = 0; copy < c.n; copy++) {
        put_vertices(data, copy, &c);
        put_triangles(data, copy, &c);
    }
    data->positions = swap(data->positions, c.positions);
    data->normals = swap(data->normals, c.normals);
    data->tangents = swap(data->tangents, c.tangents);
    data->uvs = swap(data->uvs, c.uvs);
    data->colours = swap(data->colours, c.colours);
    data->triangles = swap(data->triangles, c.corners);
    data->triangle_material = swap(data->triangle_material, c.choices);
    data->n_vertices = (int)(c.n * c.vertices);
    data->n_triangles = (int)(c.n * c.triangles);
    data->places = swap(data->places, NULL);
    data->n_places = 0;
    return LF_OK;
}
