#include "render/papers/prefix.h"

static lf_vec3 lens_point(const lf_general *g, const lf_prefix *p, int view)
{
    return lf_rig_point(&g->rig, g->rig.b[view] + (float)p->lx, (float)p->ly, 0.0f);
}

static void end_on_surface(const lf_general *g, lf_prefix *p)
{
    lf_vec3 d = lf_sub(p->event.hit.p, g->rig.eye);
    p->event.kind = LF_EVENT_SURFACE;
    p->event.p = p->event.hit.p;
    p->x = (double)lf_dot(d, g->rig.right);
    p->y = (double)lf_dot(d, g->rig.up);
    p->z = (double)lf_dot(d, g->rig.forward);
}

void lf_prefix_draw(const lf_general *g, lf_general_worker *w, lf_prefix *p)
{
    const lf_rig *rig = &g->rig;
    float film[2], lens[2], chord;
    lf_row_plane plane;
    lf_sampler_2d(p->sampler, film);
    lf_sampler_2d(p->sampler, lens);
    lf_rig_row_plane(rig, (float)p->row + film[1], lens, &plane);
    chord = (2.0f * lf_sampler_1d(p->sampler) - 1.0f) * plane.lens_chord;
    p->lx = (double)chord;
    p->ly = (double)plane.ly;
    p->my = plane.my;
    float slope = lf_rig_slope(rig, p->view, (float)p->column + film[0]) - chord / rig->focus,
          length = sqrtf(1.0f + slope * slope + plane.my * plane.my);
    lf_vec3 o = lens_point(g, p, p->view),
            d = lf_scale(lf_rig_direction(rig, slope, plane.my, 1.0f), 1.0f / length);
    w->tracer.width = 0.0f;
    w->tracer.spread = lf_rig_spread(rig) / length;
    bool surface = lf_trace_seen(&w->tracer, o, d, INFINITY, &p->event.hit);
    double end = surface ? (double)p->event.hit.t : (double)INFINITY;
    p->event.kind = LF_EVENT_ESCAPE;
    p->event.w = d;
    lf_media_path_init(&p->path, &w->tracer, o, d, end);
    int volume = 0;
    double t = lf_null_chain_draw(&p->path, &w->chain, &volume);
    if (isinf(t)) {
        if (surface)
            end_on_surface(g, p);
        return;
    }
    p->z = t / (double)length;
    p->x = (double)(rig->b[p->view] + chord) + (double)slope * p->z;
    p->y = p->ly + (double)plane.my * p->z;
    p->event.kind = LF_EVENT_MEDIUM;
    p->event.p = lf_madd(o, (float)t, d);
    p->event.volume = volume;
    lf_media_path_init(&p->path, &w->tracer, o, d, t);
}

/* The column of a view's film that the pivot is seen in through the copied lens point; < 0: none.
 */
static int column_of(const lf_general *g, const lf_prefix *p, int view)
{
    const lf_rig *rig = &g->rig;
    double x = (p->x - (double)rig->b[view] - p->lx) / p->z + p->lx / (double)rig->focus,
           u = ((double)rig->skew[view] + (double)rig->distance * x - (double)rig->x0) /
               (double)rig->dx;
    return u >= 0.0 && u < (double)rig->width ? (int)u : -1;
}

void lf_prefix_look(const lf_general *g, lf_general_worker *w, const lf_prefix *p)
{
    for (int k = 0; k < g->rig.n_views; k++) {
        w->to_pivot[k] = lf_normalize(lf_sub(p->event.p, lens_point(g, p, k)));
        w->column[k] = k == p->view ? p->column : column_of(g, p, k);
    }
}

double lf_prefix_area(const lf_general *g, const lf_prefix *p, int view)
{
    const double axis[3] = {0.0, 0.0, 1.0}, pivot[3] = {p->x, p->y, p->z},
                 lens[3] = {(double)g->rig.b[view] + p->lx, p->ly, 0.0};
    double film[3] = {lens[0] + (p->x - lens[0]) / p->z, lens[1] + (p->y - lens[1]) / p->z, 1.0},
           normal[3];
    bool surface = p->event.kind == LF_EVENT_SURFACE;
    normal[0] = surface ? (double)lf_dot(p->event.hit.ng, g->rig.right) : 0.0;
    normal[1] = surface ? (double)lf_dot(p->event.hit.ng, g->rig.up) : 0.0;
    normal[2] = surface ? (double)lf_dot(p->event.hit.ng, g->rig.forward) : 0.0;
    return lf_shift_area(lens, film, axis, pivot, surface ? normal : NULL);
}

bool lf_prefix_visible(const lf_general *g, lf_general_worker *w, const lf_prefix *p, int view)
{
    const lf_event *event = &p->event;
    bool surface = event->kind == LF_EVENT_SURFACE;
    if (w->column[view] < 0 || (surface && !(lf_dot(event->hit.ng, w->to_pivot[view]) < 0.0f)))
        return false;
    lf_vec3 lens = lens_point(g, p, view), to = lf_sub(lens, event->p);
    lf_vec3 o =
        surface ? lf_offset(&g->seen, event->p, event->hit.ng, to, lf_length(to)) : event->p;
    return lf_trace_passed_seen(&w->tracer, o, lf_sub(lens, o), 1.0f - 1e-6f) > 0.0f;
}

double lf_prefix_ratio(const lf_general *g, lf_general_worker *w, const lf_prefix *p, int view)
{
    lf_vec3 o = lens_point(g, p, view);
    double length = (double)lf_length(lf_sub(p->event.p, o));
    lf_media_path target;
    lf_media_path_init(&target, &w->tracer, o, w->to_pivot[view], length);
    return lf_prefix_area(g, p, p->view) / lf_prefix_area(g, p, view) *
           lf_shift_ratio(g->shift, &p->path.majorant, &target.majorant, w->chain.n, w->chain.nulls,
                          lf_media_path_extinction, &target);
}
