#include "daemon/tools/rendering_plate.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/output/content.h"
#include "daemon/output/hologram.h"
#include "daemon/tools/plan_inputs.h"

/* CPU seconds per byte of samples, measured (docs/lab/applications.md): hashing files, moving
 * samples to their pictures, and writing these as PNG. */
#define HASH_SECONDS 3e-9
#define MOVE_SECONDS 2e-9
#define FILE_SECONDS 3e-8

struct lf_plate_job {
    lf_render_arguments arguments; /* those of the command line, with what the plate sets */
    lf_plate plate;
    json_t *facts;
    bool is_finished; /* by an earlier run, and it is not to be rendered again */
};

/* Tasks of a plate with these cameras. */
static int rows_of(const lf_camera *camera)
{
    return camera->n_rows > 0 ? camera->n_rows : 1;
}

static void take_rows(lf_rendering *r)
{
    lf_render_arguments *a = &r->sequence.plate->arguments;
    if (a->hologram.all_rows)
        a->frames.last = rows_of(lf_scene_camera(r->scene)) - 1;
}

lf_status lf_rendering_plate_open(lf_rendering *r, lf_error *err)
{
    if (r->arguments->kind != &lf_output_hologram)
        return LF_OK;
    lf_plate_job *job = lf_calloc(1, sizeof *job);
    if (!job)
        return lf_error_set(err, LF_E_NOMEM, r->arguments->out, "out of memory");
    job->arguments = *r->arguments;
    lf_hologram_complete(&job->arguments.hologram.options);
    r->sequence.plate = job;
    r->arguments = &job->arguments;
    take_rows(r);
    return LF_OK;
}

/* Replaces the scene by one with the patch. */
static lf_status patch(lf_rendering *r, const json_t *changes, lf_error *err)
{
    lf_scene *patched = NULL;
    const lf_status status = lf_rendering_patched(r, changes, r->scene, &patched, err);
    if (status != LF_OK)
        return status;
    lf_scene_unref(r->scene);
    r->scene = patched;
    take_rows(r);
    return lf_rendering_resolve(r, err);
}

/* The size of the preset's views. */
static void size_views(lf_options *options, const lf_hologram_preset *preset, double aspect)
{
    if (!preset || options->view_width > 0)
        return;
    options->view_height = preset->height;
    options->view_width =
        preset->width > 0 ? preset->width : (int)fmax(1, round(preset->height * aspect));
}

lf_status lf_rendering_plate_rig(lf_rendering *r, lf_error *err)
{
    lf_plate_job *job = r->sequence.plate;
    json_t *changes = NULL;
    if (!job)
        return LF_OK;
    lf_options *options = &job->arguments.options;
    const lf_hologram_options *hologram = &job->arguments.hologram.options;
    lf_status status =
        lf_hologram_patch(hologram, lf_scene_camera(r->scene), options->views, &changes, err);
    if (status != LF_OK || !changes)
        return status;
    const double aspect = hologram->width_mm > 0 ? hologram->width_mm / hologram->height_mm
                                                 : r->settings.camera.aspect;
    size_views(options, lf_hologram_preset_of(hologram), aspect);
    if (hologram->preset)
        options->views = 0;
    status = patch(r, changes, err);
    json_decref(changes);
    return status;
}

/* The settings with all rows of cameras. */
static lf_status whole_settings(const lf_rendering *r, lf_render_settings *out, lf_error *err)
{
    lf_layout layout;
    const lf_options *o = &r->arguments->options;
    const lf_status status = lf_resolve_rows(o, lf_scene_camera(r->scene), NULL, out, &layout, err);
    out->seed = o->seed;
    return status;
}

/* What decides the pictures. Names of folders do not. */
static json_t *settings_json(const lf_rendering *r, const lf_render_settings *settings)
{
    const lf_render_arguments *a = r->arguments;
    const lf_budget budget = lf_rendering_budget(r);
    const char *slash = strrchr(a->scene, '/');
    lf_film_settings film = *lf_scene_film_settings(r->scene);
    if (a->options.has_exposure)
        film = lf_exposed_film(&film, a->options.exposure);
    return lf_output_settings(slash ? slash + 1 : a->scene, settings, NULL, a->options.estimator,
                              r->reconstructs, budget.passes > 0 ? (double)budget.passes : -1,
                              &film);
}

/* What the scene shows is a fact, too: files may change between two rows. */
static lf_status add_hash(const lf_rendering *r, const lf_render_settings *settings, json_t *facts)
{
    char hash[LF_PICTURE_HASH];
    lf_status status = facts ? lf_picture_hash(r->scene, settings, hash) : LF_E_NOMEM;
    if (status == LF_OK && json_object_set_new(facts, "scene_hash", json_string(hash)) != 0)
        status = LF_E_NOMEM;
    return status;
}

static void warn_of_depth(const lf_rendering *r, const lf_hologram_depth *depth)
{
    char words[LF_DEPTH_WORDS];
    if (lf_hologram_depth_words(depth, &r->settings.camera, words, sizeof words)[0] != '\0')
        lf_log(LF_LOG_WARNING, "%s: %s", r->arguments->scene, words);
}

