#include "render/transport/path/sunlight.h"
#include "render/transport/path/path.h"

#include <string.h>

#include "base/alloc.h"
#include "render/transport/light/light_kind.h"
#include "render/transport/light/sky_light.h"
#include "render/transport/path/face_albedo.h"
#include "render/transport/path/sunlight_map.h"
#include "render/transport/path/sunlight_media.h"

enum { TEXELS = 2048, NODES = 160 };

typedef struct star {
    const lf_light *light;
    lf_vec3 toward;
    lf_sunlight_map near, whole; /* near: around small objects; searched first */
    lf_sunlight_media media;
} star;

struct lf_sunlight {
    lf_scene *scene;
    int n;
    lf_sky_light sky; /* n == 0 */
    star stars[LF_SUNLIGHT_LIGHTS];
};

/* ----------------------------------------------------------------------------- make, release -- */

static bool is_sun(const lf_light *light)
{
    return light->kind == &lf_light_distant && lf_max3(light->irradiance) > 0.0f;
}

/* Whether maps can represent the suns. */
static bool has_suns(const lf_scene *scene)
{
    bool found = false;
    for (int i = 0; i < scene->n_lights_infinite; i++)
        found = found || is_sun(&scene->lights[i]);
    return found && !lf_has(scene, LF_TRAIT_INSTANCES);
}

static float grey_of(const lf_material *m)
{
    float albedo[LF_ALBEDO_NUMBERS];
    lf_material_albedo(m, m->albedo, m->metallic, albedo);
    return (albedo[0] + albedo[1] + albedo[2]) * (1.0f / 3.0f);
}

/* Whether surfaces send on more or less by their normal, or by their material. */
static bool sky_tells(const lf_scene *scene)
{
    bool emits = false, varies = false;
    for (int i = 0; i < scene->n_lights_infinite; i++) {
        const lf_light *light = &scene->lights[i];
        const bool sky = lf_max3(light->radiance) > 0.0f;
        emits = emits || sky;
        varies = varies || is_sun(light) || (sky && light->kind->varies(light));
    }
    for (int i = 1; i < scene->n_materials && emits && !lf_has(scene, LF_TRAIT_VARYING_ALBEDO); i++)
        varies = varies || grey_of(&scene->materials[i]) != grey_of(&scene->materials[0]);
    return varies;
}

bool lf_sunlight_needed(const lf_scene *scene)
{
    return scene->n_meshes > 0 && (has_suns(scene) || sky_tells(scene));
}

/* The strongest ones, in the scene's order if equal; returns their number. */
static int choose(const lf_scene *scene, star stars[LF_SUNLIGHT_LIGHTS])
{
    int n = 0;
    for (int i = 0; i < scene->n_lights_infinite && has_suns(scene); i++) {
        const lf_light *light = &scene->lights[i];
        if (!is_sun(light))
            continue;
        int at = n;
        while (at > 0 && lf_mean3(stars[at - 1].light->irradiance) < lf_mean3(light->irradiance))
            at--;
        if (at == LF_SUNLIGHT_LIGHTS)
            continue;
        n += n < LF_SUNLIGHT_LIGHTS;
        for (int k = n - 1; k > at; k--)
            stars[k] = stars[k - 1];
        stars[at] = (star){.light = light, .toward = lf_scale(light->direction, -1.0f)};
    }
    return n;
}

static lf_status make(star *sun, const lf_scene *scene, int texels, lf_pool *pool,
                      const lf_cancel *cancel)
{
    float m = sun->light->versine;
    const lf_sunlight_view view = {.toward = sun->toward,
                                   .spread = sqrtf(m * (2.0f - m)) / lf_max(1.0f - m, 0.1f)};
    lf_status status = lf_sunlight_map_init(&sun->near, scene, &view, texels, true, pool, cancel);
    if (status == LF_OK)
        status = lf_sunlight_map_init(&sun->whole, scene, &view,
                                      sun->near.texels ? texels / 2 : texels, false, pool, cancel);
    if (status == LF_OK)
        status = lf_sunlight_media_init(&sun->media, scene, sun->toward, NODES, pool, cancel);
    return status;
}

lf_status lf_sunlight_create(lf_scene *scene, int texels, lf_pool *pool, const lf_cancel *cancel,
                             lf_sunlight **out)
{
    lf_sunlight *sunlight = lf_calloc(1, sizeof *sunlight);
    lf_status status = LF_OK;
    if (!sunlight)
        return LF_E_NOMEM;
    sunlight->scene = lf_scene_ref(scene);
    sunlight->n = choose(scene, sunlight->stars);
    if (sunlight->n == 0)
        lf_sky_light_init(&sunlight->sky, scene);
    for (int i = 0; i < sunlight->n && status == LF_OK; i++)
        status = make(&sunlight->stars[i], scene, texels > 0 ? texels : TEXELS, pool, cancel);
    if (status == LF_OK)
        *out = sunlight;
    else
        lf_sunlight_destroy(sunlight);
    return status;
}

