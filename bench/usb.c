/* quiltbench usb [SCENE]: updates of a simulated USB display in this process, against copying as
 * many bytes; and what a scene that converges sends to it. */
#include <stdio.h>
#include <string.h>

#include "bench/bench.h"
#include "bench/command.h"
#include "bench/usb.h"
#include "device/model/usb_model.h"
#include "device/usb/gud_host.h"

typedef struct arguments {
    lf_options options;
    const char *scene; /* NULL = none */
    const char *json;
    int repeat;
    double seconds;
} arguments;

typedef enum content {
    NOISE,
    GRADIENTS,
    SCENE, /* the panel's picture of the scene, right way up and upside down */
} content;

/* A display and what it is made to show. */
typedef struct work {
    const char *name;
    uint8_t format;
    bool lz4;
    content content;
    bool same; /* the display shows it already */
    int side;  /* of a square that changes; 0 = the whole panel */
} work;

static const work works[] = {
    {"noise, RGB888", LF_GUD_RGB888, false, NOISE, false, 0},
    {"noise, XRGB8888", LF_GUD_XRGB8888, false, NOISE, false, 0},
    {"noise, RGB565", LF_GUD_RGB565, false, NOISE, false, 0},
    {"noise, RGB888, LZ4 offered", LF_GUD_RGB888, true, NOISE, false, 0},
    {"gradients, RGB888, LZ4 offered", LF_GUD_RGB888, true, GRADIENTS, false, 0},
    {"scene, RGB888", LF_GUD_RGB888, false, SCENE, false, 0},
    {"scene, XRGB8888", LF_GUD_XRGB8888, false, SCENE, false, 0},
    {"scene, RGB565", LF_GUD_RGB565, false, SCENE, false, 0},
    {"scene, RGB888, LZ4 offered", LF_GUD_RGB888, true, SCENE, false, 0},
    {"unchanged, RGB888", LF_GUD_RGB888, false, NOISE, true, 0},
    {"471x471 of noise, RGB888", LF_GUD_RGB888, false, NOISE, false, 471},
};

static const lf_rect panels[] = {{0, 0, 1536, 2048}, {0, 0, 3840, 2160}};

typedef struct bench {
    const arguments *arguments;
    json_t *lines;
    lf_model_gud *gud;
    lf_usb_link *link;
    lf_gud_host *host;
    lf_image8 pictures[2], copy;
    lf_image8 scene; /* of a Portrait; empty = none */
} bench;

static const char shared[] = "calibration " LF_OPTIONS_VIEWS " " LF_OPTIONS_RENDER;

static const lf_param own[] = {
    LF_BENCH_FIELD(LF_PARAM_NUMBER, "seconds", offsetof(arguments, seconds), "S", 0.1, 3600, 20,
                   "time to converge"),
    LF_BENCH_REPEAT(offsetof(arguments, repeat), 15,
                    "number of repetitions; the median is reported"),
    LF_BENCH_JSON(offsetof(arguments, json)),
    {0},
};

static void print_help(void)
{
    printf("Usage: quiltbench usb [SCENE] [options]\n"
           "Measure updates of a simulated USB display in this process, including the decoding: "
           "milliseconds, MB/s of changed\n"
           "pixels (three bytes each), bytes on the wire, and the ratio to copying the changed "
           "pixels. With a scene, also measure\n"
           "what its rendering sends while it converges; the default panel is a nominal "
           "Portrait.\n\n");
    lf_param_print_help(own, NULL);
    lf_param_print_help(lf_option_params, shared);
    printf(LF_OPTIONS_HELP_LAST);
}

static const lf_bench_command command = {"usb", shared, own, print_help, 0, 1, "at most one SCENE"};

/* ---------------------------------------------------------------------------------- pictures -- */

static uint8_t noise_at(int x, int y, int seed)
{
    uint32_t h = (uint32_t)x * 73856093u ^ (uint32_t)y * 19349663u ^ (uint32_t)seed * 83492791u;
    h = (h ^ h >> 15) * 2246822519u;
    return (uint8_t)(h >> 13);
}

static uint8_t gradient_at(int x, int y, int seed)
{
    return (uint8_t)(x / 96 + y / 32 + seed);
}

static bool inside(lf_rect r, int x, int y)
{
    return x >= r.x && x < r.x + r.width && y >= r.y && y < r.y + r.height;
}

