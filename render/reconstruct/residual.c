#include "render/reconstruct/residual.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "render/reconstruct/answer.h"

#define EPSILON 1e-2f
/* An agreement of the halves counts as chance up to this number of its standard deviations; in the
 * finest tiles, which have most noise. */
#define DOUBT 2.0f
#define DOUBT_FINEST 4.0f
/* Steps of sharpening. */
#define ROUNDS 3
/* Limit of one step of a level relative to the expectation: if that was almost 0, one bright path
 * would be multiplied. Finer levels find brighter light. */
#define MOST 1.5f

static void *make_tiles(const lf_residual *r, int level, int n_views, size_t size)
{
    return lf_pages((size_t)n_views * (size_t)r->down[level] * (size_t)r->across[level], size);
}

lf_residual *lf_residual_create(const lf_reconstruct_view *view)
{
    lf_residual *out = lf_calloc(1, sizeof *out);
    bool whole = out;
    for (int l = 0; l < LF_RESIDUAL_LEVELS && whole; l++) {
        const int side = LF_RESIDUAL_SIDE << l;
        out->across[l] = (view->width + side - 1) / side;
        out->down[l] = (view->height + side - 1) / side;
    }
    if (whole) {
        out->tiles[0] = make_tiles(out, 0, view->n_views, sizeof *out->tiles[0]);
        out->chosen = lf_calloc((size_t)view->n_views, sizeof *out->chosen);
    }
    if (whole && out->tiles[0] && out->chosen)
        return out;
    lf_residual_destroy(out);
    return NULL;
}

lf_status lf_residual_begin(lf_residual *residual, int n_views)
{
    bool whole = true;
    for (int l = 0; l < LF_RESIDUAL_LEVELS && whole; l++) {
        if (l > 0)
            residual->tiles[l] = make_tiles(residual, l, n_views, sizeof *residual->tiles[l]);
        residual->fitted[l] = make_tiles(residual, l, n_views, sizeof *residual->fitted[l]);
        whole = residual->tiles[l] && residual->fitted[l];
    }
    return whole ? LF_OK : LF_E_NOMEM;
}

void lf_residual_end(lf_residual *residual)
{
    for (int l = 0; l < LF_RESIDUAL_LEVELS; l++) {
        lf_pages_free(residual->fitted[l]);
        residual->fitted[l] = NULL;
        if (l == 0)
            continue;
        lf_pages_free(residual->tiles[l]);
        residual->tiles[l] = NULL;
    }
}

void lf_residual_destroy(lf_residual *residual)
{
    if (!residual)
        return;
    lf_residual_end(residual);
    lf_pages_free(residual->tiles[0]);
    lf_free(residual->chosen);
    lf_free(residual);
}

static size_t index_of(const lf_residual *all, int level, int view, int v, int u)
{
    return ((size_t)view * (size_t)all->down[level] + (size_t)v) * (size_t)all->across[level] +
           (size_t)u;
}

static lf_residual_tile *tile_at(const lf_reconstruction *r, int level, int view, int v, int u)
{
    return &r->residual->tiles[level][index_of(r->residual, level, view, v, u)];
}

static lf_residual_fitted *fitted_at(const lf_reconstruction *r, int level, int view, int v, int u)
{
    return &r->residual->fitted[level][index_of(r->residual, level, view, v, u)];
}

/* -------------------------------------------------------------------------------------- sums -- */

static void add_pixel(lf_residual_sums *sums, const lf_answered_row *o, size_t i)
{
    const lf_film_known *known = lf_film_known_at(o->film, o->row);
    const float q = o->scratch->row.q[i];
    lf_pixel_found found[2];
    float shown[3];
    lf_answer_pixel(o, i, found, shown);
    for (int c = 0; c < 3; c++) {
        for (int h = 0; h < 2; h++) {
            sums->found[h][c] += found[h].n[c];
            sums->expected[h][c] += found[h].w * shown[c];
        }
        sums->shown[c] += q * shown[c];
        sums->known[c] += known ? known[i].b[c] : o->film->sky[c] * (1.0f - q);
    }
    sums->pixels += 1.0f;
}

static void add_row(const lf_reconstruction *r, const lf_answered_row *o, int number)
{
    const int width = r->view.width;
    for (int k = 0; k < r->view.n_views; k++) {
        if (!lf_view_is_fitted(r, o->row, k))
            continue;
        lf_answer_predict(o, k * width, width);
        for (int i = 0; i < width; i++) {
            const size_t at = (size_t)k * (size_t)width + (size_t)i;
            if (lf_pixel_is_fitted(&o->scratch->row, at))
                add_pixel(&fitted_at(r, 0, k, number, i / LF_RESIDUAL_SIDE)->sums, o, at);
        }
    }
}