static bool same_media(const lf_scene *a, const lf_scene *b)
{
    bool same = a->n_volumes == b->n_volumes;
    for (int i = 0; i < a->n_volumes && same; i++) {
        const lf_volume *v = &a->volumes[i], *w = &b->volumes[i];
        same = v->kind == w->kind && v->grid == w->grid && v->nearest == w->nearest &&
               v->sigma_scale == w->sigma_scale &&
               memcmp(v->to_volume, w->to_volume, sizeof v->to_volume) == 0;
    }
    return same;
}

bool lf_sunlight_adopt(lf_sunlight *sunlight, lf_scene *scene)
{
    lf_scene *own = sunlight->scene;
    lf_sunlight other;
    if (own == scene)
        return true;
    other.n = choose(scene, other.stars);
    bool same = other.n > 0 && own->geometry == scene->geometry && sunlight->n == other.n &&
                memcmp(own->origin, scene->origin, sizeof own->origin) == 0 &&
                same_media(own, scene);
    for (int i = 0; i < other.n && same; i++) {
        const lf_light *a = sunlight->stars[i].light, *b = other.stars[i].light;
        same = a->direction.x == b->direction.x && a->direction.y == b->direction.y &&
               a->direction.z == b->direction.z && a->versine == b->versine;
    }
    if (!same)
        return false;
    for (int i = 0; i < sunlight->n; i++) {
        sunlight->stars[i].light = other.stars[i].light;
        sunlight->stars[i].media.scene = scene;
    }
    sunlight->scene = lf_scene_ref(scene);
    lf_scene_unref(own);
    return true;
}

void lf_sunlight_destroy(lf_sunlight *sunlight)
{
    if (!sunlight)
        return;
    for (int i = 0; i < sunlight->n; i++) {
        lf_sunlight_map_finish(&sunlight->stars[i].near);
        lf_sunlight_map_finish(&sunlight->stars[i].whole);
        lf_sunlight_media_finish(&sunlight->stars[i].media);
    }
    lf_scene_unref(sunlight->scene);
    lf_free(sunlight);
}

/* ---------------------------------------------------------------------------------- look-ups -- */

void lf_sunlight_face_init(lf_sunlight_face *face, const lf_sunlight *sunlight, lf_vec3 n)
{
    for (int i = 0; i < sunlight->n; i++) {
        face->slope[i][0] = lf_sunlight_map_slope(&sunlight->stars[i].near, n);
        face->slope[i][1] = lf_sunlight_map_slope(&sunlight->stars[i].whole, n);
    }
}

/* For a surface that faces the light. */
static float share_of(const star *sun, const lf_sunlight_slope slope[2], lf_vec3 p)
{
    float share = sun->near.texels ? lf_sunlight_map_share(&sun->near, p, &slope[0]) : -1.0f;
    if (share < 0.0f)
        share = lf_sunlight_map_share(&sun->whole, p, &slope[1]);
    if (share < 0.0f)
        share = 1.0f;
    return share > 0.0f && sun->media.scene->n_volumes > 0
               ? share * expf(-lf_sunlight_media_depth(&sun->media, p))
               : share;
}

bool lf_sunlight_share(const lf_sunlight *sunlight, int i, lf_vec3 p, lf_vec3 n, float *out_share,
                       const lf_light **out_light)
{
    if (i < 0 || i >= sunlight->n)
        return false;
    lf_sunlight_face face;
    lf_sunlight_face_init(&face, sunlight, n);
    *out_share = lf_dot(n, sunlight->stars[i].toward) > 0.0f
                     ? share_of(&sunlight->stars[i], face.slope[i], p)
                     : 0.0f;
    *out_light = sunlight->stars[i].light;
    return true;
}

float lf_sunlight_of_sky(const lf_sunlight *sunlight, lf_vec3 n, const lf_material *material)
{
    const float white = lf_sky_light_white(&sunlight->sky, n);
    return lf_has(sunlight->scene, LF_TRAIT_VARYING_ALBEDO) ? white : white * grey_of(material);
}

float lf_sunlight_reflected(const lf_sunlight *sunlight, const lf_sunlight_face *face,
                            const lf_hit *hit, lf_vec3 wo)
{
    const lf_material *material = lf_hit_material(hit);
    float sum = 0.0f;
    if (sunlight->n == 0)
        return lf_sunlight_of_sky(sunlight, hit->ns, material);
    for (int i = 0; i < sunlight->n; i++) {
        const star *sun = &sunlight->stars[i];
        lf_vec3 f;
        if (!(lf_dot(hit->ng, sun->toward) > 0.0f))
            continue;
        if (lf_hit_bent_normal(hit))
            (void)lf_hit_eval_folded(hit, wo, sun->toward, &f);
        else
            (void)material->kind->eval(material, hit->ns, wo, sun->toward, &f);
        float reflected = lf_mean3(lf_mul(f, sun->light->irradiance));
        if (reflected > 0.0f)
            sum += reflected * share_of(sun, face->slope[i], hit->p);
    }
    return sum;
}

bool lf_sunlight_has_suns(const lf_sunlight *sunlight)
{
    return sunlight->n > 0;
}

float lf_sunlight_mean(const lf_scene *scene)
{
    lf_sky_light sky;
    if (!lf_sunlight_needed(scene) || has_suns(scene))
        return 0.0f;
    lf_sky_light_init(&sky, scene);
    return lf_sky_light_mean(&sky);
}
