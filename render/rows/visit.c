/* A visit of a row: plane, slice, exits, base samples. What is the same for every integrator. */
#include "render/rows/native.h"
#include "render/rows/outlines.h"
#include "render/rows/queue.h"

/* ----------------------------------------------------------------------------------- lattice -- */

static int gcd(int a, int b)
{
    return b ? gcd(b, a % b) : a;
}

/* A step coprime to n near n times 1 - 1/golden ratio: neighbouring columns take distant views. */
static int lattice_step(int n)
{
    int step = (int)(0.381966 * n);
    while (gcd(step, n) != 1)
        step++;
    return step;
}

/* The views of a column in the order in which visits take them: rank r of column u is view step (u
 * + r) mod n. A visit takes the next `subsets` ranks of every column, from a start that is uniform
 * in a half's first visit: a pixel is sampled with probability subsets / n in each visit, and once
 * in any n passes, however they were cut into visits. */
static int lattice_view(const lf_visit *visit, int column, int j)
{
    return (int)((int64_t)visit->step * (column + visit->start + j) % visit->rig->n_views);
}

/* 1 / step modulo n. */
static int lattice_inverse(int step, int n)
{
    int inverse = 1;
    while ((int64_t)step * inverse % n != 1 % n)
        inverse++;
    return inverse;
}

bool lf_lattice_has(const lf_visit *visit, int view, int column)
{
    for (int j = 0; j < visit->subsets; j++)
        if (lattice_view(visit, column, j) == view)
            return true;
    return false;
}

/* D R over the mean of D of the base's own ray, a channel each; R stands in factor[c * LF_LANES]
 * for what the pivot's place makes of it, and is completed here where `corrected`. */
static lf_vec3 own_channels(const lf_visit *visit, const lf_pivot *pivot, lf_rays *ray,
                            bool corrected, float factor)
{
    lf_scratch *w = visit->worker;
    float tau[3 * LF_LANES], r[3 * LF_LANES], d[3], sum = 0.0f, least = INFINITY;
    float length = sqrtf(1.0f + visit->plane.my * visit->plane.my + ray->slope[0] * ray->slope[0]);
    bool medium = pivot->event.kind == LF_EVENT_MEDIUM;
    lf_media_depths_of_channels(&w->media, visit->kernels, LF_LANES, ray->x0, ray->slope,
                                ray->z_end, tau, -1, NULL);
    for (int i = 0; i < 3 * LF_LANES; i++)
        r[i] = factor;
    ray->channels = true;
    if (corrected)
        lf_correction_transmittance(&w->media, ray, LF_CORRECTION_PIVOT, 0.0f, &w->tracer, r);
    for (int c = 0; c < 3; c++) {
        d[c] = medium ? w->media.item[pivot->medium].colour[c] : 1.0f;
        least = lf_min(least, d[c] > 0.0f ? tau[c * LF_LANES] : INFINITY);
    }
    for (int c = 0; c < 3; c++)
        sum += d[c] *= expf(length * (least - lf_max(tau[c * LF_LANES], least)));
    return lf_scale(lf_v3(d[0] * r[0], d[1] * r[LF_LANES], d[2] * r[2 * LF_LANES]), 3.0f / sum);
}

float lf_visit_correction(const lf_visit *visit, int view, const lf_pivot *pivot,
                          lf_vec3 *out_channels)
{
    lf_scratch *w = visit->worker;
    bool corrected =
        lf_correction_needed(&w->media) && !lf_has_fault(visit, LF_FAULT_NO_CORRECTION);
    *out_channels = lf_v3(1.0f, 1.0f, 1.0f);
    if (!corrected && !visit->scene->looks.chromatic)
        return 1.0f;
    float x0 = visit->rig->b[view] + pivot->lx, slope = (pivot->x - x0) / pivot->z, factor = 1.0f;
    float lanes[4][LF_LANES];
    if (corrected && pivot->event.kind == LF_EVENT_MEDIUM &&
        w->media.item[pivot->medium].kind == LF_MEDIUM_SLICE) {
        float sampled = lf_slice_density(&w->media.item[pivot->medium].slice, x0, slope, pivot->z);
        float density = lf_correction_density(&w->media, pivot->medium, visit->scene,
                                              pivot->event.p, sampled, &w->tracer);
        factor = sampled > 0.0f ? density / sampled : 1.0f;
    }
    if (!(factor > 0.0f))
        return 0.0f;
    for (int k = 0; k < LF_LANES; k++) {
        lanes[0][k] = x0;
        lanes[1][k] = slope;
        lanes[2][k] = pivot->z;
        lanes[3][k] = factor;
    }
    lf_rays ray = {visit->scene, visit->rig, &visit->plane, visit->kernels, LF_LANES,
                   lanes[0],     lanes[1],   lanes[2],      0.0f,           false};
    if (visit->scene->looks.chromatic) {
        *out_channels = own_channels(visit, pivot, &ray, corrected, factor);
        return 1.0f;
    }
    lf_correction_transmittance(&w->media, &ray, LF_CORRECTION_PIVOT, 0.0f, &w->tracer, lanes[3]);
    return lanes[3][0];
}