lf_status lf_residual_sum(lf_reconstruction *r, const lf_film *film, int number)
{
    const int first = number * LF_RESIDUAL_SIDE;
    lf_status status = LF_OK;
    for (int k = 0; k < r->view.n_views; k++)
        memset(tile_at(r, 0, k, number, 0), 0,
               (size_t)r->residual->across[0] * sizeof(lf_residual_tile));
    for (int row = first; row < first + LF_RESIDUAL_SIDE && row < film->height && status == LF_OK;
         row++) {
        lf_answered_row o;
        if (!(film->rows[row].n[0] > 0.0 && film->rows[row].n[1] > 0.0))
            continue;
        status = lf_answer_open(r, film, row, LF_READ_SUMMED, &o);
        if (status == LF_OK)
            add_row(r, &o, number);
        lf_answer_close(r, &o);
    }
    return status;
}

/* Adds a finest tile's sums with the current corrections. */
static void add_sums(lf_residual_sums *to, const lf_residual_tile *tile,
                     const lf_residual_sums *from)
{
    for (int c = 0; c < 3; c++) {
        const float times = 1.0f + tile->lacks[LF_BOTH][c];
        for (int h = 0; h < 2; h++) {
            to->found[h][c] += from->found[h][c];
            to->expected[h][c] += times * from->expected[h][c];
        }
        to->shown[c] += times * from->shown[c];
        to->known[c] += from->known[c];
    }
    to->pixels += from->pixels;
}

/* ------------------------------------------------------------------------------------ shares -- */

static float lack_of(float found, float expected)
{
    return fminf(MOST, fmaxf(-1.0f, found / expected - 1.0f));
}

/* Corrections of a tile by each half and by both; in relMSE, the improvement if both halves agree,
 * and the size of the step. */
static void weigh(const lf_residual_sums *s, float lacks[LF_VARIANTS][3], lf_residual_tile *out)
{
    memset(lacks, 0, LF_VARIANTS * sizeof *lacks);
    out->agreed = out->total = 0.0f;
    for (int c = 0; c < 3; c++) {
        if (!(s->expected[0][c] > 0.0f && s->expected[1][c] > 0.0f))
            continue;
        for (int h = 0; h < 2; h++)
            lacks[h][c] = lack_of(s->found[h][c], s->expected[h][c]);
        lacks[LF_BOTH][c] =
            lack_of(s->found[0][c] + s->found[1][c], s->expected[0][c] + s->expected[1][c]);
        const float radiance = (s->known[c] + s->shown[c]) / s->pixels,
                    scattered = s->shown[c] / s->pixels,
                    counts = s->pixels * scattered * scattered / (radiance * radiance + EPSILON);
        out->agreed += counts * lacks[0][c] * lacks[1][c];
        out->total += counts * lacks[LF_BOTH][c] * lacks[LF_BOTH][c];
    }
}

/* The n-th of the 27 tiles around one, in its view and the neighbouring ones; NULL: none; and its
 * weight. */
static const lf_residual_tile *around(const lf_reconstruction *r, int level, int view, int v, int u,
                                      int n, float *weight)
{
    const lf_around a = lf_around_at(n);
    *weight = a.weight;
    view += a.dz;
    v += a.dv;
    u += a.du;
    if (view < 0 || view >= r->view.n_views || v < 0 || v >= r->residual->down[level] || u < 0 ||
        u >= r->residual->across[level])
        return NULL;
    return tile_at(r, level, view, v, u);
}

static float share_of(const lf_reconstruction *r, int level, int view, int v, int u)
{
    float agreed = 0.0f, total = 0.0f, variance = 0.0f, weight;
    for (int n = 0; n < 27; n++) {
        const lf_residual_tile *other = around(r, level, view, v, u, n, &weight);
        agreed += other ? weight * other->agreed : 0.0f;
        total += other ? weight * other->total : 0.0f;
    }
    if (!(agreed > 0.0f && total > 0.0f))
        return 0.0f;
    for (int n = 0; n < 27; n++) {
        const lf_residual_tile *other = around(r, level, view, v, u, n, &weight);
        const float off = other ? weight * (other->agreed - agreed / total * other->total) : 0.0f;
        variance += off * off;
    }
    const float chance = (level == 0 ? DOUBT_FINEST : DOUBT) * sqrtf(variance);
    return fminf(1.0f, fmaxf(0.0f, (agreed - chance) / total));
}

