/* The fans of a row: of every column or, in a coarse visit, of the columns where something changes.
 */
#include <string.h>

#include "render/rows/outlines.h"

/* ----------------------------------------------------------------------------- coarse frames -- */

/* What a fan has met, for the columns between it and the next. */
typedef struct lf_fan_end {
    int column;
    int material[LF_MAX_LANES];
    float nearness[LF_MAX_LANES];
    bool has_alphas[LF_MAX_LANES];
} lf_fan_end;

bool lf_unscattered_next_groups(uint32_t *left, int n_views, int *first, int *end)
{
    const uint32_t all = ~UINT32_C(0) >> (32 - (n_views + LF_LANES - 1) / LF_LANES);
    *left &= all;
    if (*left == 0)
        return false;
    const int from = __builtin_ctz(*left);
    const uint32_t behind = ~(*left >> from);
    const int n = behind ? __builtin_ctz(behind) : 32;
    *first = from * LF_LANES;
    *end = (from + n) * LF_LANES;
    *left &= n < 32 ? ~(((UINT32_C(1) << n) - 1) << from) : 0;
    return true;
}

static void take_end(const lf_unscattered *e, int column, uint32_t groups, lf_fan_end *out)
{
    const lf_visit *visit = e->visit;
    const lf_scratch *w = visit->worker;
    out->column = column;
    for (int first, end; lf_unscattered_next_groups(&groups, visit->rig->n_views, &first, &end);) {
        lf_unscattered_fan(e, column, first, end);
        for (int k = first; k < end && k < visit->rig->n_views; k++) {
            out->material[k] = w->met.material[k];
            out->nearness[k] = lf_nearness(visit->rig->distance, w->z_end[k]);
            out->has_alphas[k] =
                e->has_alphas && visit->sums.feature && w->alpha.seen[k].cover > 0.0f;
        }
    }
}

/* Whether view k meets other surfaces in two columns. */
static bool is_torn(const lf_unscattered *e, const lf_fan_end *a, const lf_fan_end *b, int k)
{
    const float steepest = 3.0f;
    const lf_rig *rig = e->visit->rig;
    float apart = steepest * (float)(b->column - a->column) * rig->dx / rig->distance;
    return a->material[k] != b->material[k] || fabsf(a->nearness[k] - b->nearness[k]) > apart;
}

/* Whether view k sees a texture, which cannot be interpolated between columns. */
static bool sees_texture(const lf_unscattered *e, const lf_fan_end *at, int k)
{
    const int material = at->material[k];
    return e->visit->sums.albedo && material >= 0 &&
           (lf_has(e->visit->scene, LF_TRAIT_VERTEX_COLOURS) ||
            e->visit->scene->materials[material].textures);
}

/* Whether an edge lies between two columns of view k: interpolation would turn it into a ramp. */
static bool has_edge(const lf_unscattered *e, const lf_fan_end *a, const lf_fan_end *b, int k)
{
    const float most_q = 0.1f;
    const lf_visit *visit = e->visit;
    const float *q = visit->sums.half.q + (size_t)k * (size_t)visit->rig->width;
    return is_torn(e, a, b, k) || fabsf(q[a->column] - q[b->column]) > most_q || a->has_alphas[k] ||
           b->has_alphas[k] || sees_texture(e, a, k) || sees_texture(e, b, k);
}

/* Interpolates a column between two others, at t from a to b; features are weighted by the pivots.
 */
