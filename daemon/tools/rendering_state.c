/* --state: saves the film of each light field at intervals and when the job is stopped, and resumes
 * from it. */
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/output/output.h"
#include "daemon/tools/job_state.h"
#include "daemon/tools/rendering.h"

static double spp(const lf_rendering *r, double passes)
{
    return passes / r->settings.camera.n_views;
}

void lf_rendering_state_look(lf_rendering *r, const lf_render_progress *progress)
{
    lf_rendering_state *s = &r->state;
    if (!r->arguments->state.file)
        return;
    if (s->goes_on && !s->told)
        lf_log(LF_LOG_INFO, "%s: continuing at %.4g spp", s->path, spp(r, progress->passes));
    s->told = true;
    /* a job that stops again before adding passes would never end */
    if (lf_time_now() - s->saved < s->interval || !(progress->passes > s->passes) ||
        (s->spreads && !progress->whole))
        return;
    s->passes = progress->passes;
    atomic_store_explicit(r->pause, 1, memory_order_relaxed);
}

static bool is_stopped(const lf_rendering *r)
{
    return atomic_load_explicit(r->cancel, memory_order_relaxed);
}

/* ------------------------------------------------------------------------------- which it is -- */

char *lf_rendering_state_path(const lf_rendering *r, int frame, int camera_row, int shutter_part)
{
    const int numbers[] = {frame, camera_row, shutter_part};
    char *path = lf_strdup(r->arguments->state.file);
    for (size_t i = 0; path && i < sizeof numbers / sizeof *numbers; i++) {
        if (numbers[i] < 0)
            continue;
        char *next = lf_frames_path(path, numbers[i]);
        lf_free(path);
        path = next;
    }
    return path;
}

static lf_job_place place_of(const lf_rendering *r, const lf_saved_field *field)
{
    const lf_state_arguments *a = &r->arguments->state;
    const bool of_rows = r->arguments->frames.of_rows, is_grid = r->settings.camera.n_rows > 0;
    lf_job_place place = {.first_row = a->has_rows ? a->first_row : 0,
                          .last_row = a->has_rows ? a->last_row : r->settings.height - 1,
                          .stream = (uint32_t)a->stream,
                          .frame = field->frame,
                          .camera_row = is_grid ? r->camera_row : -1,
                          .shutter_part = field->shutter_part};
    if (r->sequence.on && of_rows)
        place.camera_row = r->sequence.frame;
    else if (r->sequence.on && field->frame < 0)
        place.frame = r->sequence.frame;
    return place;
}

/* Removes a state that this run has made or continued, and no other file that has its name. */
static void remove_state(const char *path)
{
    json_t *head = NULL;
    int fd = -1;
    if (!path || lf_job_state_open(path, &fd, NULL, &head, NULL) != LF_OK)
        return;
    close(fd);
    json_decref(head);
    unlink(path);
}

void lf_rendering_state_remove_at(const lf_rendering *r, int frame, int camera_row,
                                  int shutter_part)
{
    char *path = lf_rendering_state_path(r, frame, camera_row, shutter_part);
    remove_state(path);
    lf_free(path);
}

char *lf_rendering_state_current(const lf_rendering *r, int camera_row)
{
    const bool of_rows = r->arguments->frames.of_rows;
    const int current = r->sequence.on ? r->sequence.frame : -1;
    if (of_rows)
        return lf_rendering_state_path(r, -1, current, -1);
    return lf_rendering_state_path(r, current, r->settings.camera.n_rows > 0 ? camera_row : -1, -1);
}

void lf_rendering_state_remove(const lf_rendering *r)
{
    for (int row = 0; row < lf_rendering_camera_rows(r); row++) {
        char *path = lf_rendering_state_current(r, row);
        remove_state(path);
        lf_free(path);
    }
}

static lf_part part_of(const lf_job_place *place)
{
    return (lf_part){place->first_row, place->last_row + 1, 1, place->stream};
}

lf_status lf_rendering_state_fits(const lf_rendering *r, lf_error *err)
{
    const lf_state_arguments *a = &r->arguments->state;
    const int height = r->settings.height;
    if (!a->has_rows || a->last_row < height)
        return LF_OK;
    return lf_error_set(err, LF_E_ARG, "--rows",
                        "%d:%d is outside the image; expected rows within 0:%d", a->first_row,
                        a->last_row, height - 1);
}

/* ----------------------------------------------------------------------------- save, take up -- */

