/* quiltbench micro SCENE: the inner loops one by one, on fans of rays that this scene gives. Every
 * instruction set's kernels are held against the plain C ones, bit for bit, and timed in turns with
 * them. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "bench/bench.h"
#include "bench/command.h"
#include "daemon/output/content.h"
#include "render/renderer.h"
#include "render/rows/rows.h"
#include "render/transport/lanes/suffix_batch.h"

#define N_FANS 512
#define N_RAYS 4096
#define MAX_TABLES 8

typedef struct arguments {
    lf_options options;
    const char *scene, *json;
    int repeat;
    bool fault;
} arguments;

/* One ray a view, as the march takes them. */
typedef struct fan {
    float x0[LF_MAX_LANES], slope[LF_MAX_LANES], z_end[LF_MAX_LANES];
} fan;

/* What the kernels answered for all fans. */
typedef struct answers {
    float tau[N_FANS][LF_MAX_LANES], sigma[N_FANS][LF_MAX_LANES], density[N_FANS][LF_MAX_LANES],
        sum[N_FANS];
} answers;

typedef struct bench {
    const arguments *arguments;
    lf_scene *scene;
    lf_pool *pool;
    lf_renderer *renderer;
    const lf_rows *rows; /* its state */
    lf_scratch *worker;
    lf_row_plane plane;
    lf_body body; /* a shape of the size of the window, for the kernel of shapes */
    int lanes, n_fans, n_rays;
    fan *pivots, *unscattered; /* [N_FANS] that end at a collision, and that go through */
    int medium[N_FANS];
    lf_event *events; /* [N_RAYS] collisions … */
    lf_vec3 *ways;    /* … and a direction from each */
    answers *answers[2];
    double mean_depth;
    json_t *lines;
} bench;

static const char shared[] = LF_OPTIONS_VIEWS " seed";

static const lf_param own[] = {
    LF_BENCH_REPEAT(offsetof(arguments, repeat), 15,
                    "number of repetitions; the median is reported"),
    {.name = "fault",
     .option = "fault",
     .help = "flip one bit of a result, so that the run must fail",
     .type = LF_PARAM_SWITCH,
     .place = offsetof(arguments, fault)},
    LF_BENCH_JSON(offsetof(arguments, json)),
    {0},
};

static void print_help(void)
{
    printf("Usage: quiltbench micro SCENE [options]\n"
           "Measure the CPU time of the inner loops on the ray fans of the scene's middle row, "
           "in ns per view or item. The exit\n"
           "status is 1 if the kernels of an instruction set differ from the plain C "
           "kernels.\n\n");
    lf_param_print_help(own, NULL);
    lf_param_print_help(lf_option_params, shared);
    printf(LF_OPTIONS_HELP_LAST);
}

static const lf_bench_command command = {"micro", shared, own, print_help, 1, 1, "one SCENE"};

/* -------------------------------------------------------------------------------------- rays -- */

static fan fan_to(const bench *b, float x, float z)
{
    const lf_rig *rig = &b->rows->rig;
    fan f;
    for (int k = 0; k < b->lanes; k++) {
        f.x0[k] = rig->b[k];
        f.slope[k] = (x - rig->b[k]) / (isfinite(z) ? z : rig->distance);
        f.z_end[k] = z;
    }
    return f;
}

/* Where base rays of the row collide; the fans that meet there, and those through the same points
 * of the window. */
