#include "render/rows/light_pilot.h"

#include <string.h>

#include "base/alloc.h"
#include "render/rows/fan_steps.h"
#include "render/rows/light_connect.h"

/* Samples of the first part, and light paths of each part, in chunks. */
enum { PIVOTS = LF_PILOT_ACROSS * LF_PILOT_DOWN, ASKING_PATHS = 2048, ROUNDS = 3, CHUNK = 256 };
/* Light paths of a later round: a share of the view pixels, within limits. */
#define LEARNING_SHARE 0.15
/* Chunks of the first round, in which all vertices survive, and of later ones. */
enum { FIRST_LEARNING = 16, LEAST_LEARNING = 32, MOST_LEARNING = 512 };

/* The share of the variance from which light paths pay off. */
#define LEAST_SHARE 0.7
/* The share of it that the light paths of a pass must take in balance with camera paths. */
#define LEAST_BALANCED 0.25
/* Cost of connecting a vertex to all views, relative to that of a path up to there. */
#define COST_OF_RAYS 2.0
#define KEY UINT64_C(0x6c69676874706174)

/* ------------------------------------------------------------------------------ camera paths -- */

/* What light paths take from camera paths: nothing, their class, or what the balance gives them. */
typedef enum taken { NOTHING, CLASS, BALANCED, TAKEN } taken;

/* Two suffixes of one pivot. */
typedef struct pivot_sample {
    int tile;
    float mean;            /* of the light that the ray brings */
    float variance[TAKEN]; /* of what is left */
} pivot_sample;

typedef struct asking {
    const lf_light_pilot *pilot;
    const lf_light_plan *plan;
    lf_scratch *workers;
    pivot_sample *pivots; /* [PIVOTS] */
    double *found;        /* [chunks] variance of camera paths as light paths see it */
    bool *missed;         /* [chunks] whether camera paths cannot find some light */
    taken first, end;     /* what is sampled */
} asking;

static int view_of(const lf_light_pilot *pilot, int i)
{
    return lf_pilot_view(pilot->rig->n_views, i % LF_PILOT_ACROSS, i / LF_PILOT_ACROSS);
}

/* A camera ray. false: it meets no surface with a lobe. */
static bool draw_pivot(const lf_light_pilot *pilot, lf_tracer *tracer, int i, pivot_sample *out,
                       lf_event *event)
{
    const lf_rig *rig = pilot->rig;
    const int x = i % LF_PILOT_ACROSS, y = i / LF_PILOT_ACROSS;
    const float u = ((float)x + lf_rng(tracer)) / LF_PILOT_ACROSS * (float)rig->width,
                v = ((float)y + lf_rng(tracer)) / LF_PILOT_DOWN * (float)rig->height;
    out->tile = lf_pilot_part(rig, (int)lf_min(v, (float)(rig->height - 1)),
                              (int)lf_min(u, (float)(rig->width - 1)));
    return lf_pilot_pivot(tracer, rig, view_of(pilot, i), (const float[]){u, v}, event, &out->mean);
}

/* The scale of the balance for a direction, without visibility: a bound. */
static float balance_scale(const asking *a, int i, const lf_event *event, lf_vec3 wi)
{
    const lf_light_pilot *pilot = a->pilot;
    const lf_rig *rig = pilot->rig;
    const lf_pivot pivot = {.z = lf_dot(lf_sub(event->p, rig->eye), rig->forward)};
    const lf_visit visit = {.rig = rig};
    const bool alone = pilot->alone, many = !alone && lf_fan_is_glossy(pilot->scene, event);
    const int own = view_of(pilot, i), first = alone ? own : 0,
              end = alone ? own + 1 : rig->n_views;
    float over = 0.0f;
    for (int k = first; k < end; k++) {
        const lf_vec3 d = lf_sub(lf_rig_point(rig, rig->b[k], 0.0f, 0.0f), event->p);
        lf_vec3 f;
        over += fabsf(lf_dot(event->hit.ng, d)) *
                lf_scatter_eval(pilot->scene, event, lf_normalize(d), wi, &f);
    }
    over *= lf_fan_unit(&visit, &pivot) * (many ? (float)LF_GLOSSY_DIRECTIONS : 1.0f);
    return lf_light_balance_scale(a->plan->m * (float)(end - first), over);
}

