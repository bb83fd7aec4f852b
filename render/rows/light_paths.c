#include "render/rows/light_paths.h"

#include <string.h>

#include "base/alloc.h"
#include "render/rows/light_connect.h"
#include "render/rows/native.h"
#include "render/transport/sampler.h"

/* Paths of a chunk: enough that its list is cheap, few enough for many workers. */
enum { CHUNK = 512 };

bool lf_light_paths_serve(const lf_scene *scene, const lf_render_settings *settings)
{
    const lf_traits has = scene->traits | lf_view_traits(settings);
    return scene->embree && !(has & ~(LF_TRAITS_SURFACE_SCENES & ~LF_TRAIT_OVERLAPS));
}

/* ---------------------------------------------------------------------------------- the sets -- */

/* The number of light paths of a visit. */
static int64_t paths_of(const lf_light_paths *paths, const lf_visit_order *order)
{
    return (int64_t)paths->plan.per_pass * order->subsets / order->column_step;
}

/* A set for this half and number, of which there is one for most passes. NULL: out of memory. */
static lf_light_set *set_for(lf_light_paths *paths, const lf_visit_order *order, int half,
                             uint32_t index)
{
    for (int i = 0; i < paths->n_sets; i++)
        if (paths->sets[i].half == half && paths->sets[i].index == index)
            return &paths->sets[i];
    if (paths->n_sets == paths->sets_allocated) {
        const int n = 2 * paths->sets_allocated + 1;
        lf_light_set *grown = lf_calloc((size_t)n, sizeof *grown);
        if (!grown)
            return NULL;
        if (paths->n_sets > 0)
            memcpy(grown, paths->sets, (size_t)paths->n_sets * sizeof *grown);
        lf_free(paths->sets);
        paths->sets = grown;
        paths->sets_allocated = n;
    }
    lf_light_set *set = &paths->sets[paths->n_sets];
    if (!set->row_end)
        set->row_end = lf_calloc((size_t)paths->rig->height + 1, sizeof *set->row_end);
    if (!set->row_end)
        return NULL;
    set->half = half;
    set->index = index;
    set->key = lf_hash64(lf_hash64(lf_hash64(order->random, 18), (uint64_t)half), index);
    set->n = paths_of(paths, order);
    paths->n_sets++;
    return set;
}

/* Finds the sets of the pass's rows. */
static lf_status find_sets(lf_light_paths *paths, const lf_pass *pass, const lf_film *film)
{
    const lf_film_stream *stream = &film->streams[pass->order->stream];
    paths->n_sets = 0;
    for (int row = 0; row < film->height; row++)
        paths->set_of[row] = -1;
    for (int i = 0; i < pass->n_rows; i++) {
        const int row = pass->first_row + i * pass->row_step;
        const lf_film_counts *given = &stream->rows[row];
        if (lf_pass_has_had(pass, given))
            continue;
        const int half = lf_pass_half(pass, given);
        const lf_light_set *set = set_for(paths, pass->order, half, given->visits[half]);
        if (!set)
            return LF_E_NOMEM;
        paths->set_of[row] = (int)(set - paths->sets);
    }
    return LF_OK;
}

static lf_status make_chunks(lf_light_paths *paths)
{
    int n = 0;
    for (int i = 0; i < paths->n_sets; i++) {
        lf_light_set *set = &paths->sets[i];
        set->first_chunk = n;
        set->n_chunks = (int)((set->n + CHUNK - 1) / CHUNK);
        n += set->n_chunks;
    }
    paths->n_chunks = n;
    if (n <= paths->chunks_allocated)
        return LF_OK;
    lf_light_chunk *grown = lf_calloc((size_t)n, sizeof *grown);
    if (!grown)
        return LF_E_NOMEM;
    if (paths->chunks_allocated > 0)
        memcpy(grown, paths->chunks, (size_t)paths->chunks_allocated * sizeof *grown);
    lf_free(paths->chunks);
    paths->chunks = grown;
    paths->chunks_allocated = n;
    return LF_OK;
}

/* -------------------------------------------------------------------------------- the chunks -- */

/* One chunk while it is traced. */
typedef struct tracing {
    const lf_light_paths *paths;
    int set;
    lf_light_chunk *chunk;
    bool failed; /* out of memory */
} tracing;

static bool wants(void *context, int row)
{
    const tracing *t = context;
    return t->paths->set_of[row] == t->set;
}

static bool grow(lf_light_chunk *chunk)
{
    const size_t n = chunk->allocated > 0 ? 2 * chunk->allocated : 256;
    lf_light_splat *splats = lf_calloc(n, sizeof *splats);
    uint32_t *rows = lf_calloc(n, sizeof *rows);
    if (!splats || !rows) {
        lf_free(splats);
        lf_free(rows);
        return false;
    }
    if (chunk->n > 0) {
        memcpy(splats, chunk->splats, chunk->n * sizeof *splats);
        memcpy(rows, chunk->rows, chunk->n * sizeof *rows);
    }
    lf_free(chunk->splats);
    lf_free(chunk->rows);
    chunk->splats = splats;
    chunk->rows = rows;
    chunk->allocated = n;
    return true;
}

