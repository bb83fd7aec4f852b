#include "render/transport/light/emitters.h"

#include "base/alloc.h"
#include "render/scene/fault.h"
#include "render/transport/light/light_types.h"

static bool emits(const lf_light *light)
{
    return light->kind->emit && light->select > 0.0f;
}

/* Adds the starts of a light to emitters->of; share is not normalised yet. */
static lf_status add_starts(lf_emitters *emitters, const lf_light *light)
{
    lf_sky_lobe lobes[LF_SKY_LOBES];
    int n = 0;
    if (!light->environment) {
        emitters->of[emitters->n++] = (lf_emitter){.light = light, .share = light->select};
        return LF_OK;
    }
    const lf_status status = lf_sky_lobes_find(light, lobes, &n);
    for (int i = 0; i < n; i++)
        emitters->of[emitters->n++] =
            (lf_emitter){.light = light, .share = light->select * lobes[i].share, .lobe = lobes[i]};
    return status;
}

static lf_status find_starts(lf_emitters *emitters)
{
    const lf_scene *scene = emitters->scene;
    size_t most = 0;
    for (int i = 0; i < scene->n_lights; i++)
        if (emits(&scene->lights[i]))
            most += scene->lights[i].environment ? LF_SKY_LOBES : 1;
    if (most == 0)
        return LF_OK;
    emitters->of = lf_calloc(most, sizeof *emitters->of);
    emitters->first = lf_calloc((size_t)scene->n_lights + 1, sizeof *emitters->first);
    lf_status status = emitters->of && emitters->first ? LF_OK : LF_E_NOMEM;
    for (int i = 0; i < scene->n_lights && status == LF_OK; i++) {
        if (emits(&scene->lights[i]))
            status = add_starts(emitters, &scene->lights[i]);
        emitters->first[i + 1] = emitters->n;
        if (i < scene->n_lights_infinite)
            emitters->n_infinite = emitters->n;
    }
    return status;
}

static lf_status set_shares(lf_emitters *emitters)
{
    double total = 0.0, sum = 0.0;
    emitters->cumulative = lf_calloc((size_t)emitters->n + 1, sizeof *emitters->cumulative);
    if (!emitters->cumulative)
        return LF_E_NOMEM;
    for (int i = 0; i < emitters->n; i++)
        total += (double)emitters->of[i].share;
    for (int i = 0; i < emitters->n; i++) {
        lf_emitter *of = &emitters->of[i];
        sum += (double)of->share / total;
        emitters->cumulative[i + 1] = (float)sum;
        of->share = emitters->cumulative[i + 1] - emitters->cumulative[i];
    }
    return LF_OK;
}

static lf_status place_squares(lf_emitters *emitters)
{
    const size_t n = (size_t)emitters->n_infinite, cells = n * LF_EMITTER_CELLS;
    if (n == 0)
        return LF_OK;
    emitters->density = lf_calloc(cells, sizeof *emitters->density);
    emitters->cell_sums = lf_calloc(cells + n, sizeof *emitters->cell_sums);
    emitters->prior = lf_calloc(cells, sizeof *emitters->prior);
    if (!emitters->density || !emitters->cell_sums || !emitters->prior)
        return LF_E_NOMEM;
    for (size_t i = 0; i < n; i++) {
        lf_emitter *of = &emitters->of[i];
        of->square =
            (lf_emitter_square){.first = emitters->n_cells,
                                .density = emitters->density + i * LF_EMITTER_CELLS,
                                .cumulative = emitters->cell_sums + i * (LF_EMITTER_CELLS + 1),
                                .prior = emitters->prior + i * LF_EMITTER_CELLS,
                                .lobe = of->light->environment ? &of->lobe : NULL};
        emitters->n_cells += LF_EMITTER_CELLS;
        if (of->light->environment)
            lf_emitter_square_place(&of->square, emitters->scene, of->lobe.axis,
                                    of->lobe.least_cosine);
        else
            lf_emitter_square_place(&of->square, emitters->scene,
                                    lf_scale(of->light->direction, -1.0f),
                                    1.0f - of->light->versine);
    }
    return LF_OK;
}

lf_status lf_emitters_init(lf_emitters *emitters, const lf_scene *scene)
{
    *emitters = (lf_emitters){.scene = scene};
    if (!(scene->bounds.max.x >= scene->bounds.min.x))
        return LF_OK;
    lf_status status = find_starts(emitters);
    if (status == LF_OK && emitters->n > 0)
        status = set_shares(emitters);
    if (status == LF_OK && emitters->n > 0)
        status = place_squares(emitters);
    if (status != LF_OK || emitters->n == 0)
        lf_emitters_finish(emitters);
    return status;
}

