#include "render/reconstruct/shrink.h"

#include <math.h>
#include <string.h>

#include "render/reconstruct/past.h"

/* N/W counts as noise until the halves' agreement exceeds this number of its standard deviations.
 */
#define RAW_DOUBT 2.0f
#define EPSILON 1e-2
/* A half represents at most this multiple of its own samples. */
#define MOST_STOOD_FOR 4.0
/* Minimum part of other cells in the decision about a share. */
#define LEAST_OTHERS 0.25f

/* ------------------------------------------------------------------------------------ planes -- */

static double dot(const lf_plane *a, const lf_plane *b)
{
    double s = (double)a->constant * (double)b->constant;
    for (int i = 0; i < LF_FEATURES; i++)
        s += (double)a->slope[i] * (double)b->slope[i];
    return s;
}

/* Sum of W f p: the moments' symmetric matrix applied to a plane. */
static lf_plane apply(const lf_moments *m, const lf_plane *p)
{
    lf_plane out;
    lf_by_feature sum, row, slope, products;
    memcpy(&row, m->wf, sizeof row);
    memcpy(&slope, p->slope, sizeof slope);
    products = row * slope;
    sum = row * p->constant;
    out.constant = m->w * p->constant;
    for (int i = 0; i < LF_FEATURES; i++) {
        out.constant += products[i];
        memcpy(&row, m->wff[i], sizeof row);
        sum += row * p->slope[i];
    }
    memcpy(out.slope, &sum, sizeof out.slope);
    return out;
}

/* Sum of N f. */
static lf_plane found(const lf_moments *m, int c)
{
    lf_plane out = {.constant = m->n[c]};
    memcpy(out.slope, m->nf[c], sizeof out.slope);
    return out;
}

static lf_plane minus(const lf_plane *a, const lf_plane *b)
{
    lf_plane out = {.constant = a->constant - b->constant};
    for (int i = 0; i < LF_FEATURES; i++)
        out.slope[i] = a->slope[i] - b->slope[i];
    return out;
}

static void add_scaled(lf_plane *to, const lf_plane *from, float scale)
{
    to->constant += scale * from->constant;
    for (int i = 0; i < LF_FEATURES; i++)
        to->slope[i] += scale * from->slope[i];
}

/* --------------------------------------------------------------------------- the level above -- */

/* The up to eight cells above that a cell lies between, and what each counts. */
typedef struct lf_above {
    int n;
    const lf_cell *cell[8];
    float weight[8];
    float shift[8][3]; /* from the middle of the cell above to the middle of the cell */
} lf_above;

/* i = 0: the cell that contains x; 1: the nearer of its neighbours. */
static int above_of(int x, int i)
{
    return lf_half_of(x) + (i == 0 ? 0 : x - 2 * lf_half_of(x) == 1 ? 1 : -1);
}

static float apart(int x, int above, float side)
{
    return ((float)x + 0.5f) * side - ((float)above + 0.5f) * 2.0f * side;
}

static void find_above(const lf_reconstruction *r, int level, int number, const lf_cell *cell,
                       lf_above *out)
{
    const lf_lattice *up = &r->level[level + 1];
    float side = (float)(1 << level), sum = 0.0f;
    out->n = 0;
    for (int i = 0; i < 8; i++) {
        int v = above_of(number, i >> 2), u = above_of(cell->u, i & 1),
            z = above_of(cell->z, i >> 1 & 1);
        int at = v >= 0 && v < up->n_bands ? lf_band_find(&up->bands[v], u, z) : -1;
        if (at < 0)
            continue;
        float *shift = out->shift[out->n];
        shift[0] = apart(cell->u, u, side);
        shift[1] = apart(number, v, side);
        shift[2] = apart(cell->z, z, side);
        out->cell[out->n] = &up->bands[v].cells[at];
        out->weight[out->n] =
            (i & 1 ? 0.25f : 0.75f) * (i >> 1 & 1 ? 0.25f : 0.75f) * (i >> 2 ? 0.25f : 0.75f);
        sum += out->weight[out->n++];
    }
    for (int i = 0; i < out->n; i++)
        out->weight[i] /= sum;
}

typedef struct lf_guess {
    lf_plane x[LF_VARIANTS][3];
    bool known[LF_VARIANTS];
} lf_guess;

static void add_above(const lf_above *above, int i, int variant, float weight, lf_plane out[3])
{
    for (int c = 0; c < 3; c++) {
        lf_plane moved = above->cell[i]->node[variant][c];
        for (int j = 0; j < 3; j++)
            moved.constant += moved.slope[j] * above->shift[i][j];
        add_scaled(&out[c], &moved, weight);
    }
}