static void draw_fans(bench *b)
{
    const lf_rig *rig = &b->rows->rig;
    lf_tracer *tracer = &b->worker->tracer;
    int tries = 0;
    for (; b->n_rays < N_RAYS && tries < 64 * N_RAYS; tries++) {
        int view = (int)(lf_rng(tracer) * (float)rig->n_views);
        float window = rig->x0 + lf_rng(tracer) * (float)rig->width * rig->dx;
        lf_media_ray ray = {.x0 = rig->b[view],
                            .slope = (window - rig->b[view]) / rig->distance,
                            .z_end = INFINITY};
        ray.length = sqrtf(1.0f + ray.slope * ray.slope + b->plane.my * b->plane.my);
        lf_collision c =
            lf_media_collide(&b->worker->media, &ray, 0, lf_rng(tracer), false, tracer);
        if (!isfinite(c.z))
            continue;
        float x = ray.x0 + ray.slope * c.z;
        if (b->n_fans < N_FANS) {
            b->medium[b->n_fans] = c.medium;
            b->unscattered[b->n_fans] = fan_to(b, window, INFINITY);
            b->pivots[b->n_fans++] = fan_to(b, x, c.z);
        }
        lf_vec3 travel = lf_normalize(lf_rig_direction(rig, ray.slope, b->plane.my, 1.0f));
        b->events[b->n_rays] = (lf_event){.kind = LF_EVENT_MEDIUM, .w = travel};
        b->events[b->n_rays].p = lf_rig_point(rig, x, b->plane.ly + b->plane.my * c.z, c.z);
        b->events[b->n_rays].volume = b->worker->media.item[c.medium].volume;
        b->ways[b->n_rays++] =
            lf_phase_sample(0.0f, travel, (float[2]){lf_rng(tracer), lf_rng(tracer)});
    }
}

static lf_rays rays_of(const bench *b, const fan *f, const lf_kernels *kernels)
{
    return (lf_rays){.scene = &b->rows->seen,
                     .rig = &b->rows->rig,
                     .plane = &b->plane,
                     .kernels = kernels,
                     .n = b->lanes,
                     .x0 = f->x0,
                     .slope = f->slope,
                     .z_end = f->z_end};
}

/* Mean optical depth of the middle view's rays that meet anything, for what the line says of the
 * scene. */
static void measure_depth(bench *b)
{
    const lf_rig *rig = &b->rows->rig;
    double sum = 0;
    int n = 0;
    for (int u = 0; u < rig->width; u++) {
        fan f = fan_to(b, rig->x0 + ((float)u + 0.5f) * rig->dx, INFINITY);
        float tau[LF_MAX_LANES];
        const lf_rays rays = rays_of(b, &f, lf_kernels_get());
        lf_media_depths(&b->worker->media, &rays, tau, -1, NULL);
        sum += (double)tau[rig->n_views / 2];
        n += tau[rig->n_views / 2] > 0;
    }
    b->mean_depth = n ? sum / n : 0;
}

static lf_status prepare(bench *b, lf_error *err)
{
    const arguments *a = b->arguments;
    lf_render_settings settings;
    lf_layout layout;
    lf_status status = lf_scene_load(a->scene, NULL, NULL, &b->scene, err);
    if (status == LF_OK)
        lf_log_warnings(b->scene, NULL);

    if (status == LF_OK)
        status =
            lf_resolve_view(&a->options, lf_scene_camera(b->scene), NULL, &settings, &layout, err);
    if (status == LF_OK && lf_pool_create(1, &b->pool) != LF_OK)
        status = lf_error_set(err, LF_E_NOMEM, a->scene, "out of memory");
    if (status == LF_OK)
        status = lf_renderer_create(b->scene, &settings, b->pool, &b->renderer, err);
    if (status != LF_OK)
        return status;
    b->rows = b->renderer->state;
    b->pivots = lf_calloc(N_FANS, sizeof *b->pivots);
    b->unscattered = lf_calloc(N_FANS, sizeof *b->unscattered);
    b->events = lf_calloc(N_RAYS, sizeof *b->events);
    b->ways = lf_calloc(N_RAYS, sizeof *b->ways);
    for (int i = 0; i < 2; i++)
        b->answers[i] = lf_calloc(1, sizeof *b->answers[i]);
    if (!b->pivots || !b->unscattered || !b->events || !b->ways || !b->answers[0] || !b->answers[1])
        return lf_error_set(err, LF_E_NOMEM, a->scene, "out of memory");
    const lf_rig *rig = &b->rows->rig;
    b->worker = &b->rows->workers[0];
    b->worker->tracer.scene = b->renderer->scene;
    b->worker->tracer.rng = lf_hash64(a->options.seed, 1);
    b->lanes = lf_rig_lanes(rig);
    lf_rig_row_plane(rig, 0.5f * (float)rig->height, (float[2]){0.5f, 0.5f}, &b->plane);
    const lf_media_plane at = {
        .rig = rig, .plane = &b->plane, .kernels = lf_kernels_get(), .phase = {0.5f, 0.5f}};
    lf_media_cut(&b->worker->media, &b->rows->frame, b->renderer->scene->volumes, &at,
                 &b->worker->tracer.lookups);
    draw_fans(b);
    if (b->n_fans < N_FANS)
        return lf_error_set(err, LF_E_ARG, a->scene,
                            "too few rays of the middle row collide with a volume; choose a scene "
                            "with a denser volume");
    measure_depth(b);
    b->body = (lf_body){.shape = LF_VOLUME_SPHERE, .sigma_t = 1.0f, .depth = {0, 0, 1}};
    b->body.origin[2] = -rig->distance;
    b->body.across[0] = 1.0f;
    return LF_OK;
}

