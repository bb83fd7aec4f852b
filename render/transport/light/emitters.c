#include "render/transport/light/emitters.h"

#include "base/alloc.h"
#include "render/transport/light/light_types.h"

/* Share of the paths that is even over a square. */
#define EVEN 0.1

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

static void make_even(lf_emitter_square *square)
{
    for (int i = 0; i < LF_EMITTER_CELLS; i++) {
        square->density[i] = 1.0f;
        square->cumulative[i] = (float)i / LF_EMITTER_CELLS;
    }
    square->cumulative[LF_EMITTER_CELLS] = 1.0f;
}

lf_status lf_emitters_init(lf_emitters *emitters, const lf_scene *scene)
{
    double total = 0.0, sum = 0.0;
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
        make_even(&of->square);
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

float lf_emitters_density(const lf_emitters *emitters, const lf_light *light, lf_vec3 p, lf_vec3 ng,
                          lf_vec3 wi, float distance)
{
    const lf_emitter *of = &emitters->of[light - emitters->scene->lights];
    if (!(of->share > 0.0f))
        return 0.0f;
    return of->share * fabsf(lf_dot(ng, wi)) *
           light->kind->emit_density(light, &of->square, p, wi, distance);
}

lf_vec3 lf_emitters_weigh(const lf_emitters *emitters, const lf_light *light, lf_vec3 radiance,
                          float rate, lf_vec3 p, lf_vec3 ng, lf_vec3 wi, float distance)
{
    const lf_scene *scene = emitters->scene;
    if (light) {
        float density = lf_emitters_density(emitters, light, p, ng, wi, distance);
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
        float x = rate * lf_emitters_density(emitters, light, p, ng, wi, INFINITY);
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
    double root[LF_EMITTER_CELLS];
    for (int i = 0; i < emitters->n; i++) {
        lf_emitter_square *square = &emitters->of[i].square;
        double sum = 0.0, before = 0.0;
        for (int c = 0; c < LF_EMITTER_CELLS && square->cumulative; c++)
            sum += root[c] = sqrt(smooth(second + square->first, c));
        if (!(sum > 0.0))
            continue;
        for (int c = 0; c < LF_EMITTER_CELLS; c++) {
            before += EVEN / LF_EMITTER_CELLS + (1.0 - EVEN) * root[c] / sum;
            square->cumulative[c + 1] =
                c + 1 < LF_EMITTER_CELLS ? lf_cumulative_round(before) : 1.0f;
            square->density[c] =
                LF_EMITTER_CELLS * (square->cumulative[c + 1] - square->cumulative[c]);
        }
    }
}