/* ------------------------------------------------------------------------------ base samples -- */

/* A base ray in its row's plane; returns its direction. */
static lf_vec3 make_ray(const lf_visit *visit, int view, float u, float lx, lf_media_ray *ray)
{
    const lf_rig *rig = visit->rig;
    ray->x0 = rig->b[view] + lx;
    ray->slope = lf_rig_slope(rig, view, u) - lx / rig->focus;
    ray->length = sqrtf(1.0f + ray->slope * ray->slope + visit->plane.my * visit->plane.my);
    ray->z_end = INFINITY;
    return lf_scale(lf_rig_direction(rig, ray->slope, visit->plane.my, 1.0f), 1.0f / ray->length);
}

void lf_pivot_begin(lf_pivot *pivot, lf_vec3 w, float lens, lf_sampler *sampler)
{
    lf_event *event = &pivot->event;
    event->w = w;
    event->from = event->channels = event->left = lf_v3(0.0f, 0.0f, 0.0f);
    event->t = event->surface = 0.0f;
    event->interior = NULL;
    event->nest.n = 0;
    event->flesh = (lf_flesh){0};
    pivot->lx = lens;
    pivot->boost = 0.0f;
    pivot->is_pane = false;
    pivot->sampler = sampler;
}

/* film: where in the pixel, 0..1; < 0 = drawn. What is found is shared, or only its delta lobe
 * followed (native_only). */
static void base_sample(const lf_visit_plan *plan, lf_visit *visit, int view, int column,
                        float film, bool native_only, uint64_t key, uint32_t index)
{
    lf_scratch *worker = visit->worker;
    const lf_rig *rig = visit->rig;
    lf_sampler sampler;
    uint64_t pixel = lf_hash64(key, (uint64_t)view * (uint64_t)rig->width + (uint64_t)column + 16);
    worker->base_paths++;
    if (column < worker->reach.first[view] || column >= worker->reach.end[view])
        return; /* it escapes */
    lf_sampler_init(&sampler, plan->sampler, pixel, index);
    worker->tracer.rng = lf_hash64(pixel ^ visit->random, ~(uint64_t)index);

    float jitter[2], lens = 0.0f;
    lf_sampler_2d(&sampler, jitter);
    if (visit->plane.lens_chord > 0.0f)
        lens = (2.0f * lf_sampler_1d(&sampler) - 1.0f) * visit->plane.lens_chord;
    lf_media_ray ray;
    lf_vec3 w = make_ray(visit, view, (float)column + (film < 0.0f ? jitter[0] : film), lens, &ray);

    lf_pivot pivot;
    lf_event *event = &pivot.event;
    lf_pivot_begin(&pivot, w, lens, &sampler);
    lf_vec3 eye = lf_rig_point(rig, ray.x0, visit->plane.ly, 0.0f);
    worker->tracer.width = 0.0f;
    worker->tracer.spread = lf_rig_spread(rig) / ray.length;
    bool surface = lf_trace_seen(&worker->tracer, eye, w, INFINITY, &event->hit);
    bool pane = surface && event->hit.material->glass.is_pane;
    bool shared = surface && (event->hit.material->has_lobe || pane);
    bool native = surface && (shared || event->hit.material->has_delta);
    lf_hit first;
    if (visit->scene->looks.paned && plan->order.cover && !native)
        native =
            lf_trace_pane(&worker->tracer, eye, w, 0.0f, surface ? event->hit.t : INFINITY, &first);
    if (surface)
        ray.z_end = event->hit.t / ray.length;
    /* Rays that end on a scattering surface are tracked natively also where collisions are forced.
     */
    int channel = plan->scene->looks.chromatic ? (int)(3.0f * lf_sampler_1d(&sampler)) : 0;
    lf_collision collision = lf_media_collide(&worker->media, &ray, channel, jitter[1],
                                              plan->order.cover && !native, &worker->tracer);
    bool natives = native_only || lf_natives_by_base(visit, view, column);
    if (visit->scene->looks.paned && natives && visit->sums.native) {
        float t_end = surface ? event->hit.t : INFINITY;
        if (collision.z < INFINITY)
            t_end = collision.z * ray.length;
        lf_natives_of_panes(visit, view, column, &pivot, eye, t_end);
    }
    if (collision.z < INFINITY && !native_only) {
        event->kind = LF_EVENT_MEDIUM;
        pivot.z = collision.z;
        pivot.x = ray.x0 + ray.slope * pivot.z;
        pivot.medium = collision.medium;
        pivot.boost = collision.boost * visit->weight;
        event->p = lf_rig_point(rig, pivot.x, visit->plane.ly + visit->plane.my * pivot.z, pivot.z);
        event->volume = worker->media.item[collision.medium].volume;
        if (visit->queue)
            lf_queue_push(visit->queue, visit, view, column, &pivot);
        else
            visit->acting->pivot(visit, view, column, &pivot, NULL);
    } else if (surface && !(collision.z < INFINITY)) {
        lf_vec3 d = lf_sub(event->hit.p, rig->eye);
        event->kind = LF_EVENT_SURFACE;
        event->p = event->hit.p;
        pivot.is_pane = pane;
        pivot.boost = visit->weight;
        pivot.x = lf_dot(d, rig->right);
        pivot.z = lf_dot(d, rig->forward);
        if (natives && !pane)
            lf_natives_of_surface(visit, view, column, &pivot);
        if (shared && !native_only)
            visit->acting->pivot(visit, view, column, &pivot, NULL);
    }
}

