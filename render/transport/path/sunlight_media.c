#include "render/transport/path/sunlight_media.h"

#include "base/alloc.h"

typedef struct job {
    lf_sunlight_media *media;
    lf_vec3 corner, step[3]; /* of node (0, 0, 0), and from node to node, scene-local */
    const lf_cancel *cancel;
} job;

static bool is_grid(const lf_volume *volume)
{
    return volume->kind == LF_VOLUME_GRID && volume->sigma_max > 0.0f;
}

static float grids_at(const lf_scene *scene, lf_vec3 p)
{
    float sigma = 0.0f;
    for (int i = 0; i < scene->n_volumes; i++)
        if (is_grid(&scene->volumes[i]))
            sigma += lf_volume_sigma_t(&scene->volumes[i], p);
    return sigma;
}

/* Node by node away from the light; what lies between two is as in the middle. */
static void march_item(void *context, int y, int worker)
{
    job *j = context;
    lf_sunlight_media *media = j->media;
    const int *size = media->size;
    float length = lf_length(j->step[2]);
    (void)worker;
    for (int x = 0; x < size[0]; x++) {
        if (j->cancel && atomic_load_explicit(j->cancel, memory_order_relaxed))
            return;
        float *depth = media->depth + ((size_t)y * (size_t)size[0] + (size_t)x) * (size_t)size[2];
        lf_vec3 top = lf_madd(lf_madd(j->corner, (float)x, j->step[0]), (float)y, j->step[1]);
        for (int k = 1; k < size[2]; k++)
            depth[k] = depth[k - 1] +
                       length * grids_at(media->scene, lf_madd(top, (float)k - 0.5f, j->step[2]));
    }
}

/* Bounds of the grids in the light's frame; false: there are none. */
static bool grid_bounds(const lf_scene *scene, const lf_vec3 axes[3], float min[3], float max[3])
{
    bool any = false;
    for (int i = 0; i < 3; i++) {
        min[i] = INFINITY;
        max[i] = -INFINITY;
    }
    for (int v = 0; v < scene->n_volumes; v++) {
        const lf_volume *volume = &scene->volumes[v];
        any = any || is_grid(volume);
        for (int c = 0; c < 8 && is_grid(volume); c++) {
            lf_vec3 p = lf_v3(c & 1 ? volume->bounds_max.x : volume->bounds_min.x,
                              c & 2 ? volume->bounds_max.y : volume->bounds_min.y,
                              c & 4 ? volume->bounds_max.z : volume->bounds_min.z);
            for (int i = 0; i < 3; i++) {
                min[i] = lf_min(min[i], lf_dot(axes[i], p));
                max[i] = lf_max(max[i], lf_dot(axes[i], p));
            }
        }
    }
    return any;
}

lf_status lf_sunlight_media_init(lf_sunlight_media *media, const lf_scene *scene, lf_vec3 toward,
                                 int nodes, lf_pool *pool, const lf_cancel *cancel)
{
    job j = {.media = media, .cancel = cancel};
    lf_vec3 axes[3];
    float min[3], max[3];
    *media = (lf_sunlight_media){.scene = scene, .toward = toward};
    lf_tangents(toward, &axes[0], &axes[1]);
    axes[2] = lf_scale(toward, -1.0f);
    if (!grid_bounds(scene, axes, min, max))
        return LF_OK;
    float longest = lf_max(max[0] - min[0], lf_max(max[1] - min[1], max[2] - min[2])),
          step = longest / (float)(nodes - 3), most = 2.0f * (float)nodes;
    if (!(step > 0.0f && step < INFINITY))
        return LF_OK;
    for (int i = 0; i < 3; i++) {
        const float row[3] = {axes[i].x, axes[i].y, axes[i].z};
        float first = min[i] - step;
        media->size[i] = (int)lf_min(lf_max(ceilf((max[i] - first) / step), 0.0f), most) + 2;
        for (int k = 0; k < 3; k++)
            media->to_nodes[i][k] = row[k] / step;
        media->to_nodes[i][3] = -first / step;
        j.corner = lf_madd(j.corner, first, axes[i]);
        j.step[i] = lf_scale(axes[i], step);
    }
    media->depth = lf_calloc((size_t)media->size[0] * (size_t)media->size[1],
                             (size_t)media->size[2] * sizeof *media->depth);
    if (!media->depth)
        return LF_E_NOMEM;
    lf_status status = lf_pool_run(pool, media->size[1], march_item, &j, cancel);
    return cancel && atomic_load_explicit(cancel, memory_order_relaxed) ? LF_E_CANCELLED : status;
}

void lf_sunlight_media_finish(lf_sunlight_media *media)
{
    lf_free(media->depth);
    *media = (lf_sunlight_media){0};
}

/* ---------------------------------------------------------------------------------- look-ups -- */

lf_vec3 lf_sunlight_media_node(const lf_sunlight_media *media, const int node[3])
{
    lf_vec3 p = lf_v3(0.0f, 0.0f, 0.0f);
    for (int i = 0; i < 3; i++) { /* rows are at right angles */
        const float *m = media->to_nodes[i];
        const lf_vec3 row = lf_v3(m[0], m[1], m[2]);
        p = lf_madd(p, ((float)node[i] - m[3]) / lf_dot(row, row), row);
    }
    return p;
}

static float grids_depth(const lf_sunlight_media *media, lf_vec3 p)
{
    const int *size = media->size;
    int at[3];
    float part[3];
    for (int i = 0; i < 3; i++) {
        const float *m = media->to_nodes[i];
        float x = m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], last = (float)(size[i] - 1);
        if (!(x > 0.0f) || (i < 2 && !(x < last)))
            return 0.0f;
        x = lf_min(x, last);
        at[i] = (int)x < size[i] - 2 ? (int)x : size[i] - 2;
        part[i] = x - (float)at[i];
    }
    size_t along = (size_t)size[2], row = along * (size_t)size[0];
    const float *d = media->depth + (size_t)at[1] * row + (size_t)at[0] * along + at[2];
    float low =
        lf_lerp(lf_lerp(d[0], d[1], part[2]), lf_lerp(d[along], d[along + 1], part[2]), part[0]);
    d += row;
    float high =
        lf_lerp(lf_lerp(d[0], d[1], part[2]), lf_lerp(d[along], d[along + 1], part[2]), part[0]);
    return lf_lerp(low, high, part[1]);
}

static float shape_depth(const lf_volume *volume, lf_vec3 p, lf_vec3 toward)
{
    float o[3], d[3], from, to;
    for (int i = 0; i < 3; i++) {
        const float *m = volume->to_volume[i];
        o[i] = m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
        d[i] = m[0] * toward.x + m[1] * toward.y + m[2] * toward.z;
    }
    lf_shape_interval(volume->kind, o, d, &from, &to);
    return volume->sigma_scale * (lf_max(to, 0.0f) - lf_max(from, 0.0f));
}

float lf_sunlight_media_depth(const lf_sunlight_media *media, lf_vec3 p)
{
    const lf_scene *scene = media->scene;
    float depth = media->depth ? grids_depth(media, p) : 0.0f;
    for (int i = 0; i < scene->n_volumes; i++)
        if (scene->volumes[i].kind != LF_VOLUME_GRID)
            depth += lf_max(shape_depth(&scene->volumes[i], p, media->toward), 0.0f);
    return depth;
}