static void interpolate(const lf_visit *visit, size_t pixel, size_t a, size_t b, float t)
{
    const lf_film_sums *sums = &visit->sums;
    const float *q = sums->half.q;
    float weight[2] = {(1.0f - t) * lf_max(q[a], 0.0f), t * lf_max(q[b], 0.0f)},
          sum = weight[0] + weight[1];
    lf_film_pivots(sums, pixel, lf_lerp(q[a], q[b], t));
    if (sums->known)
        lf_film_known_light(sums, pixel, lf_lerp(sums->known[a][0], sums->known[b][0], t),
                            lf_lerp(sums->known[a][1], sums->known[b][1], t),
                            lf_lerp(sums->known[a][2], sums->known[b][2], t));
    if (visit->worker->mirrors)
        visit->worker->mirrors[pixel] = visit->worker->mirrors[a] || visit->worker->mirrors[b];
    if (!sums->feature)
        return;
    const lf_feature *x = &sums->feature[a], *y = &sums->feature[b];
    float s = sum > 0.0f ? weight[1] / sum : t;
    lf_film_note(sums, pixel,
                 (lf_feature){lf_lerp(x->nearness, y->nearness, s),
                              lf_lerp(x->spread, y->spread, s), lf_lerp(x->surface, y->surface, s),
                              lf_lerp(x->light, y->light, s)});
    if (!sums->albedo)
        return;
    float albedo[LF_ALBEDO_NUMBERS];
    for (int c = 0; c < LF_ALBEDO_NUMBERS; c++)
        albedo[c] = lf_lerp(sums->albedo[a][c], sums->albedo[b][c], s);
    lf_film_note_albedo(sums, pixel, albedo);
}

/* The columns between two fans of these groups of views: traced if a group has an edge there, else
 * interpolated. */
static void fill_between(const lf_unscattered *e, const lf_fan_end *a, const lf_fan_end *b,
                         uint32_t groups)
{
    const lf_visit *visit = e->visit;
    const int views = visit->rig->n_views;
    const size_t width = (size_t)visit->rig->width;
    float from = (float)a->column +
                 lf_unscattered_film_point(e->visit->number.key, a->column, e->visit->number.index),
          to = (float)b->column +
               lf_unscattered_film_point(e->visit->number.key, b->column, e->visit->number.index);
    uint32_t edges = 0;
    for (int k = 0; k < views && b->column > a->column + 1; k++)
        if (groups >> (k / LF_LANES) & 1 && has_edge(e, a, b, k))
            edges |= UINT32_C(1) << (k / LF_LANES);
    for (int column = a->column + 1; column < b->column; column++) {
        float t = ((float)column +
                   lf_unscattered_film_point(e->visit->number.key, column, e->visit->number.index) -
                   from) /
                  (to - from);
        uint32_t followed = edges, others = groups & ~edges;
        for (int first, end; lf_unscattered_next_groups(&followed, views, &first, &end);)
            lf_unscattered_fan(e, column, first, end);
        for (int first, end; lf_unscattered_next_groups(&others, views, &first, &end);)
            for (int k = first; k < end && k < views; k++) {
                size_t row = (size_t)k * width;
                interpolate(visit, row + (size_t)column, row + (size_t)a->column,
                            row + (size_t)b->column, t);
            }
    }
}

/* Marks pixels between other rows as not computed; the fans follow. */
static void leave_smooth(const lf_unscattered *e)
{
    const lf_rig *rig = e->visit->rig;
    const uint32_t *smooth = e->visit->worker->met.smooth;
    for (int k = 0; k < rig->n_views; k++) {
        float *q = e->visit->sums.half.q + (size_t)k * (size_t)rig->width;
        for (int column = 0; column < rig->width; column++)
            q[column] = smooth[column / LF_UNSCATTERED_COARSE] >> (k / LF_LANES) & 1 ? -1.0f : 0.0f;
    }
}

static void coarse_row(const lf_unscattered *e)
{
    const int last = e->visit->rig->width - 1;
    const uint32_t *smooth = e->visit->worker->met.smooth;
    uint32_t groups = e->between ? ~smooth[0] : ~UINT32_C(0);
    lf_fan_end ends[2];
    memset(ends, 0, sizeof ends);
    if (e->between)
        leave_smooth(e);
    take_end(e, 0, groups, &ends[0]);
    for (int i = 0, column = 0; column < last; i++) {
        const uint32_t before = groups;
        column = column + LF_UNSCATTERED_COARSE < last ? column + LF_UNSCATTERED_COARSE : last;
        if (e->between)
            groups = column < last ? ~smooth[i + 1] : 0;
        take_end(e, column, before | groups, &ends[(i + 1) % 2]);
        fill_between(e, &ends[i % 2], &ends[(i + 1) % 2], before);
    }
}

