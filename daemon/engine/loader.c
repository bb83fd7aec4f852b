#include "daemon/engine/loader.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/sandbox/import.h"
#include "base/sandbox/import_group.h"
#include "base/thread.h"
#include "daemon/engine/folder.h"
#include "daemon/output/blank.h"
#include "daemon/output/fit.h"
#include "daemon/output/orbit.h"
#include "daemon/threads/worker.h"

/* How long a change waits, in seconds, for the picture before it to be shown; and how long if the
 * one before that was not shown. */
#define MOMENT_SECONDS 0.1
#define STARVED_SECONDS 3.0
#define LOOK_NS 2000000
/* Limit of merged loads, all answered together. It is much larger than the number that arrive
 * during a slow picture. Otherwise a flood of changes would never be caught up with. */
#define MOST_AT_ONCE 65536

struct lf_loader {
    lf_engine *engine;
    const lf_roots *roots;
    lf_worker *worker;
    atomic_bool ends;
    lf_import_group group;   /* of the current load */
    _Atomic int64_t current; /* its number */
    /* owned by the worker */
    lf_content *content; /* content of the last commit */
    bool starved;        /* the content before it was never shown */
};

lf_load *lf_load_create(lf_load_kind kind)
{
    lf_load *load = lf_calloc(1, sizeof *load);
    if (load) {
        load->kind = kind;
        load->zoom = 1;
        load->sent.fd = -1;
    }
    return load;
}

bool lf_load_is_sent(const lf_load *load)
{
    return load->sent.document || load->sent.fd >= 0;
}

void lf_load_destroy(lf_load *load)
{
    if (!load)
        return;
    lf_free(load->file);
    lf_free(load->name);
    json_decref(load->patch);
    json_decref(load->sent.document);
    if (load->sent.fd >= 0)
        close(load->sent.fd);
    lf_passed_unref(load->sent.passed);
    lf_content_unref(load->content);
    lf_free(load);
}

/* ------------------------------------------------------------------------------------- orbit -- */

/* The next load merged into this one; NULL: none. */
static const lf_load *next_of(const lf_load *load)
{
    return (const lf_load *)(const void *)load->task.next;
}

/* The moves of a load and of loads merged into it, in order. */
static json_t *orbit_patch(const lf_scene *scene, const lf_load *load)
{
    lf_camera camera = *lf_scene_camera(scene);
    for (; load; load = next_of(load)) {
        double p[3];
        lf_orbit_camera(&camera, load->yaw, load->pitch, load->zoom, p);
        memcpy(camera.position, p, sizeof p);
        camera.focus_distance /= load->zoom; /* keeps the focus on the same point */
    }
    const double *at = camera.position;
    json_t *patch = json_pack("{s:{s:[f,f,f]}}", "camera", "position", at[0], at[1], at[2]);
    if (json_object_get(json_object_get(lf_scene_json(scene), "camera"), "focus_distance"))
        json_object_set_new(json_object_get(patch, "camera"), "focus_distance",
                            json_real(camera.focus_distance));
    return patch;
}

/* ---------------------------------------------------------------------------------- contents -- */

static lf_status stage_of_scene(const lf_load *load, lf_scene *scene, const char *file,
                                lf_content **out, lf_error *err)
{
    lf_status status = lf_content_from_scene(
        scene, file, &load->options, load->has_calibration ? &load->calibration : NULL, out, err);
    lf_scene_unref(scene);
    return status;
}

static lf_status turn_pages(const lf_roots *roots, lf_load *load)
{
    char *path = NULL;
    lf_status status = load->step != 0
                           ? lf_folder_neighbour(load->file, load->step, roots, &path, &load->err)
                           : LF_OK;
    if (path) {
        lf_free(load->file);
        load->file = path;
        load->step = 0; /* the load may run again */
    }
    return status;
}

