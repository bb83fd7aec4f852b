/* The nodes of a lattice: fits of N/W on features, over the cells around each. */
#include "render/reconstruct/solve.h"

#include <string.h>

#include "render/reconstruct/kernel.h"

/* A node of both halves with this many pivots uses half its own fit, half the level above. */
#define FEW_PIVOTS 1.0f

/* From the middles of the 27 cells around one to its own. */
typedef float lf_shifts[27][LF_FEATURES];

static void find_shifts(float side, lf_shifts out)
{
    memset(out, 0, sizeof(lf_shifts));
    for (int n = 0; n < 27; n++) {
        const lf_around a = lf_around_at(n);
        out[n][LF_PLACE] = (float)a.du * side;
        out[n][LF_ROW] = (float)a.dv * side;
        out[n][LF_DEPTH] = (float)a.dz * side;
    }
}

/* Tent-weighted sums of the neighbouring cells, each half's by its own features, relative to the
 * cell's middle. */
static void gather(const lf_reconstruct_kernels *kernels, const lf_lattice *level, int number,
                   const lf_cell *cell, lf_shifts shifts, lf_moments sum[2])
{
    memset(sum, 0, 2 * sizeof *sum);
    for (int n = 0; n < 27; n++) {
        float weight;
        const lf_cell_sums *other = lf_sums_around(level, number, cell, n, &weight);
        for (int h = 0; h < 2 && other; h++)
            kernels->move(&sum[h], &other->half[h][h], weight, shifts[n]);
    }
}

/* Fits that wait until a group is complete. */
typedef struct lf_fits {
    lf_moments moments[LF_SOLVE_LANES];
    lf_plane (*out[LF_SOLVE_LANES])[3];
    int n;
} lf_fits;

static void make(const lf_reconstruction *r, lf_fits *fits)
{
    static const lf_moments none = {.w = 0.0f};
    const lf_moments *m[LF_SOLVE_LANES];
    lf_plane nowhere[3];
    for (int l = 0; l < LF_SOLVE_LANES; l++) {
        m[l] = l < fits->n ? &fits->moments[l] : &none;
        fits->out[l] = l < fits->n ? fits->out[l] : &nowhere;
    }
    r->kernels->solve(m, (double)r->cell_depth, fits->out);
    fits->n = 0;
}

static void fit(const lf_reconstruction *r, const lf_moments *sum, lf_cell *cell, int variant,
                lf_fits *fits)
{
    const float few = variant == LF_BOTH ? FEW_PIVOTS : 0.5f * FEW_PIVOTS;
    cell->filled[variant] = sum->w > 0.0f;
    cell->own[variant] = cell->filled[variant] ? sum->w / (sum->w + few) : 0.0f;
    if (!cell->filled[variant])
        return;
    fits->moments[fits->n] = *sum;
    fits->out[fits->n++] = &cell->node[variant];
    if (fits->n == LF_SOLVE_LANES)
        make(r, fits);
}

/* Keeps what is needed of the sums after the fit. */
static void note_seen(const lf_cell_sums *sums, lf_cell *cell)
{
    const lf_moments *a = &sums->half[0][0], *b = &sums->half[1][1];
    cell->seen[0] = a->w + b->w;
    for (int c = 0; c < 3; c++)
        cell->seen[1 + c] = a->n[c] + b->n[c];
}

void lf_solve_band(lf_reconstruction *r, int level, int number)
{
    static const float here[LF_FEATURES];
    lf_band *band = &r->level[level].bands[number];
    lf_fits fits = {.n = 0};
    lf_shifts shifts;
    find_shifts((float)(1 << level), shifts);
    for (int i = 0; i < band->n; i++) {
        lf_cell *cell = &band->cells[i];
        lf_moments sum[LF_VARIANTS];
        note_seen(&band->sums[i], cell);
        gather(r->kernels, &r->level[level], number, cell, shifts, sum);
        sum[LF_BOTH] = sum[LF_HALF_A];
        r->kernels->move(&sum[LF_BOTH], &sum[LF_HALF_B], 1.0f, here);
        for (int v = 0; v < LF_VARIANTS; v++)
            fit(r, &sum[v], cell, v, &fits);
    }
    if (fits.n > 0)
        make(r, &fits);
}
