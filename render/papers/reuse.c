#include "render/papers/reuse.h"

void lf_path_keeper_begin(lf_path_keeper *keeper, double m, lf_path_sample *out)
{
    keeper->reservoir = (lf_reservoir){.m = m};
    keeper->out = out;
    out->kept = 0;
    out->weight = 0.0;
    out->value = (lf_path_value){.depth = 0.0};
    out->brought = lf_v3(0.0f, 0.0f, 0.0f);
}

bool lf_path_keeper_offer(lf_path_keeper *keeper, const lf_path_value *value, double weight,
                          double u)
{
    lf_path_sample *out = keeper->out;
    if (!(weight > 0.0) || !isfinite(weight))
        return false;
    out->brought = lf_madd(out->brought, (float)(weight / (double)lf_mean3(value->f)), value->f);
    if (!lf_reservoir_offer(&keeper->reservoir, weight, lf_path_target(value), u))
        return false;
    out->value = *value;
    out->kept = 1;
    return true;
}

void lf_path_keeper_end(lf_path_keeper *keeper)
{
    lf_path_sample *out = keeper->out;
    out->m = keeper->reservoir.m;
    out->weight = lf_reservoir_weight(&keeper->reservoir);
    out->brought = lf_scale(out->brought, out->m > 0.0 ? (float)(1.0 / out->m) : 0.0f);
}

lf_vec3 lf_path_sample_radiance(const lf_path_sample *sample, double depth)
{
    const double more = exp(-depth) - exp(-sample->value.depth);
    return sample->kept ? lf_madd(sample->brought, (float)(more * sample->weight), sample->value.f)
                        : sample->brought;
}

/* --------------------------------------------------------------------------------- the walks -- */

void lf_path_sample_draw(int n, const lf_light_walk *walks, int taken, lf_tracer *tracer,
                         lf_path_sample *out)
{
    lf_path_keeper keeper;
    lf_path_keeper_begin(&keeper, (double)n, out);
    for (int i = 0; i < taken; i++)
        for (int k = 0; k < walks[i].n_candidates; k++) {
            const lf_path_candidate *found = &walks[i].candidates[k];
            if (lf_path_keeper_offer(&keeper, &found->value, found->weight, (double)lf_rng(tracer)))
                lf_light_walk_path(&walks[i], found, &out->path);
        }
    lf_path_keeper_end(&keeper);
}

/* ----------------------------------------------------------------------------------- streams -- */

/* The target function of stream i's path along the rays of all streams; out_own: its value along
 * the first. */
static void targets_of(const lf_path_space *space, int n, const lf_reuse_input *inputs, int i,
                       lf_tracer *tracer, double *out, lf_path_value *out_own)
{
    for (int s = 0; s < n; s++) {
        const lf_path_sample *sample = inputs[i].sample;
        const lf_path_value value =
            s == i ? sample->value
                   : lf_light_path_value(space, inputs[s].ray, &sample->path, tracer);
        out[s] = lf_path_target(&value);
        if (s == 0)
            *out_own = value;
    }
}

void lf_path_sample_combine(const lf_path_space *space, int n, const lf_reuse_input *inputs,
                            lf_reuse_weights weights, lf_tracer *tracer, lf_path_sample *out)
{
    lf_path_keeper keeper;
    double m[LF_MAX_REUSE], target[LF_MAX_REUSE], all = 0.0;
    for (int i = 0; i < n; i++) {
        m[i] = inputs[i].m;
        all += m[i];
    }
    lf_path_keeper_begin(&keeper, all, out);
    for (int i = 0; i < n; i++) {
        const lf_path_sample *sample = inputs[i].sample;
        const bool unbiased = weights == LF_REUSE_UNBIASED;
        lf_path_value own;
        if (!sample->kept)
            continue;
        targets_of(space, unbiased ? n : 1, inputs, i, tracer, target, &own);
        const double share = unbiased ? lf_reservoir_share(n, m, target, i) : 1.0,
                     weight = target[0] * m[i] * sample->weight * share;
        if (lf_path_keeper_offer(&keeper, &own, weight, (double)lf_rng(tracer)))
            out->path = sample->path;
    }
    lf_path_keeper_end(&keeper);
}
