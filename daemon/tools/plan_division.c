#include "daemon/tools/plan_division.h"

#include <math.h>
#include <stdlib.h>

#include "base/alloc.h"

/* Bands of a light field if the limit of memory cannot be met by any number of them. */
#define MOST_VAIN_BANDS 16

/* A job while it is divided. */
typedef struct division {
    const lf_plan_job *job;
    const lf_plan_model *model;
    const lf_plan_limits *limits;
    double passes[LF_PLAN_SAMPLES]; /* of all rows of a sample */
    lf_plan_division out;
    int task_room, finish_room;
} division;

/* -------------------------------------------------------------------------------------- cost -- */

/* The samples on both sides of a field, and the weight of the second. */
static double around(const lf_plan_model *m, int field, int *out_before, int *out_after)
{
    int after = 0;
    while (after < m->n_samples - 1 && m->samples[after].field < field)
        after++;
    const int before = after > 0 && m->samples[after].field > field ? after - 1 : after;
    const double width = m->samples[after].field - m->samples[before].field;
    *out_before = before;
    *out_after = after;
    return width > 0 ? (field - m->samples[before].field) / width : 0;
}

static bool knows_time(const lf_plan_model *m)
{
    return m->samples[0].row_cpu;
}

static double begin_cpu(const lf_plan_model *m, int field)
{
    int a, b;
    const double weight = around(m, field, &a, &b);
    return (1 - weight) * m->samples[a].begin_cpu + weight * m->samples[b].begin_cpu;
}

/* CPU seconds of the passes of an image row. */
static double row_cpu(const lf_plan_model *m, int field, int row)
{
    int a, b;
    const double weight = around(m, field, &a, &b);
    return (1 - weight) * m->samples[a].row_cpu[row] + weight * m->samples[b].row_cpu[row];
}

/* Of all rows. */
static double passes_cpu(const division *d, int field)
{
    int a, b;
    const double weight = around(d->model, field, &a, &b);
    return (1 - weight) * d->passes[a] + weight * d->passes[b];
}

/* Of the states that passes of this time leave. */
static double saves_cpu(const lf_plan_model *m, int n_rows, double passes)
{
    const double n = m->save_interval > 0 ? 1 + floor(passes / m->save_interval) : 0;
    return n * m->save_cpu * n_rows;
}

/* Of a light field in a task: without its files if the task keeps states. A task's first light
 * field shares its work with the others. */
static double field_cpu(const division *d, int field, bool is_first)
{
    const lf_plan_model *m = d->model;
    const double passes = passes_cpu(d, field) * (is_first ? 1 : d->job->again);
    return begin_cpu(m, field) + passes +
           (d->job->is_joined ? saves_cpu(m, m->height, passes) : m->answer_cpu);
}

/* Memory of a task with this many rows of a light field. */
static double memory_of(const lf_plan_model *m, int n_rows, bool writes_files)
{
    return fmax(m->loading, m->base + n_rows * m->row + (writes_files ? m->answer : 0));
}

/* A task of whole light fields. */
static lf_plan_cost fields_cost(const division *d, int first, int last)
{
    const lf_plan_model *m = d->model;
    lf_plan_cost cost = {m->load_cpu, memory_of(m, m->height, !d->job->is_joined)};
    for (int field = first; field <= last && knows_time(m); field++)
        cost.cpu_seconds += field_cpu(d, field, field == first);
    if (!knows_time(m))
        cost.cpu_seconds = -1;
    return cost;
}

