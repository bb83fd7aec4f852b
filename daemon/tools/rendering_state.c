/* --state: saves a job's film at intervals and when it is stopped, and resumes from it. */
#include <stdio.h>
#include <sys/stat.h>

#include "base/log.h"
#include "daemon/tools/job_state.h"
#include "daemon/tools/rendering.h"

static double spp(const lf_rendering *r, double passes)
{
    return passes / r->settings.camera.n_views;
}

void lf_rendering_state_look(lf_rendering *r, const lf_render_progress *progress)
{
    lf_rendering_state *s = &r->state;
    if (!r->arguments->state)
        return;
    if (s->goes_on && !s->told)
        lf_log(LF_LOG_INFO, "%s: continuing at %.4g spp", r->arguments->state,
               spp(r, progress->passes));
    s->told = true;
    /* a job that stops again before adding passes would never end */
    if (lf_time_now() - s->saved < s->interval || !(progress->passes > s->passes))
        return;
    s->passes = progress->passes;
    atomic_store_explicit(r->pause, 1, memory_order_relaxed);
}

static bool is_stopped(const lf_rendering *r)
{
    return atomic_load_explicit(r->cancel, memory_order_relaxed);
}

static lf_status save(lf_rendering *r, const json_t *of, bool complete, lf_error *err)
{
    lf_rendering_state *s = &r->state;
    const lf_job_progress progress = {s->times, complete};
    lf_status status = lf_job_state_write(r->arguments->state, of, r->renderer, &progress, err);
    s->saved = lf_time_now();
    s->is_kept |= status == LF_OK;
    return status;
}

/* Restores the state of an earlier run. */
static lf_status take_up(lf_rendering *r, const lf_budget *budget, const json_t *of,
                         lf_job_progress *out, lf_error *err)
{
    const char *path = r->arguments->state;
    struct stat st;
    if (stat(path, &st) != 0)
        return LF_OK; /* the first save reports what prevents it */
    lf_status status = lf_job_state_restore(path, of, r->renderer, out, err);
    if (status != LF_OK)
        return status;
    const double there = spp(r, (double)out->times.passes), wanted = spp(r, (double)budget->passes);
    if (budget->passes > 0 && there > wanted)
        return lf_error_set(err, LF_E_STATE, path,
                            "holds %.4g spp, but this job asks for %.4g; pass another --state FILE",
                            there, wanted);
    r->state.goes_on = r->state.is_kept = true;
    r->state.times = out->times;
    if (out->complete)
        lf_log(LF_LOG_INFO, "%s: the image is complete (%.4g spp)", path, there);
    return LF_OK;
}

/* Renders until the budget is spent or the job is stopped, and saves. */
static lf_status gather(lf_rendering *r, const lf_budget *budget, const json_t *of, float *film,
                        lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    lf_rendering_state *s = &r->state;
    for (;;) {
        const lf_render_times before = s->times;
        lf_status status =
            lf_render_gather(r->renderer, budget, a->options.estimator, s->goes_on ? &before : NULL,
                             film, lf_rendering_show, r, r->pause, &s->times);
        if (status == LF_E_STATE)
            return lf_error_set(err, status, a->state,
                                "holds passes of another job (see --state-info); remove it or pass "
                                "another --state FILE");
        if (status != LF_OK && status != LF_E_CANCELLED)
            return lf_error_set(err, status, a->out, "rendering failed");
        const lf_status kept = save(r, of, status == LF_OK, err);
        s->goes_on = true;
        if (kept != LF_OK || status == LF_OK)
            return kept;
        atomic_store_explicit(r->pause, 0, memory_order_relaxed);
        if (is_stopped(r))
            return lf_rendering_interrupted(r, err);
    }
}

lf_status lf_rendering_state_spend(lf_rendering *r, const lf_budget *budget, float *film,
                                   lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    lf_job_progress progress = {0};
    r->state.saved = lf_time_now();
    if (!lf_renderer_is_its_film(r->renderer))
        return lf_error_set(err, LF_E_ARG, "--state", "is not supported with %s",
                            r->settings.camera.list ? "a list, path or circle of cameras"
                                                    : "this --integrator");
    json_t *of = lf_job_state_of(a->scene, r->renderer, budget);
    if (!of)
        return lf_error_set(err, LF_E_NOMEM, a->state, "out of memory");
    lf_status status = take_up(r, budget, of, &progress, err);
    if (status == LF_OK && !progress.complete)
        status = gather(r, budget, of, film, err);
    json_decref(of);
    if (status == LF_OK)
        status =
            lf_render_fill(r->renderer, budget, a->options.estimator, r->cancel, &r->state.times);
    if (status == LF_E_CANCELLED)
        return lf_rendering_interrupted(r, err);
    r->gathered = &r->state.times;
    return status;
}