/* Suffix k of pivot i, with the same numbers for all that is taken. */
static lf_vec3 sample_suffix(const asking *a, int i, int k, taken what, const lf_event *event,
                             lf_tracer *tracer)
{
    const lf_light_pilot *pilot = a->pilot;
    const uint64_t key = lf_hash64(lf_hash64(KEY, (uint64_t)i), (uint64_t)k + 1);
    lf_light_balance balance = {.emitters = a->plan->emitters, .scale = 1e30f};
    lf_suffix suffix = {0};
    lf_sampler sampler;
    tracer->rng = key;
    lf_sampler_init(&sampler, LF_SAMPLER_INDEPENDENT, key, 0);
    lf_pilot_suffix(tracer, event, &sampler, &suffix);
    if (what == BALANCED)
        balance.scale = balance_scale(a, i, event, suffix.wi);
    lf_pilot_follow(tracer, event, pilot->max_depth, what == NOTHING ? NULL : &balance, &suffix);
    return lf_pilot_radiance(pilot->scene, event, &suffix);
}

static void sample_pivot(const asking *a, int i, lf_tracer *tracer)
{
    pivot_sample *out = &a->pivots[i];
    lf_event event = {0};
    lf_vec3 y[TAKEN][2];
    tracer->rng = lf_hash64(KEY, (uint64_t)i);
    if (!draw_pivot(a->pilot, tracer, i, out, &event))
        return;
    for (int k = 0; k < 2; k++)
        for (taken what = a->first; what < a->end; what++)
            y[what][k] = sample_suffix(a, i, k, what, &event, tracer);
    for (taken what = a->first; what < a->end; what++)
        out->variance[what] = lf_pilot_variance(y[what][0], y[what][1]);
    if (a->first == NOTHING)
        out->mean += 0.5f * lf_mean3(lf_add(y[NOTHING][0], y[NOTHING][1]));
}

static void sample_pivots(void *context, int item, int worker)
{
    const asking *a = context;
    lf_tracer *tracer = &a->workers[worker].tracer;
    tracer->scene = a->pilot->scene;
    for (int i = item * CHUNK; i < (item + 1) * CHUNK; i++)
        sample_pivot(a, i, tracer);
}

/* The image in tiles. */
static void find_importance(const pivot_sample *pivots, lf_light_plan *plan)
{
    lf_pilot_light light = {0};
    for (int i = 0; i < PIVOTS; i++)
        lf_pilot_light_add(&light, pivots[i].tile, pivots[i].mean);
    for (int i = 0; i < LF_PILOT_PARTS; i++)
        plan->importance[i] = (float)(1.0 / (0.1 + lf_pilot_brightness(&light, i)));
}

/* ------------------------------------------------------------------------------- light paths -- */

/* What the light paths of a chunk bring. */
typedef struct bringing {
    const lf_light_connect *connect;
    double score; /* of the current vertex: its light relative to the brightness */
    double found; /* variance of camera paths that find the same light, weighted */
    double splats;
    bool missed;
} bringing;

static bool wants_all(void *context, int row)
{
    (void)context, (void)row;
    return true;
}

static void take_light(void *context, int row, size_t pixel, lf_vec3 rgb)
{
    bringing *b = context;
    const lf_light_plan *plan = b->connect->plan;
    const lf_rig *rig = b->connect->visit.rig;
    const float importance = lf_light_importance(plan, rig, row, (int)(pixel % (size_t)rig->width));
    b->score += (double)(lf_mean3(rgb) * plan->m * importance);
    b->splats += 1.0;
}

/* The variance of camera paths of one view that find the light of a vertex: E over light paths of
 * y^2 p_light / (over p_suffix), of which the balance keeps what light paths find well. */
static void close_asking(void *context, const lf_forward_vertex *vertex)
{
    bringing *b = context;
    const double m = (double)b->connect->plan->m, over = (double)b->connect->over,
                 a = m * (double)vertex->rate;
    if (!(b->score > 0.0))
        return;
    b->missed |= !isfinite(a);
    b->found += isfinite(a) ? b->score * b->score * (1.0 + a / over) / m : 0.0;
    b->score = 0.0;
}

