/* quiltrender: one scene or quilt to one picture, print or folder of views, or to the frames of a
 * sequence. See docs/man/quiltrender.1. */
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/import/import.h"
#include "base/log.h"
#include "daemon/tools/rendering_plan.h"

#define PROGRAM LF_RENDER_PROGRAM

static lf_cancel cancel;

static void on_signal(int number)
{
    (void)number;
    atomic_store_explicit(&cancel, 1, memory_order_relaxed);
    lf_import_stop();
}

static lf_status make_one(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    lf_status status = r->scene ? lf_rendering_run(r, err) : LF_OK;
    if (status == LF_OK)
        status = lf_rendering_write(r, err);
    if (status == LF_OK && a->stats)
        status = lf_rendering_write_stats(r, err);
    return status;
}

/* Names that are not what -o says: the suffix was added. */
static void tell_names(const lf_rendering *r)
{
    const lf_sequence_state *s = &r->sequence;
    if ((!s->on || r->arguments->kind == &lf_output_video) &&
        strcmp(r->path, r->arguments->out) != 0)
        lf_log(LF_LOG_INFO, "wrote %s", r->path);
    else if (s->on && s->n_done > 0)
        lf_log(LF_LOG_INFO, "wrote %d of %d %s; the last is %s", s->n_done,
               lf_frames_count(&r->arguments->frames), lf_frames_noun(&r->arguments->frames),
               r->path);
}

static int run(const lf_render_arguments *a)
{
    lf_rendering r = {.arguments = a,
                      .line = {.on = isatty(STDERR_FILENO) == 1, .program = PROGRAM},
                      .cancel = &cancel};
    lf_error err = {0};
    lf_import_watch(lf_progress_line_reading, &r.line);
    lf_status status = lf_rendering_open(&r, &err);
    lf_import_watch(NULL, NULL);
    int code = LF_EXIT_OK;
    if (status == LF_E_ARG) {
        code = lf_usage_error(PROGRAM, &err);
        lf_rendering_finish(&r);
        return code;
    }
    if (status == LF_OK && a->plan)
        status = lf_rendering_plan(&r, &err);
    else if (status == LF_OK)
        status = r.sequence.on ? lf_rendering_frames(&r, &err) : make_one(&r, &err);
    lf_progress_line_clear(&r.line);
    if (status != LF_OK) {
        lf_log_error(&err);
        code = LF_EXIT_FAILED;
    } else if (!a->plan) {
        tell_names(&r);
    }
    lf_rendering_finish(&r);
    return code;
}

static void catch_signals(void)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)SA_RESETHAND};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    /* a limit on file size is to be an error like a full disk */
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
    if (lf_render_arguments_parse(argc, argv, &a, &done, &err) != LF_OK)
        return lf_usage_error(PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    lf_options_limit_import(&a.options);
    catch_signals();
    return run(&a);
}
