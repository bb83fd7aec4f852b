/* The nodes of a lattice: fits of N/W on features, over the cells around each. */
#include "render/reconstruct/solve.h"

#include <string.h>

#include "render/reconstruct/kernel.h"

/* The 27 cells around one: where they are from it, and what they count. */
typedef struct lf_around {
    int du, dv, dz;
    float weight, shift[LF_FEATURES]; /* to the middle between them */
} lf_around;

static void find_around(float side, lf_around out[27])
{
    for (int n = 0; n < 27; n++) {
        int du = n % 3 - 1, dz = n / 3 % 3 - 1, dv = n / 9 - 1;
        out[n] = (lf_around){
            du, dv, dz, (dv ? 0.5f : 1.0f) * (dz ? 0.5f : 1.0f) * (du ? 0.5f : 1.0f), {0}};
        out[n].shift[LF_PLACE] = (float)du * side;
        out[n].shift[LF_ROW] = (float)dv * side;
        out[n].shift[LF_DEPTH] = (float)dz * side;
    }
}

/* Tent-weighted sums of the cells around one, each half's by its own features, as seen from its
 * middle. */
static void gather(const lf_reconstruct_kernels *kernels, const lf_lattice *level, int number,
                   const lf_cell *cell, const lf_around around[27], lf_moments sum[2])
{
    memset(sum, 0, 2 * sizeof *sum);
    for (int n = 0; n < 27; n++) {
        const lf_around *a = &around[n];
        const int v = number + a->dv;
        if (v < 0 || v >= level->n_bands)
            continue;
        int i = lf_band_find(&level->bands[v], cell->u + a->du, cell->z + a->dz);
        for (int h = 0; h < 2 && i >= 0; h++)
            kernels->move(&sum[h], &level->bands[v].cells[i].half[h][h], a->weight, a->shift);
    }
}

/* Fits that wait until there are enough of them. */
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
    cell->filled[variant] = sum->w > 0.0f;
    if (!cell->filled[variant])
        return;
    fits->moments[fits->n] = *sum;
    fits->out[fits->n++] = &cell->node[variant];
    if (fits->n == LF_SOLVE_LANES)
        make(r, fits);
}

void lf_solve_band(lf_reconstruction *r, int level, int number)
{
    static const float here[LF_FEATURES];
    lf_band *band = &r->level[level].bands[number];
    lf_fits fits = {.n = 0};
    lf_around around[27];
    find_around((float)(1 << level), around);
    for (int i = 0; i < band->n; i++) {
        lf_cell *cell = &band->cells[i];
        lf_moments sum[LF_VARIANTS];
        gather(r->kernels, &r->level[level], number, cell, around, sum);
        sum[LF_BOTH] = sum[LF_HALF_A];
        r->kernels->move(&sum[LF_BOTH], &sum[LF_HALF_B], 1.0f, here);
        for (int v = 0; v < LF_VARIANTS; v++)
            fit(r, &sum[v], cell, v, &fits);
    }
    if (fits.n > 0)
        make(r, &fits);
}
