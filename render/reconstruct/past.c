#include "render/reconstruct/past.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

/* Positions beyond this are ignored. */
#define FARTHEST 1e6

typedef struct lf_past_band {
    lf_band places; /* without cells: the index is of nodes */
    lf_plane (*node)[3];
} lf_past_band;

struct lf_past {
    double deep; /* finest cells in the depth of the plane Z = D */
    bool albedo; /* R is over the albedo */
    int n_bands;
    lf_past_band *bands;
};

static double deep_of(const lf_reconstruction *r)
{
    return (double)r->view.depth / (double)r->cell_depth;
}

static bool keep_band(const lf_band *from, lf_past_band *to)
{
    lf_band *places = &to->places;
    if (from->n == 0)
        return true;
    places->layers = lf_calloc((size_t)from->nz, sizeof *places->layers);
    places->index = lf_calloc(from->n_places, sizeof *places->index);
    to->node = lf_calloc((size_t)from->n, sizeof *to->node);
    if (!places->layers || !places->index || !to->node)
        return false;
    places->z0 = from->z0;
    places->nz = from->nz;
    memcpy(places->layers, from->layers, (size_t)from->nz * sizeof *places->layers);
    for (size_t i = 0; i < from->n_places; i++) {
        int at = from->index[i];
        places->index[i] = at >= 0 && from->cells[at].filled[LF_BOTH] ? at : -1;
        if (places->index[i] >= 0)
            memcpy(to->node[at], from->cells[at].node[LF_BOTH], sizeof to->node[at]);
    }
    return true;
}

lf_past *lf_past_of(const lf_reconstruction *r)
{
    lf_past *past = r->ready ? lf_calloc(1, sizeof *past) : NULL;
    if (!past)
        return NULL;
    past->deep = deep_of(r);
    past->albedo = r->view.albedo;
    past->n_bands = r->level[0].n_bands;
    past->bands = lf_calloc((size_t)past->n_bands, sizeof *past->bands);
    bool whole = past->bands;
    for (int i = 0; i < past->n_bands && whole; i++)
        whole = keep_band(&r->level[0].bands[i], &past->bands[i]);
    if (whole)
        return past;
    lf_past_destroy(past);
    return NULL;
}

void lf_past_destroy(lf_past *past)
{
    if (!past)
        return;
    for (int i = 0; past->bands && i < past->n_bands; i++) {
        lf_band_finish(&past->bands[i].places);
        lf_free(past->bands[i].node);
    }
    lf_free(past->bands);
    lf_free(past);
}

void lf_reconstruct_follow(lf_reconstruction *r, const lf_past *past, const lf_past_move *move)
{
    r->past = past && past->albedo == r->view.albedo ? past : NULL;
    if (!r->past)
        return;
    const double side = LF_CELL_SIDE, now[4] = {side, side, 1.0 / deep_of(r), 1.0},
                 then[4] = {side, side, 1.0 / past->deep, 1.0};
    r->move.view = move->view;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            r->move.map[i][j] = move->map[i][j] * now[j] / then[i];
}

/* The position of a point for the past, and its derivatives by the current position. */
typedef struct lf_past_place {
    double at[3], slope[3][3];
} lf_past_place;

static bool find_place(const lf_past_move *move, const double x[3], lf_past_place *out)
{
    double h[4];
    for (int i = 0; i < 4; i++)
        h[i] = move->map[i][0] * x[0] + move->map[i][1] * x[1] + move->map[i][2] * x[2] +
               move->map[i][3];
    if (!(h[3] > 0.0))
        return false;
    for (int i = 0; i < 3; i++) {
        out->at[i] = h[i] / h[3];
        if (!(fabs(out->at[i]) < FARTHEST))
            return false;
        for (int j = 0; j < 3; j++)
            out->slope[i][j] = (move->map[i][j] - out->at[i] * move->map[3][j]) / h[3];
    }
    return true;
}

/* Adds weight times a node's planes, translated by `shift` from its middle. */
static void add_node(lf_plane out[3], const lf_plane node[3], float weight, const float shift[3])
{
    for (int c = 0; c < 3; c++) {
        float constant = node[c].constant;
        for (int i = 0; i < 3; i++)
            constant += node[c].slope[i] * shift[i];
        out[c].constant += weight * constant;
        for (int i = 0; i < LF_FEATURES; i++)
            out[c].slope[i] += weight * node[c].slope[i];
    }
}

/* Interpolates between up to eight nodes around a position; false: there is no node. */
static bool look_up(const lf_past *past, const double at[3], lf_plane out[3])
{
    float sum = 0.0f;
    memset(out, 0, 3 * sizeof *out);
    for (int i = 0; i < 8; i++) {
        int node[3];
        float weight = 1.0f, shift[3];
        for (int j = 0; j < 3; j++) {
            node[j] = (int)floor(at[j] - 0.5) + (i >> j & 1);
            shift[j] = (float)(at[j] - 0.5 - node[j]);
            weight *= 1.0f - fabsf(shift[j]);
        }
        const lf_past_band *band =
            node[1] >= 0 && node[1] < past->n_bands ? &past->bands[node[1]] : NULL;
        int n = band ? lf_band_find(&band->places, node[0], node[2]) : -1;
        if (n < 0 || !(weight > 0.0f))
            continue;
        add_node(out, band->node[n], weight, shift);
        sum += weight;
    }
    for (int c = 0; c < 3 && sum > 0.0f; c++) {
        out[c].constant /= sum;
        for (int i = 0; i < LF_FEATURES; i++)
            out[c].slope[i] /= sum;
    }
    return sum > 0.0f;
}

/* From the past's coordinates to the current ones. */
static void turn(lf_plane *plane, const lf_past_place *place, float view)
{
    float slope[3];
    plane->constant += view * plane->slope[LF_VIEW];
    for (int j = 0; j < 3; j++) {
        slope[j] = 0.0f;
        for (int i = 0; i < 3; i++)
            slope[j] += plane->slope[i] * (float)place->slope[i][j];
    }
    memcpy(plane->slope, slope, sizeof slope);
    plane->slope[LF_SPREAD] *= (float)place->slope[LF_DEPTH][LF_DEPTH];
}

bool lf_past_recall(const lf_reconstruction *r, int number, const lf_cell *cell, lf_plane out[3])
{
    const double middle[3] = {cell->u + 0.5, number + 0.5, cell->z + 0.5};
    lf_past_place place;
    if (!find_place(&r->move, middle, &place) || !look_up(r->past, place.at, out))
        return false;
    for (int c = 0; c < 3; c++)
        turn(&out[c], &place, r->move.view);
    return true;
}
