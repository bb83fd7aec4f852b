/* A visit of a row: plane, slices, unscattered light, base samples. The part that all integrators
 * share. */
#include "render/rows/extinction.h"
#include "render/rows/light_paths.h"
#include "render/rows/outlines.h"
#include "render/rows/queue.h"
#include "render/rows/visit_steps.h"

/* ------------------------------------------------------------------------------------- visit -- */

/* Native samples that a visit takes in each pixel with a delta lobe: one, so that even the shortest
 * visit completes a mirror's image; two if these are at most six for each of the pixel's base
 * samples. */
static int mirror_rounds(const lf_visit_plan *plan)
{
    enum { MIRROR_TIMES = 6 };
    if (!lf_has(plan->scene, LF_TRAIT_MIRRORS) || plan->order.column_step > 1)
        return 0;
    return MIRROR_TIMES * plan->order.subsets < 2 * plan->rig->n_views ? 1 : 2;
}

/* B, q and features of a visit. The visit's plane must be cut, and is cut again at the end. */
static void find_known(lf_visit *visit)
{
    const bool fault = lf_has_fault(visit, LF_FAULT_OTHER_ROW);
    lf_visit_number of = visit->number;
    if (fault) {
        of.key = lf_hash64(of.key, 8);
        lf_visit_cut(visit, of, 0);
    }
    lf_unscattered_row(visit, false);
    for (int i = 1; i < lf_outlines_planes(of.index) && visit->outlines; i++) {
        lf_visit_cut(visit, of, i);
        lf_unscattered_outlines(visit, i);
    }
    if (visit->outlines || fault)
        lf_visit_cut(visit, visit->number, 0);
}

/* The row's samples from this stream so far. */
static const lf_film_counts *given_before(const lf_visit *visit)
{
    const lf_visit_plan *plan = visit->plan;
    return &plan->film->streams[plan->order.stream].rows[visit->row];
}

/* Position at which the lattice continues. */
static int64_t passes_before(const lf_visit *visit)
{
    return llround(given_before(visit)->n[visit->half] * visit->rig->n_views);
}

/* Initialises everything except the plane. */
static void begin(const lf_visit_plan *plan, lf_visit *visit)
{
    const int views = plan->rig->n_views;
    visit->plan = plan;
    visit->scene = plan->scene;
    visit->rig = plan->rig;
    visit->kernels = plan->kernels;
    visit->acting = visit->sharing = plan->sharing;
    visit->triangles = plan->triangles;
    visit->max_depth = plan->max_depth;
    visit->splitting = plan->splitting;
    visit->number.key = lf_visit_key(plan->order.random, visit->row, visit->half);
    visit->number.index = given_before(visit)->visits[visit->half];
    visit->random = lf_hash64(lf_hash64(visit->number.key, 3), visit->number.index);
    visit->subsets = plan->order.subsets;
    visit->lattice = (lf_visit_lattice){
        .start = (int)(lf_sampler_radical(lf_hash64(visit->number.key, 7), 0) * (float)views) +
                 (int)(passes_before(visit) % views),
        .first = (int)((visit->random >> 32) % (uint64_t)plan->order.column_step),
        .step = lf_lattice_step(views),
        .views = views};
    visit->weight = 1.0f;
    visit->alone = 1.0f;
    visit->mirror_rounds = mirror_rounds(plan);
    visit->more = plan->order.subsets > 0
                      ? (float)(visit->mirror_rounds * views) / (float)plan->order.subsets
                      : 0.0f;
    visit->faults = plan->order.faults;
    visit->worker->tracer.scene = plan->scene;
    visit->worker->tracer.roulette = plan->splitting.roulette;
    if (plan->counts) {
        lf_counts_row(plan->counts, visit->row, visit->worker->expected);
        visit->expected = visit->worker->expected;
    }
    visit->extinction = lf_has(plan->scene, LF_TRAIT_CHROMATIC_MEDIA) ? &lf_extinction_chromatic
                                                                      : &lf_extinction_grey;
    lf_scratch *w = visit->worker;
    for (int c = 0; c < 3; c++)
        w->channels.received[c] = visit->extinction->channels > 1
                                      ? w->channels.density + c * lf_rig_lanes(plan->rig)
                                      : w->density;
}