/* Loads a picture or a video; named: its name holds the tiles. */
static lf_status load_quilt(const lf_roots *roots, lf_load *load, bool named, bool moves,
                            lf_content **out)
{
    const lf_calibration *calibration = load->has_calibration ? &load->calibration : NULL;
    lf_options options = load->options;
    if (load->words.columns > 0) {
        options.columns = load->words.columns;
        options.rows = load->words.rows;
    } else if (named && (!load->meant || strcmp(load->file, load->meant) != 0)) {
        options.columns = options.rows = 0;
    }
    lf_status status =
        moves ? lf_content_from_movie(load->file, roots, &options, load->words.plays_once,
                                      calibration, out, &load->err)
              : lf_content_from_quilt(load->file, roots, &options, calibration, out, &load->err);
    /* a caller of a method has no command line */
    if (status == LF_E_ARG && load->deferred && !named && options.columns == 0)
        status = lf_error_set(&load->err, LF_E_ARG, load->file,
                              "the file name has no quilt suffix such as _qs8x6a0.75; rename the "
                              "file or pass quilt=COLUMNSxROWS to scene.load");
    return status;
}

static lf_status load_file(const lf_loader *loader, const lf_roots *roots, lf_load *load,
                           lf_content **out)
{
    lf_status status = turn_pages(roots, load);
    if (status != LF_OK)
        return status;
    int columns, rows;
    double aspect;
    const char *dot = strrchr(load->file, '.');
    bool named = lf_layout_from_name(load->file, &columns, &rows, &aspect);
    /* For a file named like a quilt, report that it is not a picture, rather than that it is not
     * JSON. */
    bool meant = named && dot && strcmp(dot, ".json") != 0;
    if (lf_movie_ending(load->file) || lf_is_movie(load->file, roots))
        return load_quilt(roots, load, named, true, out);
    if (meant || lf_is_quilt(load->file, roots) || lf_image_is_foreign(load->file, roots))
        return load_quilt(roots, load, named, false, out);
    if (load->words.columns > 0)
        return lf_error_set(&load->err, LF_E_ARG, load->file,
                            "is not an image; quilt=COLUMNSxROWS applies only to images");
    lf_scene *scene = NULL;
    const lf_scene *previous = loader->content ? loader->content->scene : NULL;
    status = lf_scene_load_patched(load->file, &load->options.alone, NULL, roots, previous, &scene,
                                   &load->err);
    if (status == LF_OK)
        lf_log_warnings(scene, NULL);
    return status == LF_OK ? stage_of_scene(load, scene, load->file, out, &load->err) : status;
}

/* Loads a quilt that a client sent. */
static lf_status load_sent_quilt(const lf_roots *roots, lf_load *load, lf_content **out)
{
    return lf_content_from_sent_quilt(load->file, &load->words.quilt, roots->passed, &load->options,
                                      load->has_calibration ? &load->calibration : NULL, out,
                                      &load->err);
}

/* Loads a scene that a client sent. The content keeps the document, so that it can be loaded
 * again. */
static lf_status load_sent(const lf_loader *loader, const lf_roots *roots, lf_load *load,
                           lf_content **out)
{
    json_t *doc = json_incref(load->sent.document);
    lf_scene *scene = NULL;
    lf_status status =
        doc ? LF_OK : lf_scene_document_read(load->sent.fd, load->file, &doc, &load->err);
    if (status == LF_OK)
        status =
            lf_scene_from_json(doc, "", load->file, roots,
                               loader->content ? loader->content->scene : NULL, &scene, &load->err);
    if (status == LF_OK) {
        lf_log_warnings(scene, NULL);
        status = stage_of_scene(load, scene, load->file, out, &load->err);
    }
    if (status == LF_OK)
        (*out)->sent = json_incref(doc);
    json_decref(doc);
    return status;
}

/* Loads doc (ownership taken; NULL: out of memory) instead of the current scene. */
static lf_status load_document(const lf_loader *loader, const lf_roots *roots, lf_load *load,
                               json_t *doc, lf_content **out)
{
    const lf_content *now = loader->content;
    if (!doc)
        return lf_error_set(&load->err, LF_E_NOMEM, now->file, "out of memory");
    lf_scene *scene = NULL;
    lf_status status = lf_scene_from_json(doc, lf_scene_folder(now->scene), now->file, roots,
                                          now->scene, &scene, &load->err);
    json_decref(doc);
    if (status == LF_OK)
        lf_log_warnings(scene, now->scene);
    return status == LF_OK ? stage_of_scene(load, scene, now->file, out, &load->err) : status;
}

