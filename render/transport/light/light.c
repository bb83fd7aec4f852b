#include "base/alloc.h"
#include "render/transport/light/equiangular.h"
#include "render/transport/light/light_types.h"
#include "render/transport/sampler.h"
#include "render/transport/surface/surface_texture.h"

/* Share of the picks that is uniform over all lights: the power estimate ignores distances and
 * shadows. */
#define EVEN_SHARE 0.2

#define LIST(name) &lf_light_##name,
const lf_light_kind *const lf_light_kinds[] = {LF_LIGHT_KINDS(LIST) NULL};

lf_vec3 lf_light_escape(const lf_scene *scene, lf_vec3 w, float *out_pdf)
{
    lf_vec3 radiance = lf_v3(0.0f, 0.0f, 0.0f);
    float pdf = 0.0f;
    for (int i = 0; i < scene->n_lights_infinite; i++) {
        const lf_light *light = &scene->lights[i];
        float p;
        radiance = lf_add(radiance, light->kind->escape(light, w, &p));
        pdf += light->select * p;
    }
    *out_pdf = pdf;
    return radiance;
}

lf_vec3 lf_light_seen(const lf_scene *scene, lf_vec3 w)
{
    lf_vec3 radiance = lf_v3(0.0f, 0.0f, 0.0f);
    for (int i = 0; i < scene->n_lights_infinite; i++) {
        const lf_light *light = &scene->lights[i];
        float pdf;
        if (!light->hidden)
            radiance = lf_add(radiance, light->kind->escape(light, w, &pdf));
    }
    return radiance;
}

/* u[0] with more digits. It has 24 bits, and picking a light uses some of them, but the light may
 * have millions of triangles. A hash of the other two numbers appends further bits. */
static double refine(const float u[3])
{
    uint64_t others = (uint64_t)(u[1] * 0x1p24f) << 32 | (uint64_t)(u[2] * 0x1p24f);
    return (double)u[0] + (double)(lf_hash64(others, 0) >> 40) * 0x1p-48;
}

/* Picks the first light whose cumulative probability is above *u, which becomes the position of u
 * in the light's interval. */
static const lf_light *pick(const lf_scene *scene, double *u)
{
    int first = 0, count = scene->n_lights;
    while (count > 0) {
        int half = count / 2;
        bool below = (double)scene->lights[first + half].cumulative <= *u;
        first = below ? first + half + 1 : first;
        count = below ? count - half - 1 : half;
    }
    const lf_light *light = &scene->lights[first];
    *u = (*u - (double)(light->cumulative - light->select)) / (double)light->select;
    return light;
}

bool lf_light_draw(const lf_scene *scene, lf_vec3 p, const float u[3], lf_light_sample *out)
{
    if (!lf_scene_has_light_sampling(scene))
        return false;
    double place = scene->n_lights > scene->n_lights_infinite ? refine(u) : (double)u[0];
    const lf_light *light = pick(scene, &place);
    *out = (lf_light_sample){.distance = INFINITY};
    if (!light->kind->draw(scene, light, p, place, u + 1, out))
        return false;
    if (light - scene->lights < scene->n_lights_infinite && !out->delta)
        out->radiance = lf_light_escape(scene, out->wi, &out->pdf);
    else
        out->pdf *= light->select;
    out->light = light;
    return out->pdf > 0.0f;
}

bool lf_light_draw_from(const lf_scene *scene, const lf_light *light, lf_vec3 p, const float u[3],
                        lf_light_sample *out)
{
    if (!light->kind->draw(scene, light, p, refine(u), u + 1, out))
        return false;
    out->pdf *= light->select;
    out->light = light;
    return out->pdf > 0.0f;
}

/* The lights are ordered by kind, mesh and material, in that order. */
const lf_light *lf_light_of_hit(const lf_scene *scene, const lf_hit *hit)
{
    int mesh = (int)(hit->mesh - scene->meshes);
    uint16_t material = (uint16_t)(hit->material - scene->materials);
    int first = scene->n_lights_infinite, count = scene->n_lights - first;
    while (count > 0) {
        int half = count / 2;
        const lf_light *l = &scene->lights[first + half];
        bool below = !lf_light_has_faces(l) || l->mesh < mesh ||
                     (l->mesh == mesh && l->mesh_material < material);
        first = below ? first + half + 1 : first;
        count = below ? count - half - 1 : half;
    }
    return &scene->lights[first];
}