static void take(void *context, int row, size_t pixel, lf_vec3 rgb)
{
    tracing *t = context;
    lf_light_chunk *chunk = t->chunk;
    if (chunk->n == chunk->allocated && !grow(chunk)) {
        t->failed = true;
        return;
    }
    chunk->splats[chunk->n] = (lf_light_splat){{rgb.x, rgb.y, rgb.z}, (uint32_t)pixel};
    chunk->rows[chunk->n++] = (uint32_t)row;
}

typedef struct trace_job {
    lf_light_paths *paths;
    unsigned faults;
    atomic_int failed;
} trace_job;

static void trace_chunk(void *context, int item, int worker)
{
    trace_job *job = context;
    lf_light_paths *paths = job->paths;
    int i = 0;
    while (item >= paths->sets[i].first_chunk + paths->sets[i].n_chunks)
        i++;
    const lf_light_set *set = &paths->sets[i];
    tracing t = {.paths = paths, .set = i, .chunk = &paths->chunks[item]};
    lf_light_connect connect;
    lf_light_connect_init(&connect, paths->scene, paths->rig, &paths->workers[worker],
                          &paths->plan);
    connect.visit.faults = job->faults;
    connect.sink = (lf_light_sink){.context = &t, .wants = wants, .take = take};
    t.chunk->n = 0;
    const int64_t first = (int64_t)(item - set->first_chunk) * CHUNK,
                  end = first + CHUNK < set->n ? first + CHUNK : set->n;
    for (int64_t path = first; path < end; path++)
        lf_light_connect_path(&connect, lf_hash64(set->key, (uint64_t)path), paths->max_depth,
                              paths->alone);
    if (t.failed)
        atomic_store_explicit(&job->failed, 1, memory_order_relaxed);
}

/* Sorts the splats of a set by row; within a row they stay in the order of their paths. */
static lf_status sort_set(lf_light_paths *paths, lf_light_set *set)
{
    const lf_light_chunk *chunks = &paths->chunks[set->first_chunk];
    size_t n = 0;
    memset(set->row_end, 0, ((size_t)paths->rig->height + 1) * sizeof *set->row_end);
    for (int c = 0; c < set->n_chunks; c++) {
        n += chunks[c].n;
        for (size_t i = 0; i < chunks[c].n; i++)
            set->row_end[chunks[c].rows[i] + 1]++;
    }
    if (n > set->allocated) {
        lf_free(set->sorted);
        set->allocated = 0;
        set->sorted = lf_calloc(n + n / 2, sizeof *set->sorted);
        if (!set->sorted)
            return LF_E_NOMEM;
        set->allocated = n + n / 2;
    }
    /* row_end[i + 1] is the count of row i; shifted by one more, it becomes where the row goes on
     */
    size_t sum = 0;
    for (int row = 0; row < paths->rig->height; row++) {
        const size_t count = set->row_end[row + 1];
        set->row_end[row + 1] = sum;
        sum += count;
    }
    for (int c = 0; c < set->n_chunks; c++)
        for (size_t i = 0; i < chunks[c].n; i++)
            set->sorted[set->row_end[chunks[c].rows[i] + 1]++] = chunks[c].splats[i];
    return LF_OK;
}

lf_status lf_light_paths_begin(lf_light_paths *paths, const lf_pass *pass, const lf_film *film,
                               const lf_cancel *cancel)
{
    trace_job job = {.paths = paths, .faults = pass->order->faults};
    paths->n_sets = 0;
    paths->emitters.faults = pass->order->faults;
    if (pass->order->subsets == 0 || pass->order->fans)
        return LF_OK;
    lf_status status = find_sets(paths, pass, film);
    if (status == LF_OK)
        status = make_chunks(paths);
    if (status == LF_OK)
        status = lf_pool_run(paths->pool, paths->n_chunks, trace_chunk, &job, cancel);
    if (status == LF_OK && atomic_load_explicit(&job.failed, memory_order_relaxed))
        status = LF_E_NOMEM;
    for (int i = 0; i < paths->n_sets && status == LF_OK; i++)
        status = sort_set(paths, &paths->sets[i]);
    return status;
}

/* To M; or, if the film has features, to N, whose quotient by W the reconstruction filters. Not
 * where W is a mark (lf_film_settle). so_far: both halves. */