/* ----------------------------------------------------------------------------------- kernels -- */

static void run_march(const bench *b, const lf_kernels *k, answers *out)
{
    const lf_media *media = &b->worker->media;
    for (int i = 0; i < b->n_fans; i++) {
        const fan *f = &b->pivots[i];
        memset(out->tau[i], 0, sizeof out->tau[i]);
        if (media->item[b->medium[i]].kind == LF_MEDIUM_SLICE)
            k->march(&media->item[b->medium[i]].slice, b->lanes, f->x0, f->slope, f->z_end,
                     out->tau[i], out->sigma[i]);
    }
}

static void run_unscattered(const bench *b, const lf_kernels *k, answers *out)
{
    for (int i = 0; i < b->n_fans; i++) {
        const lf_rays rays = rays_of(b, &b->unscattered[i], k);
        lf_media_depths(&b->worker->media, &rays, out->tau[i], -1, NULL);
    }
}

static void run_through(const bench *b, const lf_kernels *k, answers *out)
{
    for (int i = 0; i < b->n_fans; i++) {
        const fan *f = &b->pivots[i];
        memset(out->tau[i], 0, sizeof out->tau[i]);
        k->through(&b->body, b->lanes, f->x0, f->slope, f->z_end, out->tau[i]);
    }
}

static void run_densities(const bench *b, const lf_kernels *k, answers *out)
{
    for (int i = 0; i < b->n_fans; i++)
        out->sum[i] = k->densities(b->lanes, out->sigma[i], out->tau[i], out->density[i]);
}

/* What every pivot of mvpt costs behind its geometry. */
static void run_pivot(const bench *b, const lf_kernels *k, answers *out)
{
    for (int i = 0; i < b->n_fans; i++) {
        const lf_rays rays = rays_of(b, &b->pivots[i], k);
        lf_media_depths(&b->worker->media, &rays, out->tau[i], b->medium[i], out->sigma[i]);
        out->sum[i] = k->densities(b->lanes, out->sigma[i], out->tau[i], out->density[i]);
    }
}

static const struct kernel {
    const char *name;
    void (*run)(const bench *b, const lf_kernels *k, answers *out);
} kernels[] = {
    {"march to a collision", run_march},
    {"densities", run_densities},
    {"march through (unscattered light)", run_unscattered},
    {"through a shape", run_through},
    {"transmittances of a pivot", run_pivot},
};

static void add_line(bench *b, const char *what, const char *table_name, const char *unit,
                     double ns, double ratio)
{
    if (!b->arguments->json || strcmp(b->arguments->json, "-") != 0)
        printf("%-34s %-8s %10.2f ns per %-10s %6.2fx\n", what, table_name, ns, unit, ratio);
    json_array_append_new(b->lines,
                          json_pack("{s:s, s:s, s:s, s:f, s:f}", "what", what, "kernels",
                                    table_name, "a", unit, "ns", ns, "times_plain_c", ratio));
}

static void seconds_of(const bench *b, const struct kernel *what, const lf_kernels *k, answers *out,
                       lf_timing *timing)
{
    double start = lf_time_cpu();
    what->run(b, k, out);
    lf_timing_add(timing, lf_time_cpu() - start);
}