static double settle_shares(const lf_reconstruction *r, int level, int view)
{
    double chosen = 0.0;
    for (int v = 0; v < r->residual->down[level]; v++)
        for (int u = 0; u < r->residual->across[level]; u++) {
            lf_residual_tile *tile = tile_at(r, level, view, v, u);
            tile->share = share_of(r, level, view, v, u);
            /* its own noise has decided at most this much of the step */
            const double taken = (double)(tile->share * tile->total),
                         own = fmin(fabs((double)tile->agreed - taken), taken);
            if (tile->share > 0.0f && tile->share < 1.0f && tile->total > 0.0f)
                chosen += own * own / (double)tile->total;
        }
    return chosen;
}

/* ------------------------------------------------------------------------------------- steps -- */

/* Of n tiles of `side`, the two around a position; and the weight of the second. */
static void between(float place, int side, int n, int out[2], float *out_part)
{
    const float at = place / (float)side - 0.5f, low = floorf(at);
    const int first = (int)low;
    *out_part = at - low;
    out[0] = first > 0 ? first : 0;
    out[1] = first + 1 < n ? first + 1 : n - 1;
}

/* Interpolates share times correction between the tiles of a level around a position. */
static void step_at(const lf_reconstruction *r, int level, int view, float row, float column,
                    float out[LF_VARIANTS][3])
{
    const int side = LF_RESIDUAL_SIDE << level;
    int v[2], u[2];
    float down, along;
    between(row, side, r->residual->down[level], v, &down);
    between(column, side, r->residual->across[level], u, &along);
    memset(out, 0, LF_VARIANTS * sizeof *out);
    for (int n = 0; n < 4; n++) {
        const lf_residual_tile *tile = tile_at(r, level, view, v[n >> 1], u[n & 1]);
        const float part =
            tile->share * (n >> 1 ? down : 1.0f - down) * (n & 1 ? along : 1.0f - along);
        for (int i = 0; i < LF_VARIANTS; i++)
            for (int c = 0; c < 3; c++)
                out[i][c] += part * tile->lacks[i][c];
    }
}

static void take(lf_residual_tile *tile, float step[LF_VARIANTS][3])
{
    for (int i = 0; i < LF_VARIANTS; i++)
        for (int c = 0; c < 3; c++)
            tile->lacks[i][c] = (1.0f + tile->lacks[i][c]) * (1.0f + step[i][c]) - 1.0f;
}

/* The larger tiles of a level, from the finest. */
static void coarsen(const lf_reconstruction *r, int level, int view)
{
    for (int v = 0; v < r->residual->down[0]; v++)
        for (int u = 0; u < r->residual->across[0]; u++)
            add_sums(&fitted_at(r, level, view, v >> level, u >> level)->sums,
                     tile_at(r, 0, view, v, u), &fitted_at(r, 0, view, v, u)->sums);
    for (int v = 0; v < r->residual->down[level]; v++)
        for (int u = 0; u < r->residual->across[level]; u++) {
            lf_residual_tile *tile = tile_at(r, level, view, v, u);
            weigh(&fitted_at(r, level, view, v, u)->sums, tile->lacks, tile);
        }
}

/* A step for a finest tile with the current corrections. */
static void weigh_finest(lf_residual_tile *tile, const lf_residual_sums *sums,
                         float step[LF_VARIANTS][3])
{
    lf_residual_sums now;
    memset(&now, 0, sizeof now);
    add_sums(&now, tile, sums);
    weigh(&now, step, tile);
}

void lf_residual_weigh(lf_reconstruction *r, int level, int view)
{
    float step[LF_VARIANTS][3];
    if (level == LF_RESIDUAL_LEVELS - 1)
        r->residual->chosen[view] = 0.0;
    if (level > 0) {
        coarsen(r, level, view);
        return;
    }
    for (int v = 0; v < r->residual->down[0]; v++)
        for (int u = 0; u < r->residual->across[0]; u++)
            weigh_finest(tile_at(r, 0, view, v, u), &fitted_at(r, 0, view, v, u)->sums, step);
}

