/* What a job costs: measured on some image rows of some light fields, the rest from the sizes of
 * what a task allocates. */
#include <math.h>
#include <stdio.h>
#include <sys/resource.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/number.h"
#include "daemon/output/guides.h"
#include "daemon/tools/plan.h"
#include "daemon/tools/rendering_shared.h"

/* Paths rendered to estimate the time, in at least LEAST_ROWS image rows if there are as many. */
#define PILOT_PATHS 5e5
#define LEAST_ROWS 16
#define MOST_ROWS 64

/* ----------------------------------------------------------------------------------- process -- */

/* CPU seconds of this process and of its ended children. */
static double process_cpu(void)
{
    struct rusage children;
    getrusage(RUSAGE_CHILDREN, &children);
    return lf_time_cpu() + (double)children.ru_utime.tv_sec + (double)children.ru_stime.tv_sec +
           1e-6 * (double)(children.ru_utime.tv_usec + children.ru_stime.tv_usec);
}

/* Resident memory of this process in bytes. */
static double process_memory(void)
{
    char text[128] = "";
    uint64_t pages = 0;
    FILE *f = fopen("/proc/self/statm", "re");
    const char *after = f && fgets(text, sizeof text, f) ? lf_whole_read(text, &pages) : NULL;
    if (after) /* the second number */
        (void)lf_whole_read(after + 1, &pages);
    if (f)
        fclose(f);
    return (double)pages * (double)sysconf(_SC_PAGESIZE);
}

static double process_peak(void)
{
    struct rusage self;
    getrusage(RUSAGE_SELF, &self);
    return 1024.0 * (double)self.ru_maxrss;
}

/* -------------------------------------------------------------------------------------- rows -- */

/* Image rows that are rendered, evenly spread. */
typedef struct pilot {
    int first, step, n; /* rows first, first + step, … */
    int at_once;        /* rows that are timed together, so that all workers have one */
    int64_t passes;
} pilot;

static pilot pilot_of(const lf_rendering *r, const lf_plan *plan)
{
    const int64_t cycles = 2 * (int64_t)r->settings.camera.n_views;
    pilot p = {.at_once = lf_pool_threads(r->pool),
               .passes = plan->passes < cycles ? plan->passes : cycles};
    const double fit = PILOT_PATHS / ((double)p.passes * plan->width);
    const int wanted = (int)fmin(fmax(fit, LEAST_ROWS), MOST_ROWS);
    p.step = plan->height > wanted ? plan->height / wanted : 1;
    p.first = p.step / 2;
    p.n = (plan->height - p.first - 1) / p.step + 1;
    return p;
}

/* Fills the times of all rows from those of the pilot's groups of rows, each of which stands for
 * the rows around its middle. */
static void spread(const pilot *p, const double *group_cpu, int n_groups, int height, double *out)
{
    for (int row = 0; row < height; row++) {
        const double at =
                         ((row - p->first) / (double)p->step - 0.5 * (p->at_once - 1)) / p->at_once,
                     clamped = fmin(fmax(at, 0), n_groups - 1);
        const int before = (int)clamped, after = before + 1 < n_groups ? before + 1 : before;
        out[row] = group_cpu[before] + (clamped - before) * (group_cpu[after] - group_cpu[before]);
    }
}