/* The prediction of the level above for a cell, relative to its middle; a half without data uses
 * both. */
static void predict(const lf_above *above, lf_guess *out)
{
    memset(out, 0, sizeof *out);
    for (int v = LF_VARIANTS - 1; v >= 0; v--) {
        float sum = 0.0f;
        for (int i = 0; i < above->n; i++)
            sum += above->cell[i]->filled[v] ? above->weight[i] : 0.0f;
        out->known[v] = sum > 0.0f;
        for (int i = 0; i < above->n && sum > 0.0f; i++)
            if (above->cell[i]->filled[v])
                add_above(above, i, v, above->weight[i] / sum, out->x[v]);
        if (sum == 0.0f && out->known[LF_BOTH])
            memcpy(out->x[v], out->x[LF_BOTH], sizeof out->x[v]);
        out->known[v] = out->known[v] || out->known[LF_BOTH];
    }
}

/* The change of the guess by a node: zero if it has no data, small if it has few. */
static lf_plane step_of(const lf_cell *cell, const lf_guess *guess, int variant, int c)
{
    lf_plane step = {0};
    if (!cell->filled[variant])
        return step;
    const lf_plane full = minus(&cell->node[variant][c], &guess->x[variant][c]);
    add_scaled(&step, &full, cell->own[variant]);
    return step;
}

/* ------------------------------------------------------------------------------------ shares -- */

/* The weight of a squared error of R in the relMSE of the image; x: approximately R there. */
static double importance(const lf_cell_sums *cell, const lf_plane *x, int c)
{
    const lf_raw_sums *raw = &cell->raw;
    double pixels = fmax((double)raw->pixels, 1.0), q = (double)raw->q / pixels, w = 0.0, sum = 0.0,
           albedo = (double)raw->albedo[c] / pixels;
    for (int h = 0; h < 2; h++) {
        lf_plane mean = {.constant = cell->half[h][h].w};
        memcpy(mean.slope, cell->half[h][h].wf, sizeof mean.slope);
        sum += dot(&mean, x);
        w += (double)cell->half[h][h].w;
    }
    double radiance =
        (w > 0.0 ? fmax(sum / w, 0.0) * q * albedo : 0.0) + (double)raw->known[c] / pixels;
    return albedo * albedo * q / (radiance * radiance + EPSILON);
}

/* Sums over steps away from x (of both halves): their products with a half's data minus `against`,
 * and their squares. */
typedef struct lf_worth {
    double agreed, total;
} lf_worth;

static lf_worth weigh(const lf_cell_sums *cell, const lf_plane x[3], lf_plane against[][3],
                      lf_plane step[LF_VARIANTS][3])
{
    lf_worth out = {0.0, 0.0};
    for (int c = 0; c < 3; c++) {
        double g = importance(cell, &x[c], c);
        for (int h = 0; h < 2; h++) {
            const lf_moments *m = &cell->half[h][1 - h];
            lf_plane n = found(m, c), wx = apply(m, &against[h][c]), off = minus(&n, &wx),
                     w = apply(&cell->half[h][h], &step[LF_BOTH][c]);
            out.agreed += g * dot(&step[h][c], &off);
            out.total += g * dot(&step[LF_BOTH][c], &w);
        }
    }
    return out;
}

void lf_shrink_weigh(lf_reconstruction *r, int level, int number)
{
    lf_band *band = &r->level[level].bands[number];
    for (int i = 0; i < band->n; i++) {
        lf_cell *cell = &band->cells[i];
        lf_above above;
        lf_guess guess;
        lf_plane step[LF_VARIANTS][3];
        find_above(r, level, number, cell, &above);
        predict(&above, &guess);
        for (int v = 0; v < LF_VARIANTS; v++)
            for (int c = 0; c < 3; c++)
                step[v][c] = step_of(cell, &guess, v, c);
        lf_worth worth = weigh(&band->sums[i], guess.x[LF_BOTH], guess.x, step);
        cell->agreed = (float)worth.agreed;
        cell->total = (float)worth.total;
    }
}

/* The step from a cell's nodes to the past; zero if either has no data. */
static void find_step_to_past(const lf_cell *cell, const lf_plane past[3],
                              lf_plane step[LF_VARIANTS][3])
{
    memset(step, 0, LF_VARIANTS * sizeof *step);
    for (int v = 0; v < LF_VARIANTS; v++)
        for (int c = 0; c < 3 && cell->filled[v]; c++)
            step[v][c] = minus(&past[c], &cell->node[v][c]);
}

