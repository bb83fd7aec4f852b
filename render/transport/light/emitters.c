#include "render/transport/light/emitters.h"

#include "base/alloc.h"
#include "render/scene/fault.h"
#include "render/transport/light/light_types.h"

/* Share of the paths that stays as before any was traced. */
#define UNLEARNED 0.1
/* Scenes with more meshes have an even start. */
#define MOST_SHADOWS 4096

static bool emits(const lf_light *light)
{
    return light->kind->emit && light->select > 0.0f && !light->has_picture;
}

static bool has_square(const lf_light *light)
{
    return light->kind->escape && emits(light);
}

/* The square across a distant light that covers the shadow of the scene's ball from every direction
 * of the light. */
static void place_square(const lf_scene *scene, const lf_light *light, lf_emitter_square *out)
{
    const lf_vec3 d = lf_sub(scene->bounds.max, scene->bounds.min);
    const float radius = 0.5f * lf_length(d);
    out->middle = lf_scale(lf_add(scene->bounds.min, scene->bounds.max), 0.5f);
    out->half = 1.001f * radius / (1.0f - light->versine);
    lf_tangents(lf_scale(light->direction, -1.0f), &out->right, &out->up);
}

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
 * an equal share to each, so that small ones beside large ones are found. weight [cells]: sum 1. */
