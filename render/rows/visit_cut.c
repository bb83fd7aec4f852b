/* The plane of a visit, at its shutter time, and the sections cut by it. */
#include "render/rows/extinction.h"
#include "render/rows/outlines.h"
#include "render/rows/prefix_factor.h"
#include "render/rows/visit_steps.h"

/* The lights in the media of the row, as seen in its plane. */
static void cut_equiangular(lf_visit *visit)
{
    lf_scratch *w = visit->worker;
    int base = 0;
    for (int k = 0; k < visit->rig->n_views && w->media.n_here > 0; k++)
        base += w->reach.end[k] - w->reach.first[k];
    lf_equiangular_row_init(&w->equiangular, visit->scene, visit->rig, &visit->plane, &w->media,
                            (float)base,
                            visit->sharing->entry.shares ? 1.0f : (float)visit->rig->n_views);
}

static void cut_meshes(const lf_visit *visit)
{
    lf_scratch *w = visit->worker;
    bool alphas = lf_has(visit->scene, LF_TRAITS_SEEN_THROUGH);
    lf_section_cut(&w->section, visit->triangles, visit->scene, visit->rig, visit->row,
                   &visit->plane, alphas ? LF_CUT_OPAQUE : LF_CUT_ALL);
    if (alphas)
        lf_section_cut(&w->alpha.section, visit->triangles, visit->scene, visit->rig, visit->row,
                       &visit->plane, LF_CUT_ALPHAS);
}

lf_rays lf_visit_rays(const lf_visit *visit, int from, int to)
{
    const lf_scratch *w = visit->worker;
    return (lf_rays){.scene = visit->scene,
                     .rig = visit->rig,
                     .plane = &visit->plane,
                     .kernels = visit->kernels,
                     .n = to - from,
                     .x0 = w->x0 + from,
                     .slope = w->slope + from,
                     .z_end = w->z_end + from,
                     .channels = visit->extinction->channels > 1};
}

static lf_row_cut cut_of(const lf_visit *visit, const lf_section *section)
{
    return (lf_row_cut){section, visit->triangles, visit->scene, visit->rig, &visit->plane};
}

lf_row_cut lf_visit_section(const lf_visit *visit)
{
    return cut_of(visit, &visit->worker->section);
}

lf_row_cut lf_visit_alphas(const lf_visit *visit)
{
    return cut_of(visit, &visit->worker->alpha.section);
}

void lf_visit_set_shutter_time(lf_visit *visit, lf_visit_number number)
{
    const lf_visit_plan *plan = visit->plan;
    float time = lf_sampler_radical(lf_hash64(number.key, 17), number.index);
    if (lf_has_fault(visit, LF_FAULT_NO_TIME))
        time = 0.5f;
    lf_shutter_time_set(plan->shutter, plan->moving, time);
    visit->worker->tracer.time = time;
    if (lf_has_fault(visit, LF_FAULT_OTHER_TIME))
        visit->worker->tracer.time = 1.0f - time;
}

void lf_visit_cut(lf_visit *visit, lf_visit_number number, int plane)
{
    const lf_visit_plan *plan = visit->plan;
    const uint64_t key = number.key;
    const uint32_t index = number.index;
    lf_scratch *w = visit->worker;
    const float lens[2] = {lf_sampler_radical(lf_hash64(key, 1), index),
                           lf_sampler_radical(lf_hash64(key, 2), index)};
    const lf_media_plane at = {.rig = visit->rig,
                               .plane = &visit->plane,
                               .kernels = visit->kernels,
                               .phase = {lf_sampler_radical(lf_hash64(key, 15), index),
                                         lf_sampler_radical(lf_hash64(key, 4), index)}};
    const float offset = lf_outlines_row(lf_hash64(key, 0), index, plane);
    lf_rig_row_plane(visit->rig, (float)visit->row + offset, lens, &visit->plane);
    lf_media_cut(&w->media, plan->frame, visit->scene->volumes, &at, &w->tracer.lookups);
    lf_media_cut(&w->emission.emissive, plan->emissive, visit->scene->emissive.field, &at,
                 &w->tracer.lookups);
    if (visit->triangles)
        cut_meshes(visit);
    if (plan->skip & LF_SKIP_BACKGROUND)
        lf_reach_of(&w->reach, visit->scene, visit->rig, &visit->plane, &w->media,
                    &w->emission.emissive);
    else
        lf_reach_whole(&w->reach, visit->rig);
    cut_equiangular(visit);
    lf_prefix_find(visit);
}

int lf_visit_planes(const lf_visit_plan *plan, int64_t index)
{
    const bool outlines = plan->triangles && plan->film->layout.has_features && !plan->order.coarse;
    return outlines ? lf_outlines_planes((uint32_t)index) : 1;
}