static void ask_light(void *context, int item, int worker)
{
    asking *a = context;
    const lf_light_pilot *pilot = a->pilot;
    lf_light_connect connect;
    bringing b = {.connect = &connect};
    lf_light_connect_init(&connect, pilot->scene, pilot->rig, &a->workers[worker], a->plan);
    connect.sink = (lf_light_sink){&b, wants_all, take_light, close_asking};
    for (int i = item * CHUNK; i < (item + 1) * CHUNK; i++)
        lf_light_connect_path(&connect, lf_hash64(KEY, ~(uint64_t)i), pilot->max_depth, true);
    a->found[item] = b.found;
    a->missed[item] = b.missed;
}

/* Variance of camera paths, relative to the brightness. */
static double left_by(const asking *a, taken what)
{
    double sum = 0.0;
    for (int i = 0; i < PIVOTS; i++) {
        const double weight = (double)a->plan->importance[a->pivots[i].tile];
        sum += weight * weight * (double)a->pivots[i].variance[what] / PIVOTS;
    }
    return sum;
}

/* Whether light paths that take this reduce the variance by a share. */
static bool reduce(const asking *a, taken what, double least)
{
    const lf_rig *rig = a->pilot->rig;
    const double all = left_by(a, NOTHING);
    double found = 0.0;
    bool missed = false;
    for (int i = 0; i < ASKING_PATHS / CHUNK; i++) {
        found += a->found[i] / ASKING_PATHS;
        missed |= a->missed[i];
    }
    found /= (double)rig->width * rig->height;
    return missed || fmax(all - left_by(a, what), 0.0) + found > least * (all + found);
}

/* Samples pivots and light paths, and decides. */
static lf_status ask(asking *a, lf_light_plan *plan, bool *out_serves)
{
    lf_pool *pool = a->pilot->pool;
    a->end = BALANCED;
    lf_status status = lf_pool_run(pool, PIVOTS / CHUNK, sample_pivots, a, NULL);
    if (status == LF_OK) {
        find_importance(a->pivots, plan);
        status = lf_pool_run(pool, ASKING_PATHS / CHUNK, ask_light, a, NULL);
    }
    if (status != LF_OK || !out_serves)
        return status;
    *out_serves = reduce(a, CLASS, LEAST_SHARE);
    if (!*out_serves)
        return LF_OK;
    a->first = BALANCED;
    a->end = TAKEN;
    status = lf_pool_run(pool, PIVOTS / CHUNK, sample_pivots, a, NULL);
    *out_serves = status == LF_OK && reduce(a, BALANCED, LEAST_BALANCED);
    return status;
}

lf_status lf_light_pilot_asks(const lf_light_pilot *pilot, lf_light_plan *plan, bool *out_serves)
{
    const int n = lf_pool_threads(pilot->pool);
    lf_light_plan asked = *plan;
    asking a = {.pilot = pilot,
                .plan = &asked,
                .workers = lf_calloc((size_t)n, sizeof *a.workers),
                .pivots = lf_calloc(PIVOTS, sizeof *a.pivots),
                .found = lf_calloc(ASKING_PATHS / CHUNK, sizeof *a.found),
                .missed = lf_calloc(ASKING_PATHS / CHUNK, sizeof *a.missed)};
    lf_status status = a.workers && a.pivots && a.found && a.missed ? LF_OK : LF_E_NOMEM;
    asked.m = (float)plan->per_pass; /* of one view */
    asked.cut = 0.0f;
    if (status == LF_OK)
        status = ask(&a, &asked, out_serves);
    if (status == LF_OK)
        memcpy(plan->importance, asked.importance, sizeof plan->importance);
    lf_free(a.workers);
    lf_free(a.pivots);
    lf_free(a.found);
    lf_free(a.missed);
    return status;
}

/* ---------------------------------------------------------------------------------- learning -- */

/* A vertex that light reaches. */
typedef struct score {
    float value;
    int cell;
} score;

/* The scores of a chunk, in order. */
typedef struct scores {
    score *of;
    int n, allocated;
    double splats;
    bool failed;
} scores;

typedef struct learning {
    const lf_light_pilot *pilot;
    const lf_light_plan *plan;
    lf_scratch *workers;
    scores *chunks;
    int n_chunks; /* a round's */
    int round;
} learning;

typedef struct learner {
    bringing bringing; /* first: take_light has it as its context */
    scores *out;
} learner;

