/* A job that is divided: every image row of every light field is in one task, tasks keep the
 * limits, and costs are those of the model. */
#include <math.h>

#include "daemon/tools/plan_division.h"
#include "tests/testing.h"

#define FIELDS 7
#define ROWS 40

/* Ten seconds a light field, most of it in the middle rows; two to load. */
typedef struct fixture {
    double row_cpu[2][ROWS];
    lf_plan_model model;
    lf_plan_job job;
} fixture;

static int set_up(void **state)
{
    static fixture f;
    f = (fixture){
        .model = {.n_samples = 2,
                  .samples = {{.field = 0, .begin_cpu = 1, .row_cpu = f.row_cpu[0]},
                              {.field = 6, .begin_cpu = 1, .row_cpu = f.row_cpu[1]}},
                  .height = ROWS,
                  .load_cpu = 2,
                  .answer_cpu = 3,
                  .save_cpu = 0.01,
                  .save_interval = 100,
                  .join_cpu = 0.5,
                  .loading = 50,
                  .base = 100,
                  .row = 10,
                  .answer = 200,
                  .join = 900},
        .job = {.has_fields = true, .last = FIELDS - 1, .can_band = true, .group = 1, .again = 1}};
    for (int row = 0; row < ROWS; row++) {
        const double from_middle = fabs(row - 0.5 * (ROWS - 1));
        f.row_cpu[0][row] = (ROWS / 2 - from_middle) * 10 / (ROWS * ROWS / 4);
        f.row_cpu[1][row] = 2 * f.row_cpu[0][row];
    }
    *state = &f;
    return 0;
}

static void assert_near(double x, double expected, double within)
{
    if (!(fabs(x - expected) <= within))
        fail_msg("%g, expected %g", x, expected);
}

static lf_plan_division divide(const fixture *f, double seconds, double memory)
{
    const lf_plan_limits limits = {seconds, memory};
    lf_plan_division out;
    lf_error err = {0};
    lf_assert_ok(lf_plan_divide(&f->job, &f->model, &limits, &out, &err), &err);
    return out;
}

/* How often an image row of a light field is in a task. */
static int count_of(const lf_plan_division *d, int field, int row)
{
    int n = 0;
    for (int i = 0; i < d->n_tasks; i++) {
        const lf_plan_task *t = &d->tasks[i];
        const bool has_field = field >= t->fields[0] && field <= t->fields[1],
                   is_whole = t->rows[1] < t->rows[0];
        n += has_field && (is_whole || (row >= t->rows[0] && row <= t->rows[1]));
    }
    return n;
}

static void assert_complete(const lf_plan_division *d)
{
    for (int field = 0; field < FIELDS; field++)
        for (int row = 0; row < ROWS; row++)
            assert_int_equal(count_of(d, field, row), 1);
}

/* The model's time of one row of one light field. */
static double row_of(const fixture *f, int field, int row)
{
    return f->row_cpu[0][row] * (1 + field / (FIELDS - 1.0));
}

static double task_seconds(const fixture *f, const lf_plan_task *t)
{
    const bool is_whole = t->rows[1] < t->rows[0];
    const int first = is_whole ? 0 : t->rows[0], last = is_whole ? ROWS - 1 : t->rows[1];
    double sum = f->model.load_cpu;
    for (int field = t->fields[0]; field <= t->fields[1]; field++) {
        sum += 1 + (is_whole ? f->model.answer_cpu : (last - first + 1) * f->model.save_cpu);
        for (int row = first; row <= last; row++)
            sum += row_of(f, field, row);
    }
    return sum;
}

static double task_memory(const fixture *f, const lf_plan_task *t)
{
    const bool is_whole = t->rows[1] < t->rows[0];
    return f->model.base + (is_whole ? ROWS * f->model.row + f->model.answer
                                     : (t->rows[1] - t->rows[0] + 1) * f->model.row);
}

static void assert_costs(const fixture *f, const lf_plan_division *d)
{
    for (int i = 0; i < d->n_tasks; i++) {
        assert_near(d->tasks[i].cost.cpu_seconds, task_seconds(f, &d->tasks[i]), 1e-9);
        assert_near(d->tasks[i].cost.memory, task_memory(f, &d->tasks[i]), 1e-9);
    }
}

