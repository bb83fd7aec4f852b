/* Steps of mvpt that also light paths take at their pivots (mvpt.c); private to render/rows/. */
#ifndef LF_RENDER_FAN_STEPS_H
#define LF_RENDER_FAN_STEPS_H

#include "render/rows/visit.h"

/* Sets worker->scale to h_k for the views that have the pivot in their frame and see its side (else
 * 0), their film columns, and the rays from them. base: the view that drew the pivot; < 0: none, it
 * was drawn by light. */
void lf_fan_project(const lf_visit *visit, const lf_pivot *pivot, int base);

/* The lobes of all views towards wi: their pdfs and f_k; returns sum_k worker->strategy_k pdf_k. */
float lf_fan_eval(lf_visit *visit, const lf_pivot *pivot, lf_vec3 wi, lf_fan_lobes *out);

/* Directions drawn at a pivot on a glossy surface: a lobe narrower than the view cone serves few
 * views. */
#define LF_GLOSSY_DIRECTIONS 4
static inline bool lf_fan_is_glossy(const lf_scene *scene, const lf_event *event)
{
    return event->kind == LF_EVENT_SURFACE && lf_is_view_dependent(scene, event) &&
           !event->hit.material->has_delta;
}
/* Directions that a pivot draws. */
int lf_fan_directions(const lf_visit *visit, const lf_pivot *pivot);

/* Pixels of a view per unit area at a pivot on a surface, in units of worker->scale. */
static inline float lf_fan_unit(const lf_visit *visit, const lf_pivot *pivot)
{
    const lf_rig *rig = visit->rig;
    return rig->distance * rig->distance /
           (pivot->z * pivot->z * pivot->z * rig->dx * fabsf(rig->dy));
}

#endif