static void take_all(const lf_reconstruction *r, int level, int view)
{
    float step[LF_VARIANTS][3];
    for (int v = 0; v < r->residual->down[0]; v++)
        for (int u = 0; u < r->residual->across[0]; u++) {
            lf_residual_tile *tile = tile_at(r, 0, view, v, u);
            const float share = tile->share;
            if (level > 0)
                step_at(r, level, view, ((float)v + 0.5f) * LF_RESIDUAL_SIDE,
                        ((float)u + 0.5f) * LF_RESIDUAL_SIDE, step);
            else
                weigh_finest(tile, &fitted_at(r, 0, view, v, u)->sums, step);
            for (int i = 0; i < LF_VARIANTS && level == 0; i++)
                for (int c = 0; c < 3; c++)
                    step[i][c] *= share;
            take(tile, step);
        }
}

/* Interpolation blurs the corrections of tiles; so they are sharpened beforehand, until their means
 * are near the required ones. */
static float mean_along(const float x[3])
{
    return 0.125f * (x[0] + x[2]) + 0.75f * x[1];
}

static void sharpen_tile(const lf_reconstruction *r, int view, int v, int u)
{
    const int last_v = r->residual->down[0] - 1, last_u = r->residual->across[0] - 1;
    lf_residual_tile *tile = tile_at(r, 0, view, v, u);
    for (int i = 0; i < LF_VARIANTS; i++)
        for (int c = 0; c < 3; c++) {
            float means[3];
            for (int dv = -1; dv <= 1; dv++) {
                float x[3];
                for (int du = -1; du <= 1; du++) {
                    const int at_v = v + dv < 0        ? 0
                                     : v + dv > last_v ? last_v
                                                       : v + dv,
                              at_u = u + du < 0        ? 0
                                     : u + du > last_u ? last_u
                                                       : u + du;
                    x[du + 1] = tile_at(r, 0, view, at_v, at_u)->lacks[i][c];
                }
                means[dv + 1] = mean_along(x);
            }
            /* at most half beyond: more would ring */
            const float wanted = fitted_at(r, 0, view, v, u)->wanted[i][c],
                        sharper = tile->lacks[i][c] + wanted - mean_along(means),
                        off = 0.5f * fabsf(wanted);
            tile->lacks[i][c] = fmaxf(-1.0f, fminf(wanted + off, fmaxf(wanted - off, sharper)));
        }
}

static void sharpen(const lf_reconstruction *r, int view)
{
    for (int v = 0; v < r->residual->down[0]; v++)
        for (int u = 0; u < r->residual->across[0]; u++) {
            float(*wanted)[3] = fitted_at(r, 0, view, v, u)->wanted;
            memcpy(wanted, tile_at(r, 0, view, v, u)->lacks, LF_VARIANTS * sizeof *wanted);
        }
    for (int round = 0; round < ROUNDS; round++)
        for (int v = 0; v < r->residual->down[0]; v++)
            for (int u = 0; u < r->residual->across[0]; u++)
                sharpen_tile(r, view, v, u);
}

void lf_residual_share(lf_reconstruction *r, int level, int view)
{
    r->residual->chosen[view] += settle_shares(r, level, view);
}

void lf_residual_take(lf_reconstruction *r, int level, int view)
{
    take_all(r, level, view);
    if (level == 0)
        sharpen(r, view);
}

double lf_residual_chosen(const lf_reconstruction *r)
{
    double sum = 0.0;
    for (int k = 0; k < r->view.n_views && r->residual; k++)
        sum += r->residual->chosen[k];
    return sum;
}

static bool anything(const lf_residual_tile *tiles, int n)
{
    for (int i = 0; i < n; i++)
        for (int c = 0; c < 3; c++)
            if (tiles[i].lacks[LF_BOTH][c] != 0.0f)
                return true;
    return false;
}

static float mix(float a, float b, float part)
{
    return a + part * (b - a);
}

bool lf_residual_row(const lf_reconstruction *r, int row, int view, int variant, float (*out)[3])
{
    if (!r->residual)
        return false;
    const int n = r->residual->across[0];
    int v[2], u[2];
    float down, along;
    between((float)row + 0.5f, LF_RESIDUAL_SIDE, r->residual->down[0], v, &down);
    const lf_residual_tile *above = tile_at(r, 0, view, v[0], 0),
                           *below = tile_at(r, 0, view, v[1], 0);
    if (!anything(above, n) && !anything(below, n))
        return false;
    for (int k = 0; k < r->view.width; k++) {
        between((float)k + 0.5f, LF_RESIDUAL_SIDE, n, u, &along);
        for (int c = 0; c < 3; c++)
            out[k][c] =
                1.0f + mix(mix(above[u[0]].lacks[variant][c], above[u[1]].lacks[variant][c], along),
                           mix(below[u[0]].lacks[variant][c], below[u[1]].lacks[variant][c], along),
                           down);
    }
    return true;
}