void lf_emitters_finish(lf_emitters *emitters)
{
    for (int i = 0; i < emitters->n; i++)
        lf_sky_lobe_finish(&emitters->of[i].lobe);
    lf_free(emitters->of);
    lf_free(emitters->cumulative);
    lf_free(emitters->first);
    lf_free(emitters->density);
    lf_free(emitters->cell_sums);
    lf_free(emitters->prior);
    *emitters = (lf_emitters){0};
}

const lf_light *lf_emitters_draw(const lf_emitters *emitters, const float u[LF_EMITTER_NUMBERS],
                                 lf_emitted *out, int *out_cell)
{
    float rest;
    const lf_emitter *of =
        &emitters->of[lf_cdf_find(emitters->cumulative, emitters->n, u[0], &rest)];
    const lf_light *light = of->light;
    *out = (lf_emitted){.cell = -1};
    *out_cell = -1;
    if (!(of->share > 0.0f) || !light->kind->emit(emitters->scene, light, &of->square, u + 1, out))
        return NULL;
    out->flux = lf_scale(out->flux, 1.0f / of->share);
    if (out->cell >= 0)
        *out_cell = of->square.first + out->cell;
    return light;
}

static float density_of(const lf_emitters *emitters, const lf_emitter *of, lf_vec3 p, lf_vec3 ng,
                        const lf_light_end *end)
{
    return of->share * fabsf(lf_dot(ng, end->wi)) *
           of->light->kind->emit_density(emitters->scene, of->light, &of->square, p, end);
}

float lf_emitters_density(const lf_emitters *emitters, const lf_light *light, lf_vec3 p, lf_vec3 ng,
                          const lf_light_end *end)
{
    const ptrdiff_t i = light - emitters->scene->lights;
    float sum = 0.0f;
    for (int s = emitters->first[i]; s < emitters->first[i + 1]; s++)
        sum += density_of(emitters, &emitters->of[s], p, ng, end);
    return sum;
}

/* The density of a start, as camera paths see it. */
static float seen_density(const lf_emitters *emitters, const lf_emitter *of, lf_vec3 p, lf_vec3 ng,
                          const lf_light_end *end)
{
    if (!lf_has_fault(emitters, ~0))
        return density_of(emitters, of, p, ng, end);
    if (lf_has_fault(emitters, LF_FAULT_NO_SKY_STARTS) && of->square.lobe)
        return 0.0f;
    lf_emitter seen = *of;
    lf_light even = *of->light;
    if (lf_has_fault(emitters, LF_FAULT_NO_CELL_PDF))
        seen.square.density = NULL;
    if (lf_has_fault(emitters, LF_FAULT_NO_PICTURE_PDF)) {
        even.has_picture = false;
        seen.light = &even;
    }
    return density_of(emitters, &seen, p, ng, end);
}

lf_vec3 lf_emitters_weigh(const lf_emitters *emitters, const lf_light *light, lf_vec3 radiance,
                          float rate, lf_vec3 p, lf_vec3 ng, const lf_light_end *end)
{
    if (light) {
        const ptrdiff_t i = light - emitters->scene->lights;
        float density = 0.0f;
        for (int s = emitters->first[i]; s < emitters->first[i + 1]; s++)
            density += seen_density(emitters, &emitters->of[s], p, ng, end);
        return density > 0.0f ? lf_scale(radiance, 1.0f / (1.0f + rate * density)) : radiance;
    }
    for (int s = 0; s < emitters->n_infinite; s++) {
        const lf_emitter *of = &emitters->of[s];
        if (of->square.lobe && !lf_sky_lobe_near(of->square.lobe, end->wi))
            continue;
        const float density = seen_density(emitters, of, p, ng, end);
        if (!(density > 0.0f))
            continue;
        float pdf;
        const lf_vec3 own = of->light->kind->escape(of->light, end->wi, &pdf);
        if (!(lf_max3(own) > 0.0f))
            continue;
        const float x = rate * density;
        radiance = lf_madd(radiance, 1.0f / (1.0f + x) - 1.0f, own);
    }
    return lf_v3(lf_max(radiance.x, 0.0f), lf_max(radiance.y, 0.0f), lf_max(radiance.z, 0.0f));
}

void lf_emitters_learn(lf_emitters *emitters, const double *second)
{
    for (int s = 0; s < emitters->n_infinite; s++) {
        lf_emitter_square *square = &emitters->of[s].square;
        lf_emitter_square_learn(square, second + square->first);
    }
}