static bool same(const bench *b, const answers *x, const answers *y)
{
    size_t bytes = (size_t)b->lanes * sizeof(float);
    bool equal = memcmp(x->sum, y->sum, sizeof x->sum) == 0;
    for (int i = 0; i < b->n_fans && equal; i++)
        equal = memcmp(x->tau[i], y->tau[i], bytes) == 0 &&
                memcmp(x->sigma[i], y->sigma[i], bytes) == 0 &&
                memcmp(x->density[i], y->density[i], bytes) == 0;
    return equal;
}

static lf_status measure_kernel(bench *b, const struct kernel *what, lf_error *err)
{
    lf_timing timing[MAX_TABLES] = {0};
    double views = (double)b->n_fans * b->rows->rig.n_views;
    int n = 0;
    for (int i = 0; i <= b->arguments->repeat; i++) {
        for (n = 0; n < MAX_TABLES && lf_kernels_at(n); n++) {
            answers *out = b->answers[n > 0];
            seconds_of(b, what, lf_kernels_at(n), out, &timing[n]);
            if (n > 0 && b->arguments->fault)
                ((unsigned char *)out->tau[0])[0] ^= 1;
            if (n > 0 && !same(b, b->answers[0], out))
                return lf_error_set(
                    err, LF_E_STATE, what->name,
                    "the %s kernels and the plain C kernels differ in their results",
                    lf_kernels_at(n)->name);
            if (i == 0)
                timing[n].n = 0; /* pages and caches as they will be */
        }
    }
    double plain = lf_timing_quantile(&timing[0], 0.5);
    for (int k = 0; k < n; k++) {
        double seconds = lf_timing_quantile(&timing[k], 0.5);
        add_line(b, what->name, lf_kernels_at(k)->name, "view", 1e9 * seconds / views,
                 plain / seconds);
    }
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- steps -- */

/* Each adds up something of every answer, so that none can be left out. */

static double step_collision(bench *b)
{
    double sum = 0;
    int volume = 0;
    for (int i = 0; i < b->n_rays; i++) {
        float t =
            lf_track_collision(&b->worker->tracer, b->events[i].p, b->ways[i], INFINITY, &volume);
        sum += isfinite(t) ? (double)t : 1;
    }
    return sum;
}

static double step_transmittance(bench *b)
{
    double sum = 0;
    for (int i = 0; i < b->n_rays; i++)
        sum += (double)lf_track_transmittance(&b->worker->tracer, b->events[i].p, b->ways[i],
                                              INFINITY);
    return sum;
}

static double step_lookup(bench *b)
{
    double sum = 0;
    for (int i = 0; i < b->n_rays; i++)
        sum += (double)lf_volume_sigma_t(&b->renderer->scene->volumes[b->events[i].volume],
                                         b->events[i].p);
    return sum;
}

static double step_phase(bench *b)
{
    double sum = 0;
    for (int i = 0; i < b->n_rays; i++)
        sum += (double)lf_phase_between(0.6f, b->events[i].w, b->ways[i]);
    return sum;
}

static double step_light(bench *b)
{
    lf_tracer *t = &b->worker->tracer;
    double sum = 0;
    for (int i = 0; i < b->n_rays; i++) {
        const float u[3] = {lf_rng(t), lf_rng(t), lf_rng(t)};
        lf_light_sample light;
        if (lf_light_draw(b->renderer->scene, b->events[i].p, u, &light))
            sum += (double)light.pdf;
    }
    return sum;
}

static double step_sampler(bench *b)
{
    lf_sampler s;
    double sum = 0;
    for (int i = 0; i < b->n_rays; i++) {
        float u[2];
        if (i % 16 == 0)
            lf_sampler_init(&s, LF_SAMPLER_OWEN, lf_hash64(b->arguments->options.seed, (uint64_t)i),
                            (uint32_t)i);
        lf_sampler_2d(&s, u);
        sum += (double)u[0];
    }
    return sum;
}

/* One collision in so many. */
enum { SUFFIX_ITEMS = 16 };

static double step_suffix(bench *b)
{
    double sum = 0;
    for (int i = 0; i < b->n_rays / SUFFIX_ITEMS; i++)
        sum +=
            (double)lf_path_scattered(&b->worker->tracer, &b->events[i], 1, LF_DEFAULT_MAX_DEPTH).x;
    return sum;
}

static const struct step {
    const char *name, *unit;
    double (*run)(bench *b);
    int items; /* of N_RAYS, one in so many */
} steps[] = {
    {"next collision", "ray", step_collision, 1},  {"transmittance", "ray", step_transmittance, 1},
    {"extinction", "point", step_lookup, 1},       {"phase function", "pair", step_phase, 1},
    {"light drawn", "sample", step_light, 1},      {"sampler, owen", "pair", step_sampler, 1},
    {"suffix", "path", step_suffix, SUFFIX_ITEMS},
};

static lf_status measure_step(bench *b, const struct step *what, lf_error *err)
{
    lf_timing timing = {0};
    for (int i = 0; i <= b->arguments->repeat; i++) {
        double start = lf_time_cpu();
        double sum = what->run(b);
        if (i > 0)
            lf_timing_add(&timing, lf_time_cpu() - start);
        if (!isfinite(sum))
            return lf_error_set(err, LF_E_STATE, what->name, "a result is not a finite number");
    }
    add_line(b, what->name, "-", what->unit,
             1e9 * lf_timing_quantile(&timing, 0.5) * what->items / b->n_rays, 1);
    return LF_OK;
}

/* ------------------------------------------------------------------------- suffixes in lanes -- */

static void add_bits(uint64_t *hash, const float *x, int n)
{
    for (int i = 0; i < n; i++) {
        uint32_t bits;
        memcpy(&bits, &x[i], sizeof bits);
        *hash = lf_hash64(*hash, bits);
    }
}

/* All that a batch's suffixes have found. */
static void add_batch(uint64_t *hash, const lf_suffix_batch *batch)
{
    const int paths = batch->n * batch->each;
    add_bits(hash, batch->left, batch->n);
    for (int c = 0; c < 3; c++)
        add_bits(hash, batch->radiance[c], paths);
    add_bits(hash, batch->escaped, paths);
}

/* All collisions as pivots, in batches; a hash of what their suffixes find. */
static uint64_t run_lanes(bench *b, const lf_suffixes *suffixes, lf_suffix_batch *batch,
                          lf_timing *timing)
{
    const lf_scene *scene = b->renderer->scene;
    const double start = lf_time_cpu();
    uint64_t hash = 0;
    lf_tracer tracer = {.scene = scene};
    memset(batch, 0, sizeof *batch);
    lf_suffix_batch_init(batch, b->renderer->lanes, suffixes, LF_BATCH_EACH);
    for (int i = 0; i < b->n_rays; i++) {
        const lf_event *event = &b->events[i];
        const lf_batch_pivot pivot = {.p = event->p,
                                      .w = event->w,
                                      .volume = event->volume,
                                      .rng = lf_hash64(b->arguments->options.seed, (uint64_t)i)};
        lf_sampler sampler;
        lf_sampler_init(&sampler, LF_SAMPLER_OWEN, pivot.rng, 0);
        lf_suffix_batch_add(batch, scene, &pivot, &sampler);
        if (!lf_suffix_batch_is_full(batch) && i + 1 < b->n_rays)
            continue;
        lf_suffix_batch_trace(batch, &tracer, LF_DEFAULT_MAX_DEPTH);
        add_batch(&hash, batch);
        lf_suffix_batch_clear(batch);
    }
    lf_timing_add(timing, lf_time_cpu() - start);
    return hash;
}

static lf_status time_lanes(bench *b, lf_suffix_batch *batch, lf_error *err)
{
    lf_timing timing[MAX_TABLES] = {0}, single = {0};
    int n = 0;
    for (int i = 0; i <= b->arguments->repeat; i++) {
        uint64_t plain = 0;
        const double start = lf_time_cpu();
        if (!isfinite(step_suffix(b)))
            return lf_error_set(err, LF_E_STATE, "suffix", "a result is not a finite number");
        lf_timing_add(&single, lf_time_cpu() - start);
        for (n = 0; n < MAX_TABLES && lf_kernels_at(n); n++) {
            const lf_suffixes *suffixes = lf_kernels_at(n)->suffixes;
            uint64_t hash = run_lanes(b, suffixes, batch, &timing[n]);
            plain = n == 0 ? hash : plain;
            if (hash != plain + (n > 0 && b->arguments->fault))
                return lf_error_set(err, LF_E_STATE, "suffix in lanes",
                                    "the results of %s and of plain C differ", suffixes->name);
        }
    }
    add_line(b, "suffix one by one, alternating with", "-", "path",
             1e9 * SUFFIX_ITEMS * lf_timing_quantile(&single, 0.5) / b->n_rays, 1);
    const double plain = lf_timing_quantile(&timing[0], 0.5);
    for (int k = 0; k < n; k++) {
        double seconds = lf_timing_quantile(&timing[k], 0.5);
        add_line(b, "suffix in lanes", lf_kernels_at(k)->suffixes->name, "path",
                 1e9 * seconds / LF_BATCH_EACH / b->n_rays, plain / seconds);
    }
    return LF_OK;
}

/* In turns with those that go one by one, where lanes serve the scene. */
static lf_status measure_lanes(bench *b, lf_error *err)
{
    if (!b->renderer->lanes || b->n_rays < SUFFIX_ITEMS)
        return LF_OK;
    lf_suffix_batch *batch = lf_calloc(1, sizeof *batch);
    if (!batch)
        return lf_error_set(err, LF_E_NOMEM, "suffix in lanes", "out of memory");
    lf_status status = time_lanes(b, batch, err);
    lf_free(batch);
    return status;
}

static lf_status measure(bench *b, lf_error *err)
{
    lf_status status = measure_lanes(b, err);
    for (size_t i = 0; i < sizeof kernels / sizeof kernels[0] && status == LF_OK; i++)
        status = measure_kernel(b, &kernels[i], err);
    for (size_t i = 0; i < sizeof steps / sizeof steps[0] && status == LF_OK; i++)
        status = measure_step(b, &steps[i], err);
    return status;
}

static lf_status write_json(const bench *b, lf_error *err)
{
    const lf_rig *rig = &b->rows->rig;
    json_t *object = json_pack(
        "{s:s, s:o, s:i, s:i, s:i, s:i, s:f, s:O}", "scene", b->arguments->scene, "machine",
        lf_bench_machine(), "views", rig->n_views, "width", rig->width, "height", rig->height,
        "repeat", b->arguments->repeat, "optical_depth", b->mean_depth, "lines", b->lines);
    return lf_bench_write_json(b->arguments->json, object, err);
}

int lf_bench_micro(int argc, char **argv)
{
    arguments a = {0};
    bench b = {.arguments = &a};
    lf_error err = {0};
    int code = LF_EXIT_OK;
    if (!lf_bench_command_begin(&command, argc, argv, &a.options, &a, &code))
        return code;
    a.scene = argv[optind];
    b.lines = json_array();
    lf_status status =
        b.lines ? prepare(&b, &err) : lf_error_set(&err, LF_E_NOMEM, a.scene, "out of memory");
    if (status == LF_OK && !lf_bench_is_stdout(a.json))
        printf("%s: %d views of %dx%d; middle row: optical depth %.1f along rays that meet a "
               "medium\n\n",
               a.scene, b.rows->rig.n_views, b.rows->rig.width, b.rows->rig.height, b.mean_depth);
    if (status == LF_OK)
        status = measure(&b, &err);
    if (status == LF_OK && a.json)
        status = write_json(&b, &err);
    lf_free(b.pivots);
    lf_free(b.unscattered);
    lf_free(b.events);
    lf_free(b.ways);
    lf_free(b.answers[0]);
    lf_free(b.answers[1]);
    lf_renderer_destroy(b.renderer);
    lf_pool_destroy(b.pool);
    lf_scene_unref(b.scene);
    json_decref(b.lines);
    return status == LF_OK ? LF_EXIT_OK : lf_bench_fail(&err);
}