static void short_light_fields_share_a_task(void **state)
{
    const fixture *f = *state;
    lf_plan_division d = divide(f, 60, 0);
    assert_complete(&d);
    assert_costs(f, &d);
    assert_true(d.n_tasks > 1 && d.n_tasks < FIELDS);
    assert_int_equal(d.n_finishes, 0);
    for (int i = 0; i < d.n_tasks; i++)
        assert_true(d.tasks[i].cost.cpu_seconds <= 60);
    for (int i = 0; i + 1 < d.n_tasks; i++) { /* one more would be too many */
        lf_plan_task more = d.tasks[i];
        more.fields[1]++;
        assert_true(task_seconds(f, &more) > 60);
    }
    lf_plan_division_finish(&d);
}

static void no_minutes_is_a_light_field_each(void **state)
{
    const fixture *f = *state;
    lf_plan_division d = divide(f, 0, 0);
    assert_complete(&d);
    assert_int_equal(d.n_tasks, FIELDS);
    lf_plan_division_finish(&d);
}

static void long_light_fields_are_bands_of_like_cost(void **state)
{
    const fixture *f = *state;
    lf_plan_division d = divide(f, 8, 0);
    assert_complete(&d);
    assert_costs(f, &d);
    assert_int_equal(d.n_finishes, FIELDS);
    for (int i = 0; i < d.n_finishes; i++) {
        const lf_plan_finish *finish = &d.finishes[i];
        const lf_plan_task *first = &d.tasks[finish->tasks[0]], *last = &d.tasks[finish->tasks[1]];
        assert_int_equal(finish->fields[0], i);
        assert_int_equal(first->fields[0], i);
        assert_int_equal(last->fields[1], i);
        assert_int_equal(first->rows[0], 0);
        assert_int_equal(last->rows[1], ROWS - 1);
        assert_true(finish->tasks[1] > finish->tasks[0]);
        assert_near(finish->cost.cpu_seconds, 2 + 1 + ROWS * 0.01 + 3, 1e-9);
        assert_near(finish->cost.memory, 100 + ROWS * 10 + 200, 1e-9);
    }
    for (int i = 0; i < d.n_tasks; i++) /* half a row more, and the save */
        assert_true(d.tasks[i].cost.cpu_seconds <= 8 + 0.5 + ROWS * 0.01);
    const lf_plan_task *edge = &d.tasks[d.finishes[FIELDS - 1].tasks[0]], *next = edge + 1;
    assert_true(edge->rows[1] - edge->rows[0] > next->rows[1] - next->rows[0]);
    lf_plan_division_finish(&d);
}

static void bands_last_as_long_as_beginning_does(void **state)
{
    const fixture *f = *state;
    lf_plan_division d = divide(f, 0.001, 0);
    assert_complete(&d);
    for (int i = 0; i < d.n_tasks; i++)
        assert_true(d.tasks[i].cost.cpu_seconds > 5);
    lf_plan_division_finish(&d);
}

static void memory_limits_bands(void **state)
{
    const fixture *f = *state;
    lf_plan_division d = divide(f, 60, 170);
    assert_complete(&d);
    assert_costs(f, &d);
    for (int i = 0; i < d.n_tasks; i++)
        assert_true(d.tasks[i].cost.memory <= 170);
    lf_plan_division_finish(&d);
}

/* One row needs 110; more and more tasks would not help. */
static void memory_that_cannot_be_met_makes_few_tasks(void **state)
{
    fixture *f = *state;
    assert_near(lf_plan_least_memory(&f->job, &f->model), 110, 1e-9);
    lf_plan_division d = divide(f, 1e6, 109);
    assert_int_equal(d.n_finishes, FIELDS);
    assert_true(d.n_tasks <= 16 * FIELDS);
    for (int i = 0; i < d.n_tasks; i++)
        assert_in_range(d.tasks[i].rows[1] - d.tasks[i].rows[0], 0, 2);
    assert_complete(&d);
    lf_plan_division_finish(&d);
    d = divide(f, 1e6, 110); /* can be met: a row each */
    assert_complete(&d);
    assert_int_equal(d.n_tasks, ROWS * FIELDS);
    lf_plan_division_finish(&d);
    /* light fields that cannot be divided: as many in a task as the time allows */
    f->job.can_band = false;
    assert_near(lf_plan_least_memory(&f->job, &f->model), 100 + ROWS * 10 + 200, 1e-9);
    d = divide(f, 1e6, 109);
    assert_int_equal(d.n_tasks, 1);
    lf_plan_division_finish(&d);
    f->job.is_joined = true; /* states only */
    assert_near(lf_plan_least_memory(&f->job, &f->model), 100 + ROWS * 10, 1e-9);
}