/* A light field on its way. */
typedef struct work {
    const lf_saved_field *field;
    const lf_budget *budget;
    lf_part part;
    json_t *of;
} work;

/* Another run of the same job may have saved more. */
static bool is_behind(const lf_rendering *r, const work *w)
{
    lf_job_progress there;
    return lf_job_state_check(r->state.path, w->of, &there, NULL) == LF_OK &&
           there.times.passes > r->state.times.passes;
}

static lf_status save(lf_rendering *r, const work *w, bool complete, lf_error *err)
{
    lf_rendering_state *s = &r->state;
    const lf_job_progress progress = {s->times, complete, 1};
    lf_status status = LF_OK;
    if (!is_behind(r, w))
        status = lf_job_state_write(s->path, w->of, w->field->renderer, &progress, err);
    s->saved = lf_time_now();
    s->is_kept |= status == LF_OK;
    return status;
}

/* Checks the progress in a file against what this job asks for. */
static lf_status check_progress(const lf_rendering *r, const work *w, const lf_job_progress *there,
                                lf_error *err)
{
    const char *path = r->state.path;
    const double held = spp(r, (double)there->times.passes),
                 wanted = spp(r, (double)w->budget->passes);
    if (there->n_streams > 1 && !there->complete)
        return lf_error_set(err, LF_E_STATE, path,
                            "holds %.4g spp of %d random streams, which cannot be continued; ask "
                            "for %.4g spp",
                            held, there->n_streams, held);
    if (w->budget->passes > 0 && held > wanted)
        return lf_error_set(err, LF_E_STATE, path,
                            "holds %.4g spp, but this job asks for %.4g; pass another --state FILE",
                            held, wanted);
    return LF_OK;
}

/* Restores the state of an earlier run. */
static lf_status take_up(lf_rendering *r, const work *w, lf_job_progress *out, lf_error *err)
{
    const char *path = r->state.path;
    const bool is_all = lf_state_is_all(&r->arguments->state);
    struct stat st;
    if (stat(path, &st) != 0)
        return LF_OK; /* the first save reports what prevents it */
    lf_status status = lf_job_state_check(path, w->of, out, err);
    if (status == LF_OK)
        status = check_progress(r, w, out, err);
    if (status == LF_OK && !(is_all && out->complete))
        status = lf_job_state_restore(path, w->of, w->field->renderer, out, err);
    if (status != LF_OK)
        return status;
    r->state.goes_on = r->state.is_kept = true;
    r->state.times = out->times;
    r->state.passes = (double)out->times.passes;
    if (out->complete && !is_all && !r->sequence.on && lf_rendering_camera_rows(r) == 1)
        lf_log(LF_LOG_INFO, "%s: the image is complete (%.4g spp)", path,
               spp(r, (double)out->times.passes));
    return LF_OK;
}

/* Renders until the budget is spent or the job is stopped, and saves. */
static lf_status gather(lf_rendering *r, const work *w, float *film, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const lf_saved_field *field = w->field;
    lf_rendering_state *s = &r->state;
    lf_budget budget = *w->budget;
    budget.part = &w->part;
    for (;;) {
        const lf_render_times before = s->times;
        lf_status status = lf_render_gather(field->renderer, &budget, a->options.estimator,
                                            s->goes_on ? &before : NULL, film, field->show,
                                            field->context, r->pause, &s->times);
        if (status == LF_E_STATE)
            return lf_error_set(err, status, s->path,
                                "holds passes of another job (see --state-info); remove it or pass "
                                "another --state FILE");
        if (status != LF_OK && status != LF_E_CANCELLED)
            return lf_error_set(err, status, a->out, "rendering failed");
        const lf_status kept = save(r, w, status == LF_OK, err);
        s->goes_on = true;
        if (kept != LF_OK || status == LF_OK)
            return kept;
        atomic_store_explicit(r->pause, 0, memory_order_relaxed);
        if (is_stopped(r))
            return lf_rendering_interrupted(r, err);
    }
}

/* Starts another light field. */
static lf_status begin(lf_rendering *r, const lf_job_place *place, work *w, lf_error *err)
{
    lf_rendering_state *s = &r->state;
    char *path = lf_rendering_state_path(r, place->frame, place->camera_row, place->shutter_part);
    lf_free(s->path);
    *s = (lf_rendering_state){.interval = s->interval,
                              .saved = lf_time_now(),
                              .spreads = lf_renderer_spreads(w->field->renderer),
                              .path = path};
    w->part = part_of(place);
    w->of =
        path ? lf_job_state_of(r->arguments->scene, w->field->renderer, w->budget, place) : NULL;
    return w->of ? LF_OK : lf_error_set(err, LF_E_NOMEM, r->arguments->state.file, "out of memory");
}

