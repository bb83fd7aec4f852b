#include "render/rows/light_connect.h"

#include <string.h>

#include "render/plane/kernel.h"
#include "render/rows/fan_steps.h"

void lf_light_connect_init(lf_light_connect *connect, const lf_scene *scene, const lf_rig *rig,
                           lf_scratch *worker, const lf_light_plan *plan)
{
    *connect = (lf_light_connect){.visit = {.scene = scene,
                                            .rig = rig,
                                            .kernels = lf_kernels_get(),
                                            .splitting = plan->splitting,
                                            .worker = worker},
                                  .plan = plan,
                                  .view = -1};
    worker->tracer.scene = scene;
    worker->tracer.roulette = 0.0f;
}

/* The pivot that the vertex is for the cameras, in a row plane of its own; false: no row of the
 * film. */
static bool make_pivot(lf_light_connect *connect, const lf_forward_vertex *vertex,
                       lf_pivot *out_pivot)
{
    lf_visit *visit = &connect->visit;
    const lf_rig *rig = visit->rig;
    const lf_hit *hit = &vertex->event->hit;
    const lf_vec3 d = lf_sub(hit->p, rig->eye);
    const float y = lf_dot(d, rig->up), z = lf_dot(d, rig->forward);
    if (hit->mesh->hidden || !(z > 0.0f))
        return false;
    const float row = (rig->distance * (y / z) - rig->y0) / rig->dy;
    if (!(row >= 0.0f && row < (float)rig->height))
        return false;
    visit->row = (int)row;
    visit->plane = (lf_row_plane){.my = y / z};
    if (!connect->sink.wants(connect->sink.context, visit->row))
        return false;
    out_pivot->event = *vertex->event;
    out_pivot->x = lf_dot(d, rig->right);
    out_pivot->z = z;
    out_pivot->lx = 0.0f;
    return true;
}

/* The lobes of all views towards the vertex before, as in lf_fan_eval; the sum over the views of
 * scale times pdf. */
static float eval(lf_light_connect *connect, const lf_pivot *pivot, lf_vec3 back, lf_fan_lobes *out)
{
    lf_visit *visit = &connect->visit;
    lf_scratch *w = visit->worker;
    const int n = visit->rig->n_views;
    memcpy(w->strategy, w->scale, sizeof *w->strategy * (size_t)lf_rig_lanes(visit->rig));
    if (lf_is_view_dependent(visit->scene, &pivot->event)) {
        lf_fan_look_back(visit, &pivot->event.hit);
        return lf_fan_eval(visit, pivot, back, out);
    }
    *out = (lf_fan_lobes){.pdf = w->lobe, .f = {w->f[0], w->f[0], w->f[0]}};
    float sum = 0.0f, pdf = lf_scatter_eval(visit->scene, &pivot->event, pivot->event.hit.ng, back,
                                            &out->colour);
    for (int k = 0; k < n; k++) {
        w->lobe[k] = pdf;
        w->f[0][k] = 1.0f;
        sum += w->scale[k] * pdf;
    }
    return sum;
}

static lf_vec3 lobe_of(const lf_fan_lobes *f, int k)
{
    return lf_mul(f->colour, lf_v3(f->f[0][k], f->f[1][k], f->f[2][k]));
}

/* a / (a + over), where a is M times the rate. */
static float weight_of(const lf_light_connect *connect, float rate, float over)
{
    const float a = connect->plan->m * rate;
    if (!(a > 0.0f))
        return 0.0f;
    return a < INFINITY ? a / (a + over) : 1.0f;
}

/* Multiplies the scale of each view by the transmittance in front of the pivot; returns the new sum
 * of scale times pdf. */