static void memory_divides_without_times(void **state)
{
    fixture *f = *state;
    f->model.samples[0].row_cpu = f->model.samples[1].row_cpu = NULL;
    lf_plan_division d = divide(f, 60, 100 + 13 * 10);
    assert_complete(&d);
    for (int i = 0; i < d.n_tasks; i++) {
        assert_true(d.tasks[i].cost.memory <= 100 + 13 * 10);
        assert_true(d.tasks[i].cost.cpu_seconds < 0);
        assert_int_equal(d.tasks[i].rows[1] - d.tasks[i].rows[0] + 1, 10);
    }
    lf_plan_division_finish(&d);
    d = divide(f, 60, 0);
    assert_int_equal(d.n_tasks, FIELDS);
    lf_plan_division_finish(&d);
}

static void what_cannot_be_in_bands_is_whole(void **state)
{
    fixture *f = *state;
    f->job.can_band = false;
    lf_plan_division d = divide(f, 8, 170);
    assert_complete(&d);
    assert_int_equal(d.n_tasks, FIELDS);
    assert_int_equal(d.n_finishes, 0);
    lf_plan_division_finish(&d);
    f->job.is_joined = f->job.is_whole = true;
    d = divide(f, 8, 170);
    assert_int_equal(d.n_tasks, 1);
    assert_true(d.tasks[0].fields[1] < d.tasks[0].fields[0]);
    lf_plan_division_finish(&d);
}

/* Light fields that become one file: states, and one finish for all; or one task. */
static void what_is_joined_keeps_states(void **state)
{
    fixture *f = *state;
    f->job.is_joined = true;
    lf_plan_division d = divide(f, 60, 0);
    assert_complete(&d);
    assert_costs(f, &d);
    assert_int_equal(d.n_finishes, 1);
    assert_int_equal(d.finishes[0].tasks[0], 0);
    assert_int_equal(d.finishes[0].tasks[1], d.n_tasks - 1);
    assert_true(d.finishes[0].fields[1] < d.finishes[0].fields[0]);
    assert_near(d.finishes[0].cost.memory, 900, 1e-9);
    assert_near(d.finishes[0].cost.cpu_seconds, 2 + FIELDS * (0.5 + ROWS * 0.01), 1e-9);
    for (int i = 0; i < d.n_tasks; i++)
        assert_true(d.tasks[i].rows[0] == 0 && d.tasks[i].rows[1] == ROWS - 1);
    lf_plan_division_finish(&d);
    d = divide(f, 8, 0);
    assert_complete(&d);
    assert_int_equal(d.n_finishes, 1);
    lf_plan_division_finish(&d);
    d = divide(f, 1000, 0);
    assert_int_equal(d.n_tasks, 1);
    assert_int_equal(d.n_finishes, 0);
    assert_near(d.tasks[0].cost.cpu_seconds, 2 + FIELDS * (1 + 0.5 + 15), 0.2);
    lf_plan_division_finish(&d);
}

/* Frames of a video: files that a finish joins. */
static void frames_are_joined(void **state)
{
    fixture *f = *state;
    f->job.joins_files = true;
    f->job.can_band = false;
    lf_plan_division d = divide(f, 60, 0);
    assert_complete(&d);
    assert_int_equal(d.n_finishes, 1);
    assert_near(d.finishes[0].cost.cpu_seconds, 2 + FIELDS * 0.5, 1e-9);
    for (int i = 0; i < d.n_tasks; i++)
        assert_true(d.tasks[i].rows[1] < d.tasks[i].rows[0]);
    lf_plan_division_finish(&d);
}