static void add_splat(lf_visit *visit, const lf_film_half so_far[2], const lf_light_splat *splat)
{
    const float *c = splat->rgb;
    const double *n = visit->plan->film->rows[visit->row].n;
    if (!visit->sums.feature)
        lf_visit_add_native(visit, splat->pixel, lf_v3(c[0], c[1], c[2]));
    else if (!isfinite(c[0] + c[1] + c[2]))
        visit->worker->tracer.nonfinite++;
    else if (lf_film_takes_light(so_far, n, visit->half, &visit->sums, splat->pixel))
        lf_film_scatter(&visit->sums, splat->pixel, c[0], c[1], c[2]);
}

void lf_light_paths_add(const lf_light_paths *paths, lf_visit *visit)
{
    const int i = paths->n_sets > 0 ? paths->set_of[visit->row] : -1;
    if (i < 0)
        return;
    const lf_light_set *set = &paths->sets[i];
    const lf_film_half so_far[2] = {lf_film_at(visit->plan->film, visit->row, 0),
                                    lf_film_at(visit->plan->film, visit->row, 1)};
    for (size_t s = set->row_end[visit->row]; s < set->row_end[visit->row + 1]; s++)
        add_splat(visit, so_far, &set->sorted[s]);
}

/* Light paths for each view pixel and native sample. */
#define PER_PIXEL 0.75
/* Most bytes of the splats of a pass. */
#define MOST_BYTES 2e8

/* Sets the number of paths for each pass. */
static void set_number(lf_light_paths *paths, double per_pass)
{
    const double most = LF_LIGHT_PATHS_MOST, n = fmin(fmax(per_pass, 2.0), most);
    paths->plan.per_pass = (int)(2.0 * floor(0.5 * n + 0.5));
    paths->plan.m =
        (float)paths->plan.per_pass * (paths->alone ? 1.0f : (float)paths->rig->n_views);
}

/* Runs the pilot. wanted: as in lf_render_settings. */
static lf_status choose(lf_light_paths *paths, int wanted)
{
    const lf_rig *rig = paths->rig;
    const lf_light_pilot pilot = {.scene = paths->scene,
                                  .rig = rig,
                                  .pool = paths->pool,
                                  .max_depth = paths->max_depth,
                                  .alone = paths->alone};
    double splats = 0.0;
    bool serves = true;
    bool *const asked = wanted < 0 ? &serves : NULL;
    set_number(paths, wanted > 0 ? wanted : PER_PIXEL * rig->width * rig->height);
    lf_status status = lf_light_pilot_asks(&pilot, &paths->plan, asked);
    if (status == LF_OK && !serves) {
        paths->plan.per_pass = 0;
        return LF_OK;
    }
    if (status == LF_OK)
        status = lf_light_pilot_learns(&pilot, &paths->emitters, &paths->plan, &splats);
    /* splats are stored twice: with their rows, and sorted */
    const double bytes = splats * rig->n_views * (2.0 * sizeof(lf_light_splat) + sizeof(uint32_t));
    if (status == LF_OK && wanted < 0 && bytes * paths->plan.per_pass > MOST_BYTES)
        set_number(paths, MOST_BYTES / bytes);
    if (status == LF_OK && wanted < 0 && !(splats > 0.0))
        paths->plan.per_pass = 0;
    return status;
}

lf_status lf_light_paths_init(lf_light_paths *paths, const lf_integrator_input *input,
                              const lf_scene *seen, const lf_rig *rig, bool alone)
{
    const lf_render_settings *settings = input->settings;
    *paths = (lf_light_paths){.scene = seen,
                              .rig = rig,
                              .pool = input->pool,
                              .max_depth = lf_max_depth(input->scene, settings->max_depth),
                              .alone = alone};
    if (settings->light_paths == 0 || !lf_light_paths_serve(input->scene, settings))
        return LF_OK;
    lf_status status = lf_emitters_init(&paths->emitters, seen);
    if (status != LF_OK || !lf_emitters_any(&paths->emitters))
        return status;
    paths->set_of = lf_calloc((size_t)rig->height, sizeof *paths->set_of);
    if (!paths->set_of)
        return LF_E_NOMEM;
    paths->plan.emitters = &paths->emitters;
    paths->plan.splitting = LF_SPLITTING_NONE;
    return choose(paths, settings->light_paths);
}

void lf_light_paths_finish(lf_light_paths *paths)
{
    for (int i = 0; i < paths->chunks_allocated; i++) {
        lf_free(paths->chunks[i].splats);
        lf_free(paths->chunks[i].rows);
    }
    for (int i = 0; i < paths->sets_allocated; i++) {
        lf_free(paths->sets[i].row_end);
        lf_free(paths->sets[i].sorted);
    }
    lf_free(paths->chunks);
    lf_free(paths->sets);
    lf_free(paths->set_of);
    lf_emitters_finish(&paths->emitters);
    *paths = (lf_light_paths){0};
}
