/* quiltrender: renders a scene or converts a quilt to one picture, print or folder of views, or to
 * a sequence. See docs/man/quiltrender.1. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/list.h"
#include "base/log.h"
#include "base/sandbox/import.h"
#include "base/thread.h"
#include "daemon/tools/batch.h"
#include "daemon/tools/job_state.h"
#include "daemon/tools/plan_inputs.h"
#include "daemon/tools/read_chart.h"
#include "daemon/tools/receipt.h"
#include "daemon/tools/rendering_plan.h"
#include "daemon/tools/simulate.h"
#include "render/papers/papers.h"

#define PROGRAM LF_RENDER_PROGRAM

static lf_cancel cancel, paused;

static void on_signal(int number)
{
    (void)number;
    atomic_store_explicit(&cancel, 1, memory_order_relaxed);
    atomic_store_explicit(&paused, 1, memory_order_relaxed);
    lf_import_stop();
}

static lf_status make_one(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    lf_status status = r->scene ? lf_rendering_run(r, err) : LF_OK;
    if (status == LF_OK && !lf_state_is_all(&a->state))
        status = lf_rendering_write(r, err);
    if (status == LF_OK && a->stats)
        status = lf_rendering_write_stats(r, err);
    return status;
}

/* "48 views of 420x560, 16 spp, 35 s": content per file, and total time. */
static void describe(const lf_rendering *r, double seconds, char *words, size_t size)
{
    const lf_render_settings *s = &r->settings;
    const int rows = s->camera.n_rows > 0 ? s->camera.n_rows : 1;
    const int views = r->is_quilt ? r->layout.n_views : lf_camera_views(&s->camera);
    const int width = r->is_quilt ? r->layout.view_width : s->width,
              height = r->is_quilt ? r->layout.view_height : s->height;
    words[0] = '\0';
    if (views == 1)
        lf_list_add(words, size, "%dx%d pixels", width, height);
    else if (views > 1)
        lf_list_add(words, size, "%d views of %dx%d", views, width, height);
    if (r->times.passes > 0)
        lf_list_add(words, size, "%.4g spp",
                    (double)r->times.passes / ((double)rows * s->camera.n_views));
    lf_list_add(words, size, seconds < 10 ? "%.1f s" : "%.0f s", seconds);
}

static void tell_names(const lf_rendering *r, double seconds)
{
    const lf_sequence_state *s = &r->sequence;
    const lf_frames *frames = &r->arguments->frames;
    char words[128];
    describe(r, seconds, words, sizeof words);
    if (!s->on)
        lf_log(LF_LOG_INFO, "wrote %s (%s)", r->path, words);
    else if (r->arguments->kind == &lf_output_video)
        lf_log(LF_LOG_INFO, "wrote %s (%d frames of %s)", r->path, s->n_done, words);
    else if (s->n_done > 0)
        lf_log(LF_LOG_INFO, "wrote %d of %d %s; the last is %s (%s)", s->n_done,
               lf_frames_count(frames), lf_frames_noun(frames), r->path, words);
}

/* What the states hold that are the only output. */
static void tell_states(const lf_rendering *r, double seconds)
{
    const int n = r->sequence.on ? r->sequence.n_done : lf_rendering_camera_rows(r);
    char words[64];
    snprintf(words, sizeof words, seconds < 10 ? "%.1f s" : "%.0f s", seconds);
    if (n == 1)
        lf_log(LF_LOG_INFO, "%s is complete (%s)", r->state.path, words);
    else
        lf_log(LF_LOG_INFO, "%d states are complete; the last is %s (%s)", n, r->state.path, words);
}

/* The copies of a sheet, and the order of a flip. */
static void tell_layout(const lf_rendering *r)
{
    char words[256];
    const int n_images = r->is_quilt ? r->layout.n_views : r->print.n_views;
    if (r->arguments->kind == &lf_output_print &&
        lf_print_layout_text(&r->print, n_images, words, sizeof words)[0] != '\0')
        lf_log(LF_LOG_INFO, "%s: %s", r->path, words);
}

