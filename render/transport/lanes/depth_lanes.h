/* The algorithm of depth_kernel.h over the lanes of the including file (depth_*.c). A lane is a
 * ray. It either integrates a cell or enters the next brick (and leaves an empty one at once). The
 * operation that most lanes wait for is done for all of them. A lane whose ray has ended takes the
 * next ray.
 *
 * Positions are relative to the current brick, between 0 and 8, and distances start from 0 in each
 * brick. So the entry into a brick is rounded to 5e-7 of a voxel, whatever the size of the grid and
 * the distance of the eye.
 *
 * Interpolated, a cell's values are a + b s + c s^2 + d s^3 along the ray, with s from the middle
 * of its part of length h. Their integral is h (a + c h^2/12), and c follows from the mixed
 * derivatives. */
#ifndef LF_RENDER_DEPTH_LANES_H
#define LF_RENDER_DEPTH_LANES_H

#include "render/transport/lanes/depth_kernel.h"
#include "render/transport/lanes/lanes.h"

/* Number of lanes in a cell that is enough to process cells next. */
enum { ENOUGH = 5 * LF_WIDTH / 8 };

typedef struct walk {
    lanes p[3], d[3], inverse[3]; /* in the brick: p + t d */
    /* whole numbers: cell, face through which it is left; up: 1, or -1 for down */
    lanes cell[3], face[3], up[3];
    lanes t, end;
    lanes in_brick, sum;
    lanes_int brick[3], first, job; /* first: index of the brick's first value */
    mask in_cell, waits;            /* neither: the lane has no ray */
} walk;

/* --------------------------------------------------------------------------------- the cells -- */

typedef struct corners {
    lanes v[8]; /* [z][y][x] */
} corners;

#if defined(LF_LANES_AVX2)
/* Two neighbours along x of four lanes each; fewer loads than gathers need. */
LF_INLINE __m128 two(const float *a, const float *b)
{
    const __m128 low = _mm_castsi128_ps(_mm_loadl_epi64((const __m128i *)(const void *)a));
    return _mm_loadh_pi(low, (const __m64 *)(const void *)b);
}
LF_INLINE void load_row(const float *v, const int32_t at[LF_WIDTH], lanes *a, lanes *b)
{
    const __m256 x = _mm256_setr_m128(two(v + at[0], v + at[1]), two(v + at[4], v + at[5])),
                 y = _mm256_setr_m128(two(v + at[2], v + at[3]), two(v + at[6], v + at[7]));
    *a = (lanes)_mm256_shuffle_ps(x, y, 0x88);
    *b = (lanes)_mm256_shuffle_ps(x, y, 0xdd);
}
#else
LF_INLINE void load_row(const float *v, const int32_t at[LF_WIDTH], lanes *a, lanes *b)
{
    lanes x = {0}, y = {0};
    for (int k = 0; k < LF_WIDTH; k++) {
        x[k] = v[at[k]];
        y[k] = v[at[k] + 1];
    }
    *a = x;
    *b = y;
}
#endif

/* lf_short_value */
LF_INLINE void load_short_row(const uint16_t *v, const int32_t at[LF_WIDTH], float scale, lanes *a,
                              lanes *b)
{
    lanes_int pair = {0};
    for (int k = 0; k < LF_WIDTH; k++) {
        int32_t word;
        memcpy(&word, v + at[k], sizeof word);
        pair[k] = word;
    }
    *a = (lanes)((pair & 0xffff) << 13) * scale;
    *b = (lanes)((lanes_int)((lanes_bits)pair >> 16) << 13) * scale;
}

LF_INLINE void load_corners(const lf_grid *grid, bool is_short, const int32_t at[LF_WIDTH],
                            corners *c)
{
    for (int i = 0; i < 4; i++) {
        const int row = ((i >> 1) * LF_BRICK_VALUES + (i & 1)) * LF_BRICK_VALUES;
        if (is_short)
            load_short_row(grid->shorts + row, at, grid->short_scale, &c->v[2 * i],
                           &c->v[2 * i + 1]);
        else
            load_row(grid->values + row, at, &c->v[2 * i], &c->v[2 * i + 1]);
    }
}

