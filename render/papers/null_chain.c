#include "render/papers/null_chain.h"

#include <assert.h>

/* The part of a ray within the bounds of a volume; false: it misses them. */
static bool find_span(const lf_volume *volume, lf_vec3 o, lf_vec3 w, lf_span *out)
{
    float from[3], along[3], t0 = 0.0f, t1 = INFINITY;
    for (int i = 0; i < 3; i++) {
        const float *m = volume->to_volume[i];
        from[i] = m[0] * o.x + m[1] * o.y + m[2] * o.z + m[3];
        along[i] = m[0] * w.x + m[1] * w.y + m[2] * w.z;
    }
    if (volume->kind != LF_VOLUME_GRID)
        lf_shape_interval(volume->kind, from, along, &t0, &t1);
    for (int i = 0; i < 3 && volume->kind == LF_VOLUME_GRID; i++) {
        float last = (float)volume->grid->size[i], a = (-1.0f - from[i]) / along[i],
              b = (last - from[i]) / along[i];
        if (along[i] == 0.0f && !(from[i] > -1.0f && from[i] < last))
            return false;
        t0 = along[i] == 0.0f ? t0 : lf_max(t0, lf_min(a, b));
        t1 = along[i] == 0.0f ? t1 : lf_min(t1, lf_max(a, b));
    }
    *out = (lf_span){(double)t0, (double)t1, (double)volume->sigma_max};
    return t1 > t0 && t1 > 0.0f;
}

void lf_media_path_init(lf_media_path *path, lf_tracer *tracer, lf_vec3 o, lf_vec3 w, double end)
{
    const lf_scene *scene = tracer->scene;
    lf_span spans[LF_MAX_VOLUMES];
    int n = 0;
    for (int i = 0; i < scene->n_volumes; i++)
        n += find_span(&scene->volumes[i], o, w, &spans[n]);
    path->tracer = tracer;
    path->o = o;
    path->w = w;
    lf_majorant_make(&path->majorant, n, spans, end);
}

double lf_media_path_depth_bound(const lf_scene *scene)
{
    double depth = 0.0;
    for (int i = 0; i < scene->n_volumes; i++) {
        const lf_volume *v = &scene->volumes[i];
        depth += (double)(v->sigma_max * lf_length(lf_sub(v->bounds_max, v->bounds_min)));
    }
    return depth;
}

double lf_media_path_extinction(void *path, double t)
{
    lf_media_path *p = path;
    const lf_scene *scene = p->tracer->scene;
    lf_vec3 at = lf_madd(p->o, (float)t, p->w);
    double sum = 0.0;
    for (int i = 0; i < scene->n_volumes; i++)
        sum += (double)lf_volume_sigma_t(&scene->volumes[i], at);
    p->tracer->lookups += scene->n_volumes;
    return sum;
}

/* Picks one of the volumes at a point, in proportion to their extinctions. */
static int pick_volume(lf_media_path *path, double t, double sum)
{
    const lf_scene *scene = path->tracer->scene;
    lf_vec3 at = lf_madd(path->o, (float)t, path->w);
    double left = (double)lf_rng(path->tracer) * sum;
    int last = 0;
    for (int i = 0; i < scene->n_volumes; i++) {
        double own = (double)lf_volume_sigma_t(&scene->volumes[i], at);
        if (!(own > 0.0))
            continue;
        last = i;
        left -= own;
        if (left < 0.0)
            break;
    }
    return last;
}

double lf_null_chain_draw(lf_media_path *path, lf_null_chain *out, int *out_volume)
{
    lf_tracer *tracer = path->tracer;
    double depth = 0.0;
    lf_majorant_point p;
    out->n = 0;
    for (;;) {
        depth += (double)lf_rng_exponential(tracer);
        if (!lf_majorant_at_depth(&path->majorant, depth, &p))
            return INFINITY;
        double extinction = lf_media_path_extinction(path, p.t);
        if ((double)lf_rng_fine(tracer) * p.mu < extinction) {
            *out_volume = pick_volume(path, p.t, extinction);
            return p.t;
        }
        assert(out->n < LF_MAX_NULLS);
        if (out->n < LF_MAX_NULLS)
            out->nulls[out->n++] = (lf_null){p, extinction};
    }
}