/* ------------------------------------------------------------------------------------- visit -- */

/* Native samples that a visit takes of each pixel with a delta lobe: one, so that the shortest
 * visit shows a mirror's image whole; two where sharing takes so many that they are six or fewer
 * for each of its samples. */
static int mirror_rounds(const lf_visit_plan *plan)
{
    enum { MIRROR_TIMES = 6 };
    if (!plan->scene->has_delta || plan->order.column_step > 1)
        return 0;
    return MIRROR_TIMES * plan->order.subsets < 2 * plan->rig->n_views ? 1 : 2;
}

/* The lights in the media of the row, as seen in its plane. */
static void cut_glows(lf_visit *visit)
{
    lf_scratch *w = visit->worker;
    int base = 0;
    for (int k = 0; k < visit->rig->n_views && w->media.n_here > 0; k++)
        base += w->reach.end[k] - w->reach.first[k];
    lf_glow_row_init(&w->glows, visit->scene, visit->rig, &visit->plane, &w->media, (float)base,
                     visit->sharing->entry.shares ? 1.0f : (float)visit->rig->n_views);
}

static void cut_meshes(const lf_visit_plan *plan, const lf_visit *visit)
{
    lf_scratch *w = visit->worker;
    bool veils = plan->scene->looks.veiled;
    lf_section_cut(&w->section, plan->triangles, plan->scene, plan->rig, visit->row, &visit->plane,
                   veils ? LF_CUT_OPAQUE : LF_CUT_ALL);
    if (veils)
        lf_section_cut(&w->veil.section, plan->triangles, plan->scene, plan->rig, visit->row,
                       &visit->plane, LF_CUT_VEILS);
}

lf_veils lf_visit_veils(const lf_visit *visit)
{
    return (lf_veils){&visit->worker->veil.section, visit->triangles, visit->scene, visit->rig,
                      &visit->plane};
}

/* Draws the moment of a visit, where anything moves. */
static void set_moment(const lf_visit_plan *plan, lf_visit *visit, uint64_t key, uint32_t index)
{
    float time = lf_sampler_radical(lf_hash64(key, 17), index);
    if (lf_has_fault(&plan->order, LF_FAULT_NO_TIME))
        time = 0.5f;
    lf_moment_set(plan->moment, plan->moving, time);
    visit->worker->tracer.time = time;
    if (lf_has_fault(&plan->order, LF_FAULT_OTHER_TIME))
        visit->worker->tracer.time = 1.0f - time;
}

/* Draws the plane of a visit, or another of its outlines, and cuts the volumes with it. offsets
 * names the sequence of row offsets. */