/* patch NULL: out of memory. */
static json_t *patched(const json_t *doc, const json_t *patch)
{
    return patch ? lf_json_merge_patch(doc, patch) : NULL;
}

/* The patches of a load and of loads merged into it, in order. */
static lf_status load_patches(const lf_loader *loader, const lf_roots *roots, lf_load *load,
                              lf_content **out)
{
    json_t *doc = patched(lf_scene_json(loader->content->scene), load->patch);
    for (const lf_load *next = next_of(load); next && doc; next = next_of(next)) {
        if (next->patch && lf_json_merge_into(doc, next->patch))
            continue;
        json_decref(doc);
        doc = NULL;
    }
    return load_document(loader, roots, load, doc, out);
}

/* Features that are no longer needed do no harm. */
static bool same_settings(const lf_content *a, const lf_content *b)
{
    const lf_render_settings *s = &a->settings, *t = &b->settings;
    const char *left = s->integrator ? s->integrator : "",
               *right = t->integrator ? t->integrator : "";
    return a->layout.columns == b->layout.columns && a->layout.rows == b->layout.rows &&
           a->layout.aspect == b->layout.aspect && s->camera.cone == t->camera.cone &&
           s->camera.track == t->camera.track && s->camera.aspect == t->camera.aspect &&
           s->camera.n_views == t->camera.n_views && s->width == t->width &&
           s->height == t->height && s->sampler == t->sampler && s->seed == t->seed &&
           s->max_depth == t->max_depth && strcmp(left, right) == 0 &&
           (s->features || !t->features);
}

static bool same_layout(const lf_layout *a, const lf_layout *b)
{
    return a->n_views == b->n_views && a->columns == b->columns && a->rows == b->rows &&
           a->view_width == b->view_width && a->view_height == b->view_height &&
           a->aspect == b->aspect;
}

/* Draws a picture with depth for another panel; other finished pictures have the views that they
 * have, and so has one that came by a descriptor. */
static lf_status draw_again(const lf_roots *roots, lf_load *load, const lf_content *now,
                            lf_content **out)
{
    const lf_calibration *calibration = load->has_calibration ? &load->calibration : NULL;
    lf_options options = load->options;
    options.standing = now->standing;
    if (!now->is_rgbd || now->is_passed)
        return LF_OK;
    lf_status status =
        now->player
            ? lf_content_from_movie(now->file, roots, &options, now->plays_once, calibration, out,
                                    &load->err)
            : lf_content_from_quilt(now->file, roots, &options, calibration, out, &load->err);
    if (status == LF_OK && !load->force && same_layout(&now->layout, &(*out)->layout)) {
        lf_content_unref(*out);
        *out = NULL;
    }
    return status;
}

static lf_status make_content(const lf_loader *loader, const lf_roots *roots, lf_load *load,
                              lf_content **out)
{
    if (load->kind == LF_LOAD_FILE && load->words.quilt.given)
        return load_sent_quilt(roots, load, out);
    if (load->kind == LF_LOAD_FILE)
        return lf_load_is_sent(load) ? load_sent(loader, roots, load, out)
                                     : load_file(loader, roots, load, out);
    const lf_content *now = loader->content;
    if (load->kind == LF_LOAD_APPLY) {
        if (!now || !now->scene)
            return now ? draw_again(roots, load, now, out) : LF_OK;
        lf_status status =
            stage_of_scene(load, lf_scene_ref(now->scene), now->file, out, &load->err);
        if (status == LF_OK && !load->force && same_settings(now, *out)) {
            lf_content_unref(*out);
            *out = NULL;
        }
        return status;
    }
    if (!now || !now->scene)
        return lf_error_set(&load->err, LF_E_STATE, now ? now->file : "",
                            now ? "it is a finished picture, which has no camera or scene; "
                                  "scene.load or playlist.change sets depth, focus and zoom"
                                : "no scene is loaded; load one with scene.load first");
    if (load->kind == LF_LOAD_PATCH)
        return load_patches(loader, roots, load, out);
    json_t *patch = NULL;
    lf_status status = LF_OK;
    if (load->kind == LF_LOAD_FIT)
        status = lf_fit_patch(now->scene, &now->settings, load->name, load->fill, load->steps,
                              &patch, &load->err);
    else
        patch = orbit_patch(now->scene, load);
    if (status == LF_OK)
        status = load_document(loader, roots, load, patched(lf_scene_json(now->scene), patch), out);
    json_decref(patch);
    return status;
}

