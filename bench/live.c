/* quiltbench live SCENE: what somebody in front of the panel sees after a command. The daemon's
 * loader and engine run here as they do in quiltd; in place of a device that needs its time, every
 * frame is shown at once, and its rectangles are counted as a device counts them. */
#include <errno.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/wakeup.h"
#include "bench/bench.h"
#include "bench/command.h"
#include "daemon/engine/loader.h"
#include "daemon/output/render_job.h"

#define MAX_MOMENTS 6
#define PATIENCE_SECONDS 600.0
#define IDLE_SECONDS 2.0
#define SPEED_REPEAT 3
#define REFERENCE_SEED UINT64_C(0x5eed0000)
#define BYTES_A_PIXEL 3

static const double all_moments[MAX_MOMENTS] = {0.1, 0.3, 1, 3, 10, 30};

typedef struct arguments {
    lf_options options;
    const char *scene, *json;
    int repeat;
    double yaw;
    double seconds; /* how long is watched */
    double reference_seconds;
    double epsilon;
    int speed_passes;
} arguments;

/* One command and what followed. */
typedef struct watch {
    double start;
    int64_t before; /* generation shown until then */
    double coarse, complete, coarse_cpu, complete_cpu;
    double cpu_start, wire_bytes, cpu_seconds;
    int updates;
    double rel_mse[MAX_MOMENTS];
} watch;

typedef struct bench {
    const arguments *arguments;
    int n_moments;
    lf_calibration calibration;
    int event_fd;
    lf_roots roots;
    lf_inbox inbox;
    bool has_inbox;
    lf_engine *engine;
    lf_loader *loader;
    lf_content *content; /* what is shown, for references and speeds */
    lf_status load_status;
    lf_error load_error;
    int64_t generation;
    bool answered;
    size_t n; /* samples of a panel frame */
    uint8_t *shown[MAX_MOMENTS];
    float *reference; /* [n] linear */
    double reference_error;
    float to_linear[256];
    lf_timing coarse, complete, coarse_cpu, complete_cpu;
    lf_timing rel_mse[MAX_MOMENTS], updates, wire_bytes, cpu;
    double idle_cpu, speed_up;
} bench;

/* --------------------------------------------------------------------------------- arguments -- */

static const char shared[] = "calibration " LF_OPTIONS_VIEWS " " LF_OPTIONS_RENDER;

static const lf_param own[] = {
    LF_BENCH_REPEAT(offsetof(arguments, repeat), 5, "number of camera moves"),
    LF_BENCH_FIELD(LF_PARAM_NUMBER, "yaw", offsetof(arguments, yaw), "DEGREES", -180, 180, 5,
                   "angle of each camera move"),
    LF_BENCH_FIELD(LF_PARAM_NUMBER, "seconds", offsetof(arguments, seconds), "S", 0.1, 3600, 10,
                   "time to watch after each camera move"),
    LF_BENCH_FIELD(LF_PARAM_NUMBER, "reference-time", offsetof(arguments, reference_seconds), "S",
                   1e-2, 1e6, 60, "CPU seconds of each of the two reference renderings"),
    LF_BENCH_FIELD(LF_PARAM_NUMBER, "epsilon", offsetof(arguments, epsilon), "E", 0, 1e9, 1e-2,
                   "epsilon of relMSE"),
    LF_BENCH_FIELD(LF_PARAM_WHOLE, "speed-passes", offsetof(arguments, speed_passes), "N", 0,
                   LF_TIMING_MAX, 4, "passes for measuring the speed-up; 0: do not measure it"),
    LF_BENCH_JSON(offsetof(arguments, json)),
    {0},
};

static void print_help(void)
{
    printf("Usage: quiltbench live SCENE [options]\n"
           "Measure the panel image 0.1, 0.3, 1, 3, 10 and 30 s after camera.orbit (relMSE), the "
           "time to a coarse and to a complete\n"
           "frame, updates, bytes on the wire, CPU use, and the speed-up by threads. The default "
           "panel is a nominal Portrait.\n\n");
    lf_param_print_help(own, NULL);
    lf_param_print_help(lf_option_params, shared);
    printf(LF_OPTIONS_HELP_LAST);
}

static const lf_bench_command command = {"live", shared, own, print_help, 1, 1, "one SCENE"};

/* ---------------------------------------------------------------------------------- commands -- */