static int run(const lf_render_arguments *a)
{
    const bool is_terminal = isatty(STDERR_FILENO) == 1;
    const double begun = lf_time_now();
    lf_rendering r = {.arguments = a,
                      .line = {.on = is_terminal,
                               .logs = !is_terminal,
                               .program = PROGRAM,
                               .interval = LF_PROGRESS_INTERVAL},
                      .cancel = &cancel,
                      .pause = &paused,
                      .state.interval = LF_STATE_INTERVAL};
    lf_error err = {0};
    if (a->depth.batch)
        return lf_batch_run(&r);
    lf_import_watch(lf_progress_line_reading, &r.line);
    if (a->plan.json)
        lf_plan_inputs_begin();
    lf_status status = lf_rendering_open(&r, &err);
    lf_import_watch(NULL, NULL);
    int code = LF_EXIT_OK;
    if (status == LF_E_ARG) {
        code = lf_usage_error(PROGRAM, &err);
        lf_rendering_finish(&r);
        return code;
    }
    if (status == LF_OK && a->plan.on)
        status = lf_rendering_plan(&r, &err);
    else if (status == LF_OK)
        status = r.sequence.on ? lf_rendering_frames(&r, &err) : make_one(&r, &err);
    if (status == LF_OK && a->files && !a->plan.on)
        status = lf_receipt_write(&r, &err);
    lf_progress_line_clear(&r.line);
    if (status == LF_E_ARG && strncmp(err.where, "--", 2) == 0) {
        code = lf_usage_error(PROGRAM, &err); /* found only with the renderer */
    } else if (status != LF_OK) {
        lf_log_error(&err);
        code = a->state.file && status == LF_E_CANCELLED ? LF_EXIT_INTERRUPTED : LF_EXIT_FAILED;
    } else if (!a->plan.on && lf_state_is_all(&a->state)) {
        tell_states(&r, lf_time_now() - begun);
    } else if (!a->plan.on) {
        tell_names(&r, lf_time_now() - begun);
        tell_layout(&r);
    }
    lf_rendering_finish(&r);
    return code;
}

static int print_state(const char *path)
{
    json_t *info = NULL;
    lf_error err = {0};
    if (lf_job_state_info(path, &info, &err) != LF_OK) {
        lf_log_error(&err);
        return LF_EXIT_FAILED;
    }
    json_dumpf(info, stdout, JSON_INDENT(2));
    putchar('\n');
    json_decref(info);
    return fflush(stdout) == 0 ? LF_EXIT_OK : LF_EXIT_FAILED;
}

static void catch_signals(void)
{
    /* A second Ctrl-C ends at once. Farms may send SIGTERM twice, to a group and by a script; a job
     * that is saving its state must survive that. */
    struct sigaction action = {.sa_handler = on_signal};
    sigaction(SIGTERM, &action, NULL);
    action.sa_flags = (int)SA_RESETHAND;
    sigaction(SIGINT, &action, NULL);
    /* exceeding a file size limit becomes an error like a full disk */
    action = (struct sigaction){.sa_handler = SIG_IGN};
    sigaction(SIGXFSZ, &action, NULL);
    sigaction(SIGPIPE, &action, NULL);
}

int main(int argc, char **argv)
{
    lf_render_arguments a;
    lf_error err = {0};
    bool done = false;
    lf_log_init(PROGRAM, LF_LOG_INFO);
    if (lf_simulate_is_wanted(argc, argv)) {
        catch_signals();
        return lf_simulate_run(argc, argv, &cancel);
    }
    lf_papers_add();
    const lf_status status = lf_render_arguments_parse(argc, argv, &a, &done, &err);
    if (status == LF_E_IO) {
        lf_log_error(&err);
        return LF_EXIT_FAILED;
    }
    if (status != LF_OK)
        return lf_usage_error(PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    if (a.state.info)
        return print_state(a.state.info);
    lf_options_limit_import(&a.options);
    catch_signals();
    if (a.of_print.photo)
        return lf_read_chart(&a);
    return run(&a);
}