static uint8_t sample_at(const bench *b, content c, int x, int y, int seed)
{
    switch (c) {
    case NOISE:
        return noise_at(x, y, seed);
    case GRADIENTS:
        return gradient_at(x, y, seed);
    case SCENE:
        break;
    }
    /* a panel that is larger shows it several times */
    int row = y % b->scene.height;
    return b->scene.data[(size_t)(seed ? b->scene.height - 1 - row : row) * b->scene.stride +
                         (size_t)(x % (3 * b->scene.width))];
}

/* Both pictures; they differ within `changed` only, and not at all when the display is to show it
 * already. */
static void paint(bench *b, const work *w, lf_rect changed)
{
    for (int i = 0; i < 2; i++)
        for (int y = 0; y < b->pictures[i].height; y++)
            for (int x = 0; x < b->pictures[i].width * 3; x++) {
                int seed = i > 0 && !w->same && inside(changed, x / 3, y) ? 1 : 0;
                b->pictures[i].data[(size_t)y * b->pictures[i].stride + (size_t)x] =
                    sample_at(b, w->content, x, y, seed);
            }
}

static lf_rect changed_by(const work *w, lf_rect panel)
{
    return w->side > 0 ? (lf_rect){panel.width / 3, panel.height / 3, w->side, w->side} : panel;
}

static void finish(bench *b)
{
    lf_gud_host_destroy(b->host);
    if (b->link)
        b->link->ops->close(b->link);
    lf_model_gud_destroy(b->gud);
    b->host = NULL;
    b->link = NULL;
    b->gud = NULL;
    for (int i = 0; i < 2; i++)
        lf_image8_finish(&b->pictures[i]);
    lf_image8_finish(&b->copy);
}

static lf_status make(bench *b, const work *w, lf_rect panel, lf_error *err)
{
    const lf_model_gud_options options = {.width = panel.width,
                                          .height = panel.height,
                                          .formats = &w->format,
                                          .n_formats = 1,
                                          .lz4 = w->lz4};
    if (lf_image8_init(&b->pictures[0], panel.width, panel.height, 3) != LF_OK ||
        lf_image8_init(&b->pictures[1], panel.width, panel.height, 3) != LF_OK ||
        lf_image8_init(&b->copy, panel.width, panel.height, 3) != LF_OK ||
        lf_model_gud_create(&options, NULL, &b->gud) != LF_OK ||
        !(b->link = lf_usb_model_open(b->gud)))
        return lf_error_set(err, LF_E_NOMEM, "usb", "out of memory");
    paint(b, w, changed_by(w, panel));
    lf_status status = lf_gud_host_open(b->link, &b->host, err);
    if (status == LF_OK)
        status = lf_gud_host_choose(b->host, panel.width, panel.height, err);
    if (status == LF_OK)
        status = lf_gud_host_start(b->host, err);
    return status == LF_OK ? lf_gud_host_update(b->host, &b->pictures[1], &panel, 1, err) : status;
}

/* ------------------------------------------------------------------------------------ timing -- */

static void copy_rect(bench *b, const lf_image8 *from, lf_rect r)
{
    for (int y = r.y; y < r.y + r.height; y++)
        memcpy(b->copy.data + (size_t)y * b->copy.stride + (size_t)r.x * 3,
               from->data + (size_t)y * from->stride + (size_t)r.x * 3, (size_t)r.width * 3);
}

static void report(bench *b, const work *w, lf_rect panel, lf_rect changed, double seconds,
                   double copying, uint64_t wire)
{
    double bytes = (double)changed.width * changed.height * 3;
    char name[128];
    snprintf(name, sizeof name, "%dx%d: %s", panel.width, panel.height, w->name);
    if (!lf_bench_is_stdout(b->arguments->json))
        printf("%-44s %10.3f %10.0f %12.0f %10.3f %8.2f\n", name, 1e3 * seconds,
               1e-6 * bytes / seconds, (double)wire, 1e3 * copying, seconds / copying);
    json_array_append_new(b->lines,
                          json_pack("{s:s, s:f, s:f, s:I, s:f, s:f}", "what", name, "ms",
                                    1e3 * seconds, "mb_per_second", 1e-6 * bytes / seconds,
                                    "bytes_on_the_wire", (json_int_t)wire, "copy_ms", 1e3 * copying,
                                    "ratio_to_copy", seconds / copying));
}