/* The job as one task, which keeps no states. */
static lf_plan_cost whole_cost(const division *d)
{
    const lf_plan_model *m = d->model;
    const lf_plan_job *job = d->job;
    const double n = job->last - job->first + 1;
    lf_plan_cost cost = fields_cost(d, job->first, job->last);
    if (job->is_joined || job->joins_files)
        cost.memory = fmax(cost.memory, m->join);
    for (int field = job->first; field <= job->last && knows_time(m) && job->is_joined; field++)
        cost.cpu_seconds -= saves_cpu(m, m->height, passes_cpu(d, field));
    if (knows_time(m) && (job->is_joined || job->joins_files))
        cost.cpu_seconds += n * m->join_cpu;
    if (job->is_closed) {
        cost.cpu_seconds += knows_time(m) ? m->close.cpu_seconds : 0;
        cost.memory = fmax(cost.memory, m->base + m->close.memory);
    }
    return cost;
}

/* Image rows of a light field, kept as a state. */
static lf_plan_cost band_cost(const division *d, int field, int first_row, int last_row)
{
    const lf_plan_model *m = d->model;
    const int n_rows = last_row - first_row + 1;
    double passes = 0;
    for (int row = first_row; row <= last_row && knows_time(m); row++)
        passes += row_cpu(m, field, row);
    const double cpu = m->load_cpu + begin_cpu(m, field) + passes + saves_cpu(m, n_rows, passes);
    return (lf_plan_cost){knows_time(m) ? cpu : -1, memory_of(m, n_rows, false)};
}

/* The files of a light field from its state. */
static lf_plan_cost finish_cost(const division *d, int field)
{
    const lf_plan_model *m = d->model;
    return (lf_plan_cost){m->load_cpu + begin_cpu(m, field) + m->save_cpu * m->height +
                              m->answer_cpu,
                          memory_of(m, m->height, true)};
}

static lf_plan_cost join_cost(const division *d)
{
    const lf_plan_model *m = d->model;
    const double a_field = m->join_cpu + (d->job->is_joined ? m->save_cpu * m->height : 0),
                 n = d->job->last - d->job->first + 1;
    return (lf_plan_cost){m->load_cpu + n * a_field, fmax(m->loading, m->join)};
}

static lf_plan_cost close_cost(const division *d)
{
    const lf_plan_model *m = d->model;
    return (lf_plan_cost){m->load_cpu + m->close.cpu_seconds,
                          fmax(m->loading, m->base + m->close.memory)};
}

double lf_plan_least_memory(const lf_plan_job *job, const lf_plan_model *m)
{
    const bool has_bands = job->can_band && m->height > 1;
    return memory_of(m, has_bands ? 1 : m->height, !has_bands && !job->is_joined);
}

/* Unknown times are within every limit. */
static bool is_short(const division *d, const lf_plan_cost *cost)
{
    return !(d->limits->cpu_seconds > 0) || cost->cpu_seconds <= d->limits->cpu_seconds;
}

static bool fits(const division *d, const lf_plan_cost *cost)
{
    return is_short(d, cost) && (!(d->limits->memory > 0) || cost->memory <= d->limits->memory);
}

/* -------------------------------------------------------------------------------------- rows -- */

/* Makes room for one more item of a list. */
static bool make_room(void **list, int n, int *room, size_t size)
{
    if (n < *room)
        return true;
    const int more = *room > 0 ? 2 * *room : 16;
    void *longer = realloc(*list, (size_t)more * size);
    if (!longer)
        return false;
    *list = longer;
    *room = more;
    return true;
}

static lf_status add_task(division *d, const lf_plan_task *task, lf_error *err)
{
    lf_plan_division *out = &d->out;
    if (out->n_tasks == LF_PLAN_MOST_TASKS)
        return lf_error_set(err, LF_E_ARG, "--task-minutes",
                            "would divide the job into more than %d tasks; ask for longer tasks",
                            LF_PLAN_MOST_TASKS);
    void *list = out->tasks;
    const bool has_room = make_room(&list, out->n_tasks, &d->task_room, sizeof *out->tasks);
    out->tasks = list;
    if (!has_room)
        return lf_error_set(err, LF_E_NOMEM, "--plan", "out of memory");
    out->tasks[out->n_tasks++] = *task;
    return LF_OK;
}