/* ------------------------------------------------------------------------------------ passed -- */

/* The passed files that a load may open: for a file only its own, otherwise also the files of the
 * current content. A new reference, which may be NULL. */
static lf_status gather_passed(const lf_loader *loader, lf_load *load, lf_passed **out)
{
    const bool anew = load->kind == LF_LOAD_FILE || !loader->content;
    lf_passed *all = anew ? NULL : lf_passed_ref(loader->content->passed);
    for (const lf_load *next = load; next; next = next_of(next)) {
        lf_passed *joined = NULL;
        if (!next->sent.passed)
            continue;
        lf_status status = lf_passed_join(all, next->sent.passed, &joined, &load->err);
        lf_passed_unref(all);
        if (status != LF_OK)
            return status;
        all = joined;
    }
    *out = all;
    return LF_OK;
}

/* The content keeps the files that it names. */
static void keep_passed(const lf_loader *loader, const lf_load *load, lf_passed *passed,
                        lf_content *content)
{
    const lf_content *now = loader->content;
    content->is_passed =
        load->kind == LF_LOAD_FILE
            ? load->words.quilt.given ||
                  (!content->sent && lf_passed_has(load->sent.passed, content->file))
            : now && now->is_passed;
    if (load->kind != LF_LOAD_FILE && now)
        content->sent = json_incref(now->sent);
    for (const lf_load *next = load; next; next = next_of(next))
        if (next->sent.passed)
            lf_passed_drop_unopened(passed, next->sent.passed);
    content->passed = lf_passed_ref(passed);
}

static lf_status make_of_passed(const lf_loader *loader, lf_load *load, lf_content **out)
{
    lf_roots roots = *loader->roots; /* the folders are borrowed */
    lf_status status = gather_passed(loader, load, &roots.passed);
    if (status != LF_OK)
        return status;
    status = make_content(loader, &roots, load, out);
    if (status == LF_OK && *out)
        keep_passed(loader, load, roots.passed, *out);
    lf_passed_unref(roots.passed);
    return status;
}

/* True if the patch only changes how the picture is displayed. */
static bool is_shown_anew(const lf_loader *loader, const lf_load *load, const lf_content *content)
{
    const lf_content *now = loader->content;
    return load->kind != LF_LOAD_FILE && load->kind != LF_LOAD_APPLY &&
           same_settings(now, content) &&
           lf_same_picture(now->scene, &now->settings, content->scene, &content->settings);
}

/* Warns once, until the depth was fine in between or the scene changes. */
static void tell_depth(const lf_content *content, const lf_content *before)
{
    char words[LF_DEPTH_WORDS];
    bool told = before && before->depth.exceeded && strcmp(before->file, content->file) == 0;
    if (content->depth.exceeded && !told)
        lf_log(LF_LOG_WARNING, "%s: %s", content->file,
               lf_depth_words(&content->depth, content->settings.width, LF_DEPTH_PANEL, words,
                              sizeof words));
}

static void tell_unseen(const lf_content *content, const lf_content *before)
{
    bool told = before && before->is_unseen && strcmp(before->file, content->file) == 0;
    if (content->is_unseen && !told)
        lf_log(LF_LOG_WARNING, "%s: %s", content->file, lf_unseen_words(true));
}

static lf_status fail_cancelled(lf_load *load)
{
    return lf_error_set(&load->err, LF_E_CANCELLED, load->file ? load->file : "", "cancelled");
}