static void find_prior(const lf_scene *scene, const lf_emitter_square *square, double *weight)
{
    const bool shadows = scene->n_meshes > 0 && scene->n_meshes <= MOST_SHADOWS;
    for (int c = 0; c < LF_EMITTER_CELLS; c++)
        weight[c] = (shadows ? 0.5 : 1.0) / LF_EMITTER_CELLS;
    for (int i = 0; i < scene->n_meshes && shadows; i++) {
        int low[2], high[2];
        find_shadow(square, &scene->meshes[i].box, low, high);
        const double n = (double)(high[0] - low[0] + 1) * (high[1] - low[1] + 1);
        for (int y = low[1]; y <= high[1]; y++)
            for (int x = low[0]; x <= high[0]; x++)
                weight[y * LF_EMITTER_GRID + x] += 0.5 / (n * scene->n_meshes);
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

lf_status lf_emitters_init(lf_emitters *emitters, const lf_scene *scene)
{
    double total = 0.0, sum = 0.0, weight[LF_EMITTER_CELLS];
    int squares = 0;
    for (int i = 0; i < scene->n_lights; i++) {
        total += emits(&scene->lights[i]) ? (double)scene->lights[i].select : 0.0;
        squares += has_square(&scene->lights[i]);
    }
    *emitters = (lf_emitters){.scene = scene, .n = scene->n_lights};
    if (!(total > 0.0) || !(scene->bounds.max.x >= scene->bounds.min.x))
        return LF_OK;
    const size_t n = (size_t)scene->n_lights, cells = (size_t)squares * LF_EMITTER_CELLS;
    emitters->of = lf_calloc(n, sizeof *emitters->of);
    emitters->cumulative = lf_calloc(n + 1, sizeof *emitters->cumulative);
    emitters->density = lf_calloc(cells, sizeof *emitters->density);
    emitters->cell_sums = lf_calloc(cells + (size_t)squares, sizeof *emitters->cell_sums);
    if (!emitters->of || !emitters->cumulative || !emitters->density || !emitters->cell_sums) {
        lf_emitters_finish(emitters);
        return LF_E_NOMEM;
    }
    for (int i = 0; i < scene->n_lights; i++) {
        const lf_light *light = &scene->lights[i];
        lf_emitter *of = &emitters->of[i];
        sum += emits(light) ? (double)light->select / total : 0.0;
        emitters->cumulative[i + 1] = (float)sum;
        of->share = emitters->cumulative[i + 1] - emitters->cumulative[i];
        if (!has_square(light))
            continue;
        of->square.first = emitters->n_cells;
        of->square.density = emitters->density + emitters->n_cells;
        of->square.cumulative =
            emitters->cell_sums + emitters->n_cells + emitters->n_cells / LF_EMITTER_CELLS;
        place_square(scene, light, &of->square);
        find_prior(scene, &of->square, weight);
        set_cells(&of->square, weight);
        emitters->n_cells += LF_EMITTER_CELLS;
    }
    return LF_OK;
}

void lf_emitters_finish(lf_emitters *emitters)
{
    lf_free(emitters->of);
    lf_free(emitters->cumulative);
    lf_free(emitters->density);
    lf_free(emitters->cell_sums);
    *emitters = (lf_emitters){0};
}

const lf_light *lf_emitters_draw(const lf_emitters *emitters, const float u[LF_EMITTER_NUMBERS],
                                 lf_emitted *out, int *out_cell)
{
    float rest;
    const int i = lf_cdf_find(emitters->cumulative, emitters->n, u[0], &rest);
    const lf_light *light = &emitters->scene->lights[i];
    const lf_emitter *of = &emitters->of[i];
    *out = (lf_emitted){.cell = -1};
    *out_cell = -1;
    if (!(of->share > 0.0f) || !light->kind->emit(emitters->scene, light, &of->square, u + 1, out))
        return NULL;
    out->flux = lf_scale(out->flux, 1.0f / of->share);
    if (out->cell >= 0)
        *out_cell = of->square.first + out->cell;
    return light;
}

static float density_of(const lf_emitter *of, const lf_light *light,
                        const lf_emitter_square *square, lf_vec3 p, lf_vec3 ng, lf_vec3 wi,
                        float distance)
{
    return of->share > 0.0f ? of->share * fabsf(lf_dot(ng, wi)) *
                                  light->kind->emit_density(light, square, p, wi, distance)
                            : 0.0f;
}

float lf_emitters_density(const lf_emitters *emitters, const lf_light *light, lf_vec3 p, lf_vec3 ng,
                          lf_vec3 wi, float distance)
{
    const lf_emitter *of = &emitters->of[light - emitters->scene->lights];
    return density_of(of, light, &of->square, p, ng, wi, distance);
}

/* lf_emitters_density, as camera paths see it. */
static float seen_density(const lf_emitters *emitters, const lf_light *light, lf_vec3 p, lf_vec3 ng,
                          lf_vec3 wi, float distance)
{
    const lf_emitter *of = &emitters->of[light - emitters->scene->lights];
    lf_emitter_square even = of->square;
    if (!lf_has_fault(emitters, LF_FAULT_NO_CELL_PDF))
        return density_of(of, light, &of->square, p, ng, wi, distance);
    even.density = NULL;
    return density_of(of, light, &even, p, ng, wi, distance);
}

lf_vec3 lf_emitters_weigh(const lf_emitters *emitters, const lf_light *light, lf_vec3 radiance,
                          float rate, lf_vec3 p, lf_vec3 ng, lf_vec3 wi, float distance)
{
    const lf_scene *scene = emitters->scene;
    if (light) {
        float density = seen_density(emitters, light, p, ng, wi, distance);
        return lf_scale(radiance, 1.0f / (1.0f + rate * density));
    }
    for (int i = 0; i < scene->n_lights_infinite; i++) {
        light = &scene->lights[i];
        if (!(emitters->of[i].share > 0.0f))
            continue;
        float pdf;
        lf_vec3 own = light->kind->escape(light, wi, &pdf);
        if (!(lf_max3(own) > 0.0f))
            continue;
        float x = rate * seen_density(emitters, light, p, ng, wi, INFINITY);
        radiance = lf_madd(radiance, 1.0f / (1.0f + x) - 1.0f, own);
    }
    return lf_v3(lf_max(radiance.x, 0.0f), lf_max(radiance.y, 0.0f), lf_max(radiance.z, 0.0f));
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

void lf_emitters_learn(lf_emitters *emitters, const double *second)
{
    double root[LF_EMITTER_CELLS], weight[LF_EMITTER_CELLS];
    for (int i = 0; i < emitters->n; i++) {
        lf_emitter_square *square = &emitters->of[i].square;
        double sum = 0.0;
        if (!square->cumulative)
            continue;
        for (int c = 0; c < LF_EMITTER_CELLS; c++)
            sum += root[c] = sqrt(smooth(second + square->first, c));
        if (!(sum > 0.0))
            continue;
        find_prior(emitters->scene, square, weight);
        for (int c = 0; c < LF_EMITTER_CELLS; c++)
            weight[c] = UNLEARNED * weight[c] + (1.0 - UNLEARNED) * root[c] / sum;
        set_cells(square, weight);
    }
}