lf_status lf_rendering_state_spend(lf_rendering *r, const lf_saved_field *field,
                                   const lf_budget *budget, float *film, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const lf_job_place place = place_of(r, field);
    lf_job_progress progress = {0};
    work w = {.field = field, .budget = budget};
    if (!lf_renderer_is_its_film(field->renderer))
        return lf_error_set(err, LF_E_ARG, "--state", "is not supported with this --integrator");
    if (a->state.has_rows && lf_renderer_spreads(field->renderer))
        return lf_error_set(err, LF_E_ARG, "--rows",
                            "is not supported with a list, path or circle of cameras, which share "
                            "paths among all rows");
    lf_status status = lf_rendering_state_fits(r, err);
    if (status == LF_OK)
        status = begin(r, &place, &w, err);
    if (status == LF_OK)
        status = take_up(r, &w, &progress, err);
    if (status == LF_OK && !progress.complete)
        status = gather(r, &w, film, err);
    json_decref(w.of);
    if (status == LF_OK && !lf_state_is_all(&a->state))
        status = lf_render_fill(field->renderer, budget, a->options.estimator, r->cancel,
                                &r->state.times);
    return status == LF_E_CANCELLED ? lf_rendering_interrupted(r, err) : status;
}

/* ------------------------------------------------------------------------------- kept frames -- */

void lf_rendering_state_stays(lf_rendering *r, const char *path, const lf_error *why)
{
    const bool elsewhere = strcmp(why->where, path) != 0;
    lf_progress_line_clear(&r->line);
    lf_log(LF_LOG_WARNING, "%s: stays: %s%s%s", path, elsewhere ? why->where : "",
           elsewhere ? ": " : "", why->what);
}

/* Whether the state was saved after the files of the current frame were written, which then lack
 * its samples. Rows of a plate have receipts, and parts of shutters are of several frames. */
static bool is_newer(const lf_rendering *r, const lf_saved_field *field)
{
    struct stat state, written;
    if (r->sequence.plate || field->shutter_part >= 0)
        return false;
    char *file = lf_output_file_name(lf_rendering_kind(r), r->path, 0);
    const bool are_there = file && stat(file, &written) == 0 && stat(r->state.path, &state) == 0;
    lf_free(file);
    return !are_there || state.st_mtim.tv_sec > written.st_mtim.tv_sec ||
           (state.st_mtim.tv_sec == written.st_mtim.tv_sec &&
            state.st_mtim.tv_nsec > written.st_mtim.tv_nsec);
}

void lf_rendering_state_remove_known(lf_rendering *r, const lf_saved_field *field,
                                     const lf_budget *budget)
{
    const lf_job_place place = place_of(r, field);
    lf_job_progress there = {0};
    work w = {.field = field, .budget = budget};
    lf_error err = {0};
    lf_status status = begin(r, &place, &w, &err);
    const char *path = r->state.path ? r->state.path : r->arguments->state.file;
    if (status == LF_OK && access(path, F_OK) == 0) {
        status = lf_job_state_check(path, w.of, &there, &err);
        if (status == LF_OK && (!there.complete || is_newer(r, field)))
            status = lf_error_set(&err, LF_E_STATE, path,
                                  "the kept files may lack its %.4g spp; remove it, or the files "
                                  "to continue",
                                  spp(r, (double)there.times.passes));
        if (status == LF_OK)
            unlink(path);
    }
    json_decref(w.of);
    if (status != LF_OK)
        lf_rendering_state_stays(r, path, &err);
}

lf_status lf_rendering_state_remove_kept(lf_rendering *r, lf_error *err)
{
    const lf_budget budget = lf_rendering_budget(r);
    lf_status status = LF_OK;
    for (r->camera_row = 0; status == LF_OK && r->camera_row < lf_rendering_camera_rows(r);
         r->camera_row++) {
        const lf_render_settings settings = lf_rendering_row_settings(r);
        lf_saved_field field = {NULL, -1, -1, NULL, NULL};
        status = lf_renderer_create(r->scene, &settings, r->pool, &field.renderer, err);
        if (status == LF_OK)
            lf_rendering_state_remove_known(r, &field, &budget);
        lf_renderer_destroy(field.renderer);
    }
    return status;
}