/* Measures the passes of one light field into row_cpu [height], in CPU seconds. */
static lf_status measure_rows(lf_rendering *r, lf_plan *plan, double *row_cpu, lf_error *err)
{
    const pilot p = pilot_of(r, plan);
    const int n_groups = (p.n + p.at_once - 1) / p.at_once;
    double *group_cpu = lf_calloc((size_t)n_groups, sizeof *group_cpu);
    lf_status status = group_cpu ? LF_OK : LF_E_NOMEM;
    for (int i = 0; i < n_groups && status == LF_OK; i++) {
        const int left = p.n - i * p.at_once, n = left < p.at_once ? left : p.at_once,
                  first = p.first + i * p.at_once * p.step;
        const lf_part part = {
            .first_row = first, .end_row = first + (n - 1) * p.step + 1, .row_step = p.step};
        const double start = lf_time_cpu();
        status = lf_renderer_passes(r->renderer, &part, p.passes, false, NULL, NULL, r->cancel);
        group_cpu[i] = (lf_time_cpu() - start) / n * ((double)plan->passes / (double)p.passes);
    }
    if (status == LF_OK)
        spread(&p, group_cpu, n_groups, plan->height, row_cpu);
    lf_free(group_cpu);
    plan->rows_measured = p.n;
    return status == LF_OK
               ? LF_OK
               : lf_error_set(err, status, r->arguments->out, "%s",
                              status == LF_E_CANCELLED ? "interrupted; the plan is not complete"
                                                       : "cannot measure");
}

/* ------------------------------------------------------------------------------------- model -- */

static int channels_of(const lf_rendering *r)
{
    const lf_options *o = &r->arguments->options;
    return lf_layer_channels(o->guides ? LF_GUIDE_LAYERS : o->layers, NULL);
}

/* Memory of a light field's answer and files, besides its sums. */
static double answer_bytes(const lf_rendering *r, const lf_plan *plan)
{
    const double pixels = (double)plan->n_views * plan->width * plan->height;
    return pixels * (3 + channels_of(r)) * sizeof(float);
}

/* Renders a part of the light field of r and adds it to the model. */
static lf_status add_sample(lf_rendering *r, lf_plan *plan, double field, lf_error *err)
{
    lf_plan_model *m = &plan->model;
    lf_plan_sample *sample = &m->samples[m->n_samples];
    const double start = process_cpu();
    lf_status status = r->renderer
                           ? lf_renderer_restart(r->renderer, r->scene, &r->settings, err)
                           : lf_renderer_create(r->scene, &r->settings, r->pool, &r->renderer, err);
    *sample = (lf_plan_sample){.field = field, .begin_cpu = process_cpu() - start};
    if (status != LF_OK)
        return status;
    m->n_samples++;
    const double seconds = lf_rendering_budget(r).seconds;
    if (plan->passes == 0 && !(seconds > 0))
        return LF_OK;
    sample->row_cpu = lf_calloc((size_t)plan->height, sizeof *sample->row_cpu);
    if (!sample->row_cpu)
        return lf_error_set(err, LF_E_NOMEM, r->arguments->out, "out of memory");
    for (int row = 0; row < plan->height; row++)
        sample->row_cpu[row] = seconds * lf_pool_threads(r->pool) / plan->height;
    return plan->passes > 0 ? measure_rows(r, plan, sample->row_cpu, err) : LF_OK;
}

lf_status lf_plan_measure(lf_rendering *r, lf_plan *plan, lf_error *err)
{
    lf_plan_model *m = &plan->model;
    lf_render_stats stats;
    m->height = plan->height;
    m->load_cpu = process_cpu();
    m->loading = process_peak();
    lf_status status = add_sample(r, plan, 0.5 * (plan->job.first + plan->job.last), err);
    if (status != LF_OK)
        return status;
    lf_renderer_stats(r->renderer, &stats);
    plan->film_bytes = (double)stats.film_bytes;
    m->row = plan->film_bytes / plan->height;
    m->base = process_memory() - m->row * plan->rows_measured;
    if (plan->n_parts > 0)
        m->base += (lf_shared_renderers(plan->n_parts, plan->a_frame) - 1) * plan->film_bytes;
    m->answer = answer_bytes(r, plan);
    m->save_interval = LF_STATE_INTERVAL * lf_pool_threads(r->pool);
    m->join = m->base + plan->film_bytes + m->answer;
    if (plan->job.is_joined)
        m->join += (plan->job.last - plan->job.first) * m->answer;
    return LF_OK;
}

void lf_plan_model_finish(lf_plan_model *model)
{
    for (int i = 0; i < model->n_samples; i++)
        lf_free(model->samples[i].row_cpu);
}
