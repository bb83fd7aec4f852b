/* What a job costs: measured on some image rows of some light fields, the rest from the sizes of
 * what a task allocates. */
#include "daemon/tools/plan_measure.h"

#include <math.h>

#include "base/alloc.h"
#include "daemon/tools/plan_process.h"
#include "daemon/tools/rendering_shared.h"

/* Paths rendered to estimate the time, in at least LEAST_ROWS image rows if there are as many: half
 * of them if light fields share the paths. */
#define PILOT_PATHS 6e5
#define LEAST_ROWS 16
#define MOST_ROWS 64
/* Rows of a camera grid that are measured: the scene looks different from each. */
#define MEASURED_CAMERA_ROWS 3
/* A denoised image depends on the rows around: strips of as many rows, and the least passes that
 * show how visits grow. */
#define STRIP_ROWS 8
#define LEAST_STRIPS 5
#define LEAST_PASSES 24
/* Passes in which a renderer is made ready. */
#define FIRST_PASSES 2
#define LEAST_DENOISED_PASSES 96

/* -------------------------------------------------------------------------------------- rows -- */

/* The number of passes per row, in turn; the second may be 0. */
static void choose_passes(const lf_plan *plan, const lf_plan_pilot *p, bool features,
                          int64_t out[2])
{
    const double affordable = PILOT_PATHS / p->n_fields / ((double)p->n_rows * plan->width);
    const int64_t least = features ? LEAST_DENOISED_PASSES : LEAST_PASSES,
                  most = affordable > (double)least ? (int64_t)affordable : least;
    out[0] = plan->passes;
    out[1] = 0;
    if (plan->passes <= most)
        return;
    out[0] = features ? most / 6 / 2 * 2 : most / 8 / 2 * 2;
    out[0] = out[0] > 2 ? out[0] : 2;
    out[1] = most / 2 * 2 - out[0];
}

static void choose_rows(const lf_rendering *r, const lf_plan *plan, lf_plan_pilot *p)
{
    const int threads = lf_pool_threads(r->pool), height = plan->height,
              least = r->settings.features ? LEAST_STRIPS * STRIP_ROWS
                      : p->n_fields > 1    ? LEAST_ROWS / 2
                                           : LEAST_ROWS;
    const double fit = PILOT_PATHS / p->n_fields / ((double)plan->passes * plan->width);
    const int wanted = (int)fmin(fmax(fit, least), fmax(MOST_ROWS, least));
    p->strip = r->settings.features ? STRIP_ROWS : 1;
    p->strip = (p->strip + threads - 1) / threads * threads;
    p->n = (wanted + p->strip - 1) / p->strip;
    if (p->n * p->strip >= height) {
        p->strip = p->strip < height ? p->strip : height;
        p->n = (height + p->strip - 1) / p->strip;
    }
    p->n_rows = p->n * p->strip < height ? p->n * p->strip : height;
    p->height = height;
}

int lf_plan_strip(const lf_plan_pilot *p, int index, int *out_end)
{
    int first = index * p->strip;
    if (p->n_rows == p->height) {
        *out_end = first + p->strip < p->height ? first + p->strip : p->height;
        return first;
    }
    first = (int)((2 * index + 1) * (int64_t)p->height / (2 * p->n)) - p->strip / 2;
    if (p->strip % STRIP_ROWS == 0) /* cells of a fit are not cut */
        first = (first + STRIP_ROWS / 2) / STRIP_ROWS * STRIP_ROWS;
    first = first + p->strip > p->height ? p->height - p->strip : first;
    first = first < 0 ? 0 : first;
    *out_end = first + p->strip;
    return first;
}

/* Fills the times of all rows from those of the strips' rows. */
static void spread(const lf_plan_pilot *p, const double *row_cpu, double *out)
{
    int before = 0, end;
    for (int row = 0; row < p->height; row++) {
        const int first = lf_plan_strip(p, before, &end),
                  after = before + 1 < p->n ? before + 1 : before;
        const double middle = 0.5 * (first + end - 1);
        const int next_first = lf_plan_strip(p, after, &end);
        const double next = 0.5 * (next_first + end - 1),
                     weight =
                         next > middle ? fmin(fmax((row - middle) / (next - middle), 0), 1) : 0;
        out[row] = (1 - weight) * row_cpu[before] + weight * row_cpu[after];
        if (row >= next && after > before)
            before = after;
    }
}