/* The mean of a cell's values along d, over `length` around the middle f. */
LF_INLINE lanes mean_of(const corners *c, const lanes f[3], const lanes d[3], lanes length)
{
    const lanes *v = c->v;
    const lanes e00 = v[1] - v[0], e10 = v[3] - v[2], e01 = v[5] - v[4], e11 = v[7] - v[6];
    const lanes a00 = v[0] + f[0] * e00, a01 = v[4] + f[0] * e01;
    const lanes g0 = v[2] + f[0] * e10 - a00, g1 = v[6] + f[0] * e11 - a01;
    const lanes low = a00 + f[1] * g0, high = a01 + f[1] * g1;
    const lanes side = e10 - e00, all_three = e11 - e01 - side;
    const lanes xy = side + f[2] * all_three, xz = e01 - e00 + f[1] * all_three, yz = g1 - g0;
    const lanes second = d[0] * (xy * d[1] + xz * d[2]) + yz * d[1] * d[2];
    return low + f[2] * (high - low) + length * length * (1.0f / 12.0f) * second;
}

LF_INLINE lanes voxels(const lf_grid *grid, bool is_short, const int32_t at[LF_WIDTH])
{
    lanes out = {0};
    for (int k = 0; k < LF_WIDTH; k++)
        out[k] =
            is_short ? lf_short_value(grid->shorts[at[k]], grid->short_scale) : grid->values[at[k]];
    return out;
}

LF_INLINE void take_cell(walk *w, const lf_grid *grid, bool nearest, bool is_short)
{
    const mask m = w->in_cell;
    const lanes zero = all(0.0f);
    lanes next[3], f[3], value, outside = zero;
    int32_t at[LF_WIDTH];
    for (int i = 0; i < 3; i++)
        next[i] = (w->face[i] - w->p[i]) * w->inverse[i];
    const lanes to = least(most(least(least(next[0], next[1]), next[2]), w->t), w->end),
                length = to - w->t, middle = w->t + 0.5f * length;
    lanes_int place = to_int(
        (w->cell[2] * (float)LF_BRICK_VALUES + w->cell[1]) * (float)LF_BRICK_VALUES + w->cell[0]);
    place = choose_int(m, w->first + place, all_int(0));
    memcpy(at, &place, sizeof at);
    if (nearest) {
        value = voxels(grid, is_short, at);
    } else {
        corners c;
        load_corners(grid, is_short, at, &c);
        for (int i = 0; i < 3; i++)
            f[i] = w->p[i] - w->cell[i] + middle * w->d[i];
        value = mean_of(&c, f, w->d, length);
    }
    w->in_brick = w->in_brick + choose(m, length * value, zero);
    for (int i = 0; i < 3; i++) {
        const lanes step = choose(both(m, is_at_most(next[i], to)), w->up[i], zero);
        w->cell[i] = w->cell[i] + step;
        w->face[i] = w->face[i] + step;
        outside = most(outside, magnitude(w->cell[i] - 0.5f * (LF_BRICK - 1)));
    }
    w->t = choose(m, to, w->t);
    const mask left =
        both(m, either(is_less(all(0.5f * LF_BRICK), outside), is_at_most(w->end, to)));
    w->in_cell = without(m, left);
    w->waits = either(w->waits, left);
}

/* -------------------------------------------------------------------------------- the bricks -- */

/* The cell that contains a position. */
LF_INLINE void find_cell(walk *w, int i, mask m)
{
    const lanes last = all((float)(LF_BRICK - 1)), cell = least(to_float(to_int(w->p[i])), last);
    w->cell[i] = choose(m, cell, w->cell[i]);
    w->face[i] = w->cell[i] + choose(is_less(all(0.0f), w->up[i]), all(1.0f), all(0.0f));
}

/* Leaves the brick for the neighbour; returns the rays that have ended. */
LF_INLINE mask leave(walk *w, const lf_grid *grid, mask m, float enough)
{
    const lanes zero = all(0.0f), side = all((float)LF_BRICK);
    mask ended;
    w->sum = w->sum + choose(m, w->in_brick, zero);
    w->end = choose(m, w->end - w->t, w->end);
    ended = either(is_at_most(w->end, zero), is_less(all(enough), w->sum));
    for (int i = 0; i < 3; i++) {
        const mask above = both(m, is_less(all(LF_BRICK - 0.5f), w->cell[i])),
                   below = both(m, is_less(w->cell[i], all(-0.5f)));
        lanes p = least(most(w->p[i] + w->t * w->d[i], zero), side);
        p = choose(above, zero, choose(below, side, p));
        w->p[i] = choose(m, p, w->p[i]);
        w->brick[i] = w->brick[i] + choose_int(above, all_int(1), all_int(0)) -
                      choose_int(below, all_int(1), all_int(0));
        find_cell(w, i, m);
        const lanes b = to_float(w->brick[i]);
        ended = either(ended, either(is_less(b, zero), is_at_most(all((float)grid->bricks[i]), b)));
    }
    w->in_brick = choose(m, zero, w->in_brick);
    w->t = choose(m, zero, w->t);
    return both(m, ended);
}

