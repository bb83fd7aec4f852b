#include "daemon/engine/schedule.h"

#include <math.h>

/* Fewest rows per batch, so that no worker idles. The limit is lower for a complete picture,
 * because only slow machines, which have few workers, need batches of few rows there. */
#define MIN_ROWS 8
#define MIN_ROWS_COMPLETE 4
#define FIRST_COMPLETE_SWEEP 2
#define MAX_BATCHES 128
/* The first sweep is needed as a whole and is divided into at most this many batches. */
#define MAX_COARSE_BATCHES 4
/* Passes of the second sweep. While more than about a twentieth of the scattering view pixels are
 * holes, another shared path fills them at lower cost than native samples. A fit has no holes and
 * needs every row soon. */
#define COMPLETE_PASSES 4
#define FITTED_PASSES 2

static int subsets_of(const lf_schedule *schedule)
{
    if (schedule->sweep == 0)
        return 1;
    int doubling = (schedule->sweep - 1) / 2;
    int first = schedule->fitted ? FITTED_PASSES : COMPLETE_PASSES;
    int subsets = first << (doubling < 16 ? doubling : 16);
    return subsets < schedule->n_views ? subsets : schedule->n_views;
}

static int sweep_rows(const lf_schedule *schedule)
{
    int rows = schedule->height;
    return schedule->sweep == 0 ? (rows - LF_COARSE_ROW + LF_COARSE_STEP - 1) / LF_COARSE_STEP
                                : rows;
}

void lf_schedule_start(lf_schedule *schedule, int height, int n_views, bool fitted,
                       double passes_done)
{
    double row_seconds = schedule->row_seconds;
    *schedule = (lf_schedule){
        .height = height, .n_views = n_views, .fitted = fitted, .row_seconds = row_seconds};
    for (double sum = 0; sum < passes_done && schedule->sweep < 64; schedule->sweep++)
        sum += (double)subsets_of(schedule) * sweep_rows(schedule) / height;
}

/* The number of batches that makes each last about target_seconds. */
static int batches_for(const lf_schedule *schedule, double target_seconds)
{
    int most = schedule->sweep == 0 ? MAX_COARSE_BATCHES : MAX_BATCHES;
    int least = schedule->sweep < FIRST_COMPLETE_SWEEP ? MIN_ROWS : MIN_ROWS_COMPLETE;
    double sweep_seconds = schedule->row_seconds * sweep_rows(schedule) * subsets_of(schedule);
    int n = 1;
    /* the time per row is unknown after a restored accumulation */
    if (schedule->sweep > 0 && !(schedule->row_seconds > 0))
        sweep_seconds = (double)INFINITY;
    while (n < most && sweep_seconds > target_seconds * n &&
           sweep_rows(schedule) / (n * 2) >= least)
        n *= 2;
    return n;
}

static int reversed_bits(int value, int size)
{
    int reversed = 0;
    for (int bit = 1; bit < size; bit *= 2)
        reversed = reversed * 2 + (value & bit ? 1 : 0);
    return reversed;
}

/* Of n batches of all rows, the rows farthest from the first sweep's rows come first, and those
 * rows themselves last. */
static int first_row(int batch, int n)
{
    static const int place[LF_COARSE_STEP] = {0, 1, 3, LF_COARSE_ROW};
    if (n < LF_COARSE_STEP)
        return reversed_bits(batch, n);
    int batches = n / LF_COARSE_STEP;
    return place[batch / batches] + LF_COARSE_STEP * reversed_bits(batch % batches, batches);
}

lf_batch lf_schedule_next(lf_schedule *schedule, double target_seconds)
{
    if (schedule->batch == 0)
        schedule->n_batches = batches_for(schedule, target_seconds);
    int n = schedule->n_batches;
    lf_batch batch = {.step = n, .subsets = subsets_of(schedule), .coarse = schedule->sweep == 0};
    if (batch.coarse) {
        batch.step = n * LF_COARSE_STEP;
        batch.first = LF_COARSE_ROW + LF_COARSE_STEP * reversed_bits(schedule->batch, n);
    } else {
        batch.first = first_row(schedule->batch, n);
    }
    batch.n_rows = batch.first < schedule->height
                       ? (schedule->height - batch.first + batch.step - 1) / batch.step
                       : 0;
    return batch;
}

bool lf_schedule_done(lf_schedule *schedule, const lf_batch *batch, double seconds)
{
    if (batch->n_rows > 0) {
        double measured = seconds / ((double)batch->n_rows * batch->subsets);
        schedule->row_seconds =
            schedule->row_seconds > 0 ? 0.5 * (schedule->row_seconds + measured) : measured;
    }
    schedule->batch++;
    if (schedule->batch < schedule->n_batches)
        return false;
    schedule->batch = 0;
    schedule->sweep++;
    return true;
}

bool lf_schedule_covers(const lf_schedule *schedule)
{
    return schedule->sweep > 0;
}

bool lf_schedule_has_halves(const lf_schedule *schedule)
{
    return schedule->sweep >= 3;
}

double lf_schedule_seconds_left(const lf_schedule *schedule, double passes, double error,
                                double error_passes, double target)
{
    const double pass_seconds = schedule->row_seconds * schedule->height;
    const double left = fmax(0, error_passes * (error / target) - passes) * pass_seconds;
    const bool known = error >= 0 && target > 0 && pass_seconds > 0 && isfinite(left);
    return known ? left : -1;
}