/* True if the load, or one merged into it, goes to another frame of the scene. */
static bool changes_frame(const lf_load *load)
{
    while (load && !json_object_get(load->patch, "frame"))
        load = next_of(load);
    return load;
}

static void run_load(lf_loader *loader, lf_load *load)
{
    lf_content *content = NULL;
    load->status = make_of_passed(loader, load, &content);
    if (lf_import_is_stopped()) {
        lf_content_unref(content);
        load->status = fail_cancelled(load);
        return;
    }
    if (load->status != LF_OK || !content)
        return;
    lf_content_write_document(content);
    content->is_frame = changes_frame(load);
    load->goes_on = is_shown_anew(loader, load, content);
    if (load->goes_on)
        load->status = lf_engine_show_as(loader->engine, content, &load->generation, &load->err);
    else
        load->status =
            lf_engine_commit(loader->engine, content, load->kind == LF_LOAD_FILE && !load->fresh,
                             &load->generation, &load->restored, &load->err);
    load->committed = load->status == LF_OK;
    if (!load->committed) {
        lf_content_unref(content);
        return;
    }
    tell_depth(content, loader->content);
    tell_unseen(content, loader->content);
    lf_content_unref(loader->content);
    loader->content = content;
    load->content = lf_content_ref(content);
}

/* ------------------------------------------------------------------------------------ thread -- */

/* True if two consecutive loads can be merged. */
static bool are_one(const lf_task *task, const lf_task *next)
{
    const lf_load *a = (const lf_load *)(const void *)task,
                  *b = (const lf_load *)(const void *)next;
    if (a->kind != b->kind)
        return false;
    if (a->kind == LF_LOAD_FILE)
        return !a->deferred && !b->deferred && a->sent.document == b->sent.document &&
               a->sent.passed == b->sent.passed && !a->fresh && !b->fresh && !a->reset &&
               !b->reset && strcmp(a->file, b->file) == 0;
    return a->kind == LF_LOAD_PATCH || a->kind == LF_LOAD_ORBIT;
}

/* Merges waiting loads into a load. */
static void take_others(lf_loader *loader, lf_load *load)
{
    lf_task *last = &load->task, *next;
    for (int n = 1; n < MOST_AT_ONCE; n++) {
        next = lf_worker_take(loader->worker, are_one, &load->task);
        if (!next)
            return;
        last = last->next = next;
    }
}

/* Merged loads get the same outcome; only one reports the commit. */
static void share_outcome(const lf_load *load)
{
    for (lf_task *task = load->task.next; task; task = task->next) {
        lf_load *other = (lf_load *)(void *)task;
        other->status = load->status;
        other->err = load->err;
        other->generation = load->generation;
    }
}

static void drop_task(void *context, lf_task *task)
{
    lf_load *load = (lf_load *)(void *)task;
    (void)context;
    load->status = atomic_load(&load->job.cancelled) ? fail_cancelled(load)
                                                     : lf_error_set(&load->err, LF_E_CANCELLED, "",
                                                                    "the daemon is shutting down");
}

/* The last task of the first half. */
static lf_task *middle_of(lf_task *first)
{
    lf_task *middle = first;
    for (lf_task *end = first->next; end && end->next && end->next->next; end = end->next->next)
        middle = middle->next;
    return middle;
}

static bool any_is_cancelled(const lf_load *load)
{
    for (; load; load = next_of(load))
        if (atomic_load(&load->job.cancelled))
            return true;
    return false;
}

static void note_running(lf_load *load, bool running)
{
    for (lf_task *task = &load->task; task; task = task->next)
        atomic_store(&((lf_load *)(void *)task)->job.running, running);
}

/* The cancelled load may have ended just before; then this load was stopped by mistake and runs
 * again. */
static void run_to_its_end(lf_loader *loader, lf_load *load)
{
    bool again = true;
    atomic_store(&loader->current, load->job.id);
    note_running(load, true);
    while (again) {
        lf_import_group *before = lf_import_group_begin(&loader->group);
        if (any_is_cancelled(load))
            load->status = fail_cancelled(load);
        else
            run_load(loader, load);
        (void)lf_import_group_enter(before);
        again = load->status == LF_E_CANCELLED && atomic_load(&loader->group.cancelled) &&
                !any_is_cancelled(load) && !atomic_load(&loader->ends);
    }
    note_running(load, false);
    atomic_store(&loader->current, 0);
}

