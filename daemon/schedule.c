#include "daemon/schedule.h"

/* Rows a batch has at the least, so that no worker idles. */
#define MIN_ROWS 8
#define MAX_BATCHS 64
#define FIRST_BATCHS 4
/* The first sweep is wanted whole: it is not cut finer than this. */
#define MOST_FIRST_BATCHS 16
/* The residue that the first batchs take: a row that is at most two away from every other of its group of four. */
#define FIRST_ROW 2

static int subsets_of(const lf_schedule *schedule)
{
    int doubling = schedule->sweep / 2;
    int subsets = doubling < 16 ? 1 << doubling : 1 << 16;
    return subsets < schedule->n_views ? subsets : schedule->n_views;
}

void lf_schedule_start(lf_schedule *schedule, int height, int n_views, double passes_done)
{
    double row_seconds = schedule->row_seconds;
    *schedule = (lf_schedule){.height = height, .n_views = n_views, .row_seconds = row_seconds};
    for (double sum = 0; sum < passes_done && schedule->sweep < 64; schedule->sweep++) {
        sum += subsets_of(schedule);
    }
}

static int batchs_for(const lf_schedule *schedule, double target_seconds)
{
    int fewest = schedule->sweep == 0 ? FIRST_BATCHS : 1;
    int most = schedule->sweep == 0 ? MOST_FIRST_BATCHS : MAX_BATCHS;
    double sweep_seconds = schedule->row_seconds * schedule->height * subsets_of(schedule);
    int n = fewest;
    while (n < most && sweep_seconds > target_seconds * n && schedule->height / (n * 2) >= MIN_ROWS) {
        n *= 2;
    }
    return n;
}

static int reversed_bits(int value, int size)
{
    int reversed = 0;
    for (int bit = 1; bit < size; bit *= 2) {
        reversed = reversed * 2 + (value & bit ? 1 : 0);
    }
    return reversed;
}

lf_batch lf_schedule_next(lf_schedule *schedule, double target_seconds)
{
    if (schedule->batch == 0) {
        schedule->n_batchs = batchs_for(schedule, target_seconds);
    }
    lf_batch batch = {.step = schedule->n_batchs, .subsets = subsets_of(schedule)};
    batch.first = (reversed_bits(schedule->batch, schedule->n_batchs) + FIRST_ROW) % schedule->n_batchs;
    batch.n_rows = batch.first < schedule->height ? (schedule->height - batch.first + batch.step - 1) / batch.step : 0;
    return batch;
}

bool lf_schedule_done(lf_schedule *schedule, const lf_batch *batch, double seconds)
{
    if (batch->n_rows > 0) {
        double measured = seconds / ((double)batch->n_rows * batch->subsets);
        schedule->row_seconds = schedule->row_seconds > 0 ? 0.5 * (schedule->row_seconds + measured) : measured;
    }
    schedule->batch++;
    if (schedule->batch < schedule->n_batchs) {
        return false;
    }
    schedule->batch = 0;
    schedule->sweep++;
    return true;
}

bool lf_schedule_covers(const lf_schedule *schedule)
{
    return schedule->sweep > 0 || (schedule->batch > 0 && schedule->batch * FIRST_BATCHS >= schedule->n_batchs);
}
