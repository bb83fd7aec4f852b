#include "render/transport/light/emitter_square.h"

#include "render/transport/light/light_types.h"

/* Share of the paths that stays as before any was traced. */
#define UNLEARNED 0.1
/* Scenes with more meshes have an even start. */
#define MOST_SHADOWS 4096

/* The cells in the shadow of a box: columns and rows from low to high. */
static void find_shadow(const lf_emitter_square *square, const lf_box *box, int low[2], int high[2])
{
    float min[2] = {INFINITY, INFINITY}, max[2] = {-INFINITY, -INFINITY};
    for (int i = 0; i < 8; i++) {
        const lf_vec3 d =
            lf_sub(lf_v3(i & 1 ? box->max.x : box->min.x, i & 2 ? box->max.y : box->min.y,
                         i & 4 ? box->max.z : box->min.z),
                   square->middle);
        const float at[2] = {lf_dot(d, square->right), lf_dot(d, square->up)};
        for (int k = 0; k < 2; k++) {
            min[k] = lf_min(min[k], at[k]);
            max[k] = lf_max(max[k], at[k]);
        }
    }
    for (int k = 0; k < 2; k++) {
        const float scale = LF_EMITTER_GRID / (2.0f * square->half), end = LF_EMITTER_GRID - 1;
        low[k] = (int)lf_min(lf_max((min[k] + square->half) * scale, 0.0f), end);
        high[k] = (int)lf_min(lf_max((max[k] + square->half) * scale, 0.0f), end);
    }
}

/* What is known of a square before any path: half is even, and half goes to the shadows of meshes,
 * an equal share to each, so that small ones beside large ones are found. */
static void find_prior(const lf_scene *scene, const lf_emitter_square *square)
{
    const bool shadows = scene->n_meshes > 0 && scene->n_meshes <= MOST_SHADOWS;
    for (int c = 0; c < LF_EMITTER_CELLS; c++)
        square->prior[c] = (shadows ? 0.5 : 1.0) / LF_EMITTER_CELLS;
    for (int i = 0; i < scene->n_meshes && shadows; i++) {
        int low[2], high[2];
        find_shadow(square, &scene->meshes[i].box, low, high);
        const double n = (double)(high[0] - low[0] + 1) * (high[1] - low[1] + 1);
        for (int y = low[1]; y <= high[1]; y++)
            for (int x = low[0]; x <= high[0]; x++)
                square->prior[y * LF_EMITTER_GRID + x] += 0.5 / (n * scene->n_meshes);
    }
}

/* Sets the probabilities of the cells; weight [cells]: sum 1. */
static void set_cells(lf_emitter_square *square, const double *weight)
{
    double sum = 0.0;
    square->cumulative[0] = 0.0f;
    for (int c = 0; c < LF_EMITTER_CELLS; c++) {
        sum += weight[c];
        square->cumulative[c + 1] = c + 1 < LF_EMITTER_CELLS ? lf_cumulative_round(sum) : 1.0f;
        square->density[c] = LF_EMITTER_CELLS * (square->cumulative[c + 1] - square->cumulative[c]);
    }
}

void lf_emitter_square_place(lf_emitter_square *square, const lf_scene *scene, lf_vec3 axis,
                             float least_cosine)
{
    const lf_vec3 d = lf_sub(scene->bounds.max, scene->bounds.min);
    const float radius = 0.5f * lf_length(d);
    square->middle = lf_scale(lf_add(scene->bounds.min, scene->bounds.max), 0.5f);
    square->half = 1.001f * radius / least_cosine;
    square->axis = axis;
    lf_tangents(axis, &square->right, &square->up);
    find_prior(scene, square);
    set_cells(square, square->prior);
}

lf_vec3 lf_emitter_square_draw(const lf_emitter_square *square, const float u[3], int *out_cell,
                               float *out_area)
{
    float inside;
    const int cell = lf_cdf_find(square->cumulative, LF_EMITTER_CELLS, u[0], &inside);
    const int column = cell % LF_EMITTER_GRID, row = cell / LF_EMITTER_GRID;
    const float step = 2.0f * square->half / LF_EMITTER_GRID,
                x = ((float)column + u[1]) * step - square->half,
                y = ((float)row + u[2]) * step - square->half;
    *out_cell = cell;
    *out_area = 4.0f * square->half * square->half / square->density[cell];
    return lf_madd(lf_madd(square->middle, x, square->right), y, square->up);
}

/* The density of paths per unit area of the square at a point of it; 0 outside. */
static float density_at(const lf_emitter_square *square, float x, float y)
{
    const float scale = LF_EMITTER_GRID / (2.0f * square->half);
    const float across = (x + square->half) * scale, along = (y + square->half) * scale;
    if (!(across >= 0.0f && along >= 0.0f && across < LF_EMITTER_GRID && along < LF_EMITTER_GRID))
        return 0.0f;
    const int cell = (int)along * LF_EMITTER_GRID + (int)across;
    return (square->density ? square->density[cell] : 1.0f) / (4.0f * square->half * square->half);
}

float lf_emitter_square_density(const lf_emitter_square *square, lf_vec3 p, lf_vec3 wi)
{
    const float cosine = lf_dot(wi, square->axis);
    lf_vec3 d = lf_sub(p, square->middle);
    d = lf_madd(d, -lf_dot(d, square->axis) / cosine, wi);
    return density_at(square, lf_dot(d, square->right), lf_dot(d, square->up)) / cosine;
}

/* The mean of a cell and its neighbours, because few paths come through a cell. */
static double smooth(const double *second, int cell)
{
    const int column = cell % LF_EMITTER_GRID, row = cell / LF_EMITTER_GRID;
    double sum = 0.0;
    int n = 0;
    for (int y = row - 1; y <= row + 1; y++)
        for (int x = column - 1; x <= column + 1; x++)
            if (x >= 0 && y >= 0 && x < LF_EMITTER_GRID && y < LF_EMITTER_GRID) {
                sum += second[y * LF_EMITTER_GRID + x];
                n++;
            }
    return sum / n;
}

void lf_emitter_square_learn(lf_emitter_square *square, const double *second)
{
    double root[LF_EMITTER_CELLS], weight[LF_EMITTER_CELLS], sum = 0.0;
    for (int c = 0; c < LF_EMITTER_CELLS; c++)
        sum += root[c] = sqrt(smooth(second, c));
    if (!(sum > 0.0))
        return;
    for (int c = 0; c < LF_EMITTER_CELLS; c++)
        weight[c] = UNLEARNED * square->prior[c] + (1.0 - UNLEARNED) * root[c] / sum;
    set_cells(square, weight);
}