/* Every pixel of the lattice once; false = cancelled. */
static bool sample_lattice(lf_visit *visit, const lf_cancel *cancel)
{
    const int64_t passes = passes_before(visit);
    const int step = visit->plan->order.column_step;
    lf_base base = {.film = -1.0f, .key = visit->number.key};
    for (base.column = visit->lattice.first; base.column < visit->rig->width; base.column += step) {
        for (int j = 0; j < visit->subsets; j++) {
            if (lf_cancelled(cancel))
                return false;
            base.view = lf_visit_lattice_view(&visit->lattice, base.column, j);
            /* number of samples that the pixel has had */
            base.index = (uint32_t)((passes + j) / visit->rig->n_views);
            lf_base_sample(visit, &base);
        }
    }
    return true;
}

/* Takes as many samples as the map expects. A pixel's count runs on from visit to visit, rounded
 * down after a start that the lattice spreads over the pixels. So each pixel gets its own number on
 * average and is never off by one sample or more. false: cancelled. */
static bool sample_counts(lf_visit *visit, const lf_cancel *cancel)
{
    const int width = visit->rig->width, views = visit->rig->n_views,
              inverse = lf_lattice_inverse(visit->lattice.step, views);
    const uint64_t key = visit->number.key;
    const double n = given_before(visit)->n[visit->half], share = (double)visit->subsets / views,
                 first = (double)(lf_sampler_radical(lf_hash64(key, 11), 0) * (float)views);
    for (int column = 0; column < width; column++) {
        for (int view = 0; view < views; view++) {
            double expected =
                (double)visit->expected[(size_t)view * (size_t)width + (size_t)column];
            double rank = (double)(((int64_t)inverse * view - column) % views) - first;
            double phase = rank / views - floor(rank / views);
            uint32_t begin = (uint32_t)floor(phase + expected * n),
                     end = (uint32_t)floor(phase + expected * (n + share));
            /* With at least one certain sample, the realised number is as good as the expected one,
             * and adds no noise. */
            double count = expected * share < 1.0 ? expected * share : (double)(end - begin);
            visit->alone = end > begin ? (float)(share / count) : 1.0f;
            for (uint32_t i = begin; i < end; i++) {
                if (lf_cancelled(cancel))
                    return false;
                lf_base_sample(visit, &(lf_base){.view = view,
                                                 .column = column,
                                                 .film = -1.0f,
                                                 .key = lf_hash64(key, 13),
                                                 .index = i});
            }
        }
    }
    visit->alone = 1.0f;
    return true;
}

/* Delta lobes cannot be shared. Pixels whose film point of B and q met one get native samples of
 * their own, equally many each. The film points form a net with the row offsets. The choice of
 * pixels is independent of the samples, and their number is what the weights expect (native.c).
 * false: cancelled. */
static bool sample_mirrors(lf_visit *visit, const lf_cancel *cancel)
{
    const uint64_t key = visit->number.key;
    lf_base base = {.native_only = true, .index = visit->number.index};
    for (base.view = 0; base.view < visit->rig->n_views; base.view++) {
        for (base.column = 0; base.column < visit->rig->width; base.column++) {
            size_t pixel = (size_t)base.view * (size_t)visit->rig->width + (size_t)base.column;
            bool wanted = !visit->expected || visit->expected[pixel] > 0.0f;
            if (!visit->worker->mirrors[pixel] || !wanted)
                continue;
            for (int i = 0; i < visit->mirror_rounds; i++) {
                base.key = lf_hash64(lf_hash64(key, 12), (uint64_t)i);
                base.film =
                    lf_sampler_partner(lf_hash64(key, 0), lf_hash64(base.key, pixel), base.index);
                if (lf_cancelled(cancel))
                    return false;
                lf_base_sample(visit, &base);
            }
        }
    }
    return true;
}

/* B, q and features of a row without base samples, except between rows that differ little. It takes
 * some samples of delta lobes, which are part of B. false: cancelled. */