/* The passes of all strips; adds their CPU seconds to *out_total, and those of a row of each strip
 * to row_cpu. */
static lf_status measure_strips(lf_rendering *r, const lf_plan_pilot *p, int64_t passes,
                                double *row_cpu, double *out_total)
{
    const int64_t cycles = 2 * (int64_t)r->settings.camera.n_views;
    lf_status status = LF_OK;
    *out_total = 0;
    for (int i = 0; i < p->n && status == LF_OK; i++) {
        lf_part part = {0};
        part.first_row = lf_plan_strip(p, i, &part.end_row);
        const double start = lf_time_cpu();
        for (int64_t left = passes; left > 0 && status == LF_OK; left -= cycles)
            status = lf_renderer_passes(r->renderer, &part, left < cycles ? left : cycles, false,
                                        NULL, NULL, r->cancel);
        const double cpu = lf_time_cpu() - start;
        row_cpu[i] += cpu / (part.end_row - part.first_row);
        *out_total += cpu;
    }
    return status;
}

/* From the time of the pilot's passes to that of all: visits and paths cost time. */
static double all_passes(const lf_renderer *renderer, int64_t all, const int64_t passes[2],
                         const double cpu[2])
{
    const double n[2] = {(double)passes[0], (double)passes[1]}, whole = n[0] + n[1],
                 v[2] = {(double)lf_renderer_visits(renderer, passes[0]),
                         (double)lf_renderer_visits(renderer, passes[0] + passes[1])},
                 visits[2] = {v[0], v[1] - v[0]}, det = visits[0] * n[1] - visits[1] * n[0];
    if (passes[1] == 0)
        return (double)all / whole;
    const double visit = (cpu[0] * n[1] - cpu[1] * n[0]) / det,
                 path = (cpu[1] * visits[0] - cpu[0] * visits[1]) / det;
    if (!(visit >= 0 && path >= 0))
        return (double)all / whole;
    return (visit * (double)lf_renderer_visits(renderer, all) + path * (double)all) /
           (cpu[0] + cpu[1]);
}

/* Measures the passes of one light field into row_cpu [height], in CPU seconds. */
static lf_status measure_rows(lf_rendering *r, lf_plan *plan, lf_plan_pilot *p, double *row_cpu,
                              lf_error *err)
{
    int64_t passes[2];
    double total[2] = {0}, *strip_cpu = lf_calloc((size_t)p->n, sizeof *strip_cpu);
    lf_status status = strip_cpu ? LF_OK : LF_E_NOMEM;
    choose_passes(plan, p, r->settings.features, passes);
    for (int i = 0; i < 2 && status == LF_OK; i++)
        status = measure_strips(r, p, passes[i], strip_cpu, &total[i]);
    if (status == LF_OK) {
        const double scale = all_passes(r->renderer, plan->passes, passes, total) * plan->n_sums;
        for (int i = 0; i < p->n; i++)
            strip_cpu[i] *= scale;
        spread(p, strip_cpu, row_cpu);
    }
    lf_free(strip_cpu);
    plan->rows_measured = p->n_rows;
    return status == LF_OK
               ? LF_OK
               : lf_error_set(err, status, r->arguments->out, "%s",
                              status == LF_E_CANCELLED ? "interrupted; the plan is not complete"
                                                       : "cannot measure");
}

/* ------------------------------------------------------------------------------------- model -- */

/* Rows that all workers render at once, for what the first pass and the first fit make. */
static lf_part first_rows(const lf_rendering *r)
{
    const int threads = lf_pool_threads(r->pool), height = r->settings.height;
    return (lf_part){.end_row = threads < height ? threads : height};
}

/* Memory of a fit of almost nothing. */
static lf_status measure_fit(lf_rendering *r, lf_plan *plan, lf_error *err)
{
    if (!r->reconstructs)
        return LF_OK;
    lf_process_forget_peak();
    const double before = lf_process_memory();
    lf_status status = lf_renderer_fit(r->renderer, r->cancel);
    plan->least_fit = fmax(0, fmax(lf_process_memory(), lf_process_peak()) - before);
    lf_renderer_destroy(r->renderer); /* later fits do not begin with this one */
    r->renderer = NULL;
    return status == LF_OK ? lf_renderer_create(r->scene, &r->settings, r->pool, &r->renderer, err)
                           : lf_error_set(err, status, r->arguments->out, "cannot measure");
}