lf_vec3 lf_light_hit(const lf_scene *scene, lf_vec3 from, const lf_hit *hit, float *out_pdf)
{
    *out_pdf = 0.0f;
    if (!(lf_max3(hit->material->emission) > 0.0f) || (hit->material->one_sided && !hit->front))
        return lf_v3(0.0f, 0.0f, 0.0f);
    const lf_light *light = lf_light_of_hit(scene, hit);
    *out_pdf = light->select * light->kind->hit_pdf(light, from, hit);
    return light->has_picture ? lf_hit_emission(hit, 0.0f) : light->radiance;
}

static void make_unit(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; i++)
        v[i] = length > 0.0 ? v[i] / length : i == 1;
}

void lf_light_move(lf_light *light, const double origin[3], double time)
{
    lf_value now[LF_MAX_KEYS];
    for (int i = 0; light->kind->keys[i].name; i++) {
        const lf_value *open = &light->motion->open[i], *close = &light->motion->close[i];
        now[i] = *open;
        for (int j = 0; j < 3; j++)
            now[i].number[j] += time * (close->number[j] - open->number[j]);
        if (light->kind->keys[i].type == LF_PARAM_DIRECTION)
            make_unit(now[i].number);
    }
    light->kind->read(now, origin, light);
    if (light->kind->commit)
        light->kind->commit(light);
}

bool lf_scene_has_light_sampling(const lf_scene *scene)
{
    return scene->n_lights > 0 && scene->lights[scene->n_lights - 1].cumulative > 0.0f;
}

static int rank(const lf_light *light)
{
    int i = 0;
    while (lf_light_kinds[i] != light->kind)
        i++;
    return i;
}

/* A stable sort in place: scenes have few lights, and the mesh lights after them are sorted
 * already. */
static void order_by_kind(lf_scene *scene)
{
    for (int i = 1; i < scene->n_lights; i++) {
        lf_light light = scene->lights[i];
        int j = i;
        for (; j > 0 && rank(&scene->lights[j - 1]) > rank(&light); j--)
            scene->lights[j] = scene->lights[j - 1];
        scene->lights[j] = light;
    }
    scene->n_lights_infinite = 0;
    for (int i = 0; i < scene->n_lights; i++)
        scene->n_lights_infinite += scene->lights[i].kind->escape ? 1 : 0;
}

static double scene_radius(const lf_scene *scene)
{
    lf_vec3 d = lf_sub(scene->bounds.max, scene->bounds.min);
    double radius = d.x >= 0.0f ? 0.5 * (double)lf_length(d) : 0.0;
    return radius > 0.0 ? radius : 1.0;
}

static void set_select(lf_scene *scene)
{
    double total = 0.0, sum = 0.0, radius = scene_radius(scene);
    int lit = 0, last = -1;
    for (int i = 0; i < scene->n_lights; i++) {
        double power = scene->lights[i].kind->power(&scene->lights[i], radius);
        total += power;
        lit += power > 0.0;
        last = power > 0.0 ? i : last;
    }
    float before = 0.0f;
    for (int i = 0; i < scene->n_lights; i++) {
        lf_light *l = &scene->lights[i];
        double power = l->kind->power(l, radius);
        if (power > 0.0)
            sum += (1.0 - EVEN_SHARE) * power / total + EVEN_SHARE / lit;
        l->cumulative = last >= 0 && i >= last ? 1.0f : lf_cumulative_round(sum);
        l->select = l->cumulative - before;
        before = l->cumulative;
    }
}

static lf_traits light_traits(const lf_scene *scene)
{
    lf_traits found = scene->equiangular.n > 0 ? LF_TRAIT_EQUIANGULAR : 0;
    for (int i = 0; i < scene->n_lights; i++) {
        const lf_light *light = &scene->lights[i];
        if (i >= scene->n_lights_infinite)
            found |= LF_TRAIT_AREA_LIGHTS;
        else if (light->environment)
            found |= LF_TRAIT_SKY_PICTURES;
        else if (lf_max3(light->irradiance) > 0.0f)
            found |= LF_TRAIT_SUNS;
    }
    return found;
}

lf_status lf_lights_commit(lf_scene *scene, lf_error *err)
{
    for (int i = 0; i < scene->n_lights; i++)
        if (scene->lights[i].kind->commit)
            scene->lights[i].kind->commit(&scene->lights[i]);
    lf_status status = lf_mesh_lights_append(scene);
    if (status != LF_OK)
        return lf_error_set(err, status, scene->file.where ? scene->file.where : "scene",
                            "out of memory for the lights of emissive meshes");
    order_by_kind(scene);
    set_select(scene);
    lf_equiangular_commit(scene);
    scene->traits |= light_traits(scene);
    return LF_OK;
}