/* Stores the results of ended rays and starts others in their lanes. */
LF_INLINE void fetch(walk *w, lf_depth_jobs *jobs, mask ended, int *next)
{
    const lanes zero = all(0.0f), one = all(1.0f), tiny = all(1e-20f);
    lanes_int job = w->job;
    unsigned begun = 0;
    for (unsigned b = bits_of(ended); b; b &= b - 1) {
        const int k = __builtin_ctz(b);
        if (job[k] >= 0)
            jobs->sum[job[k]] = w->sum[k];
        job[k] = *next < jobs->n ? *next : -1;
        begun |= (unsigned)(*next < jobs->n) << k;
        *next += *next < jobs->n;
    }
    const mask m = mask_of(begun);
    const lanes_int from = choose_int(m, job, all_int(0));
    w->job = job;
    w->waits = without(w->waits, without(ended, m));
    w->end = choose(m, gather(jobs->end, from), w->end);
    w->sum = choose(m, zero, w->sum);
    for (int i = 0; i < 3; i++) {
        lanes d = gather(jobs->d[i], from);
        d = choose(is_less(magnitude(d), tiny), tiny, d);
        w->d[i] = choose(m, d, w->d[i]);
        w->inverse[i] = choose(m, 1.0f / d, w->inverse[i]);
        w->up[i] = choose(m, choose(is_less(zero, d), one, -one), w->up[i]);
        w->p[i] = choose(m, gather(jobs->p[i], from), w->p[i]);
        w->brick[i] = choose_int(m, gather_int(jobs->brick[i], from), w->brick[i]);
        find_cell(w, i, m);
    }
}

/* Enters the cells of a brick, or crosses an empty one at once. */
LF_INLINE void enter(walk *w, const lf_grid *grid)
{
    const mask m = w->waits;
    const lanes zero = all(0.0f);
    const lanes_int at =
        (w->brick[2] * grid->bricks[1] + w->brick[1]) * grid->bricks[0] + w->brick[0];
    const lanes_int number = gather_int(grid->index, choose_int(m, at, all_int(0)));
    const mask full = both(m, is_less(zero, to_float(number))), empty = without(m, full);
    lanes across[3];
    w->first = choose_int(full, number * LF_BRICK_STRIDE, w->first);
    w->in_cell = either(w->in_cell, full);
    w->waits = empty;
    if (!bits_of(empty))
        return;
    for (int i = 0; i < 3; i++)
        across[i] =
            (choose(is_less(zero, w->up[i]), all((float)LF_BRICK), zero) - w->p[i]) * w->inverse[i];
    const lanes to = least(most(least(least(across[0], across[1]), across[2]), zero), w->end);
    w->t = choose(empty, to, w->t);
    for (int i = 0; i < 3; i++) {
        const lanes beyond = choose(is_less(zero, w->up[i]), all((float)LF_BRICK), -all(1.0f));
        w->cell[i] = choose(both(empty, is_at_most(across[i], to)), beyond, w->cell[i]);
    }
}

/* --------------------------------------------------------------------------------------- all -- */

LF_INLINE int64_t trace_with(const lf_grid *grid, bool nearest, bool is_short, float enough,
                             lf_depth_jobs *jobs)
{
    walk w = {.waits = mask_of((1u << LF_WIDTH) - 1), .job = all_int(-1)};
    int64_t lookups = 0;
    int next = 0;
    fetch(&w, jobs, w.waits, &next);
    for (;;) {
        const unsigned cells = bits_of(w.in_cell), waiting = bits_of(w.waits);
        if (!(cells | waiting))
            return lookups;
        if (!waiting || __builtin_popcount(cells) >= ENOUGH) {
            lookups += __builtin_popcount(cells);
            take_cell(&w, grid, nearest, is_short);
            continue;
        }
        const mask ended = leave(&w, grid, w.waits, enough);
        if (bits_of(ended))
            fetch(&w, jobs, ended, &next);
        enter(&w, grid);
    }
}

static int64_t trace(const lf_grid *grid, bool nearest, float enough, lf_depth_jobs *jobs)
{
    if (nearest)
        return trace_with(grid, true, !grid->values, enough, jobs);
    return grid->values ? trace_with(grid, false, false, enough, jobs)
                        : trace_with(grid, false, true, enough, jobs);
}

#endif
