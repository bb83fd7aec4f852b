/* quiltbench quilt: the steps from resolved views to a panel, a file or a printer, compared with
 * copying as many bytes. */
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/alloc.h"
#include "bench/bench.h"
#include "bench/command.h"

#define MAX_PANELS 16
#define PIECE_BYTES (1 << 20)
#define PRINT_LPI 60
#define PRINT_DPI 600
#define NO_MEMORY_FILES "the system has no memory files (memfd_create)"

typedef struct arguments {
    lf_options options; /* views, view size */
    const char *json;
    const char *panels[MAX_PANELS];
    int n_panels;
    int repeat;
} arguments;

/* A step to be timed; bytes: the minimum it must read and write. */
typedef struct work {
    const char *name;
    lf_status (*run)(void *context, lf_pool *pool, lf_error *err);
    void *context;
    size_t bytes_in, bytes_out;
    bool alone; /* always runs on one thread */
    bool once;  /* slow: runs once */
    /* what it is compared with: writing bytes_out to a file in memory, not copying all bytes */
    bool is_file;
} work;

/* Times of the repetitions: wall clock, and CPU seconds of all threads. */
typedef struct times {
    lf_timing wall, cpu;
} times;

typedef struct bench {
    const arguments *arguments;
    lf_pool *pool;
    json_t *lines;
    uint8_t *copy_from, *copy_to;
    size_t copy_room;
} bench;

static const char shared[] = "views view-size threads";

static const lf_param own[] = {
    LF_BENCH_REPEAT(offsetof(arguments, repeat), 9,
                    "number of repetitions; the median is reported"),
    LF_BENCH_JSON(offsetof(arguments, json)),
    {0},
};

static void print_help(void)
{
    printf("Usage: quiltbench quilt [CALIBRATION.json …] [options]\n"
           "Measure interlacing for these panels (default: a nominal Portrait and one of "
           "7680x4320), tone mapping, filling,\n"
           "comparing and printing: milliseconds, GB/s in and out, and the ratio of the CPU time "
           "to the CPU time of copying the\n"
           "same bytes with the same threads; for prints, of writing as many bytes to a file in "
           "memory. Default: 45 views of 420x560 pixels, or 1638x910 for "
           "panels over 4 million pixels.\n"
           "Each measurement is repeated with --threads threads.\n\n");
    lf_param_print_help(own, NULL);
    lf_param_print_help(lf_option_params, shared);
    printf(LF_OPTIONS_HELP_LAST);
}

static const lf_bench_command command = {
    "quilt", shared, own, print_help, 0, MAX_PANELS, "the calibration files of a few panels"};

/* ------------------------------------------------------------------------------------ timing -- */

static void copy_piece(void *context, int item, int worker)
{
    const bench *b = context;
    size_t at = (size_t)item * PIECE_BYTES;
    (void)worker;
    memcpy(b->copy_to + at, b->copy_from + at, PIECE_BYTES);
}

/* Reads and writes `bytes` bytes in total, rounded to whole pieces. */
static void copy(bench *b, size_t bytes, lf_pool *pool)
{
    int n = (int)((bytes / 2 + PIECE_BYTES - 1) / PIECE_BYTES);
    if (pool && lf_pool_run(pool, n, copy_piece, b, NULL) == LF_OK)
        return;
    for (int i = 0; i < n; i++)
        copy_piece(b, i, 0);
}

/* Writes as many bytes to a file in memory. */
static lf_status write_plainly(bench *b, size_t bytes, lf_error *err)
{
    lf_outfile file = {.fd = memfd_create("plain", MFD_CLOEXEC), .borrowed = true};
    lf_status status = LF_OK;
    if (file.fd < 0)
        return lf_error_set(err, LF_E_IO, "print", NO_MEMORY_FILES);
    for (size_t at = 0; at < bytes && status == LF_OK; at += PIECE_BYTES)
        status = lf_outfile_write(&file, b->copy_from,
                                  bytes - at < PIECE_BYTES ? bytes - at : PIECE_BYTES, err);
    lf_outfile_abandon(&file);
    return status;
}

static lf_status make_copy_room(bench *b, size_t bytes, lf_error *err)
{
    size_t room = (bytes / 2 / PIECE_BYTES + 1) * PIECE_BYTES;
    if (room <= b->copy_room)
        return LF_OK;
    lf_free(b->copy_from);
    lf_free(b->copy_to);
    b->copy_from = lf_calloc(room, 1);
    b->copy_to = lf_calloc(room, 1);
    b->copy_room = b->copy_from && b->copy_to ? room : 0;
    if (b->copy_room == 0)
        return lf_error_set(err, LF_E_NOMEM, "quilt", "out of memory");
    memset(b->copy_from, 1, room); /* forces real pages instead of the shared zero page */
    memset(b->copy_to, 1, room);
    return LF_OK;
}

