/* Volumetric Multi-View Rendering (Fraboni et al. 2022): which views share, and equation 23. */
#include "render/papers/alike.h"
#include "render/papers/count.h"
#include "render/papers/prefix.h"

/* The inputs of equation 24: the lobes of all views at one pivot. */
typedef struct lobes {
    const lf_scene *scene;
    const lf_event *event;
    const lf_vec3 *to_pivot;
    float sign; /* of media; -1: the phase function is highest straight back */
} lobes;

static double of_media(const lobes *l, int a, int b)
{
    const lf_volume *volume = &l->scene->volumes[l->event->volume];
    lf_vec3 wa = l->to_pivot[a], wb = l->to_pivot[b];
    return lf_lobe_distance((double)lf_volume_phase(volume, wa, lf_scale(wa, l->sign)),
                            (double)lf_volume_phase(volume, wa, lf_scale(wb, l->sign)));
}

/* The direction in which a surface would mirror the direction w. */
static lf_vec3 mirrored(const lf_event *event, lf_vec3 w)
{
    return lf_madd(w, -2.0f * lf_dot(event->hit.ns, w), event->hit.ns);
}

static double of_surface(const lobes *l, int a, int b)
{
    const lf_vec3 w[2] = {l->to_pivot[a], l->to_pivot[b]};
    double pdf[2][2];
    for (int i = 0; i < 2; i++) {
        lf_vec3 wi = mirrored(l->event, w[i]), f;
        for (int k = 0; k < 2; k++)
            pdf[k][i] = (double)lf_scatter_eval(l->scene, l->event, lf_scale(w[k], -1.0f), wi, &f);
    }
    return lf_total_variation(pdf[0], pdf[1]);
}

static double distance_of(const void *context, int a, int b)
{
    const lobes *l = context;
    return l->event->kind == LF_EVENT_SURFACE ? of_surface(l, a, b) : of_media(l, a, b);
}

static void select_views(const lf_general *g, lf_general_worker *w, const lf_prefix *p)
{
    lobes l = {&g->seen, &p->event, w->to_pivot, 1.0f};
    if (p->event.kind == LF_EVENT_MEDIUM) {
        const lf_volume *volume = &g->seen.volumes[p->event.volume];
        lf_vec3 on = p->event.w, back = lf_scale(on, -1.0f);
        if (lf_volume_phase(volume, on, on) < lf_volume_phase(volume, on, back))
            l.sign = -1.0f;
    }
    const lf_selected_views views = {g->rig.n_views, p->view, distance_of, &l};
    g->selection->select(&views, &w->tracer, w->selected);
}

/* Algorithm 2, lines 4 to 10 and 15, over the selected views. Counts c_k are only in the sum. In
 * p_jj, where the paper also has c_j, they would change the meaning of the film's n between passes.
 */
static bool weigh(const lf_general *g, lf_general_worker *w, const lf_prefix *p)
{
    double sum = 0.0;
    lf_prefix_look(g, w, p);
    select_views(g, w, p);
    for (int k = 0; k < g->rig.n_views; k++) {
        bool own = k == p->view;
        w->ratio[k] = own ? 1.0 : 0.0;
        if (!own && w->selected[k] && lf_prefix_visible(g, w, p, k))
            w->ratio[k] = lf_prefix_ratio(g, w, p, k);
        if (w->ratio[k] > 0.0)
            sum += lf_expected_count(g, w, k, w->column[k]) * w->ratio[k];
    }
    for (int k = 0; k < g->rig.n_views; k++)
        w->weight[k] = w->ratio[k] / sum;
    return isfinite(sum);
}

#define SUPPORT (LF_GENERAL_SUPPORT | LF_TRAITS_PLAIN_MEDIA | LF_TRAIT_EQUIANGULAR)

const lf_general_kind lf_general_mvpt2022 = {
    .entry = {.name = "mvpt2022",
              .what = "null chains shifted to all views, as in 2022",
              .shares = true,
              .takes = LF_PAPERS_TAKES(SHIFT) | LF_PAPERS_TAKES(SELECTION),
              .supports = SUPPORT},
    .weigh = weigh};
const lf_general_kind lf_general_mismvpt = {
    .entry = {.name = "mismvpt",
              .what = "the same with weights of multiple importance sampling",
              .shares = true,
              .takes = LF_PAPERS_TAKES(SHIFT),
              .supports = SUPPORT},
    .mis = true,
    .weigh = weigh};
const lf_general_kind lf_general_amvpt2022 = {
    .entry = {.name = "amvpt2022",
              .what = "mvpt2022 with more paths where the error is larger",
              .shares = true,
              .takes = LF_PAPERS_TAKES(SHIFT) | LF_PAPERS_TAKES(SELECTION),
              .remembers = true,
              .supports = SUPPORT},
    .adaptive = true,
    .weigh = weigh};