/* Frames that share parts of their shutters stay together, and cost less. */
/* A closed job ends with a finish of everything. All of its light fields are in bands, or none. */
static void a_closed_job_has_a_last_finish(void **state)
{
    fixture *f = *state;
    f->job.is_closed = true;
    f->model.close = (lf_plan_cost){7, 4000};
    for (int bands = 0; bands < 2; bands++) {
        /* light fields cost 16 to 26 seconds: the later ones alone exceed the limit of bands */
        lf_plan_division d = divide(f, bands ? 21 : 60, 0);
        assert_complete(&d);
        int n_bands = 0;
        for (int i = 0; i < d.n_tasks; i++)
            n_bands += d.tasks[i].rows[0] <= d.tasks[i].rows[1];
        assert_int_equal(n_bands, bands ? d.n_tasks : 0);
        assert_int_equal(d.n_finishes, bands ? FIELDS + 1 : 1);
        for (int i = 0; i < d.n_finishes; i++)
            assert_int_equal(d.finishes[i].closes, i == d.n_finishes - 1);
        const lf_plan_finish *last = &d.finishes[d.n_finishes - 1];
        assert_true(last->fields[1] < last->fields[0]);
        assert_int_equal(last->tasks[0], 0);
        assert_int_equal(last->tasks[1], d.n_tasks - 1);
        assert_near(last->cost.cpu_seconds, 2 + 7, 1e-9);
        assert_near(last->cost.memory, 100 + 4000, 1e-9);
        lf_plan_division_finish(&d);
    }
    lf_plan_division d = divide(f, 1000, 0);
    assert_int_equal(d.n_tasks, 1);
    assert_int_equal(d.n_finishes, 0);
    assert_true(d.tasks[0].fields[1] < d.tasks[0].fields[0]);
    assert_near(d.tasks[0].cost.memory, 4100, 1e-9);
    lf_plan_division_finish(&d);
}

static void neighbours_share(void **state)
{
    fixture *f = *state;
    f->job.group = 3;
    f->job.again = 0.5;
    f->job.can_band = false;
    lf_plan_division d = divide(f, 8, 0);
    assert_complete(&d);
    assert_int_equal(d.n_tasks, 3);
    double first = 2 + 3 * (1 + 3);
    for (int row = 0; row < ROWS; row++)
        first += row_of(f, 0, row) + 0.5 * row_of(f, 1, row) + 0.5 * row_of(f, 2, row);
    assert_near(d.tasks[0].cost.cpu_seconds, first, 1e-9);
    lf_plan_division_finish(&d);
}

/* More of a limit is never more tasks, and the same work is never less time. */
static void limits_are_monotonic(void **state)
{
    const fixture *f = *state;
    int tasks = INT_MAX;
    for (double seconds = 3; seconds < 300; seconds *= 1.3) {
        lf_plan_division d = divide(f, seconds, 0);
        assert_true(d.n_tasks <= tasks);
        tasks = d.n_tasks;
        lf_plan_division_finish(&d);
    }
    tasks = INT_MAX;
    for (double memory = 110; memory < 1000; memory *= 1.3) {
        lf_plan_division d = divide(f, 1000, memory);
        assert_true(d.n_tasks <= tasks);
        tasks = d.n_tasks;
        lf_plan_division_finish(&d);
    }
}

static void too_many_tasks_are_refused(void **state)
{
    fixture *f = *state;
    const lf_plan_limits limits = {0, 0};
    lf_plan_division d;
    lf_error err = {0};
    f->job.last = LF_PLAN_MOST_TASKS;
    assert_int_equal(lf_plan_divide(&f->job, &f->model, &limits, &d, &err), LF_E_ARG);
    assert_string_equal(err.where, "--task-minutes");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(short_light_fields_share_a_task, set_up),
        cmocka_unit_test_setup(no_minutes_is_a_light_field_each, set_up),
        cmocka_unit_test_setup(long_light_fields_are_bands_of_like_cost, set_up),
        cmocka_unit_test_setup(bands_last_as_long_as_beginning_does, set_up),
        cmocka_unit_test_setup(memory_limits_bands, set_up),
        cmocka_unit_test_setup(memory_that_cannot_be_met_makes_few_tasks, set_up),
        cmocka_unit_test_setup(memory_divides_without_times, set_up),
        cmocka_unit_test_setup(what_cannot_be_in_bands_is_whole, set_up),
        cmocka_unit_test_setup(what_is_joined_keeps_states, set_up),
        cmocka_unit_test_setup(frames_are_joined, set_up),
        cmocka_unit_test_setup(a_closed_job_has_a_last_finish, set_up),
        cmocka_unit_test_setup(neighbours_share, set_up),
        cmocka_unit_test_setup(limits_are_monotonic, set_up),
        cmocka_unit_test_setup(too_many_tasks_are_refused, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