static void report(bench *b, const work *w, int threads, const times *work_times,
                   const times *copies)
{
    double seconds = lf_timing_quantile(&work_times->wall, 0.5),
           cpu = lf_timing_quantile(&work_times->cpu, 0.5);
    double copying = lf_timing_quantile(&copies->cpu, 0.5),
           bytes = (double)(w->bytes_in + w->bytes_out);
    if (!b->arguments->json || strcmp(b->arguments->json, "-") != 0)
        printf("%-44s %7d %10.3f %10.3f %8.2f %10.3f %8.2f\n", w->name, threads, 1e3 * seconds,
               1e3 * cpu, 1e-9 * bytes / seconds, 1e3 * copying, cpu / copying);
    json_array_append_new(
        b->lines, json_pack("{s:s, s:i, s:f, s:f, s:f, s:I, s:I, s:f, s:f, s:f}", "what", w->name,
                            "threads", threads, "ms", 1e3 * seconds, "ms_best",
                            1e3 * lf_timing_quantile(&work_times->wall, 0), "cpu_ms", 1e3 * cpu,
                            "bytes_in", (json_int_t)w->bytes_in, "bytes_out",
                            (json_int_t)w->bytes_out, "gb_per_second", 1e-9 * bytes / seconds,
                            "copy_cpu_ms", 1e3 * copying, "ratio_to_copy", cpu / copying));
}

static void add_times(times *t, double wall, double cpu)
{
    lf_timing_add(&t->wall, lf_time_now() - wall);
    lf_timing_add(&t->cpu, lf_time_cpu() - cpu);
}

static lf_status measure_on(bench *b, const work *w, lf_pool *pool, lf_error *err)
{
    times work_times = {0};
    times copies = {0};
    /* warm-up of pages and caches */
    lf_status status = w->once ? LF_OK : w->run(w->context, pool, err);
    for (int i = 0; i < (w->once ? 1 : b->arguments->repeat) && status == LF_OK; i++) {
        double wall = lf_time_now(), cpu = lf_time_cpu();
        if (w->is_file)
            status = write_plainly(b, w->bytes_out, err);
        else
            copy(b, w->bytes_in + w->bytes_out, pool);
        add_times(&copies, wall, cpu);
        wall = lf_time_now();
        cpu = lf_time_cpu();
        if (status == LF_OK)
            status = w->run(w->context, pool, err);
        add_times(&work_times, wall, cpu);
    }
    if (status == LF_OK)
        report(b, w, pool ? lf_pool_threads(pool) : 1, &work_times, &copies);
    return status;
}

static lf_status measure(bench *b, const work *w, lf_error *err)
{
    lf_status status = make_copy_room(b, w->bytes_in + w->bytes_out, err);
    if (status == LF_OK)
        status = measure_on(b, w, NULL, err);
    if (status == LF_OK && !w->alone && lf_pool_threads(b->pool) > 1)
        status = measure_on(b, w, b->pool, err);
    return status;
}

/* ------------------------------------------------------------------------------------ panels -- */

typedef struct panel {
    char name[64];
    lf_calibration calibration;
    lf_views8 views;
    uint8_t *data;
    lf_image8 out, before;
    lf_interlacer *interlacer;
    lf_filter filter;
} panel;

static lf_status run_create(void *context, lf_pool *pool, lf_error *err)
{
    panel *p = context;
    (void)pool;
    lf_interlacer_destroy(p->interlacer);
    p->interlacer = NULL;
    return lf_interlacer_create(&p->calibration, p->views.n_views, p->views.width, p->views.height,
                                0, p->filter, LF_INVERT_AUTO, &p->interlacer, err);
}

static lf_status run_interlace(void *context, lf_pool *pool, lf_error *err)
{
    panel *p = context;
    (void)err;
    lf_interlace(p->interlacer, &p->views, &p->out, pool);
    return LF_OK;
}

static lf_status run_compare(void *context, lf_pool *pool, lf_error *err)
{
    const panel *p = context;
    lf_rect rects[8];
    (void)pool;
    if (lf_changed_rects(&p->before, &p->out, rects, 8) != 1)
        return lf_error_set(err, LF_E_STATE, "quilt",
                            "one pixel differs, so one rectangle was expected");
    return LF_OK;
}