/* Marks the neighbours too: rays of a row lie in one plane, so at the border of a delta lobe one of
 * the neighbouring pixels has found it. */
static void widen(bool *mirrors, int n_views, int width)
{
    for (int view = 0; view < n_views; view++, mirrors += width) {
        bool before = false;
        for (int column = 0; column < width; column++) {
            bool here = mirrors[column];
            mirrors[column] = before || here || (column + 1 < width && mirrors[column + 1]);
            before = here;
        }
    }
}

/* Number of contributions that this visit adds to a view pixel; the mean, if a map gives other
 * numbers. */
static float contributions(const lf_visit_plan *plan)
{
    float paths = (float)plan->order.subsets / (float)plan->order.column_step;
    return plan->sharing->entry.shares ? paths : paths / (float)plan->rig->n_views;
}

static void choose_quarter(lf_unscattered *e)
{
    static const float no_lens[2] = {0.5f, 0.5f};
    const lf_visit *visit = e->visit;
    const uint32_t *visits = visit->plan->film->rows[visit->row].visits, n = visits[0] + visits[1];
    const bool right = (n & 1) != 0, below = right != ((n & 2) != 0);
    lf_row_plane of_quarter;
    e->quarter = right ? 0.75f : 0.25f;
    lf_rig_row_plane(visit->rig, (float)visit->row + (below ? 0.75f : 0.25f), no_lens, &of_quarter);
    /* through a lens: as far as the plane has it */
    e->down = visit->plane.ly != 0.0f ? 0.0f : of_quarter.my - visit->plane.my;
}

/* Data of a visit's plane. */
static lf_unscattered begin(const lf_visit *visit)
{
    lf_scratch *w = visit->worker;
    lf_unscattered e = {.visit = visit};
    e.constant = lf_unscattered_sky(visit, &e.sky);
    e.density = lf_correction_exit_density(contributions(visit->plan), visit->sums.feature);
    e.has_alphas = lf_has(visit->scene, LF_TRAITS_SEEN_THROUGH);
    choose_quarter(&e);
    for (int k = 0; k < LF_MAX_LANES; k++)
        w->met.segment[k] = -1; /* and so it stays without meshes */
    for (int i = 0; i < LF_FAN_FACES &&
                    (visit->plan->order.sunlight || lf_has(visit->scene, LF_TRAIT_VARYING));
         i++)
        w->met.face[i].segment = -1;
    for (int i = 0; i < LF_ALPHA_FACES && e.has_alphas; i++)
        w->alpha.face[i].segment = -1;
    for (int k = 0; k < LF_MAX_LANES && e.has_alphas; k++)
        w->alpha.seen[k].cover = 0.0f;
    return e;
}

void lf_unscattered_row(const lf_visit *visit, bool between)
{
    const lf_rig *rig = visit->rig;
    const bool coarse = visit->plan->order.coarse;
    lf_scratch *w = visit->worker;
    lf_unscattered e = begin(visit);
    e.between = between;
    w->tracer.rng = lf_hash64(lf_hash64(visit->number.key, 14), visit->number.index);
    if (coarse)
        coarse_row(&e);
    for (int column = 0; column < rig->width && !coarse; column++)
        lf_unscattered_fan(&e, column, 0, LF_MAX_LANES);
    if (w->mirrors)
        widen(w->mirrors, rig->n_views, rig->width);
}

void lf_unscattered_outlines(const lf_visit *visit, int plane)
{
    lf_unscattered e = begin(visit);
    lf_outlines_take(&e, plane);
}