static void cut_at(const lf_visit_plan *plan, lf_visit *visit, uint64_t key, uint64_t offsets,
                   uint32_t index, int number)
{
    const float lens[2] = {lf_sampler_radical(lf_hash64(key, 1), index),
                           lf_sampler_radical(lf_hash64(key, 2), index)};
    const float phase[2] = {lf_sampler_radical(lf_hash64(key, 15), index),
                            lf_sampler_radical(lf_hash64(key, 4), index)};
    const float offset = lf_outlines_row(offsets, index, number);
    lf_rig_row_plane(plan->rig, (float)visit->row + offset, lens, &visit->plane);
    lf_media_cut(&visit->worker->media, plan->frame, plan->scene->volumes, plan->rig, &visit->plane,
                 phase, plan->kernels, &visit->worker->tracer.lookups);
    lf_media_cut(&visit->worker->shine.flames, plan->flames, plan->scene->flames.field, plan->rig,
                 &visit->plane, phase, plan->kernels, &visit->worker->tracer.lookups);
    if (plan->triangles)
        cut_meshes(plan, visit);
    if (plan->skip & LF_SKIP_BACKGROUND)
        lf_reach_of(&visit->worker->reach, plan->scene, plan->rig, &visit->plane,
                    &visit->worker->media, &visit->worker->shine.flames);
    else
        lf_reach_whole(&visit->worker->reach, plan->rig);
    cut_glows(visit);
}

/* Draws the moment and the plane of a visit. */
static void cut(const lf_visit_plan *plan, lf_visit *visit, uint64_t key, uint64_t offsets,
                uint32_t index)
{
    if (plan->moment)
        set_moment(plan, visit, key, index);
    cut_at(plan, visit, key, offsets, index, 0);
}

/* B, q and features of a visit. It finds the visit's plane cut, and leaves it so. */
static void find_known(const lf_visit_plan *plan, lf_visit *visit, uint64_t key, uint64_t offsets,
                       uint32_t index)
{
    lf_exits_row(plan, visit, key, index, false);
    for (int i = 1; i < lf_outlines_planes(index) && visit->outlines; i++) {
        cut_at(plan, visit, key, offsets, index, i);
        lf_exits_outlines(plan, visit, key, index, i);
    }
    if (visit->outlines)
        cut_at(plan, visit, key, offsets, index, 0);
}

static void begin(const lf_visit_plan *plan, lf_visit *visit)
{
    visit->scene = plan->scene;
    visit->rig = plan->rig;
    visit->kernels = plan->kernels;
    visit->acting = visit->sharing = plan->sharing;
    visit->triangles = plan->triangles;
    visit->max_depth = plan->max_depth;
    visit->subsets = plan->order.subsets;
    visit->step = lattice_step(plan->rig->n_views);
    visit->weight = 1.0f;
    visit->alone = 1.0f;
    visit->mirror_rounds = mirror_rounds(plan);
    visit->more = plan->order.subsets > 0 ? (float)(visit->mirror_rounds * plan->rig->n_views) /
                                                (float)plan->order.subsets
                                          : 0.0f;
    visit->pilot = plan->pilot;
    visit->sunlight = plan->order.sunlight;
    visit->faults = plan->order.faults;
    visit->worker->tracer.scene = plan->scene;
    lf_channels *channels = &visit->worker->channels;
    int lanes = (plan->rig->n_views + LF_LANES - 1) / LF_LANES * LF_LANES;
    for (int c = 0; c < 3; c++)
        channels->received[c] =
            plan->scene->looks.chromatic ? channels->density + c * lanes : visit->worker->density;
}

static uint64_t key_of(uint64_t random, int row, int half)
{
    return lf_hash64(lf_hash64(random, (uint64_t)row), (uint64_t)half);
}

static uint64_t stream(const lf_visit_plan *plan, int row, int half)
{
    return key_of(plan->order.random, row, half);
}

/* What the stream has given the row so far. */
static const lf_film_counts *given_by(const lf_visit_plan *plan, int row)
{
    return &plan->film->streams[plan->order.stream].rows[row];
}

static bool cancelled(const lf_cancel *cancel)
{
    return cancel && atomic_load_explicit(cancel, memory_order_relaxed);
}