static void fill_with_noise(uint8_t *data, size_t n)
{
    for (size_t i = 0; i < n; i++)
        data[i] = (uint8_t)(i * 2654435761u >> 13);
}

static lf_status make_panel(panel *p, const arguments *a, lf_error *err)
{
    const lf_calibration *c = &p->calibration;
    bool large = (int64_t)c->screen_width_px * c->screen_height_px > 4000000;
    int width = a->options.view_width ? a->options.view_width : large ? 1638 : 420;
    int height = a->options.view_width ? a->options.view_height : large ? 910 : 560;
    size_t row = (size_t)width * 3;
    int n_views = a->options.views ? a->options.views : 45;
    p->data = lf_calloc((size_t)n_views * (size_t)height, row);
    /* the daemon's order */
    p->views = (lf_views8){n_views, width, height, row, row * (size_t)n_views, p->data};
    if (!p->data || lf_image8_init(&p->out, c->screen_width_px, c->screen_height_px, 3) != LF_OK ||
        lf_image8_init(&p->before, c->screen_width_px, c->screen_height_px, 3) != LF_OK)
        return lf_error_set(err, LF_E_NOMEM, p->name, "out of memory");
    fill_with_noise(p->data, (size_t)n_views * (size_t)height * row);
    return LF_OK;
}

static void finish_panel(panel *p)
{
    lf_interlacer_destroy(p->interlacer);
    lf_image8_finish(&p->out);
    lf_image8_finish(&p->before);
    lf_free(p->data);
}

static lf_status measure_interlacing(bench *b, panel *p, lf_filter filter, lf_error *err)
{
    char name[128];
    const char *how = filter == LF_FILTER_LINEAR ? "linear" : "nearest";
    size_t in = p->views.row_stride * (size_t)p->views.height,
           out = p->out.stride * (size_t)p->out.height;
    work w = {.name = name, .run = run_create, .context = p, .bytes_out = out, .alone = true};
    p->filter = filter;
    snprintf(name, sizeof name, "%s %dx%d: prepare %s", p->name, p->out.width, p->out.height, how);
    lf_status status = measure(b, &w, err);
    snprintf(name, sizeof name, "%s %dx%d: interlace %s", p->name, p->out.width, p->out.height,
             how);
    w.run = run_interlace;
    w.bytes_in = in;
    w.alone = false;
    w.once = filter == LF_FILTER_LINEAR;
    return status == LF_OK ? measure(b, &w, err) : status;
}

static lf_status measure_panel(bench *b, panel *p, lf_error *err)
{
    char name[128];
    lf_status status = make_panel(p, b->arguments, err);
    if (status == LF_OK)
        status = measure_interlacing(b, p, LF_FILTER_NEAREST, err);
    if (status == LF_OK) {
        size_t bytes = p->out.stride * (size_t)p->out.height;
        memcpy(p->before.data, p->out.data, bytes);
        p->before.data[bytes / 2] ^= 1;
        snprintf(name, sizeof name, "%s %dx%d: compare", p->name, p->out.width, p->out.height);
        const work w = {
            .name = name, .run = run_compare, .context = p, .bytes_in = 2 * bytes, .alone = true};
        status = measure(b, &w, err);
    }
    if (status == LF_OK)
        status = measure_interlacing(b, p, LF_FILTER_LINEAR, err);
    finish_panel(p);
    return status;
}

static lf_status measure_panels(bench *b, lf_error *err)
{
    const arguments *a = b->arguments;
    lf_status status = LF_OK;
    for (int i = 0; i < (a->n_panels ? a->n_panels : 2) && status == LF_OK; i++) {
        panel p = {.name = "panel"};
        if (a->n_panels) {
            status = lf_calibration_load(a->panels[i], &p.calibration, err);
            if (status == LF_OK && p.calibration.serial[0])
                snprintf(p.name, sizeof p.name, "%s", p.calibration.serial);
        } else {
            lf_calibration_portrait(&p.calibration);
            if (i == 1) {
                p.calibration.screen_width_px = 7680;
                p.calibration.screen_height_px = 4320;
            }
        }
        if (status == LF_OK)
            status = measure_panel(b, &p, err);
    }
    return status;
}

/* ------------------------------------------------------------------------------------- views -- */

typedef struct field {
    int n_views, width, height;
    size_t pixels;
    float *linear;
    uint8_t *rgb, *filled, *missing;
    lf_tone *tone;
} field;