static float see(lf_light_connect *connect, const lf_pivot *pivot)
{
    lf_visit *visit = &connect->visit;
    lf_scratch *w = visit->worker;
    const lf_rig *rig = visit->rig;
    const lf_hit *hit = &pivot->event.hit;
    float sum = 0.0f;
    w->tracer.width = 0.0f;
    w->tracer.spread = lf_rig_spread(rig);
    for (int k = 0; k < rig->n_views; k++) {
        if (!(w->scale[k] * w->lobe[k] > 0.0f)) {
            w->scale[k] = 0.0f;
            continue;
        }
        const lf_vec3 eye = lf_rig_point(rig, rig->b[k], 0.0f, 0.0f);
        const lf_vec3 o = lf_offset(visit->scene, hit->p, hit->ng, lf_sub(eye, hit->p),
                                    lf_length(lf_sub(hit->p, eye)));
        const float passed = lf_trace_passed_seen(&w->tracer, eye, lf_sub(o, eye), 1.0f - 1e-6f);
        sum += w->scale[k] * w->lobe[k] *
               (lf_has_fault(visit, LF_FAULT_NO_LIGHT_VISIBILITY) ? 1.0f : passed);
        w->scale[k] *= passed;
    }
    w->tracer.spread = 0.0f;
    return sum;
}

/* Light to all views, as before visibility: the most that the vertex could send. */
static float most_of(const lf_light_connect *connect, const lf_fan_lobes *f, lf_vec3 flux)
{
    const lf_scratch *w = connect->visit.worker;
    float sum = 0.0f;
    for (int k = 0; k < connect->visit.rig->n_views; k++)
        sum += w->scale[k] * lf_mean3(lf_mul(flux, lobe_of(f, k)));
    return sum;
}

/* A random number that leaves the path's own as they are: whether a row is wanted must not change
 * the path. */
static float chance(const lf_tracer *tracer)
{
    return (float)(lf_hash64(tracer->rng, 19) >> 40) * 0x1p-24f;
}

static void connect_vertex(void *context, const lf_forward_vertex *vertex)
{
    lf_light_connect *connect = context;
    lf_visit *visit = &connect->visit;
    lf_scratch *w = visit->worker;
    const lf_light_plan *plan = connect->plan;
    const lf_rig *rig = visit->rig;
    lf_pivot pivot;
    lf_fan_lobes f;
    if (!(vertex->rate > 0.0f) || !make_pivot(connect, vertex, &pivot))
        return;
    lf_fan_project(visit, &pivot, -1);
    if (connect->view >= 0)
        for (int k = 0; k < rig->n_views; k++)
            w->scale[k] = k == connect->view ? w->scale[k] : 0.0f;
    const float unit = lf_fan_unit(visit, &pivot),
                directions = lf_has_fault(visit, LF_FAULT_NO_DIRECTIONS) ? 1.0f
                             : connect->view >= 0
                                 ? (float)lf_visit_splitting(visit, &pivot.event).suffixes
                                 : (float)lf_fan_directions(visit, &pivot);
    float over = directions * unit * eval(connect, &pivot, vertex->back, &f), keep = 1.0f,
          most = unit * most_of(connect, &f, vertex->flux);
    if (!(most > 0.0f) || !(over > 0.0f))
        return;
    if (plan->cut > 0.0f) {
        most *= weight_of(connect, vertex->rate, over) *
                lf_light_importance(plan, rig, visit->row, w->column[rig->n_views / 2]);
        keep = lf_min(most / plan->cut, 1.0f);
        if (!(chance(&w->tracer) < keep))
            return;
    }
    const float seen = directions * unit * see(connect, &pivot);
    connect->over = connect->view >= 0 ? over : seen;
    const float weight = unit * weight_of(connect, vertex->rate, connect->over) / (keep * plan->m);
    for (int k = 0; k < rig->n_views; k++) {
        if (!(w->scale[k] > 0.0f))
            continue;
        const lf_vec3 light = lf_scale(lf_mul(vertex->flux, lobe_of(&f, k)), w->scale[k] * weight);
        if (lf_max3(light) > 0.0f)
            connect->sink.take(connect->sink.context, visit->row, lf_visit_pixel(visit, k), light);
    }
    if (connect->sink.close)
        connect->sink.close(connect->sink.context, vertex);
}

void lf_light_connect_path(lf_light_connect *connect, uint64_t random, int max_depth, bool alone)
{
    lf_tracer *tracer = &connect->visit.worker->tracer;
    tracer->rng = random;
    connect->view = -1;
    if (alone)
        connect->view = (int)(lf_rng(tracer) * (float)connect->visit.rig->n_views);
    lf_forward_trace(tracer, connect->plan->emitters, max_depth, connect_vertex, connect);
}