/* Shows the pictures in turn. The display shows the second one before. */
static lf_status measure(bench *b, const work *w, lf_rect panel, lf_error *err)
{
    lf_timing updates = {0}, copies = {0};
    lf_gud_host_counters before, after;
    lf_rect changed = changed_by(w, panel);
    lf_status status = LF_OK;
    lf_gud_host_counters_get(b->host, &before);
    for (int i = 0; i < b->arguments->repeat && status == LF_OK; i++) {
        double start = lf_time_now();
        copy_rect(b, &b->pictures[i % 2], changed);
        double middle = lf_time_now();
        status = lf_gud_host_update(b->host, &b->pictures[i % 2], &changed, 1, err);
        lf_timing_add(&copies, middle - start);
        lf_timing_add(&updates, lf_time_now() - middle);
    }
    lf_gud_host_counters_get(b->host, &after);
    if (status == LF_OK)
        report(b, w, panel, changed, lf_timing_quantile(&updates, 0.5),
               lf_timing_quantile(&copies, 0.5),
               (after.bytes - before.bytes) / (uint64_t)b->arguments->repeat);
    return status;
}

static lf_status measure_all(bench *b, lf_error *err)
{
    lf_status status = LF_OK;
    for (size_t p = 0; p < sizeof panels / sizeof panels[0]; p++)
        for (size_t i = 0; i < sizeof works / sizeof works[0] && status == LF_OK; i++) {
            if (works[i].content == SCENE && !b->scene.data)
                continue;
            status = make(b, &works[i], panels[p], err);
            if (status == LF_OK)
                status = measure(b, &works[i], panels[p], err);
            finish(b);
        }
    return status;
}

/* -------------------------------------------------------------------------------- converging -- */

static void report_converging(bench *b, const lf_bench_converge *c)
{
    double per_second = (c->updates - 1) / c->shown_seconds,
           share = c->wire_bytes / (c->updates * c->frame_bytes);
    double later = (c->wire_bytes - c->first_bytes) / ((c->updates - 1) * c->frame_bytes);
    if (!lf_bench_is_stdout(b->arguments->json))
        printf("converging, RGB888%-26s %.1f updates per second for %.0f s, %.0f bytes each: %.2f "
               "%% of full frames (%.2f %% without the first), last image %s\n",
               c->lz4 ? ", LZ4 offered" : "", per_second, c->shown_seconds,
               c->wire_bytes / c->updates, 100 * share, 100 * later,
               c->differences == 0 ? "exact" : "NOT EXACT");
    json_array_append_new(
        b->lines, json_pack("{s:s, s:b, s:f, s:f, s:f, s:f, s:f, s:b}", "what", "converging", "lz4",
                            c->lz4, "seconds", c->shown_seconds, "updates_per_second", per_second,
                            "bytes_an_update", c->wire_bytes / c->updates, "share_of_full_frames",
                            share, "share_without_the_first", later, "exact", c->differences == 0));
}

static lf_status measure_converging(bench *b, lf_error *err)
{
    lf_status status = LF_OK;
    for (int lz4 = 0; lz4 < 2 && b->arguments->scene && status == LF_OK; lz4++) {
        lf_bench_converge c = {.seconds = b->arguments->seconds, .lz4 = lz4 > 0};
        lf_image8_finish(&b->scene);
        status =
            lf_bench_usb_converge(b->arguments->scene, &b->arguments->options, &c, &b->scene, err);
        if (status == LF_OK)
            report_converging(b, &c);
        if (status == LF_OK && c.differences > 0)
            status =
                lf_error_set(err, LF_E_STATE, "usb",
                             "the last image on the display differs from the frame in %lld bytes",
                             (long long)c.differences);
    }
    return status;
}

int lf_bench_usb(int argc, char **argv)
{
    arguments a = {0};
    bench b = {.arguments = &a};
    lf_error err = {0};
    int code = LF_EXIT_OK;
    if (!lf_bench_command_begin(&command, argc, argv, &a.options, &a, &code))
        return code;
    a.scene = argv[optind]; /* NULL = none */
    b.lines = json_array();
    lf_status status = measure_converging(&b, &err);
    if (status == LF_OK && !lf_bench_is_stdout(a.json))
        printf("%-44s %10s %10s %12s %10s %8s\n", "", "ms", "MB/s", "wire bytes", "copy ms",
               "ratio");
    if (status == LF_OK)
        status = measure_all(&b, &err);
    if (status == LF_OK && a.json) {
        json_t *object = json_pack("{s:o, s:i, s:O}", "machine", lf_bench_machine(), "repeat",
                                   a.repeat, "lines", b.lines);
        status = lf_bench_write_json(a.json, object, &err);
    }
    lf_image8_finish(&b.scene);
    json_decref(b.lines);
    return status == LF_OK ? LF_EXIT_OK : lf_bench_fail(&err);
}