/* Light paths are those of the whole image, whatever rows a pass renders: they are measured in the
 * first passes. Strips of rows then have the fewest, with which a row costs the same. Returns the
 * CPU seconds of the light paths of further passes. */
static double leave_light_paths(lf_rendering *r, const lf_plan *plan, const lf_render_stats *first)
{
    const double passes = (double)plan->passes * plan->n_sums - FIRST_PASSES;
    if (!(first->light_path_cpu > 0))
        return 0;
    r->settings.light_paths = 1;
    return first->light_path_cpu / FIRST_PASSES * fmax(passes, 0);
}

/* The renderer of the light field of r, with an empty film. *out_cpu: what it, its first passes and
 * all light paths take. */
static lf_status begin(lf_rendering *r, lf_plan *plan, double *out_cpu, double *out_memory,
                       lf_error *err)
{
    const lf_part part = first_rows(r);
    const double start = lf_process_cpu();
    lf_render_stats stats;
    lf_status status = r->renderer
                           ? lf_renderer_restart(r->renderer, r->scene, &r->settings, err)
                           : lf_renderer_create(r->scene, &r->settings, r->pool, &r->renderer, err);
    if (status != LF_OK)
        return status;
    status = lf_renderer_passes(r->renderer, &part, FIRST_PASSES, false, NULL, NULL, r->cancel);
    if (status != LF_OK)
        return lf_error_set(err, status, r->arguments->out,
                            "interrupted; the plan is not complete");
    *out_cpu = lf_process_cpu() - start;
    lf_renderer_stats(r->renderer, &stats);
    *out_cpu += leave_light_paths(r, plan, &stats);
    *out_memory =
        lf_process_memory() - (double)stats.film_bytes / r->settings.height * part.end_row;
    status = measure_fit(r, plan, err);
    return status == LF_OK && !r->reconstructs
               ? lf_renderer_restart(r->renderer, r->scene, &r->settings, err)
               : status;
}

/* Times of a job without a number of passes: those of --time, or unknown. */
static void take_time(const lf_rendering *r, const lf_plan *plan, lf_plan_sample *sample)
{
    const double seconds = lf_rendering_budget(r).seconds;
    for (int row = 0; row < plan->height; row++)
        sample->row_cpu[row] = seconds * lf_pool_threads(r->pool) / plan->height;
    if (seconds > 0)
        return;
    lf_free(sample->row_cpu);
    sample->row_cpu = NULL;
}

/* Renders a part of the light field of r and adds it to the model. start: CPU seconds of the
 * process before its scene was read. */
static lf_status add_sample(lf_rendering *r, lf_plan *plan, double field, double start,
                            lf_plan_pilot *pilot, lf_error *err)
{
    lf_plan_model *m = &plan->model;
    lf_plan_sample *sample = &m->samples[m->n_samples];
    double memory = 0;
    *sample = (lf_plan_sample){.field = field};
    const double scene = lf_process_cpu() - start;
    lf_status status = begin(r, plan, &sample->begin_cpu, &memory, err);
    if (status != LF_OK)
        return status;
    sample->begin_cpu += scene;
    m->n_samples++;
    m->base = fmax(m->base, memory);
    sample->row_cpu = lf_calloc((size_t)plan->height, sizeof *sample->row_cpu);
    if (!sample->row_cpu)
        return lf_error_set(err, LF_E_NOMEM, r->arguments->out, "out of memory");
    const int64_t passes = plan->passes;
    plan->passes = passes > 0 ? passes : LEAST_PASSES;
    choose_rows(r, plan, pilot);
    status = measure_rows(r, plan, pilot, sample->row_cpu, err);
    plan->passes = passes;
    if (passes == 0)
        take_time(r, plan, sample);
    return status;
}