/* All of the step, except as far as each half's data contradict the past, with the other half's
 * node moved towards it. */
static void weigh_past(lf_cell *cell, const lf_cell_sums *sums, const lf_plane past[3])
{
    lf_plane step[LF_VARIANTS][3], against[2][3];
    for (int h = 0; h < 2; h++)
        memcpy(against[h], past, sizeof against[h]);
    find_step_to_past(cell, past, step);
    lf_worth worth = weigh(sums, cell->node[LF_BOTH], against, step);
    cell->agreed = (float)(worth.total + worth.agreed);
    cell->total = (float)worth.total;
}

void lf_shrink_weigh_past(lf_reconstruction *r, int number)
{
    lf_band *band = &r->level[0].bands[number];
    for (int i = 0; i < band->n; i++) {
        lf_cell *cell = &band->cells[i];
        lf_plane past[3];
        cell->agreed = cell->total = 0.0f;
        if (lf_past_recall(r, number, cell, past))
            weigh_past(cell, &band->sums[i], past);
    }
}

void lf_shrink_weigh_raw(lf_reconstruction *r, int number)
{
    lf_band *band = &r->level[0].bands[number];
    for (int i = 0; i < band->n; i++) {
        lf_cell *cell = &band->cells[i];
        const lf_cell_sums *sums = &band->sums[i];
        double agreed = 0.0, total = 0.0;
        for (int c = 0; c < 3; c++) {
            const lf_plane *both = &cell->node[LF_BOTH][c];
            double g = importance(sums, both, c), a = 0.0, t = (double)sums->raw.square[c];
            for (int h = 0; h < 2; h++) {
                const lf_plane *x = &cell->node[h][c];
                const lf_moments *m = &sums->half[h][1 - h], *own = &sums->half[h][h];
                lf_plane n = found(m, c), wx = apply(m, x), off = minus(&wx, &n),
                         n_own = found(own, c), w_own = apply(own, both);
                double seen = m->w > 0.0f ? (double)(sums->raw.weight[h] / m->w) : 0.0;
                if (seen > 0.0)
                    a += ((double)sums->raw.cross[h][c] - dot(&sums->raw.product[h][c], x)) *
                             fmin(1.0 / seen, MOST_STOOD_FOR) +
                         dot(x, &off);
                t += dot(both, &w_own) - 2.0 * dot(both, &n_own);
            }
            agreed += g * a;
            total += g * t;
        }
        cell->agreed = (float)agreed;
        cell->total = (float)total;
    }
}

void lf_shrink_collect(lf_reconstruction *r, int number)
{
    const lf_lattice *below = &r->level[0];
    lf_band *band = &r->level[1].bands[number];
    for (int i = 0; i < band->n; i++)
        band->cells[i].agreed = band->cells[i].total = 0.0f;
    for (int b = 2 * number; b < 2 * number + 2 && b < below->n_bands; b++) {
        for (int i = 0; i < below->bands[b].n; i++) {
            const lf_cell *child = &below->bands[b].cells[i];
            lf_cell *cell =
                &band->cells[lf_band_find(band, lf_half_of(child->u), lf_half_of(child->z))];
            cell->agreed += child->agreed;
            cell->total += child->total;
        }
    }
}

static float clamp_share(float x)
{
    return fminf(1.0f, fmaxf(0.0f, x));
}

/* Sums over the neighbouring cells, and the variance of their agreement, from their differences. */
typedef struct lf_decision {
    float agreed, total, variance;
} lf_decision;

static lf_decision decide(const lf_lattice *l, int number, const lf_cell *cell, bool doubted)
{
    lf_decision out = {0.0f, 0.0f, 0.0f};
    float weight;
    for (int n = 0; n < 27; n++) {
        const lf_cell *other = lf_cell_around(l, number, cell, n, &weight);
        out.agreed += other ? weight * other->agreed : 0.0f;
        out.total += other ? weight * other->total : 0.0f;
    }
    const float share = out.total > 0.0f ? out.agreed / out.total : 0.0f;
    for (int n = 0; n < 27 && doubted; n++) {
        const lf_cell *other = lf_cell_around(l, number, cell, n, &weight);
        float off = other ? weight * (other->agreed - share * other->total) : 0.0f;
        out.variance += off * off;
    }
    return out;
}