/* True if the merged loads may succeed without the first one. */
static bool spoils_others(const lf_load *load)
{
    return load->status == LF_E_CANCELLED || (load->status != LF_OK && load->kind != LF_LOAD_FILE);
}

/* Runs a load and the loads merged into it. If one of them fails or is cancelled, the others must
 * not suffer: they run again in halves, so that few are repeated. */
static void run_together(lf_loader *loader, lf_load *load)
{
    if (atomic_load(&loader->ends))
        drop_task(loader, &load->task);
    else
        run_to_its_end(loader, load);
    if (!load->task.next || !spoils_others(load) || atomic_load(&loader->ends)) {
        share_outcome(load);
        return;
    }
    lf_task *middle = middle_of(&load->task), *second = middle->next;
    middle->next = NULL;
    run_together(loader, load);
    run_together(loader, (lf_load *)(void *)second);
    middle->next = second;
}

/* Before a change: waits until the current picture was shown once. Waits only briefly, unless the
 * picture before was not shown at all. */
static void let_one_show(lf_loader *loader)
{
    double end = lf_time_now() + (loader->starved ? STARVED_SECONDS : MOMENT_SECONDS);
    lf_engine_status now;
    for (;;) {
        lf_engine_get_status(loader->engine, &now);
        loader->starved = now.state == LF_STATE_RENDERING && now.level < LF_LEVEL_COARSE;
        if (!loader->starved || lf_time_now() >= end || atomic_load(&loader->ends))
            return;
        nanosleep(&(struct timespec){.tv_nsec = LOOK_NS}, NULL);
    }
}

static void run_task(void *context, lf_task *task)
{
    lf_loader *loader = context;
    lf_load *load = (lf_load *)(void *)task;
    if (load->kind == LF_LOAD_PATCH || load->kind == LF_LOAD_ORBIT)
        let_one_show(loader);
    take_others(loader, load);
    run_together(loader, load);
}

lf_status lf_loader_create(lf_engine *engine, const lf_roots *roots, lf_inbox *inbox,
                           lf_loader **out_loader)
{
    lf_loader *loader = lf_calloc(1, sizeof *loader);
    if (!loader)
        return LF_E_NOMEM;
    loader->engine = engine;
    loader->roots = roots;
    lf_passed_stop_when(lf_import_is_stopped);
    lf_status status =
        lf_worker_create("lf-loader", run_task, drop_task, loader, inbox, &loader->worker);
    if (status != LF_OK) {
        lf_free(loader);
        return status;
    }
    *out_loader = loader;
    return LF_OK;
}

void lf_loader_destroy(lf_loader *loader)
{
    if (!loader)
        return;
    atomic_store(&loader->ends, true);
    lf_worker_destroy(loader->worker);
    lf_content_unref(loader->content);
    lf_free(loader);
}

void lf_loader_queue(lf_loader *loader, lf_load *load)
{
    lf_worker_queue(loader->worker, &load->task);
}

int lf_loader_pending(lf_loader *loader)
{
    return lf_worker_pending(loader->worker);
}

/* The later thread sees the flag of the other: the worker checks `cancelled` after it has set
 * `running` and begun the group. Cancels only once, since a second time might hit another load. */
void lf_loader_cancel(lf_loader *loader, lf_load *load)
{
    if (!atomic_exchange(&load->job.cancelled, true) && atomic_load(&load->job.running))
        lf_import_group_cancel(&loader->group);
}

static bool is_cancelled(const lf_task *task)
{
    return atomic_load(&((const lf_load *)(const void *)task)->job.cancelled);
}

void lf_loader_drop_cancelled(lf_loader *loader)
{
    lf_worker_drop(loader->worker, is_cancelled);
}

int64_t lf_loader_current(lf_loader *loader)
{
    return atomic_load(&loader->current);
}