static void add_sums(const lf_rendering *r, lf_plan *plan)
{
    lf_render_stats stats;
    lf_plan_model *m = &plan->model;
    lf_renderer_stats(r->renderer, &stats);
    plan->film_bytes = (double)stats.film_bytes;
    m->row = plan->film_bytes / plan->height;
    if (plan->n_parts > 0)
        m->base += (lf_shared_renderers(plan->n_parts, plan->a_frame) - 1) * plan->film_bytes;
    m->save_interval = LF_STATE_INTERVAL * lf_pool_threads(r->pool);
}

/* Loads the scene of a frame; camera: of frame 1. */
static lf_status take_frame(lf_rendering *r, int frame, const lf_camera *camera, lf_error *err)
{
    json_t *patch = lf_frames_patch_turned(&r->arguments->frames, camera, frame);
    lf_scene *next = NULL;
    r->sequence.frame = frame;
    const lf_status status = lf_rendering_patched(r, patch, r->scene, &next, err);
    json_decref(patch);
    if (status != LF_OK)
        return status;
    lf_scene_unref(r->scene);
    r->scene = next;
    const lf_status resolved = lf_rendering_resolve(r, err);
    if (r->settings.camera.n_rows > 0) /* one of them is measured */
        r->settings.camera = lf_camera_row(&r->settings.camera, r->settings.camera.n_rows / 2);
    return resolved;
}

/* Without the renderer of the light field before, whose fit would count as memory of a scene. */
static double begin_anew(lf_rendering *r)
{
    lf_renderer_destroy(r->renderer);
    r->renderer = NULL;
    lf_trim();
    return lf_process_cpu();
}

/* Frames may change: two of them are measured. */
static lf_status add_frames(lf_rendering *r, lf_plan *plan, lf_plan_pilot *pilot, lf_error *err)
{
    const lf_camera camera = *lf_scene_camera(r->scene);
    const int first = plan->job.first, n = plan->job.last - first,
              frames[] = {first + n / 4, plan->job.last - n / 4};
    lf_status status = LF_OK;
    for (int i = 0; i < (n > 0 ? 2 : 1) && status == LF_OK; i++) {
        const double start = begin_anew(r);
        status = take_frame(r, frames[i], &camera, err);
        if (status == LF_OK)
            status = add_sample(r, plan, frames[i], start, pilot, err);
    }
    return status;
}

/* Rows of a camera grid, each in the middle of its part of them. start: as in add_sample. */
static lf_status add_camera_rows(lf_rendering *r, lf_plan *plan, double start, lf_plan_pilot *pilot,
                                 lf_error *err)
{
    const int first = plan->job.first, n = plan->job.last - first + 1,
              fields = n < MEASURED_CAMERA_ROWS ? 1 : MEASURED_CAMERA_ROWS;
    lf_status status = LF_OK;
    pilot->n_fields = fields;
    for (int i = 0; i < fields && status == LF_OK; i++) {
        r->sequence.frame = first + (2 * i + 1) * n / (2 * fields);
        start = i > 0 ? begin_anew(r) : start;
        status = lf_rendering_resolve(r, err);
        if (status == LF_OK)
            status = add_sample(r, plan, r->sequence.frame, start, pilot, err);
    }
    return status;
}

lf_status lf_plan_measure(lf_rendering *r, lf_plan *plan, lf_error *err)
{
    lf_plan_model *m = &plan->model;
    lf_plan_pilot pilot = {.n_fields = 1};
    const double start = lf_process_cpu();
    const bool of_rows = r->arguments->frames.of_rows;
    m->height = plan->height;
    m->load_cpu = start;
    m->loading = fmax(lf_process_peak(), lf_process_child_peak());
    lf_status status =
        of_rows ? add_camera_rows(r, plan, start, &pilot, err)
        : r->sequence.on
            ? add_frames(r, plan, &pilot, err)
            : add_sample(r, plan, 0.5 * (plan->job.first + plan->job.last), start, &pilot, err);
    if (status != LF_OK)
        return status;
    add_sums(r, plan);
    return lf_plan_measure_answer(r, plan, &pilot, err);
}

void lf_plan_model_finish(lf_plan_model *model)
{
    for (int i = 0; i < model->n_samples; i++)
        lf_free(model->samples[i].row_cpu);
}