/* Every pixel of the lattice once; false = cancelled. */
static bool sample_lattice(const lf_visit_plan *plan, lf_visit *visit, int first, int64_t passes,
                           uint64_t key, const lf_cancel *cancel)
{
    for (int column = first; column < plan->rig->width; column += plan->order.column_step) {
        for (int j = 0; j < plan->order.subsets; j++) {
            if (cancelled(cancel))
                return false;
            /* So many samples the pixel has had. */
            uint32_t point = (uint32_t)((passes + j) / plan->rig->n_views);
            base_sample(plan, visit, lattice_view(visit, column, j), column, -1.0f, false, key,
                        point);
        }
    }
    return true;
}

/* As many samples as the map expects: a pixel's count runs on from visit to visit, rounded down
 * behind a start that the lattice spreads over the pixels, so that each gets its own number on
 * average and is never a sample away from it. false = cancelled. */
static bool sample_counts(const lf_visit_plan *plan, lf_visit *visit, double n, double first,
                          uint64_t key, const lf_cancel *cancel)
{
    int width = plan->rig->width, views = plan->rig->n_views,
        inverse = lattice_inverse(visit->step, views);
    double share = (double)plan->order.subsets / views;
    for (int column = 0; column < width; column++) {
        for (int view = 0; view < views; view++) {
            double expected =
                (double)visit->expected[(size_t)view * (size_t)width + (size_t)column];
            double rank = (double)(((int64_t)inverse * view - column) % views) - first;
            double phase = rank / views - floor(rank / views);
            uint32_t begin = (uint32_t)floor(phase + expected * n),
                     end = (uint32_t)floor(phase + expected * (n + share));
            /* Behind a sure sample the realised number is as good as the expected one, and has no
             * noise of its own. */
            double count = expected * share < 1.0 ? expected * share : (double)(end - begin);
            visit->alone = end > begin ? (float)(share / count) : 1.0f;
            for (uint32_t i = begin; i < end; i++) {
                if (cancelled(cancel))
                    return false;
                base_sample(plan, visit, view, column, -1.0f, false, key, i);
            }
        }
    }
    visit->alone = 1.0f;
    return true;
}

/* Native samples for holes, in the plane of one visit, until none is left farther than hole_reach
 * columns from a pixel that has something; the first of a pixel at the film point of B and q in
 * that visit, or one of its outlines in another plane. tries = 0: what is left counts as dark from
 * now on. *out_left: how many there are. false = cancelled. */
static bool fill_holes(const lf_visit_plan *plan, lf_visit *visit, int half, int tries,
                       uint64_t exits, uint32_t index, int plane, int *out_left,
                       const lf_cancel *cancel)
{
    const lf_film_row *state = &plan->film->rows[visit->row];
    const lf_film_half halves[2] = {lf_film_at(plan->film, visit->row, 0),
                                    lf_film_at(plan->film, visit->row, 1)};
    int width = plan->rig->width;
    uint64_t own = lf_hash64(exits, 6 + 16 * (uint64_t)tries + 1024 * (uint64_t)plane);
    *out_left = 0;
    for (int view = 0; view < plan->rig->n_views; view++) {
        for (int column = 0, filled = -1; column < width; column++) {
            size_t pixel = (size_t)view * (size_t)width + (size_t)column;
            /* Nobody reads it. */
            if (visit->expected && !(visit->expected[pixel] > 0.0f))
                continue;
            bool far = column - filled >= plan->order.hole_reach;
            for (int i = 0; i < tries && far && lf_film_is_hole(halves, state->n, pixel); i++) {
                float film = i > 0 ? -1.0f : lf_outlines_column(exits, column, index, plane);
                if (cancelled(cancel))
                    return false;
                base_sample(plan, visit, view, column, film, false, own,
                            index * (uint32_t)tries + (uint32_t)i);
            }
            bool hole = lf_film_is_hole(halves, state->n, pixel);
            if (hole && far && tries == 0)
                lf_film_settle(&halves[half], pixel);
            *out_left += hole && far;
            filled = hole && !(far && tries == 0) ? filled : column;
        }
    }
    return true;
}

/* Planes that a visit has found B and q in, at most: index is its number in its half. */
static int planes_of(const lf_visit_plan *plan, int64_t index)
{
    const bool outlines = plan->triangles && plan->film->layout.has_features && !plan->order.coarse;
    return outlines ? lf_outlines_planes((uint32_t)index) : 1;
}

/* Fills holes in the planes of earlier visits of a stream, of which the first of `now` is left out
 * (< 0: of none). false = cancelled. */