static bool put_provisional(lf_visit *visit, const lf_cancel *cancel)
{
    lf_scratch *w = visit->worker;
    lf_film *film = visit->plan->film;
    lf_between rows;
    const bool between = !w->mirrors && lf_between_find(film, visit->row, &rows);
    bool all = false;
    if (between) {
        all = lf_between_mark(&rows, visit->rig, w->met.smooth);
        lf_between_close(&rows);
    }
    if (all)
        return true; /* nothing is kept: the row counts as missing */
    if (visit->plan->shutter)
        lf_visit_set_shutter_time(visit, visit->number);
    lf_visit_cut(visit, visit->number, 0);
    const bool known = w->reach.any || film->layout.has_known;
    if (w->sums.native)
        lf_film_sums_begin(&w->sums);
    if (known)
        lf_unscattered_row(visit, between);
    if (visit->rig->n_views == 1)
        visit->more -= 1.0f; /* no base sample in addition (native.c) */
    if (known && visit->mirror_rounds > 0 && !sample_mirrors(visit, cancel))
        return false;
    lf_film_put_provisional(film, visit->row, known ? &w->sums : NULL, visit->subsets);
    return true;
}

/* Native samples that the visit adds to a view pixel. */
static double given_by(const lf_visit *visit)
{
    return (double)visit->subsets / visit->plan->order.column_step;
}

/* Counts a visit with an empty plane. */
static void count_empty(const lf_visit *visit)
{
    const lf_visit_plan *plan = visit->plan;
    const int step = plan->order.column_step,
              columns = (visit->rig->width - visit->lattice.first + step - 1) / step;
    visit->worker->base_paths += (int64_t)visit->subsets * columns;
    lf_film_count(plan->film, plan->order.stream, visit->row, visit->half, given_by(visit));
}

/* All samples of a visit; false = cancelled. */
static bool sample(lf_visit *visit, const lf_cancel *cancel)
{
    visit->queue = visit->plan->queue;
    if (visit->queue)
        lf_suffix_batch_clear(&visit->queue->batch); /* a cancelled visit may have left some */
    if (visit->expected ? !sample_counts(visit, cancel) : !sample_lattice(visit, cancel))
        return false;
    if (visit->queue)
        lf_queue_flush(visit->queue, visit);
    visit->queue = NULL;
    if (!lf_equiangular_visit(visit, (float)(given_by(visit) / visit->rig->n_views), cancel))
        return false;
    if (visit->plan->light)
        lf_light_paths_add(visit->plan->light, visit);
    return visit->mirror_rounds == 0 || sample_mirrors(visit, cancel);
}

/* Samples and merges an open row; *changed: the row was. */
static bool visit_open(lf_visit *visit, bool *changed, const lf_cancel *cancel)
{
    const lf_visit_plan *plan = visit->plan;
    const lf_visit_number number = visit->number;
    const int row = visit->row, half = visit->half;
    if (plan->shutter)
        lf_visit_set_shutter_time(visit, number);
    visit->outlines = lf_visit_planes(plan, number.index) > 1 && lf_outlines_find(visit);
    lf_visit_cut(visit, number, 0);
    if (!lf_film_meet(plan->film, row, visit->worker->reach.any || visit->outlines)) {
        count_empty(visit);
        return true;
    }
    lf_film_sums_begin(&visit->worker->sums);
    visit->worker->sums.coarse = plan->order.coarse;
    if (!lf_film_wants_albedo(plan->film, row))
        visit->sums.albedo = NULL;
    find_known(visit);
    if (!sample(visit, cancel))
        return false;
    *changed = true;
    lf_film_merge(plan->film, plan->order.stream, row, half, &visit->worker->sums, given_by(visit),
                  lf_hash64(lf_hash64(number.key, 9), number.index));
    return plan->order.hole_reach < 0 || lf_fill_holes(visit, number.index, cancel);
}

bool lf_visit_row(const lf_visit_plan *plan, int row, int half, lf_scratch *worker,
                  const lf_cancel *cancel)
{
    /* hole samples need a count to derive their weight from */
    if (plan->order.subsets == 0 && !(plan->film->rows[row].n[half] > 0.0))
        half = 1 - half;
    lf_visit visit = {.worker = worker, .sums = worker->sums, .row = row, .half = half};
    begin(plan, &visit);
    if (plan->order.fans)
        return put_provisional(&visit, cancel);
    bool changed = plan->order.subsets == 0;
    lf_film_open(plan->film, row);
    const bool done =
        changed ? lf_fill_holes(&visit, -1, cancel) : visit_open(&visit, &changed, cancel);
    lf_film_close(plan->film, row, changed);
    return done;
}
