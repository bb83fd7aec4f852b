#include "render/general/reuse.h"

#include "render/general/reservoir.h"

typedef struct keeping {
    lf_reservoir reservoir;
    lf_path_sample *out;
    lf_tracer *tracer;
} keeping;

static void keep(void *context, const lf_light_path *path, double target, double weight)
{
    keeping *k = context;
    if (lf_reservoir_offer(&k->reservoir, weight, target, (double)lf_rng(k->tracer))) {
        k->out->path = *path;
        k->out->kept = 1;
    }
}

static void finish(keeping *k)
{
    k->out->target = k->reservoir.target;
    k->out->m = k->reservoir.m;
    k->out->weight = lf_reservoir_weight(&k->reservoir);
}

void lf_path_sample_draw(const lf_path_space *space, const lf_camera_ray *ray, int n,
                         lf_tracer *tracer, lf_path_sample *out)
{
    keeping k = {.reservoir = {.m = (double)n}, .out = out, .tracer = tracer};
    const int walks = ray->depth > 0.0 ? n : 0;
    out->kept = 0;
    for (int i = 0; i < walks; i++)
        lf_light_path_walk(space, ray, (i + (double)lf_rng_fine(tracer)) / n, tracer, keep, &k);
    finish(&k);
}

/* The target function of stream i's path along the rays of all. */
static void targets_of(const lf_path_space *space, int n, const lf_reuse_input *inputs, int i,
                       lf_tracer *tracer, double *out)
{
    for (int s = 0; s < n; s++)
        out[s] = s == i
                     ? inputs[i].sample->target
                     : lf_light_path_target(space, inputs[s].ray, &inputs[i].sample->path, tracer);
}

void lf_path_sample_combine(const lf_path_space *space, int n, const lf_reuse_input *inputs,
                            lf_reuse_weights weights, lf_tracer *tracer, lf_path_sample *out)
{
    keeping k = {.out = out, .tracer = tracer};
    double m[LF_MAX_REUSE], target[LF_MAX_REUSE];
    out->kept = 0;
    for (int i = 0; i < n; i++) {
        m[i] = inputs[i].m;
        k.reservoir.m += m[i];
    }
    for (int i = 0; i < n; i++) {
        const lf_path_sample *sample = inputs[i].sample;
        double share = 1.0;
        if (!sample->kept)
            continue;
        if (weights == LF_REUSE_UNBIASED) {
            targets_of(space, n, inputs, i, tracer, target);
            share = lf_reservoir_share(n, m, target, i);
        } else {
            target[0] = i == 0 ? sample->target
                               : lf_light_path_target(space, inputs[0].ray, &sample->path, tracer);
        }
        keep(&k, &sample->path, target[0], target[0] * m[i] * sample->weight * share);
    }
    finish(&k);
}
