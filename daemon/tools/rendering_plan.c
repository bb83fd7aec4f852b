#include "daemon/tools/rendering_plan.h"

#include "daemon/tools/rendering_shared.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* Paths rendered to estimate the time, in at least two image rows. */
#define PILOT_PATHS 5e5
#define MOST_PILOT_ROWS 32
/* Frames per task that share parts of their shutters, in shutters. */
#define SHUTTERS_A_TASK 4

/* ------------------------------------------------------------------------------------- tasks -- */

/* A unit of rendering, and the number of units. */
typedef struct work {
    int n_parts, a_frame; /* 0: frames are whole */
    int task;             /* frames or rows per task, at most */
    int64_t passes;       /* passes of a part, or of a frame or row; 0: another limit applies */
} work;

static work work_of(const lf_rendering *r)
{
    work w = {.task = 1, .passes = lf_rendering_budget(r).passes};
    if (r->arguments->kind == &lf_output_video && r->sequence.on)
        w.task = lf_frames_count(&r->arguments->frames);
    w.n_parts = lf_shared_parts(r, &w.a_frame);
    if (w.n_parts > 0) {
        if (w.task == 1)
            w.task = SHUTTERS_A_TASK * ((w.n_parts - 1) / w.a_frame + 1);
        w.passes = w.passes > 0 ? lf_shared_budget(r, w.n_parts).passes : 0;
    }
    return w;
}

/* The units in a task of n frames or rows. */
static int64_t units_of(const work *w, int n)
{
    return w->n_parts > 0 ? (int64_t)(n - 1) * w->a_frame + w->n_parts : n;
}

/* True if a word is this option, in full or abbreviated as getopt allows; with "=" it includes its
 * value. */
static bool is_option(const char *word, const char *option)
{
    const size_t n = strcspn(word, "=");
    return n > 2 && strncmp(word, "--", 2) == 0 && strncmp(word, option, n) == 0;
}

/* Prints a word quoted for a shell. */
static void print_word(const char *word)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                "-_./:=,+@%";
    if (word[0] != '\0' && word[strspn(word, plain)] == '\0') {
        printf("%s", word);
        return;
    }
    putchar('\'');
    for (; *word; word++)
        printf(*word == '\'' ? "'\\''" : "%c", *word);
    putchar('\'');
}

/* Prints the command line with other frames or rows (none: first > last). */
static void print_task(const lf_render_arguments *a, int first, int last)
{
    const char *const option = lf_frames_option(&a->frames);
    const bool turns = a->frames.turntable > 0;
    print_word(a->argv[0]);
    if (first <= last)
        printf(" %s %d:%d", turns ? "--frames" : option, first, last);
    for (int i = 1; a->argv[i]; i++) {
        const char *word = a->argv[i];
        const bool chosen = is_option(word, turns ? "--frames" : option);
        if (chosen && !strchr(word, '=') && a->argv[i + 1])
            i++;
        if (chosen || is_option(word, "--plan"))
            continue;
        putchar(' ');
        print_word(word);
    }
    putchar('\n');
}

static void print_tasks(const lf_rendering *r, int size)
{
    const lf_render_arguments *a = r->arguments;
    if (!r->sequence.on) {
        print_task(a, 1, 0);
        return;
    }
    for (int first = a->frames.first; first <= a->frames.last; first += size) {
        const int last = first + size - 1;
        print_task(a, first, last < a->frames.last ? last : a->frames.last);
    }
}

/* -------------------------------------------------------------------------------------- time -- */

/* Measures the CPU seconds of this many passes of one light field on some of its rows, evenly
 * spread. Film memory is used only by visited rows. */
static lf_status measure(lf_rendering *r, int64_t passes, double *out_cpu, int *out_rows,
                         lf_error *err)
{
    const lf_render_settings *s = &r->settings;
    const int64_t cycles = 2 * (int64_t)s->camera.n_views, n = passes < cycles ? passes : cycles;
    const double fit = PILOT_PATHS / ((double)n * s->width);
    int rows = fit < 2 ? 2 : fit > MOST_PILOT_ROWS ? MOST_PILOT_ROWS : (int)fit;
    rows = rows < s->height ? rows : s->height;
    const int step = (s->height + rows - 1) / rows;
    const lf_part part = {.first_row = step / 2, .row_step = step};
    const double start = lf_time_cpu();
    const lf_status status =
        lf_renderer_passes(r->renderer, &part, n, false, NULL, NULL, r->cancel);
    rows = (s->height - part.first_row - 1) / step + 1;
    *out_cpu = (lf_time_cpu() - start) * ((double)passes / (double)n) * s->height / rows;
    *out_rows = rows;
    if (status == LF_OK)
        return LF_OK;
    return lf_error_set(err, status, r->arguments->out, "%s",
                        status == LF_E_CANCELLED ? "interrupted; the plan is not complete"
                                                 : "cannot measure");
}

