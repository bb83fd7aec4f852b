#include "render/rows/visit_steps.h"

static double density(const lf_visit *visit, const lf_pivot *pivot, float sum, float depth)
{
    const lf_medium *medium = &visit->worker->media.item[pivot->medium];
    /* Homogeneous shapes count as 1 in the sum (lf_media_depths). */
    return (double)sum * exp(-(double)depth) *
           (medium->kind == LF_MEDIUM_BODY ? (double)medium->body.sigma_t : 1.0);
}

float lf_equiangular_ratio(const lf_visit *visit, const lf_pivot *pivot, const lf_light *light,
                           int view, float sum, float depth)
{
    return lf_equiangular_row_ratio(&visit->worker->equiangular, light, pivot->x, pivot->z, view,
                                    density(visit, pivot, sum, depth));
}

void lf_equiangular_balance(const lf_visit *visit, const lf_pivot *pivot, int view, float sum,
                            float depth, lf_suffix *suffix)
{
    if (lf_has_fault(visit, LF_FAULT_NO_EQUIANGULAR_BALANCE))
        return;
    if (suffix->has_light)
        suffix->light.pdf *=
            1.0f + lf_equiangular_ratio(visit, pivot, suffix->light.light, view, sum, depth);
    if (suffix->found_light)
        suffix->found_pdf *=
            1.0f + lf_equiangular_ratio(visit, pivot, suffix->found_light, view, sum, depth);
}

/* One point, in every medium that contains it, because a collision belongs to one medium. */
static void scatter(lf_visit *visit, int equiangular, uint64_t key, uint32_t index)
{
    lf_scratch *w = visit->worker;
    const lf_rig *rig = visit->rig;
    lf_sampler sampler;
    float place[3], u[3], lens = 0.0f;
    lf_sampler_init(&sampler, visit->plan->sampler, key, index);
    w->tracer.rng = lf_hash64(key ^ visit->random, ~(uint64_t)index);
    lf_sampler_2d(&sampler, place);
    place[2] = lf_sampler_1d(&sampler);
    int view = (int)(lf_sampler_1d(&sampler) * (float)rig->n_views);
    lf_sampler_2d(&sampler, u + 1);
    u[0] = lf_sampler_1d(&sampler);
    if (visit->plane.lens_chord > 0.0f)
        lens = (2.0f * lf_sampler_1d(&sampler) - 1.0f) * visit->plane.lens_chord;
    lf_pivot pivot = {.lx = lens, .forced_weight = 1.0f, .sampler = &sampler};
    lf_equiangular_row_draw(&w->equiangular, equiangular, view, place, &pivot.x, &pivot.z);
    if (!(pivot.z > 0.0f))
        return;
    lf_light_sample light;
    pivot.event.kind = LF_EVENT_MEDIUM;
    pivot.event.p =
        lf_rig_point(rig, pivot.x, visit->plane.ly + visit->plane.my * pivot.z, pivot.z);
    if (!lf_light_draw_from(
            visit->scene, &visit->scene->lights[visit->scene->equiangular.item[equiangular].light],
            pivot.event.p, u, &light))
        return;
    for (int i = 0; i < w->media.n_here; i++) {
        pivot.medium = w->media.here[i];
        pivot.event.volume = w->media.item[pivot.medium].volume;
        /* What a slice has there the integrator finds out. */
        if (w->media.item[pivot.medium].kind == LF_MEDIUM_SLICE ||
            lf_volume_sigma_t(&visit->scene->volumes[pivot.event.volume], pivot.event.p) > 0.0f)
            visit->acting->equiangular(visit, view, &pivot, &light);
    }
}

bool lf_equiangular_visit(lf_visit *visit, float weight, const lf_cancel *cancel)
{
    const lf_equiangular_row *row = &visit->worker->equiangular;
    for (int i = 0; i < row->n; i++) {
        uint64_t key = lf_hash64(visit->random, 64 + (uint64_t)i);
        /* Rounded down after adding a uniform number, so that the mean is the expected number. */
        int points =
            (int)(row->plane[i].points * weight + lf_sampler_radical(lf_hash64(key, 0), 0));
        for (int j = 0; j < points; j++) {
            if (lf_cancelled(cancel))
                return false;
            scatter(visit, i, key, (uint32_t)j);
        }
    }
    return true;
}