static void tone_row(void *context, int row, int worker)
{
    const field *f = context;
    size_t n = f->pixels / (size_t)f->height, at = (size_t)row * n * 3;
    (void)worker;
    lf_tone_map(f->tone, n, f->linear + at, f->rgb + at);
}

static lf_status run_tone(void *context, lf_pool *pool, lf_error *err)
{
    field *f = context;
    (void)err;
    if (pool && lf_pool_run(pool, f->height, tone_row, f, NULL) == LF_OK)
        return LF_OK;
    for (int row = 0; row < f->height; row++)
        tone_row(f, row, 0);
    return LF_OK;
}

static lf_status run_fill(void *context, lf_pool *pool, lf_error *err)
{
    field *f = context;
    (void)err;
    (void)lf_fill(f->n_views, f->width, f->height, f->rgb, f->missing, 4, 16, f->filled, pool);
    return LF_OK;
}

/* Fixed random numbers, so that every run has the same holes. */
static void make_holes(field *f, double share)
{
    uint32_t x = 1;
    for (size_t i = 0; i < f->pixels; i++) {
        x = x * 1664525u + 1013904223u;
        f->missing[i] = x < share * 4294967296.0;
    }
}

static lf_status make_field(field *f, const arguments *a, lf_error *err)
{
    f->n_views = a->options.views ? a->options.views : 45;
    f->width = a->options.view_width ? a->options.view_width : 420;
    f->height = a->options.view_width ? a->options.view_height : 560;
    f->pixels = (size_t)f->n_views * (size_t)f->width * (size_t)f->height;
    f->linear = lf_calloc(f->pixels, 3 * sizeof(float));
    f->rgb = lf_calloc(f->pixels, 3);
    f->filled = lf_calloc(f->pixels, 3);
    f->missing = lf_calloc(f->pixels, 1);
    if (!f->linear || !f->rgb || !f->filled || !f->missing)
        return lf_error_set(err, LF_E_NOMEM, "quilt", "out of memory");
    for (size_t i = 0; i < 3 * f->pixels; i++)
        f->linear[i] = (float)(i * 2654435761u >> 8 & 0xffff) * 0x1p-16f;
    return LF_OK;
}

static lf_status measure_views(bench *b, field *f, lf_error *err)
{
    static const struct {
        const char *tonemap, *name;
    } tones[] = {{"srgb", "tone mapping, srgb"},
                 {"filmic", "tone mapping, filmic"},
                 {"aces", "tone mapping, aces"}};
    static const struct {
        double share;
        const char *name;
    } holes[] = {
        {0.01, "fill, 1 % missing"}, {0.5, "fill, 50 % missing"}, {0.95, "fill, 95 % missing"}};
    lf_status status = LF_OK;

    for (int i = 0; i < 3 && status == LF_OK; i++) {
        work w = {tones[i].name, run_tone, f,     f->pixels * 3 * sizeof(float),
                  f->pixels * 3, false,    false, false};
        status = lf_tone_create(0.5, tones[i].tonemap, &f->tone, err);
        if (status == LF_OK)
            status = measure(b, &w, err);
        lf_tone_destroy(f->tone);
    }
    for (int i = 0; i < 3 && status == LF_OK; i++) {
        work w = {holes[i].name, run_fill, f, f->pixels * 4, f->pixels * 3, false, false, false};
        make_holes(f, holes[i].share);
        status = measure(b, &w, err);
    }
    return status;
}

/* ------------------------------------------------------------------------------------- print -- */

typedef struct sheet {
    lf_print print;
    lf_print_format format;
    lf_views32 views;
} sheet;

/* Writes to memory, so that no disk is timed. */
static lf_status run_print(void *context, lf_pool *pool, lf_error *err)
{
    const sheet *s = context;
    const lf_print_run run = {.format = s->format, .pool = pool};
    lf_outfile tiff = {.fd = -1};
    lf_outfile manifest = {.fd = -1};
    int fds[2] = {memfd_create("tiff", MFD_CLOEXEC), memfd_create("manifest", MFD_CLOEXEC)};
    lf_status status = LF_OK;
    if (fds[0] < 0 || fds[1] < 0)
        status = lf_error_set(err, LF_E_IO, "print", NO_MEMORY_FILES);
    if (status == LF_OK)
        status = lf_outfile_adopt(&tiff, fds[0], err);
    if (status == LF_OK)
        status = lf_outfile_adopt(&manifest, fds[1], err);
    if (status == LF_OK)
        status = lf_print_write(&s->print, &s->views, &run, &tiff, &manifest, err);
    lf_outfile_abandon(&tiff);
    lf_outfile_abandon(&manifest);
    return status;
}