static bool replay(const lf_visit_plan *plan, lf_visit *visit, int half, int64_t now,
                   const lf_film_stream *from, int *left, const lf_cancel *cancel)
{
    enum { REPLAYS = 8 };
    for (int i = 0; *left > 0 && i < 2 * REPLAYS; i++) {
        int other = i % 2 ? 1 - half : half;
        int64_t index = (int64_t)from->rows[visit->row].visits[other] - 1 - i / 2;
        uint64_t key = key_of(lf_film_stream_random(from), visit->row, other);
        const int first = other == half && index == now ? 1 : 0,
                  end = index >= 0 ? planes_of(plan, index) : 0;
        if (first < end && plan->moment)
            set_moment(plan, visit, key, (uint32_t)index);
        for (int plane = first; *left > 0 && plane < end; plane++) {
            cut_at(plan, visit, key, lf_hash64(key, 0), (uint32_t)index, plane);
            if (!fill_holes(plan, visit, half, 1, key, (uint32_t)index, plane, left, cancel))
                return false;
        }
    }
    return true;
}

/* Fills the holes of a row: in the plane of the visit that has just been (now; < 0: none has),
 * where most are found at once, then in those of earlier visits, one of which has found that
 * something scatters there: of the pass's stream, then of the others. Each sample weighs as much as
 * the half's count so far (docs/estimators.md, "Holes"). What only older visits have met counts as
 * dark until a path arrives, whose weight is beyond comparison. false = cancelled. */
static bool fill_row(const lf_visit_plan *plan, lf_visit *visit, int half, int64_t now,
                     const lf_cancel *cancel)
{
    enum { TRIES = 4 };
    const lf_film *film = plan->film;
    const lf_film_row *state = &plan->film->rows[visit->row];
    int left = 1;
    visit->acting = plan->native;
    visit->sums = lf_film_sums_of(plan->film, visit->row, half);
    visit->weight = (float)state->n[half];
    if (now >= 0 && !fill_holes(plan, visit, half, TRIES, stream(plan, visit->row, half),
                                (uint32_t)now, 0, &left, cancel))
        return false;
    if (!replay(plan, visit, half, now, &film->streams[plan->order.stream], &left, cancel))
        return false;
    for (int i = 0; i < film->n_streams && left > 0; i++)
        if (i != plan->order.stream &&
            !replay(plan, visit, half, -1, &film->streams[i], &left, cancel))
            return false;
    return left == 0 || fill_holes(plan, visit, half, 0, 0, 0, 0, &left, cancel);
}

/* Delta lobes are nobody else's to find. Pixels whose film point of B and q met one get native
 * samples of their own, as many each. The film points are a net with the row offsets. The choice of
 * the pixels knows nothing of the samples: their number is what the weights expect (native.c).
 * false = cancelled. */
static bool sample_mirrors(const lf_visit_plan *plan, lf_visit *visit, uint64_t key, uint32_t index,
                           const lf_cancel *cancel)
{
    for (int view = 0; view < plan->rig->n_views; view++) {
        for (int column = 0; column < plan->rig->width; column++) {
            size_t pixel = (size_t)view * (size_t)plan->rig->width + (size_t)column;
            bool wanted = !visit->expected || visit->expected[pixel] > 0.0f;
            if (!visit->worker->mirrors[pixel] || !wanted)
                continue;
            for (int i = 0; i < visit->mirror_rounds; i++) {
                uint64_t own = lf_hash64(lf_hash64(key, 12), (uint64_t)i);
                float film = lf_sampler_partner(lf_hash64(key, 0), lf_hash64(own, pixel), index);
                if (cancelled(cancel))
                    return false;
                base_sample(plan, visit, view, column, film, true, own, index);
            }
        }
    }
    return true;
}

/* B, q and features of a row without base samples, but where it lies between rows that change
 * little; of delta lobes, which are in B, it has some. false = cancelled. */
