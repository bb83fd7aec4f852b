/* The algorithm of lf_cell_jobs (depth_kernel.h) over the lanes of the including file: the steps of
 * cell_walk.h. A lane is a ray. All lanes take STEPS steps without a branch; steps after a ray's
 * end have no effect. Then ended rays leave their lanes to the next rays. */
#ifndef LF_RENDER_CELL_LANES_H
#define LF_RENDER_CELL_LANES_H

#include "render/transport/lanes/depth_kernel.h"
#include "render/transport/lanes/lanes.h"

enum { STEPS = 8 };

typedef struct cell_walk {
    lanes t, end, goal, sum, next[3], stride[3];
    lanes_int cell[3], step[3], left[3], job; /* job -1: the lane has no ray */
    mask ended;
    /* where it ended: the last cell before the end, and the value there if the goal was reached */
    lanes at, behind, sigma;
} cell_walk;

LF_INLINE void store_ray(const cell_walk *w, lf_cell_jobs *jobs, int k)
{
    const int job = w->job[k];
    const float sigma = w->sigma[k];
    const bool hit = sigma > 0.0f;
    jobs->at[job] = w->at[k] + (hit ? (jobs->goal[job] - w->behind[k]) / sigma : 0.0f);
    jobs->sum[job] = hit ? jobs->goal[job] : w->behind[k];
    jobs->sigma[job] = sigma;
}

/* Stores the results of ended rays and starts other rays in their lanes; false: none left. */
LF_INLINE bool next_rays(cell_walk *w, lf_cell_jobs *jobs, int *next)
{
    const lanes zero = all(0.0f);
    lanes_int job = w->job;
    unsigned begun = 0;
    for (unsigned b = bits_of(w->ended); b; b &= b - 1) {
        const int k = __builtin_ctz(b);
        if (job[k] >= 0)
            store_ray(w, jobs, k);
        job[k] = *next < jobs->n ? *next : -1;
        begun |= (unsigned)(*next < jobs->n) << k;
        *next += *next < jobs->n;
    }
    w->job = job;
    if (begun) {
        const mask m = mask_of(begun);
        const lanes_int from = choose_int(m, job, all_int(0));
        w->t = choose(m, zero, w->t);
        w->sum = choose(m, zero, w->sum);
        w->end = choose(m, gather(jobs->end, from), w->end);
        w->goal = choose(m, gather(jobs->goal, from), w->goal);
        for (int i = 0; i < 3; i++) {
            w->next[i] = choose(m, gather(jobs->next[i], from), w->next[i]);
            w->stride[i] = choose(m, gather(jobs->stride[i], from), w->stride[i]);
            w->cell[i] = choose_int(m, gather_int(jobs->cell[i], from), w->cell[i]);
            w->step[i] = choose_int(m, gather_int(jobs->step[i], from), w->step[i]);
            w->left[i] = choose_int(m, gather_int(jobs->left[i], from), w->left[i]);
        }
        w->ended = without(w->ended, m);
    }
    return bits_of(is_at_most(zero, to_float(job))) != 0;
}

/* The table, and the strides of cells in it. */
typedef struct cell_table {
    const uint16_t *values;
    int place[3], more[3];
} cell_table;

/* The values of these cells: lf_cells_at and lf_cell_value for every lane. */
LF_INLINE lanes value_of(const cell_table *table, const lanes_int cell[3])
{
    lanes_int at = all_int(0);
    for (int i = 0; i < 3; i++)
        at = at + cell[i] * table->place[i] + (cell[i] >> LF_CELL_TILE_BITS) * table->more[i];
    lanes_int value = {0};
    int32_t places[LF_WIDTH];
    memcpy(places, &at, sizeof places);
    for (int k = 0; k < LF_WIDTH; k++)
        value[k] = (int32_t)((uint32_t)table->values[places[k]] << 16);
    return (lanes)value;
}

/* As lf_cell_walk_next. Stepping does not wait for values: it notes where a ray ends. */
LF_INLINE void take_step(cell_walk *w, const cell_table *table)
{
    const lanes zero = all(0.0f), first = least(w->next[0], w->next[1]),
                face = least(first, w->next[2]), value = value_of(table, w->cell);
    const mask z = is_less(w->next[2], first), x = is_less(w->next[0], w->next[1]),
               axis[3] = {without(x, z), without(is_at_most(zero, zero), either(x, z)), z};
    const lanes_int left = choose_int(z, w->left[2], choose_int(x, w->left[0], w->left[1]));
    const mask last = either(is_at_most(w->end, face), is_at_most(to_float(left), zero));
    const lanes to = choose(last, w->end, most(face, w->t)), sum = w->sum + value * (to - w->t);
    const mask hit = both(is_less(w->sum, sum), is_at_most(w->goal, sum)),
               now = without(either(hit, last), w->ended);
    w->at = choose(now, choose(hit, w->t, to), w->at);
    w->behind = choose(now, choose(hit, w->sum, sum), w->behind);
    w->sigma = choose(now, choose(hit, value, zero), w->sigma);
    w->ended = either(w->ended, now);
    w->t = to;
    w->sum = sum;
    for (int i = 0; i < 3; i++) {
        const mask m = without(axis[i], last);
        w->cell[i] = w->cell[i] + choose_int(m, w->step[i], all_int(0));
        w->left[i] = w->left[i] - choose_int(m, all_int(1), all_int(0));
        w->next[i] = w->next[i] + choose(m, w->stride[i], zero);
    }
}

static void trace_cells(const int n[3], const uint16_t *values, lf_cell_jobs *jobs)
{
    cell_table table = {.values = values};
    cell_walk w = {.job = all_int(-1), .ended = mask_of((1u << LF_WIDTH) - 1)};
    int next = 0;
    lf_cells_strides(n, table.place, table.more);
    while (next_rays(&w, jobs, &next))
        for (int i = 0; i < STEPS; i++)
            take_step(&w, &table);
}

#endif