static lf_status measure_print(bench *b, const field *f, lf_error *err)
{
    static const struct {
        const char *name;
        lf_stripes stripes;
        lf_compress compress;
        int bits;
        lf_print_format format;
    } kinds[] = {{"print, 60 lpi at 600 dpi, fractional", LF_STRIPES_FRACTIONAL, LF_COMPRESS_NONE,
                  8, LF_PRINT_TIFF},
                 {"print, nearest", LF_STRIPES_NEAREST, LF_COMPRESS_NONE, 8, LF_PRINT_TIFF},
                 {"print, 16 bits", LF_STRIPES_FRACTIONAL, LF_COMPRESS_NONE, 16, LF_PRINT_TIFF},
                 {"print, LZW", LF_STRIPES_FRACTIONAL, LF_COMPRESS_LZW, 8, LF_PRINT_TIFF},
                 {"print, PDF", LF_STRIPES_FRACTIONAL, LF_COMPRESS_NONE, 8, LF_PRINT_PDF}};
    int n_views = f->n_views < PRINT_DPI / PRINT_LPI ? f->n_views : PRINT_DPI / PRINT_LPI;
    size_t row = (size_t)f->width * 3;
    sheet s = {.views = {n_views, f->width, f->height, row, row * (size_t)f->n_views, f->linear}};
    lf_print_shape shape;
    lf_status status = LF_OK;

    /* sized so that a lens is a sample of the views */
    s.print = (lf_print){.lpi = PRINT_LPI,
                         .dpi = PRINT_DPI,
                         .n_views = n_views,
                         .bits = 8,
                         .compress = LF_COMPRESS_NONE};
    s.print.width_mm = f->width * 25.4 / PRINT_LPI;
    s.print.height_mm = s.print.width_mm * f->height / f->width;
    lf_print_shape_of(&s.print, &shape);
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds && status == LF_OK; i++) {
        size_t in = (size_t)n_views * row * (size_t)f->height * sizeof(float);
        size_t out = (size_t)shape.raster_width * (size_t)shape.raster_height * 3 *
                     (size_t)kinds[i].bits / 8;
        work w = {kinds[i].name, run_print, &s, in, out, false, true, true};
        s.print.stripes = kinds[i].stripes;
        s.print.compress = kinds[i].compress;
        s.print.bits = kinds[i].bits;
        s.format = kinds[i].format;
        status = measure(b, &w, err);
    }
    return status;
}

static lf_status write_json(bench *b, lf_error *err)
{
    json_t *object = json_pack("{s:o, s:i, s:O}", "machine", lf_bench_machine(), "repeat",
                               b->arguments->repeat, "lines", b->lines);
    return lf_bench_write_json(b->arguments->json, object, err);
}

int lf_bench_quilt(int argc, char **argv)
{
    arguments a = {0};
    bench b = {.arguments = &a};
    field f = {0};
    lf_error err = {0};
    int code = LF_EXIT_OK;
    if (!lf_bench_command_begin(&command, argc, argv, &a.options, &a, &code))
        return code;
    while (optind < argc)
        a.panels[a.n_panels++] = argv[optind++];
    b.lines = json_array();
    lf_status status = b.lines && lf_pool_create(a.options.threads, &b.pool) == LF_OK
                           ? LF_OK
                           : lf_error_set(&err, LF_E_NOMEM, "quilt", "out of memory");
    if (!lf_bench_is_stdout(a.json))
        printf("%-44s %7s %10s %10s %8s %10s %8s\n", "", "threads", "ms", "CPU ms", "GB/s",
               "copy CPU", "ratio");
    if (status == LF_OK)
        status = measure_panels(&b, &err);
    if (status == LF_OK)
        status = make_field(&f, &a, &err);
    if (status == LF_OK)
        status = measure_views(&b, &f, &err);
    if (status == LF_OK)
        status = measure_print(&b, &f, &err);
    if (status == LF_OK && a.json)
        status = write_json(&b, &err);
    lf_free(f.linear);
    lf_free(f.rgb);
    lf_free(f.filled);
    lf_free(f.missing);
    lf_free(b.copy_from);
    lf_free(b.copy_to);
    lf_pool_destroy(b.pool);
    json_decref(b.lines);
    return status == LF_OK ? LF_EXIT_OK : lf_bench_fail(&err);
}
