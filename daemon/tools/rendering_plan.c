#include "daemon/tools/rendering_plan.h"

#include <string.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/tools/plan.h"
#include "daemon/tools/plan_inputs.h"
#include "daemon/tools/rendering_plate.h"
#include "daemon/tools/rendering_shared.h"

/* Frames per task that share parts of their shutters, in shutters, at least. */
#define SHUTTERS_A_TASK 4

/* Bytes of all files, uncompressed; negative: unknown. */
static double files_bytes(const lf_rendering *r, int n_files_of)
{
    const lf_render_arguments *a = r->arguments;
    const lf_render_settings *s = &r->settings;
    if (r->sequence.plate)
        return lf_rendering_plate_bytes(r);
    const bool is_light = lf_output_is_light(a->kind, a->out);
    const double a_pixel = is_light ? 12 + 4.0 * lf_layer_channels(a->options.layers, NULL) : 3;
    if (a->kind == &lf_output_video && r->sequence.on) /* its frames, which are larger */
        return 3.0 * n_files_of * lf_camera_views(&s->camera) * s->width * s->height;
    if (!a->kind->surplus && a->kind != &lf_output_quilt && a->kind != &lf_output_still)
        return -1;
    return a_pixel * n_files_of * lf_camera_views(&s->camera) * s->width * s->height;
}

/* What the light fields are, and how tasks name them. */
static void describe_fields(const lf_rendering *r, lf_plan *plan)
{
    const lf_frames *frames = &r->arguments->frames;
    lf_plan_job *job = &plan->job;
    if (r->sequence.on) {
        plan->option = frames->of_rows ? "--camera-rows" : "--frames";
        job->first = frames->first;
        job->last = frames->last;
    } else if (plan->n_rows > 1) {
        plan->option = "--camera-rows";
        job->last = plan->n_rows - 1;
    }
    job->has_fields = plan->option;
    job->is_joined = !r->sequence.on && plan->n_rows > 1;
    job->joins_files = r->sequence.on && r->arguments->kind == &lf_output_video;
    job->is_closed = r->sequence.plate && r->arguments->hologram.all_rows;
}

/* Frames whose shutters overlap are rendered together. */
static void describe_shutters(const lf_rendering *r, lf_plan *plan)
{
    const int fields = plan->job.last - plan->job.first + 1;
    plan->passes = lf_rendering_budget(r).passes;
    plan->n_sums = r->sequence.on && !r->arguments->frames.of_rows ? plan->n_rows : 1;
    plan->job.group = 1;
    plan->job.again = 1;
    plan->n_parts = lf_shared_parts(r, &plan->a_frame);
    if (plan->n_parts == 0)
        return;
    if (plan->passes > 0)
        plan->passes = lf_shared_budget(r, plan->n_parts).passes;
    plan->n_sums = plan->n_parts;
    plan->job.group = SHUTTERS_A_TASK * ((plan->n_parts - 1) / plan->a_frame + 1);
    plan->job.group = plan->job.group < fields ? plan->job.group : fields;
    plan->job.again = (double)plan->a_frame / plan->n_parts;
}

/* Names the frames of a video that tasks write: beside it, or in the folder frames of a job. */
static lf_status name_frames(const lf_rendering *r, lf_plan *plan, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const bool is_one = r->layout.n_views == 1 && a->options.columns == 0;
    char *stem = lf_path_beside(a->out, "_%04d.png");
    const char *slash = stem ? strrchr(stem, '/') : NULL;
    char *name =
        stem && a->plan.json ? lf_path_join("frames", slash ? slash + 1 : stem) : lf_strdup(stem);
    lf_status status = name ? lf_output_path(is_one ? &lf_output_still : &lf_output_quilt, name,
                                             &r->layout, &plan->frames, err)
                            : lf_error_set(err, LF_E_NOMEM, a->out, "out of memory");
    lf_free(stem);
    lf_free(name);
    return status;
}

static void describe(const lf_rendering *r, lf_plan *plan)
{
    const lf_camera *camera = &r->settings.camera;
    *plan = (lf_plan){.n_rows = camera->n_rows > 0 ? camera->n_rows : 1,
                      .n_views = lf_camera_views(camera),
                      .width = r->settings.width,
                      .height = r->settings.height};
    describe_fields(r, plan);
    describe_shutters(r, plan);
    plan->files_bytes = files_bytes(r, r->sequence.on ? plan->job.last - plan->job.first + 1 : 1);
}

/* What can be divided, now that there is a renderer. */
static void describe_parts(const lf_rendering *r, lf_plan *plan)
{
    lf_plan_job *job = &plan->job;
    const bool keeps_states = lf_renderer_is_its_film(r->renderer) && !r->settings.camera.list;
    job->is_whole = job->is_joined && !keeps_states;
    job->can_band = keeps_states && plan->passes > 0 && plan->n_parts == 0 &&
                    r->arguments->kind != &lf_output_video && (plan->n_rows == 1 || job->is_joined);
}

/* More and more tasks would not help. */
static void warn_of_memory(const lf_plan *plan, double asked)
{
    const double least = lf_plan_least_memory(&plan->job, &plan->model);
    if (asked > 0 && least > asked)
        lf_log(LF_LOG_WARNING,
               "--task-memory: the smallest task needs %.0f MB, and %.0f MB were asked for",
               least / 1e6, asked / 1e6);
}

static lf_status divide_and_print(const lf_rendering *r, lf_plan *plan, lf_error *err)
{
    const lf_plan_arguments *asked = &r->arguments->plan;
    const lf_plan_limits limits = {60 * asked->minutes * lf_pool_threads(r->pool), asked->memory};
    lf_status status = lf_plan_divide(&plan->job, &plan->model, &limits, &plan->division, err);
    if (status == LF_OK)
        warn_of_memory(plan, asked->memory);
    const bool joins =
        plan->division.n_finishes > 0 && r->arguments->kind == &lf_output_video && r->sequence.on;
    if (status == LF_OK && joins)
        status = name_frames(r, plan, err);
    if (status == LF_OK)
        status = asked->json ? lf_plan_print_json(r, plan, err) : lf_plan_print_text(r, plan, err);
    return status;
}

/* Tasks would refuse these files, and keep their options for ever. */
static lf_status check_kept(lf_rendering *r, lf_error *err)
{
    lf_plan_inputs_pause(true);
    const lf_status status = lf_rendering_check_all_kept(r, err);
    lf_plan_inputs_pause(false);
    return status;
}

lf_status lf_rendering_plan(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    lf_plan plan = {0};
    lf_status status = check_kept(r, err);
    if (status == LF_OK && a->frames.of_rows) {
        r->sequence.frame = (a->frames.first + a->frames.last) / 2;
        status = lf_rendering_resolve(r, err);
    }
    if (status == LF_OK) {
        describe(r, &plan);
        if (plan.n_rows > 1)
            r->settings.camera = lf_camera_row(&r->settings.camera, plan.n_rows / 2);
        status = lf_plan_measure(r, &plan, err);
    }
    if (status == LF_OK) {
        describe_parts(r, &plan);
        if (r->sequence.plate)
            plan.model.close = lf_rendering_plate_cost(r);
        status = divide_and_print(r, &plan, err);
    }
    lf_plan_division_finish(&plan.division);
    lf_plan_model_finish(&plan.model);
    lf_free(plan.frames);
    return status;
}