static bool put_provisional(const lf_visit_plan *plan, lf_visit *visit, uint64_t key,
                            uint32_t index, const lf_cancel *cancel)
{
    lf_scratch *w = visit->worker;
    lf_between rows;
    const bool between = !w->mirrors && lf_between_find(plan->film, visit->row, &rows);
    if (between && lf_between_mark(&rows, visit->rig, w->met.smooth))
        return true; /* all of it: it is as good as missing */
    cut(plan, visit, key, lf_hash64(key, 0), index);
    const bool known = w->reach.any || plan->film->layout.has_known;
    if (w->sums.native)
        lf_film_sums_begin(&w->sums);
    if (known)
        lf_exits_row(plan, visit, key, index, between);
    if (visit->rig->n_views == 1)
        visit->more -= 1.0f; /* no base sample beside them (native.c) */
    if (known && visit->mirror_rounds > 0 && !sample_mirrors(plan, visit, key, index, cancel))
        return false;
    lf_film_put_provisional(plan->film, visit->row, known ? &w->sums : NULL, plan->order.subsets);
    return true;
}

bool lf_visit_row(const lf_visit_plan *plan, int row, int half, lf_scratch *worker,
                  const lf_cancel *cancel)
{
    const lf_film_row *state = &plan->film->rows[row];
    int width = plan->rig->width, views = plan->rig->n_views;
    if (plan->order.subsets == 0 && !(state->n[half] > 0.0))
        half = 1 - half; /* holes are filled where there is a count to weigh as much as */
    const lf_film_counts *before = given_by(plan, row);
    uint32_t index = before->visits[half];
    uint64_t key = stream(plan, row, half);
    lf_visit visit = {.worker = worker, .sums = worker->sums, .row = row};
    begin(plan, &visit);
    visit.random = lf_hash64(lf_hash64(key, 3), index);
    if (plan->counts) {
        lf_counts_row(plan->counts, row, worker->expected);
        visit.expected = worker->expected;
    }
    if (plan->order.subsets == 0)
        return fill_row(plan, &visit, half, -1, cancel);
    if (plan->order.fans)
        return put_provisional(plan, &visit, key, index, cancel);
    if (plan->moment)
        set_moment(plan, &visit, key, index);
    visit.outlines = planes_of(plan, index) > 1 && lf_outlines_find(plan, &visit);
    cut_at(plan, &visit, key, lf_hash64(key, 0), index, 0);
    double first_rank = (double)(lf_sampler_radical(lf_hash64(key, 11), 0) * (float)views);
    int64_t passes = llround(before->n[half] * views);
    visit.start =
        (int)(lf_sampler_radical(lf_hash64(key, 7), 0) * (float)views) + (int)(passes % views);

    double given = (double)plan->order.subsets / plan->order.column_step;
    int first = plan->order.column_step > 1
                    ? (int)((visit.random >> 32) % (uint64_t)plan->order.column_step)
                    : 0;
    if (!lf_film_meet(plan->film, row, worker->reach.any || visit.outlines)) {
        worker->base_paths +=
            (int64_t)plan->order.subsets *
            ((width - first + plan->order.column_step - 1) / plan->order.column_step);
        lf_film_count(plan->film, plan->order.stream, row, half, given);
        return true;
    }
    lf_film_sums_begin(&worker->sums);
    worker->sums.coarse = plan->order.coarse;
    if (!lf_film_wants_albedo(plan->film, row))
        visit.sums.albedo = NULL;
    if (lf_has_fault(&plan->order, LF_FAULT_OTHER_ROW))
        cut(plan, &visit, key, lf_hash64(key, 8), index);
    find_known(plan, &visit, key,
               lf_hash64(key, lf_has_fault(&plan->order, LF_FAULT_OTHER_ROW) ? 8 : 0), index);
    if (lf_has_fault(&plan->order, LF_FAULT_OTHER_ROW))
        cut(plan, &visit, key, lf_hash64(key, 0), index);
    visit.queue = plan->queue;
    if (visit.queue)
        lf_suffix_batch_clear(&visit.queue->batch); /* a cancelled visit may have left some */
    if (visit.expected
            ? !sample_counts(plan, &visit, before->n[half], first_rank, lf_hash64(key, 13), cancel)
            : !sample_lattice(plan, &visit, first, passes, key, cancel))
        return false;
    if (visit.queue)
        lf_queue_flush(visit.queue, &visit);
    visit.queue = NULL;
    if (!lf_glow_visit(plan, &visit, (float)(given / views), cancel))
        return false;
    if (visit.mirror_rounds > 0 && !sample_mirrors(plan, &visit, key, index, cancel))
        return false;
    lf_film_merge(plan->film, plan->order.stream, row, half, &worker->sums, given,
                  lf_hash64(lf_hash64(key, 9), index));
    return plan->order.hole_reach < 0 || fill_row(plan, &visit, half, index, cancel);
}