static lf_status add_finish(division *d, const lf_plan_finish *finish, lf_error *err)
{
    lf_plan_division *out = &d->out;
    void *list = out->finishes;
    const bool has_room = make_room(&list, out->n_finishes, &d->finish_room, sizeof *out->finishes);
    out->finishes = list;
    if (!has_room)
        return lf_error_set(err, LF_E_NOMEM, "--plan", "out of memory");
    out->finishes[out->n_finishes++] = *finish;
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- bands -- */

/* What a band of a light field may hold. */
typedef struct band_limits {
    double share; /* of the light field's cost */
    int n_rows;
} band_limits;

/* A row's part of the cost: of its time, or of the number of rows if times are unknown. */
static double weight_of(const division *d, int field, int row)
{
    return knows_time(d->model) ? row_cpu(d->model, field, row) : 1;
}

static band_limits limits_of_bands(const division *d, int field, double total)
{
    const lf_plan_model *m = d->model;
    const double begin = m->load_cpu + begin_cpu(m, field);
    band_limits limits = {total, m->height};
    if (d->limits->cpu_seconds > 0 && knows_time(m)) {
        const double most = fmax(d->limits->cpu_seconds - begin, begin);
        limits.share = total / fmin(fmax(1, ceil(total / most)), m->height);
    }
    if (d->limits->memory >= lf_plan_least_memory(d->job, m))
        limits.n_rows =
            (int)fmin(fmax(1, floor((d->limits->memory - m->base) / m->row)), m->height);
    else if (d->limits->memory > 0)
        limits.n_rows = (m->height + MOST_VAIN_BANDS - 1) / MOST_VAIN_BANDS;
    const int n_bands = (m->height + limits.n_rows - 1) / limits.n_rows; /* of like size */
    limits.n_rows = (m->height + n_bands - 1) / n_bands;
    if (!knows_time(m)) /* equal bands */
        limits.share = total / ceil(total / limits.n_rows);
    return limits;
}

/* The last row of the band that begins with `first`; *left: the cost of the rows from there on. A
 * band ends where its cost is nearest to the share, and the last one takes what is left. */
static int end_of_band(const division *d, int field, int first, const band_limits *limits,
                       double *left)
{
    const int height = d->model->height,
              most = first + limits->n_rows < height ? first + limits->n_rows : height;
    double sum = weight_of(d, field, first);
    int end = first + 1;
    if (most == height && *left < 1.5 * limits->share) {
        *left = 0;
        return height - 1;
    }
    for (; end < most; end++) {
        const double next = weight_of(d, field, end);
        if (sum + 0.5 * next > limits->share * (1 + 1e-9))
            break;
        sum += next;
    }
    *left -= sum;
    return end - 1;
}

static lf_status add_bands(division *d, int field, lf_error *err)
{
    const int height = d->model->height, first_task = d->out.n_tasks;
    double total = 0;
    for (int row = 0; row < height; row++)
        total += weight_of(d, field, row);
    const band_limits limits = limits_of_bands(d, field, total);
    double left = total;
    lf_status status = LF_OK;
    for (int first = 0; first < height && status == LF_OK;) {
        const int last = end_of_band(d, field, first, &limits, &left);
        const lf_plan_task task = {.fields = {field, field},
                                   .rows = {first, last},
                                   .cost = band_cost(d, field, first, last)};
        status = add_task(d, &task, err);
        first = last + 1;
    }
    const lf_plan_finish finish = {.fields = {field, field},
                                   .tasks = {first_task, d->out.n_tasks - 1},
                                   .cost = finish_cost(d, field)};
    return status == LF_OK && !d->job->is_joined ? add_finish(d, &finish, err) : status;
}

/* ------------------------------------------------------------------------------------ fields -- */

/* Whether one light field alone exceeds the limits and can be divided. */
static bool wants_bands(const division *d, int field)
{
    const lf_plan_cost cost = fields_cost(d, field, field);
    return d->job->can_band && d->model->height > 1 && !fits(d, &cost);
}

/* The last light field of a task that begins with `first`. */
static int end_of_fields(const division *d, int first)
{
    const lf_plan_job *job = d->job;
    int last = first + job->group - 1;
    last = last < job->last ? last : job->last;
    lf_plan_cost cost = fields_cost(d, first, last);
    if (!(d->limits->cpu_seconds > 0) || !knows_time(d->model))
        return last;
    for (; last < job->last && !wants_bands(d, last + 1); last++) {
        cost.cpu_seconds += field_cpu(d, last + 1, false);
        if (!is_short(d, &cost)) /* more of them need no more memory */
            break;
    }
    return last;
}

static lf_status add_fields(division *d, int first, int last, lf_error *err)
{
    const lf_plan_task task = {.fields = {first, last},
                               .rows = {0, d->job->is_joined ? d->model->height - 1 : -1},
                               .cost = fields_cost(d, first, last)};
    return add_task(d, &task, err);
}

static lf_status divide(division *d, lf_error *err)
{
    const lf_plan_job *job = d->job;
    lf_status status = LF_OK;
    bool all_bands = false;
    for (int field = job->first; field <= job->last && job->is_closed && !all_bands; field++)
        all_bands = wants_bands(d, field);
    for (int field = job->first; field <= job->last && status == LF_OK;) {
        const bool bands = all_bands || (!job->is_closed && wants_bands(d, field));
        const int last = bands ? field : end_of_fields(d, field);
        status = bands ? add_bands(d, field, err) : add_fields(d, field, last, err);
        field = last + 1;
    }
    const lf_plan_finish finish = {
        .fields = {0, -1},
        .tasks = {0, d->out.n_tasks - 1},
        .closes = job->is_closed,
        .cost = job->is_closed ? close_cost(d) : join_cost(d),
    };
    if (status == LF_OK && (job->is_joined || job->joins_files || job->is_closed))
        status = add_finish(d, &finish, err);
    return status;
}

/* A job without light fields to name: tasks name none. */
static void forget_fields(lf_plan_division *out)
{
    for (int i = 0; i < out->n_tasks; i++)
        out->tasks[i].fields[1] = out->tasks[i].fields[0] - 1;
    for (int i = 0; i < out->n_finishes; i++)
        out->finishes[i].fields[1] = out->finishes[i].fields[0] - 1;
}

/* Whether the job stays one task. */
static bool is_whole(const division *d, const lf_plan_cost *cost)
{
    const lf_plan_job *job = d->job;
    const bool is_one = job->is_joined || job->joins_files || job->is_closed,
               may_group = job->first == job->last || d->limits->cpu_seconds > 0;
    return job->is_whole || (is_one && may_group && knows_time(d->model) && fits(d, cost));
}

lf_status lf_plan_divide(const lf_plan_job *job, const lf_plan_model *model,
                         const lf_plan_limits *limits, lf_plan_division *out, lf_error *err)
{
    division d = {.job = job, .model = model, .limits = limits};
    lf_status status;
    for (int i = 0; i < model->n_samples && knows_time(model); i++)
        for (int row = 0; row < model->height; row++)
            d.passes[i] += model->samples[i].row_cpu[row];
    const lf_plan_task whole = {.fields = {0, -1}, .rows = {0, -1}, .cost = whole_cost(&d)};
    if (is_whole(&d, &whole.cost))
        status = add_task(&d, &whole, err);
    else
        status = divide(&d, err);
    if (status == LF_OK && !job->has_fields)
        forget_fields(&d.out);
    if (status == LF_OK)
        *out = d.out;
    else
        lf_plan_division_finish(&d.out);
    return status;
}

void lf_plan_division_finish(lf_plan_division *parts)
{
    free(parts->tasks);
    free(parts->finishes);
    *parts = (lf_plan_division){0};
}