static void task_done(void *reader, lf_task *task)
{
    bench *b = reader;
    lf_load *load = (lf_load *)task; /* its first member */
    b->load_status = load->status;
    b->load_error = load->err;
    b->generation = load->generation;
    b->answered = true;
    if (load->content) {
        lf_content_unref(b->content);
        b->content = lf_content_ref(load->content);
    }
    lf_load_destroy(load);
}

static lf_status send_load(bench *b, lf_load_kind kind, double yaw, lf_error *err)
{
    lf_load *load = lf_load_create(kind);
    if (!load)
        return lf_error_set(err, LF_E_NOMEM, b->arguments->scene, "out of memory");
    load->task.done = task_done;
    load->options = b->arguments->options;
    load->has_calibration = true;
    load->calibration = b->calibration;
    load->yaw = yaw;
    load->zoom = 1;
    if (kind == LF_LOAD_FILE) {
        load->file = realpath(b->arguments->scene, NULL);
        char *path = lf_strdup(load->file ? load->file : b->arguments->scene);
        free(load->file);
        load->file = path;
    }
    b->answered = false;
    lf_loader_queue(b->loader, load);
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- watch -- */

/* Shows the newest frame, as a device that is always ready. */
static void show(bench *b, watch *w)
{
    lf_mailbox *mailbox = lf_engine_mailbox(b->engine);
    const lf_frame *frame = lf_mailbox_take(mailbox);
    if (!frame)
        return;
    double after = lf_time_now() - w->start;
    for (int i = 0; i < frame->n_rects; i++)
        w->wire_bytes += (double)frame->rects[i].width * frame->rects[i].height * BYTES_A_PIXEL;
    w->updates++;
    bool news = frame->generation > w->before;
    if (news && frame->level >= LF_LEVEL_COARSE && w->coarse < 0) {
        w->coarse = after;
        w->coarse_cpu = lf_time_cpu() - w->cpu_start;
    }
    if (news && frame->level >= LF_LEVEL_COMPLETE && w->complete < 0) {
        w->complete = after;
        w->complete_cpu = lf_time_cpu() - w->cpu_start;
    }
    lf_mailbox_shown(mailbox);
}

/* Sleeps until something happens or `until` (seconds after the start) has come. */
static void wait_for_news(bench *b, const watch *w, double until)
{
    struct pollfd fds[2] = {{.fd = b->event_fd, .events = POLLIN},
                            {.fd = b->inbox.event_fd, .events = POLLIN}};
    double left = until - (lf_time_now() - w->start);
    if (left > 0 && poll(fds, 2, (int)(1e3 * left) + 1) > 0) {
        if (fds[1].revents)
            lf_inbox_read(&b->inbox, b);
        if (fds[0].revents)
            lf_wakeup_clear(b->event_fd);
    }
}

static void remember(bench *b, int moment)
{
    const lf_frame *frame = lf_mailbox_current(lf_engine_mailbox(b->engine));
    if (frame && frame->image.data)
        memcpy(b->shown[moment], frame->image.data, b->n);
}

/* Sends an orbit and follows the panel for `seconds`, and until a complete frame was there. */
static lf_status follow(bench *b, double yaw, double seconds, bool remembers, watch *out,
                        lf_error *err)
{
    watch *w = out;
    int moment = 0;
    *w = (watch){.start = lf_time_now(),
                 .cpu_start = lf_time_cpu(),
                 .before = b->generation,
                 .coarse = -1,
                 .complete = -1};
    lf_status status = send_load(b, LF_LOAD_ORBIT, yaw, err);
    while (status == LF_OK) {
        double now = lf_time_now() - w->start;
        if (moment < b->n_moments && now >= all_moments[moment]) {
            if (remembers)
                remember(b, moment);
            moment++;
            continue;
        }
        if (now >= seconds && w->cpu_seconds <= 0)
            w->cpu_seconds = lf_time_cpu() - w->cpu_start;
        if (now >= seconds && b->answered && w->complete >= 0)
            break;
        if (now > PATIENCE_SECONDS)
            return lf_error_set(err, LF_E_STATE, b->arguments->scene,
                                "there was no complete frame after %g s", PATIENCE_SECONDS);
        wait_for_news(b, w,
                      moment < b->n_moments ? all_moments[moment]
                      : now >= seconds      ? PATIENCE_SECONDS + 1
                                            : seconds);
        if (b->answered && b->load_status != LF_OK) {
            *err = b->load_error;
            return b->load_status;
        }
        if (lf_time_now() - w->start < seconds || w->complete < 0)
            show(b, w);
    }
    return status;
}

/* Loads the scene and waits for its first complete frame. */
static lf_status start_up(bench *b, lf_error *err)
{
    watch w = {.start = lf_time_now(), .coarse = -1, .complete = -1};
    lf_status status = send_load(b, LF_LOAD_FILE, 0, err);
    while (status == LF_OK && (!b->answered || w.complete < 0)) {
        wait_for_news(b, &w, PATIENCE_SECONDS);
        show(b, &w);
        if (b->answered && b->load_status != LF_OK) {
            *err = b->load_error;
            return b->load_status;
        }
        if (lf_time_now() - w.start > PATIENCE_SECONDS)
            return lf_error_set(err, LF_E_STATE, b->arguments->scene,
                                "there was no complete frame after %g s", PATIENCE_SECONDS);
    }
    if (status == LF_OK && !b->content->scene)
        return lf_error_set(err, LF_E_ARG, b->arguments->scene,
                            "is a finished image; expected a scene");
    return status;
}

/* --------------------------------------------------------------------------------- reference -- */

static void fill_to_linear(float out[256])
{
    for (int i = 0; i < 256; i++) {
        double s = i / 255.0;
        out[i] = (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
    }
}

static lf_status render_film(const bench *b, const lf_render_settings *settings, lf_pool *pool,
                             const lf_budget *budget, float *film, double *out_seconds,
                             lf_error *err)
{
    lf_renderer *renderer = NULL;
    lf_render_times times;
    lf_status status = lf_renderer_create(b->content->scene, settings, pool, &renderer, err);
    if (status != LF_OK)
        return status;
    double start = lf_time_now();
    status = lf_render_run(renderer, budget, b->arguments->options.estimator, film, NULL, NULL,
                           NULL, &times);
    *out_seconds = lf_time_now() - start;
    lf_renderer_destroy(renderer);
    return status == LF_OK ? LF_OK
                           : lf_error_set(err, status, b->arguments->scene, "rendering failed");
}

/* The panel's picture of a film, as the engine makes it. */
static lf_status compose(const bench *b, const float *film, uint8_t *views, lf_image8 *out,
                         lf_error *err)
{
    const lf_layout *l = &b->content->layout;
    size_t row = (size_t)l->view_width * 3;
    const lf_views8 v = {l->n_views, l->view_width, l->view_height, row, row * (size_t)l->n_views,
                         views};
    lf_tone *tone = NULL;
    lf_interlacer *interlacer = NULL;
    lf_status status =
        lf_tone_create(b->content->film.exposure, b->content->film.tonemap, &tone, err);
    if (status == LF_OK)
        status =
            lf_interlacer_create(&b->calibration, l->n_views, l->view_width, l->view_height,
                                 l->aspect, LF_FILTER_NEAREST, LF_INVERT_AUTO, &interlacer, err);
    if (status == LF_OK) {
        lf_tone_map(tone, v.row_stride / 3 * (size_t)l->view_height, film, views);
        lf_interlace(interlacer, &v, out, NULL);
    }
    lf_tone_destroy(tone);
    lf_interlacer_destroy(interlacer);
    return status;
}

/* Of the content that is shown: the mean of two panel pictures, and from half their difference what
 * that mean is off by. */
static lf_status make_reference(bench *b, lf_error *err)
{
    const lf_layout *l = &b->content->layout;
    size_t samples = (size_t)l->n_views * (size_t)l->view_width * (size_t)l->view_height * 3;
    const lf_budget budget = {.cpu_seconds = b->arguments->reference_seconds};
    float *film = lf_calloc(samples, sizeof *film);
    uint8_t *views = lf_calloc(samples, 1);
    lf_image8 panel[2] = {{0}, {0}};
    lf_pool *pool = NULL;
    double seconds, sum = 0;
    lf_status status = LF_OK;
    for (int i = 0; i < 2 && status == LF_OK; i++)
        status = lf_image8_init(&panel[i], b->calibration.screen_width_px,
                                b->calibration.screen_height_px, 3);
    if (status != LF_OK || !film || !views ||
        lf_pool_create(b->arguments->options.threads, &pool) != LF_OK)
        status = lf_error_set(err, LF_E_NOMEM, b->arguments->scene, "out of memory");
    for (uint64_t i = 0; i < 2 && status == LF_OK; i++) {
        lf_render_settings settings = b->content->settings;
        settings.seed = REFERENCE_SEED + i;
        settings.features = false; /* the reference is unfiltered, whatever is shown */
        status = render_film(b, &settings, pool, &budget, film, &seconds, err);
        if (status == LF_OK)
            status = compose(b, film, views, &panel[i], err);
    }
    for (size_t i = 0; i < b->n && status == LF_OK; i++) {
        double x = (double)b->to_linear[panel[0].data[i]],
               y = (double)b->to_linear[panel[1].data[i]], mean = 0.5 * (x + y);
        sum += 0.25 * (x - y) * (x - y) / (mean * mean + b->arguments->epsilon);
        b->reference[i] = (float)mean;
    }
    b->reference_error = sum / (double)b->n;
    lf_pool_destroy(pool);
    lf_image8_finish(&panel[0]);
    lf_image8_finish(&panel[1]);
    lf_free(film);
    lf_free(views);
    return status;
}

static double panel_error(const bench *b, const uint8_t *shown)
{
    double sum = 0;
    for (size_t i = 0; i < b->n; i++) {
        double r = (double)b->reference[i], d = (double)b->to_linear[shown[i]] - r;
        sum += d * d / (r * r + b->arguments->epsilon);
    }
    return sum / (double)b->n - b->reference_error;
}

/* --------------------------------------------------------------------------------- measuring -- */

static void add_watch(bench *b, const watch *w)
{
    lf_timing_add(&b->coarse, w->coarse);
    lf_timing_add(&b->complete, w->complete);
    lf_timing_add(&b->coarse_cpu, w->coarse_cpu);
    lf_timing_add(&b->complete_cpu, w->complete_cpu);
    lf_timing_add(&b->updates, w->updates / b->arguments->seconds);
    lf_timing_add(&b->wire_bytes, w->wire_bytes / b->arguments->seconds);
    lf_timing_add(&b->cpu, w->cpu_seconds / b->arguments->seconds);
}

static void pause_engine(bench *b, bool paused)
{
    lf_engine_controls controls = lf_engine_get_controls(b->engine);
    controls.paused = paused;
    lf_engine_set_controls(b->engine, &controls);
}

static lf_status measure_commands(bench *b, lf_error *err)
{
    const arguments *a = b->arguments;
    lf_status status = LF_OK;
    watch w;
    for (int i = 0; i < a->repeat && status == LF_OK; i++) {
        status = follow(b, a->yaw, a->seconds, true, &w, err);
        if (status != LF_OK)
            break;
        add_watch(b, &w);
        if (i == 0) { /* the same view of the scene every time; nothing else renders meanwhile */
            pause_engine(b, true);
            status = make_reference(b, err);
            pause_engine(b, false);
        }
        for (int k = 0; k < b->n_moments && status == LF_OK; k++)
            lf_timing_add(&b->rel_mse[k], panel_error(b, b->shown[k]));
        if (status == LF_OK) /* and back */
            status = follow(b, -a->yaw, 0.1, false, &w, err);
    }
    return status;
}

/* CPU share of a converged daemon: any error is low enough for it. */
static lf_status measure_idle(bench *b, lf_error *err)
{
    lf_engine_controls controls = lf_engine_get_controls(b->engine);
    lf_engine_status status;
    watch w = {.start = lf_time_now()};
    controls.target_error = 1e30;
    lf_engine_set_controls(b->engine, &controls);
    do {
        wait_for_news(b, &w, lf_time_now() - w.start + 0.1);
        show(b, &w);
        lf_engine_get_status(b->engine, &status);
        if (lf_time_now() - w.start > PATIENCE_SECONDS)
            return lf_error_set(err, LF_E_STATE, b->arguments->scene,
                                "the scene does not converge");
    } while (status.state != LF_STATE_CONVERGED);
    double start = lf_time_now(), cpu = lf_time_cpu();
    while (lf_time_now() - start < IDLE_SECONDS) {
        wait_for_news(b, &w, lf_time_now() - w.start + IDLE_SECONDS - (lf_time_now() - start));
        show(b, &w);
    }
    b->idle_cpu = (lf_time_cpu() - cpu) / (lf_time_now() - start);
    return LF_OK;
}

/* Wall clock of the same passes on one thread over that on all of them, in turns. */
static lf_status measure_speed_up(bench *b, lf_error *err)
{
    const lf_layout *l = &b->content->layout;
    const lf_budget budget = {.passes = b->arguments->speed_passes};
    float *film = lf_calloc((size_t)l->n_views * (size_t)l->view_width * (size_t)l->view_height,
                            3 * sizeof *film);
    lf_pool *pools[2] = {NULL, NULL};
    lf_timing times[2] = {0};
    lf_status status = LF_OK;
    if (!film || lf_pool_create(1, &pools[0]) != LF_OK ||
        lf_pool_create(b->arguments->options.threads, &pools[1]) != LF_OK)
        status = lf_error_set(err, LF_E_NOMEM, b->arguments->scene, "out of memory");
    for (int i = 0; i < 2 * SPEED_REPEAT && status == LF_OK; i++) {
        double seconds = 0;
        lf_render_settings settings = b->content->settings;
        settings.features = false;
        status = render_film(b, &settings, pools[i % 2], &budget, film, &seconds, err);
        lf_timing_add(&times[i % 2], seconds);
    }
    b->speed_up = lf_timing_quantile(&times[0], 0) / lf_timing_quantile(&times[1], 0);
    lf_pool_destroy(pools[0]);
    lf_pool_destroy(pools[1]);
    lf_free(film);
    return status;
}

/* ------------------------------------------------------------------------------------ answer -- */

static void print_frame(const char *level, const lf_timing *wall, const lf_timing *cpu)
{
    printf("to a %-8s frame    median %.3f s, 95 %% %.3f s; of CPU time %.3f s (%.3f .. %.3f)\n",
           level, lf_timing_quantile(wall, 0.5), lf_timing_quantile(wall, 0.95),
           lf_timing_quantile(cpu, 0.5), lf_timing_quantile(cpu, 0), lf_timing_quantile(cpu, 1));
}

static void print_table(const bench *b)
{
    const lf_layout *l = &b->content->layout;
    printf("%s: %d views of %dx%d on a panel of %dx%d, orbit by %g degrees, %d times\n\n",
           b->arguments->scene, l->n_views, l->view_width, l->view_height,
           b->calibration.screen_width_px, b->calibration.screen_height_px, b->arguments->yaw,
           b->arguments->repeat);
    print_frame("coarse", &b->coarse, &b->coarse_cpu);
    print_frame("complete", &b->complete, &b->complete_cpu);
    for (int k = 0; k < b->n_moments; k++)
        printf("after %5.1f s          relMSE of the panel %.4g (%.4g .. %.4g)\n", all_moments[k],
               lf_timing_quantile(&b->rel_mse[k], 0.5), lf_timing_quantile(&b->rel_mse[k], 0),
               lf_timing_quantile(&b->rel_mse[k], 1));
    printf("                       (of the reference itself: %.3g, subtracted)\n",
           b->reference_error);
    printf("while it converges     %.1f updates and %.2f MB a second, %.2f CPUs\n",
           lf_timing_quantile(&b->updates, 0.5), 1e-6 * lf_timing_quantile(&b->wire_bytes, 0.5),
           lf_timing_quantile(&b->cpu, 0.5));
    printf("converged              %.2f %% of a CPU\n", 100 * b->idle_cpu);
    if (b->arguments->speed_passes > 0)
        printf("all threads            %.2f times one\n", b->speed_up);
}

static json_t *quantiles(const lf_timing *t)
{
    return json_pack("{s:f, s:f, s:f, s:f}", "median", lf_timing_quantile(t, 0.5), "p95",
                     lf_timing_quantile(t, 0.95), "low", lf_timing_quantile(t, 0), "high",
                     lf_timing_quantile(t, 1));
}

static lf_status write_json(const bench *b, lf_error *err)
{
    const arguments *a = b->arguments;
    const lf_layout *l = &b->content->layout;
    json_t *moments = json_array();
    for (int k = 0; k < b->n_moments; k++)
        json_array_append_new(moments, json_pack("{s:f, s:o}", "seconds", all_moments[k], "rel_mse",
                                                 quantiles(&b->rel_mse[k])));
    json_t *object = json_pack(
        "{s:s, s:o, s:i, s:i, s:i, s:i, s:i, s:i, s:f, s:f, s:o, s:o, s:o, s:o, s:o, s:f, s:o, "
        "s:o, s:o, s:f, s:o}",
        "scene", a->scene, "machine", lf_bench_machine(), "views", l->n_views, "width",
        l->view_width, "height", l->view_height, "panel_width", b->calibration.screen_width_px,
        "panel_height", b->calibration.screen_height_px, "repeat", a->repeat, "yaw", a->yaw,
        "seconds", a->seconds, "coarse_seconds", quantiles(&b->coarse), "complete_seconds",
        quantiles(&b->complete), "coarse_cpu_seconds", quantiles(&b->coarse_cpu),
        "complete_cpu_seconds", quantiles(&b->complete_cpu), "shown", moments, "reference_rel_mse",
        b->reference_error, "updates_per_second", quantiles(&b->updates), "wire_bytes_per_second",
        quantiles(&b->wire_bytes), "cpus", quantiles(&b->cpu), "converged_cpus", b->idle_cpu,
        "speed_up", a->speed_passes > 0 ? json_real(b->speed_up) : json_null());
    return lf_bench_write_json(a->json, object, err);
}

/* ------------------------------------------------------------------------------------ set-up -- */

static lf_status prepare(bench *b, lf_error *err)
{
    const arguments *a = b->arguments;
    const lf_engine_controls controls = {.estimator = a->options.estimator,
                                         .target_error = 1e-12,
                                         .threads = a->options.threads,
                                         .denoise = a->options.denoise};
    lf_status status = LF_OK;
    lf_calibration_portrait(&b->calibration);
    if (a->options.calibration)
        status = lf_calibration_load(a->options.calibration, &b->calibration, err);
    if (status != LF_OK)
        return status;
    fill_to_linear(b->to_linear);
    b->n = (size_t)b->calibration.screen_width_px * (size_t)b->calibration.screen_height_px * 3;
    b->reference = lf_calloc(b->n, sizeof *b->reference);
    bool whole = b->reference;
    while (b->n_moments < MAX_MOMENTS && all_moments[b->n_moments] <= a->seconds) {
        b->shown[b->n_moments] = lf_calloc(b->n, 1);
        whole = whole && b->shown[b->n_moments];
        b->n_moments++;
    }
    b->event_fd = lf_wakeup_make();
    b->has_inbox = whole && b->event_fd >= 0 && lf_inbox_init(&b->inbox) == LF_OK;
    if (!b->has_inbox)
        return lf_error_set(err, LF_E_NOMEM, a->scene, "out of memory");
    status = lf_engine_create(&controls, b->event_fd, &b->engine, err);
    if (status != LF_OK)
        return status;
    lf_engine_set_panel(b->engine, &b->calibration, 1, false);
    status = lf_loader_create(b->engine, &b->roots, &b->inbox, &b->loader);
    return status == LF_OK ? LF_OK : lf_error_set(err, status, a->scene, "cannot start the loader");
}

static void finish(bench *b)
{
    lf_loader_destroy(b->loader);
    lf_engine_destroy(b->engine);
    if (b->has_inbox)
        lf_inbox_finish(&b->inbox, b);
    lf_content_unref(b->content);
    if (b->event_fd >= 0)
        close(b->event_fd);
    lf_free(b->reference);
    for (int i = 0; i < MAX_MOMENTS; i++)
        lf_free(b->shown[i]);
    lf_free(b);
}

static lf_status measure(bench *b, lf_error *err)
{
    lf_status status = start_up(b, err);
    if (status == LF_OK)
        status = measure_commands(b, err);
    if (status == LF_OK)
        status = measure_idle(b, err);
    if (status == LF_OK && b->arguments->speed_passes > 0)
        status = measure_speed_up(b, err);
    if (status == LF_OK && (!b->arguments->json || strcmp(b->arguments->json, "-") != 0))
        print_table(b);
    if (status == LF_OK && b->arguments->json)
        status = write_json(b, err);
    return status;
}

int lf_bench_live(int argc, char **argv)
{
    arguments a = {0};
    lf_error err = {0};
    int code = LF_EXIT_OK;
    if (!lf_bench_command_begin(&command, argc, argv, &a.options, &a, &code))
        return code;
    a.scene = argv[optind];
    bench *b = lf_calloc(1, sizeof *b);
    if (!b) {
        lf_error_set(&err, LF_E_NOMEM, a.scene, "out of memory");
        return lf_bench_fail(&err);
    }
    b->arguments = &a;
    b->event_fd = -1;
    lf_status status = prepare(b, &err);
    if (status == LF_OK)
        status = measure(b, &err);
    finish(b);
    return status == LF_OK ? LF_EXIT_OK : lf_bench_fail(&err);
}