static void close_learning(void *context, const lf_forward_vertex *vertex)
{
    learner *l = context;
    scores *out = l->out;
    if (out->n == out->allocated) {
        const int n = 2 * out->allocated + CHUNK;
        score *grown = lf_calloc((size_t)n, sizeof *grown);
        if (!grown) {
            out->failed = true;
            return;
        }
        if (out->n > 0)
            memcpy(grown, out->of, (size_t)out->n * sizeof *grown);
        lf_free(out->of);
        out->of = grown;
        out->allocated = n;
    }
    out->of[out->n++] = (score){(float)l->bringing.score, vertex->cell};
    l->bringing.score = 0.0;
}

static void learn_light(void *context, int item, int worker)
{
    learning *a = context;
    const lf_light_pilot *pilot = a->pilot;
    lf_light_connect connect;
    learner l = {.bringing = {.connect = &connect}, .out = &a->chunks[item]};
    lf_light_connect_init(&connect, pilot->scene, pilot->rig, &a->workers[worker], a->plan);
    connect.sink = (lf_light_sink){&l, wants_all, take_light, close_learning};
    l.out->n = 0;
    const uint64_t key = lf_hash64(KEY, (uint64_t)a->round + 100);
    for (int i = item * CHUNK; i < (item + 1) * CHUNK; i++)
        lf_light_connect_path(&connect, lf_hash64(key, (uint64_t)i), pilot->max_depth,
                              pilot->alone);
    l.out->splats = l.bringing.splats;
}

/* Sums a round in the order of its paths. */
static void sum_round(const learning *a, const lf_emitters *emitters, double *second,
                      lf_light_plan *plan, double *out_splats)
{
    const double paths = (double)a->n_chunks * CHUNK;
    double sum = 0.0;
    *out_splats = 0.0;
    for (int c = 0; c < a->n_chunks; c++) {
        const scores *chunk = &a->chunks[c];
        *out_splats += chunk->splats / paths;
        for (int i = 0; i < chunk->n; i++) {
            const double value = (double)chunk->of[i].value;
            sum += value * value;
            if (chunk->of[i].cell >= 0)
                second[chunk->of[i].cell] +=
                    value * value * (double)emitters->density[chunk->of[i].cell];
        }
    }
    plan->cut = (float)sqrt(COST_OF_RAYS * sum / paths);
}

static bool scores_failed(const learning *a)
{
    bool failed = false;
    for (int c = 0; c < a->n_chunks; c++)
        failed |= a->chunks[c].failed;
    return failed;
}

static int later_learning(const lf_rig *rig)
{
    const double n = LEARNING_SHARE * rig->n_views * rig->width * rig->height / CHUNK;
    return (int)fmin(fmax(n, LEAST_LEARNING), MOST_LEARNING);
}

lf_status lf_light_pilot_learns(const lf_light_pilot *pilot, lf_emitters *emitters,
                                lf_light_plan *plan, double *out_splats)
{
    const int n = lf_pool_threads(pilot->pool), rounds = emitters->n_cells > 0 ? ROUNDS : 1;
    const int later = later_learning(pilot->rig);
    learning a = {.pilot = pilot, .plan = plan, .workers = lf_calloc((size_t)n, sizeof *a.workers)};
    a.chunks = lf_calloc((size_t)later, sizeof *a.chunks);
    double *second = lf_calloc((size_t)emitters->n_cells + 1, sizeof *second);
    lf_status status = a.workers && a.chunks && second ? LF_OK : LF_E_NOMEM;
    for (a.round = 0; a.round < rounds && status == LF_OK; a.round++) {
        a.n_chunks = a.round == 0 ? FIRST_LEARNING : later;
        status = lf_pool_run(pilot->pool, a.n_chunks, learn_light, &a, NULL);
        if (status == LF_OK && scores_failed(&a))
            status = LF_E_NOMEM;
        if (status == LF_OK) {
            sum_round(&a, emitters, second, plan, out_splats);
            lf_emitters_learn(emitters, second);
        }
    }
    for (int c = 0; a.chunks && c < later; c++)
        lf_free(a.chunks[c].of);
    lf_free(a.workers);
    lf_free(a.chunks);
    lf_free(second);
    return status;
}