/* doubt: number of standard deviations of the agreement that count as chance. */
static float share_by(const lf_decision *d, float doubt)
{
    return d->total > 0.0f ? clamp_share((d->agreed - doubt * sqrtf(d->variance)) / d->total)
                           : 0.0f;
}

/* The decision of the neighbouring cells alone. If these have almost no data, there is none. */
static lf_decision without(const lf_decision *all, const lf_cell *cell)
{
    const float least = 1e-5f * all->total;
    lf_decision out = {.agreed = all->agreed - cell->agreed, .total = all->total - cell->total};
    float off = cell->agreed - all->agreed / all->total * cell->total;
    out.variance = fmaxf(0.0f, all->variance - off * off);
    return out.total > least ? out : (lf_decision){0.0f, 0.0f, 0.0f};
}

static void settle(const lf_lattice *l, int number, float doubt)
{
    lf_band *band = &l->bands[number];
    for (int i = 0; i < band->n; i++) {
        lf_cell *cell = &band->cells[i];
        const lf_decision all = decide(l, number, cell, doubt > 0.0f);
        cell->share = share_by(&all, doubt);
        if (!(all.total > 0.0f))
            continue;
        /* what its own noise has added to the gain (shown_error.h) */
        const lf_decision others = without(&all, cell);
        const float share = share_by(&others, doubt),
                    own = cell->agreed - clamp_share(all.agreed / all.total) * cell->total;
        if (cell->share > 0.0f && cell->share < 1.0f)
            cell->chosen += own * own / fmaxf(all.total - cell->total, LEAST_OTHERS * all.total);
        cell->chosen_most += (cell->share - share) * (cell->agreed - share * cell->total);
    }
}

void lf_shrink_settle(lf_reconstruction *r, int level, int number)
{
    settle(&r->level[level], number, 0.0f);
}

void lf_shrink_settle_raw(lf_reconstruction *r, int number)
{
    settle(&r->level[1], number, RAW_DOUBT);
}

static float share_above(const lf_above *above)
{
    float share = 0.0f;
    for (int i = 0; i < above->n; i++)
        share += above->weight[i] * above->cell[i]->share;
    return share;
}

void lf_shrink_take_bright(lf_reconstruction *r, int number)
{
    lf_band *band = &r->level[0].bands[number];
    for (int i = 0; i < band->n; i++) {
        lf_above above;
        find_above(r, 0, number, &band->cells[i], &above);
        band->cells[i].bright = 0.0f;
        for (int k = 0; k < above.n; k++)
            band->cells[i].bright += above.weight[k] * above.cell[k]->bright;
    }
}

void lf_shrink_take(lf_reconstruction *r, int level, int number)
{
    lf_band *band = &r->level[level].bands[number];
    for (int i = 0; i < band->n; i++) {
        lf_cell *cell = &band->cells[i];
        lf_above above;
        lf_guess guess;
        find_above(r, level, number, cell, &above);
        predict(&above, &guess);
        float share = level == 0 ? share_above(&above) : cell->share;
        for (int v = 0; v < LF_VARIANTS; v++) {
            /* without a guess a node is used as it is */
            for (int c = 0; c < 3 && guess.known[v]; c++) {
                lf_plane step = step_of(cell, &guess, v, c);
                cell->node[v][c] = guess.x[v][c];
                add_scaled(&cell->node[v][c], &step, share);
            }
            cell->filled[v] = cell->filled[v] || guess.known[v];
        }
    }
}

void lf_shrink_take_past(lf_reconstruction *r, int number)
{
    lf_band *band = &r->level[0].bands[number];
    for (int i = 0; i < band->n; i++) {
        lf_cell *cell = &band->cells[i];
        lf_above above;
        lf_plane past[3], step[LF_VARIANTS][3];
        if (!lf_past_recall(r, number, cell, past))
            continue;
        find_above(r, 0, number, cell, &above);
        find_step_to_past(cell, past, step);
        float share = share_above(&above);
        for (int v = 0; v < LF_VARIANTS; v++)
            for (int c = 0; c < 3; c++)
                add_scaled(&cell->node[v][c], &step[v][c], share);
    }
}

void lf_shrink_take_raw(lf_reconstruction *r, int number)
{
    lf_band *band = &r->level[0].bands[number];
    for (int i = 0; i < band->n; i++) {
        lf_above above;
        find_above(r, 0, number, &band->cells[i], &above);
        band->cells[i].share = share_above(&above);
    }
}