lf_status lf_rendering_plate_begin(lf_rendering *r, lf_error *err)
{
    lf_plate_job *job = r->sequence.plate;
    lf_render_settings settings;
    lf_hologram_depth depth;
    if (!job)
        return LF_OK;
    const lf_hologram_options *hologram = &job->arguments.hologram.options;
    const lf_frames *frames = &job->arguments.frames;
    lf_status status = whole_settings(r, &settings, err);
    if (status == LF_OK)
        status = lf_hologram_plate(hologram, &settings, &job->plate, err);
    if (status != LF_OK)
        return status;
    const bool is_known = lf_hologram_measure(hologram, r->scene, &settings, &depth);
    if (is_known)
        warn_of_depth(r, &depth);
    job->facts = lf_hologram_facts(hologram, &job->plate, &settings, is_known ? &depth : NULL,
                                   settings_json(r, &settings));
    status = add_hash(r, &settings, job->facts);
    if (status != LF_OK)
        return lf_error_set(err, status, r->path, "out of memory");
    lf_plan_inputs_pause(true);
    job->is_finished = !frames->overwrite && lf_plate_is_finished(&job->plate, r->path, job->facts);
    const bool only_checks = job->arguments.plan.on || lf_state_is_all(&job->arguments.state);
    if (only_checks)
        status = lf_plate_check(&job->plate, r->path, job->facts, err);
    lf_plan_inputs_pause(false);
    if (only_checks)
        return status;
    return lf_plate_begin(&job->plate, r->path, job->facts,
                          frames->overwrite && job->arguments.hologram.all_rows, err);
}

int lf_rendering_plate_files(const lf_rendering *r)
{
    const lf_plate_job *job = r->sequence.plate;
    return job->arguments.hologram.all_rows
               ? lf_plate_n_files(&job->plate) + 1
               : lf_frames_count(&job->arguments.frames) * lf_plate_task_files(&job->plate);
}

char *lf_rendering_plate_file(const lf_rendering *r, int i)
{
    const lf_plate_job *job = r->sequence.plate;
    const int n = lf_plate_task_files(&job->plate), first = job->arguments.frames.first;
    char *name = job->arguments.hologram.all_rows
                     ? lf_plate_file(&job->plate, i)
                     : lf_plate_task_file(&job->plate, first + i / n, i % n),
         *path = name ? lf_path_join(r->path, name) : NULL;
    lf_free(name);
    return path;
}

bool lf_rendering_plate_has(const lf_rendering *r, int row)
{
    const lf_plate_job *job = r->sequence.plate;
    return job->is_finished || lf_plate_has_task(&job->plate, r->path, job->facts, row);
}

lf_status lf_rendering_plate_write(const lf_rendering *r, const lf_output_request *request,
                                   const lf_output_source *source, lf_error *err)
{
    const int row = r->sequence.frame;
    lf_output_source of_row = *source;
    of_row.first_view = row * source->views32.n_views;
    return lf_hologram_write(request, &of_row, &r->sequence.plate->plate, r->sequence.plate->facts,
                             row, err);
}

static void show(void *context, double fraction)
{
    lf_rendering *r = context;
    char text[64];
    snprintf(text, sizeof text, "finishing the plate, %3.0f %%", 100 * fraction);
    lf_progress_line_draw(&r->line, text);
}

lf_status lf_rendering_plate_finish(lf_rendering *r, lf_error *err)
{
    const lf_plate_job *job = r->sequence.plate;
    if (!job || !job->arguments.hologram.all_rows || lf_state_is_all(&job->arguments.state))
        return LF_OK;
    const lf_output_request request = {.kind = &lf_output_hologram,
                                       .path = r->path,
                                       .pool = r->pool,
                                       .cancel = r->cancel,
                                       .progress = show,
                                       .context = r};
    lf_status status = LF_OK;
    if (!job->is_finished)
        status = lf_hologram_finish(&request, &job->plate, job->facts, err);
    lf_progress_line_clear(&r->line);
    if (status == LF_OK) {
        const lf_plate_place n = lf_plate_size(&job->plate);
        lf_log(LF_LOG_INFO, "%s %smanifest.json: %d x %d cells of %d x %d directions",
               job->is_finished ? "kept" : "wrote", r->path, n.hx, n.hy, n.u, n.v);
    }
    return status;
}

double lf_rendering_plate_bytes(const lf_rendering *r)
{
    const lf_plate *plate = &r->sequence.plate->plate;
    const double rows = lf_frames_count(&r->arguments->frames);
    return rows * (double)lf_plate_task_bytes(plate) * (lf_plate_is_direct(plate) ? 1 : 2);
}

lf_plan_cost lf_rendering_plate_cost(const lf_rendering *r)
{
    const lf_plate *plate = &r->sequence.plate->plate;
    const double bytes = (double)lf_plate_task_bytes(plate) * lf_plate_tasks(plate);
    if (lf_plate_is_direct(plate))
        return (lf_plan_cost){bytes * HASH_SECONDS, 0};
    const double a_byte = plate->form == LF_PLATE_RAW ? MOVE_SECONDS : MOVE_SECONDS + FILE_SECONDS;
    return (lf_plan_cost){bytes * (2 * HASH_SECONDS + a_byte),
                          (double)lf_plate_finish_memory(plate)};
}

void lf_rendering_plate_close(lf_rendering *r)
{
    lf_plate_job *job = r->sequence.plate;
    if (job)
        json_decref(job->facts);
    lf_free(job);
    r->sequence.plate = NULL;
}