/* -------------------------------------------------------------------------------------- plan -- */

static void print_amount(const char *what, double amount, const char *unit)
{
    static const char *const prefixes[] = {"", "k", "M", "G", "T", "P"};
    int i = 0;
    for (; amount >= 1000 && i < 5; i++)
        amount /= 1000;
    printf("# %-22s %.3g %s%s\n", what, amount, prefixes[i], unit);
}

static void print_time(const char *what, double seconds)
{
    const double hours = seconds / 3600;
    printf("# %-22s %.*f CPU %s\n", what, hours >= 2 || seconds < 1 ? 1 : 0,
           hours >= 2       ? hours
           : seconds >= 200 ? seconds / 60
                            : seconds,
           hours >= 2       ? "hours"
           : seconds >= 200 ? "minutes"
                            : "seconds");
}

/* Bytes per pixel in a file, before compression. */
static double file_bytes(const lf_render_arguments *a)
{
    return lf_output_is_light(a->kind, a->out)
               ? 12 + 4.0 * lf_layer_channels(a->options.layers, NULL)
               : 3;
}

static void print_light_fields(const lf_rendering *r, int fields, int views)
{
    const lf_render_settings *s = &r->settings;
    const lf_output_kind *kind = r->arguments->kind;
    const double pixels = (double)views * s->width * s->height;
    printf("# %d %s of %d view%s of %dx%d pixels\n", fields,
           !r->sequence.on ? "light field" : lf_frames_noun(&r->arguments->frames), views,
           views == 1 ? "" : "s", s->width, s->height);
    print_amount("view pixels", pixels * fields, "");
    if (kind->surplus || kind == &lf_output_quilt || kind == &lf_output_still)
        print_amount("files, uncompressed", pixels * fields * file_bytes(r->arguments), "B");
}

static void print_memory(const lf_rendering *r, const work *w, int views)
{
    const int renderers = w->n_parts > 0 ? lf_shared_renderers(w->n_parts, w->a_frame) : 1;
    lf_render_stats stats;
    lf_renderer_stats(r->renderer, &stats);
    print_amount("film memory", (double)renderers * (double)stats.film_bytes, "B");
    print_amount("image memory", 12.0 * views * r->settings.width * r->settings.height, "B");
}

/* Prints times of a task and of all tasks. cpu: of one unit. */
static void print_times(const lf_rendering *r, const work *w, int fields, double cpu)
{
    const int last = fields % w->task, whole = fields / w->task;
    const int64_t units = whole * units_of(w, w->task) + (last > 0 ? units_of(w, last) : 0);
    if (r->sequence.on)
        print_time("a task", cpu * (double)units_of(w, whole > 0 ? w->task : last));
    print_time("all", cpu * (double)units);
}

/* Prints the estimated time, unless the command line sets it. */
static lf_status tell_times(lf_rendering *r, const work *w, int fields, int rows, lf_error *err)
{
    double cpu;
    int measured;
    if (w->passes == 0) {
        printf("# %s\n", lf_rendering_budget(r).seconds > 0
                             ? "--time gives the time"
                             : "the time depends on the target error");
        return LF_OK;
    }
    lf_status status = measure(r, w->passes, &cpu, &measured, err);
    if (status != LF_OK)
        return status;
    print_times(r, w, fields, cpu * rows);
    printf("# measured on %d of %d image rows; excludes loading, layers, denoising and writing\n",
           measured, r->settings.height);
    return LF_OK;
}

lf_status lf_rendering_plan(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    lf_status status = LF_OK;
    if (a->frames.of_rows) {
        r->sequence.frame = (a->frames.first + a->frames.last) / 2;
        status = lf_rendering_resolve(r, err);
    }
    if (status != LF_OK)
        return status;
    const work w = work_of(r);
    const int fields = r->sequence.on ? lf_frames_count(&a->frames) : 1,
              rows = r->settings.camera.n_rows > 0 ? r->settings.camera.n_rows : 1,
              views = lf_camera_views(&r->settings.camera);
    print_light_fields(r, fields, views);
    if (rows > 1)
        r->settings.camera = lf_camera_row(&r->settings.camera, rows / 2);
    status = lf_renderer_create(r->scene, &r->settings, r->pool, &r->renderer, err);
    if (status != LF_OK)
        return status;
    print_memory(r, &w, views);
    status = tell_times(r, &w, fields, rows, err);
    if (status == LF_OK)
        print_tasks(r, w.task);
    return status;
}
