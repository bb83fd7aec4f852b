/* B and q: light that is known without sampling paths. A fan of one ray per view passes through one
 * film point of each pixel column. Its rays share y and z steps, so one march gives the
 * transmittance to all views' pixels in that column (docs/developer/estimators.md, "6. Optical
 * depth to all views"). */
#include <string.h>

#include "render/rows/extinction.h"
#include "render/rows/outlines.h"
#include "render/rows/prefix_factor.h"
#include "render/transport/light/light_kind.h"
#include "render/transport/path/sunlight.h"
#include "render/transport/surface/surface_texture.h"

/* The triangle of a segment, cached in one of n faces. */
static const lf_fan_face *face_in(const lf_visit *visit, const lf_row_cut *cut, lf_fan_face *faces,
                                  int n, int segment)
{
    lf_fan_face *face = &faces[segment % n];
    /* if rays replace segments, a fan numbers its hits by its lanes */
    if (face->segment != segment || cut->section->rays.on) {
        face->segment = segment;
        lf_section_face(cut, segment, &face->face);
        if (visit->plan->order.sunlight)
            lf_sunlight_face_init(&face->sunlight, visit->plan->order.sunlight, face->face.n);
        if (visit->sums.albedo)
            lf_face_albedo_init(&face->albedo, &face->face);
    }
    return face;
}

static const lf_fan_face *face_of(const lf_visit *visit, int segment)
{
    lf_scratch *w = visit->worker;
    const lf_row_cut section = lf_visit_section(visit);
    return face_in(visit, &section, w->met.face, LF_FAN_FACES, segment);
}

/* The point of ray k at depth z. */
static lf_vec3 place_of(const lf_visit *visit, int k, float z, lf_vec3 *out_along)
{
    const lf_scratch *w = visit->worker;
    *out_along = lf_rig_direction(visit->rig, w->slope[k], visit->plane.my, 1.0f);
    return lf_madd(lf_rig_point(visit->rig, w->x0[k], visit->plane.ly, 0.0f), z, *out_along);
}

/* The hit of ray k on a surface at depth z. */
static void hit_of(const lf_visit *visit, int k, float z, const lf_fan_face *face,
                   lf_vec3 *out_along, lf_hit *out)
{
    const lf_vec3 p = place_of(visit, k, z, out_along);
    lf_face_hit(&face->face, p, *out_along, out);
    if (lf_has(visit->scene, LF_TRAIT_VARYING) && lf_is_varied(out->mesh, out->material))
        lf_hit_vary(out, lf_rig_spread(visit->rig) * z);
}

/* Whether ray k sees the back of the surface that it meets. */
static bool meets_back(const lf_visit *visit, int k)
{
    const lf_scratch *w = visit->worker;
    lf_face face;
    const lf_row_cut section = lf_visit_section(visit);
    lf_section_face(&section, w->met.segment[k], &face);
    return lf_dot(face.n, lf_rig_direction(visit->rig, w->slope[k], visit->plane.my, 1.0f)) > 0.0f;
}

static lf_vec3 emission_of(const lf_visit *visit, int k, const lf_material *material)
{
    lf_hit hit;
    lf_vec3 along;
    if (material->one_sided && meets_back(visit, k))
        return lf_v3(0.0f, 0.0f, 0.0f);
    if (!(material->textures || material->tint == LF_TINT_ALL) ||
        !(lf_max3(material->emission) > 0.0f))
        return material->emission;
    const lf_scratch *w = visit->worker;
    hit_of(visit, k, w->z_end[k], face_of(visit, w->met.segment[k]), &along, &hit);
    return lf_hit_material(&hit)->emission;
}

/* Stores the known light of one ray, including volume emission along it, and its pivot probability.
 * material: of the surface that it meets, NULL: none. q_medium: fraction of light lost in media,
 * along the whole ray or up to the surface; transmittance: the remainder. sky: the light behind,
 * NULL: look it up. */
static void write_known(const lf_visit *visit, size_t pixel, int k, const lf_material *material,
                        float q_medium, lf_vec3 transmittance, const lf_vec3 *sky)
{
    const lf_scratch *worker = visit->worker;
    float q;
    lf_vec3 light;
    q = material && material->has_lobe ? 1.0f : q_medium;
    lf_film_pivots(&visit->sums, pixel, q);
    if (worker->mirrors)
        worker->mirrors[pixel] = material && lf_has_mirror(material);
    if (!visit->sums.known)
        return;
    if (material) {
        light = emission_of(visit, k, material);
    } else if (sky) {
        light = *sky;
    } else {
        lf_vec3 w = lf_rig_direction(visit->rig, worker->slope[k], visit->plane.my, 1.0f);
        light = lf_light_seen(visit->scene, lf_normalize(w));
    }
    light = lf_mul(light, transmittance);
    if (worker->emission.emissive.n_here > 0)
        light = lf_add(light, worker->emission.light[k]);
    lf_film_known_light(&visit->sums, pixel, light.x, light.y, light.z);
}

/* Sunlight that a surface reflects to ray k at depth z, in scenes with sunlight. */
static float sunlight_of(const lf_visit *visit, int k, float z, const lf_fan_face *face)
{
    const lf_sunlight *sunlight = visit->plan->order.sunlight;
    lf_hit hit;
    lf_vec3 along;
    if (!lf_sunlight_has_suns(sunlight)) {
        const lf_vec3 p = place_of(visit, k, z, &along);
        return lf_sunlight_of_sky(sunlight, lf_face_normal(&face->face, p, along),
                                  face->face.material);
    }
    hit_of(visit, k, z, face, &along, &hit);
    return lf_sunlight_reflected(sunlight, &face->sunlight, &hit,
                                 lf_scale(along, -1.0f / visit->worker->length[k]));
}

/* The point where another ray through ray k's pixel meets the plane of ray k's surface at depth z.
 * off: slope difference of the other ray. For a grazing face ray k's own point is used. */
static lf_vec3 beside_at(const lf_visit *visit, int k, float z, const lf_face *face,
                         const float off[2])
{
    const float grazing = 0.05f;
    const lf_scratch *w = visit->worker;
    const lf_vec3 along = lf_rig_direction(visit->rig, w->slope[k], visit->plane.my, 1.0f),
                  o = lf_rig_point(visit->rig, w->x0[k], visit->plane.ly, 0.0f),
                  other = lf_rig_direction(visit->rig, w->slope[k] + off[0],
                                           visit->plane.my + off[1], 1.0f);
    const float across = lf_dot(face->n, other);
    if (!(fabsf(across) > grazing * w->length[k]))
        return lf_madd(o, z, along);
    return lf_madd(o, lf_dot(face->n, lf_sub(face->a, o)) / across, other);
}

static void albedo_at(const lf_visit *visit, int k, float z, const lf_fan_face *face,
                      const float off[2], float out[LF_ALBEDO_NUMBERS])
{
    lf_face_albedo_at(&face->albedo, &face->face, beside_at(visit, k, z, &face->face, off),
                      lf_rig_spread(visit->rig) * z, out);
}

/* Albedo for light that is not from surfaces: scattering by media is smooth. */
static const float no_albedo[LF_ALBEDO_NUMBERS] = {1.0f, 1.0f, 1.0f, 0.0f};

static void mix_albedo(float albedo[LF_ALBEDO_NUMBERS], const float other[LF_ALBEDO_NUMBERS],
                       float share)
{
    for (int c = 0; c < LF_ALBEDO_NUMBERS; c++)
        albedo[c] += share * (other[c] - albedo[c]);
}

/* Albedo of the surface that ray k meets, weighted by the share that media do not hide, and of the
 * alpha surfaces in front of it, weighted by their visible share. */
static void write_albedo(const lf_visit *visit, size_t pixel, int k, float surface, float alphas,
                         const float off[2])
{
    const lf_scratch *w = visit->worker;
    float albedo[LF_ALBEDO_NUMBERS], met[LF_ALBEDO_NUMBERS];
    memcpy(albedo, no_albedo, sizeof albedo);
    if (surface > 0.0f) {
        albedo_at(visit, k, w->z_end[k], face_of(visit, w->met.segment[k]), off, met);
        mix_albedo(albedo, met, surface);
    }
    if (alphas > 0.0f)
        mix_albedo(albedo, w->alpha.seen[k].albedo, alphas);
    lf_film_note_albedo(&visit->sums, pixel, albedo);
}

/* ---------------------------------------------------------------------------------- features -- */

/* A smaller visible share of a surface does not justify looking up its light. */
#define LEAST_SEEN 1e-3f

/* Adds one alpha surface at depth z to the features of ray k; share: of the ray. */
static void see_alpha(const lf_unscattered *e, int k, int segment, float z, float share,
                      const float off[2], lf_alpha_seen *out)
{
    lf_scratch *w = e->visit->worker;
    const lf_row_cut alphas = lf_visit_alphas(e->visit);
    const bool sun = e->visit->plan->order.sunlight, albedo = e->visit->sums.albedo;
    float met[LF_ALBEDO_NUMBERS];
    const float nearness = lf_nearness(e->visit->rig->distance, z);
    memcpy(met, no_albedo, sizeof met);
    if (segment >= 0 && (sun || albedo)) {
        const lf_fan_face *face =
            face_in(e->visit, &alphas, w->alpha.face, LF_ALPHA_FACES, segment);
        const bool thin = face->face.material->glass.is_thin;
        if (thin) /* counts in q and W, and sends no light */
            memset(met, 0, sizeof met);
        else if (albedo)
            albedo_at(e->visit, k, z, face, off, met);
        if (sun && !thin)
            out->light += share * sunlight_of(e->visit, k, z, face);
    }
    out->cover += share;
    const float part = share / out->cover, apart = nearness - out->nearness;
    mix_albedo(out->albedo, met, part);
    out->nearness += part * apart;
    out->spread = sqrtf((1.0f - part) * (out->spread * out->spread + part * (apart * apart)));
}

/* The alpha surfaces that ray k crosses, ignoring media among them. */
static void see_alphas(const lf_unscattered *e, int k, const float off[2])
{
    const lf_alpha_crossings *ray = &e->visit->worker->alpha.walk.ray[k];
    lf_alpha_seen *out = &e->visit->worker->alpha.seen[k];
    memset(out, 0, sizeof *out);
    out->left = 1.0f;
    for (int i = 0; i < ray->n; i++) {
        const float share = out->left * (1.0f - ray->passes[i]);
        out->left *= ray->passes[i];
        if (share > LEAST_SEEN)
            see_alpha(e, k, ray->segment[i], ray->z[i], share, off, out);
    }
    out->light /= out->cover > 0.0f ? out->cover : 1.0f;
}

/* Adds alpha surfaces in front of a feature with known q; returns their share of all pivots. */
static float add_alphas(const lf_alpha_seen *alphas, float q, lf_feature *feature)
{
    const float behind = alphas->left * q;
    if (!(alphas->cover > 0.0f))
        return 0.0f;
    if (!(behind > 0.0f)) {
        *feature = (lf_feature){alphas->nearness, alphas->spread, 1.0f, alphas->light};
        return 1.0f;
    }
    const float part = alphas->cover / (alphas->cover + behind),
                apart = alphas->nearness - feature->nearness;
    feature->spread = sqrtf(part * alphas->spread * alphas->spread +
                            (1.0f - part) * (feature->spread * feature->spread) +
                            part * (1.0f - part) * (apart * apart));
    feature->nearness += part * apart;
    feature->surface += part * (1.0f - feature->surface);
    feature->light += part * (alphas->light - feature->light);
    return part;
}

/* The feature of one ray with known q: a medium, or a surface behind it. */
static void write_feature(const lf_unscattered *e, size_t pixel, int k, bool lobe,
                          const float off[2])
{
    const lf_visit *visit = e->visit;
    const lf_scratch *worker = visit->worker;
    const lf_media_moments *m = &worker->met.moments;
    const float medium = lf_min(m->met[k], 1.0f);
    float alphas = 0.0f;
    lf_feature feature = {.nearness = m->nearness[k], .spread = m->spread[k]};
    if (lobe) {
        float wall = lf_nearness(visit->rig->distance, worker->z_end[k]),
              apart = feature.nearness - wall;
        feature.surface = 1.0f - medium;
        feature.spread =
            sqrtf(medium * (feature.spread * feature.spread + feature.surface * (apart * apart)));
        feature.nearness = wall + medium * apart;
        if (feature.surface > LEAST_SEEN && e->visit->plan->order.sunlight)
            feature.light = feature.surface * sunlight_of(visit, k, worker->z_end[k],
                                                          face_of(visit, worker->met.segment[k]));
    }
    const float surface = feature.surface > LEAST_SEEN ? feature.surface : 0.0f;
    if (e->has_alphas)
        alphas = add_alphas(&worker->alpha.seen[k], lobe ? 1.0f : medium, &feature);
    lf_film_note(&visit->sums, pixel, feature);
    if (visit->sums.albedo)
        write_albedo(visit, pixel, k, surface, alphas, off);
}

/* Whether the camera sees another colour in another direction. */
static bool sky_varies(const lf_scene *scene)
{
    const lf_backdrop *b = &scene->backdrop;
    bool varies =
        b->given && (b->top.x != b->bottom.x || b->top.y != b->bottom.y || b->top.z != b->bottom.z);
    for (int i = 0; i < scene->n_lights_infinite && !b->given; i++) {
        const lf_light *light = &scene->lights[i];
        varies = varies || (!light->hidden && light->kind->varies && light->kind->varies(light));
    }
    return varies;
}

bool lf_unscattered_constant(const lf_scene *scene, float out_sky[3])
{
    if (sky_varies(scene))
        return false;
    lf_vec3 sky =
        scene->backdrop.given ? scene->backdrop.top : lf_light_seen(scene, lf_v3(0.0f, 1.0f, 0.0f));
    out_sky[0] = sky.x;
    out_sky[1] = sky.y;
    out_sky[2] = sky.z;
    return true;
}

bool lf_unscattered_sky(const lf_visit *visit, lf_vec3 *out)
{
    const lf_scene *scene = visit->scene;
    float sky[3];
    if (scene->backdrop.given)
        *out = lf_backdrop_at(&scene->backdrop, lf_rig_height_between(visit->rig, visit->plane.my));
    else if (visit->plan->skip & LF_SKIP_KNOWN_LIGHT && lf_unscattered_constant(scene, sky))
        *out = lf_v3(sky[0], sky[1], sky[2]);
    else
        return false;
    return true;
}

bool lf_unscattered_uniform(const lf_scene *scene, float out_sky[3])
{
    if (scene->emissive.n > 0 || lf_has(scene, LF_TRAIT_CHROMATIC_MEDIA))
        return false;
    for (int i = 0; i < scene->n_materials && scene->embree; i++) {
        const lf_material *m = &scene->materials[i];
        if (lf_max3(m->emission) > 0.0f || !m->has_lobe)
            return false;
    }
    for (int i = 0; i < scene->n_lights; i++)
        if (scene->lights[i].motion && scene->lights[i].kind->escape)
            return false;
    return lf_unscattered_constant(scene, out_sky);
}

float lf_unscattered_film_point(uint64_t key, int column, uint32_t index)
{
    return lf_sampler_partner(lf_hash64(key, 0), lf_hash64(lf_hash64(key, 5), (uint64_t)column),
                              index);
}

/* The groups of lanes [*from, *to) that contain all views which can meet anything in this column.
 */
static void lanes_of(const lf_reach *reach, int n_views, int column, int *from, int *to)
{
    int first = n_views, last = -1;
    for (int k = 0; k < n_views; k++) {
        bool in = column >= reach->first[k] && column < reach->end[k];
        first = in && k < first ? k : first;
        last = in ? k : last;
    }
    *from = first / LF_LANES * LF_LANES;
    *to = last < 0 ? *from : (last / LF_LANES + 1) * LF_LANES;
}

/* The fan through one film point of a column, lens offset lx. */
static void aim(const lf_visit *visit, float xw, float lx)
{
    const lf_rig *rig = visit->rig;
    lf_scratch *worker = visit->worker;
    for (int k = 0; k < lf_rig_lanes(rig); k++) {
        worker->x0[k] = rig->b[k] + lx;
        worker->slope[k] = (xw - rig->skew[k]) / rig->distance - lx / rig->focus;
        worker->z_end[k] = INFINITY;
        worker->tau[k] = 0.0f;
        worker->length[k] =
            sqrtf(1.0f + worker->slope[k] * worker->slope[k] + visit->plane.my * visit->plane.my);
        worker->met.moments.met[k] = 0.0f;
        worker->met.moments.nearness[k] = worker->met.moments.spread[k] = 0.0f;
    }
}

/* s of the point in the window through which all rays of a fan pass (for a lens: of the point's
 * image). */
static float meeting(const lf_rig *rig, float xw, float lx)
{
    return xw / rig->distance + lx * (1.0f / rig->window - 1.0f / rig->focus);
}

void lf_unscattered_alphas(const lf_unscattered *e, const lf_unscattered_rays *fan)
{
    lf_scratch *w = e->visit->worker;
    const int from = fan->from;
    const lf_row_cut alphas = lf_visit_alphas(e->visit);
    const bool features = e->visit->sums.feature;
    for (int k = from; k < fan->to; k++)
        w->alpha.mirrored[k] = false;
    lf_alphas_along(&alphas, &fan->lines, w->z_end + from, w->factor + from,
                    w->alpha.mirrored + from, features ? w->alpha.walk.ray + from : NULL);
    for (int k = from; k < fan->to && features; k++)
        see_alphas(e, k, fan->off);
}

/* Volume emission along the fan's rays; u: the jitter. */
static void emission(const lf_visit *visit, const lf_unscattered_rays *fan, float u)
{
    lf_scratch *w = visit->worker;
    const int from = fan->from;
    const bool has_alphas = lf_has(visit->scene, LF_TRAITS_SEEN_THROUGH);
    lf_rays rays = fan->rays;
    rays.channels = false;
    const lf_row_emission sources = {.media = &w->media,
                                     .rays = &rays,
                                     .length = w->length + from,
                                     .corrected = !lf_has_fault(visit, LF_FAULT_NO_CORRECTION),
                                     .alphas = has_alphas ? &w->alpha.walk : NULL};
    if (has_alphas) {
        const lf_row_cut alphas = lf_visit_alphas(visit);
        lf_alphas_begin(&w->alpha.walk, &alphas, &fan->lines, rays.z_end);
    }
    lf_row_emission_fan(&sources, u, &w->tracer, &w->emission, w->emission.light + from);
}

/* The rays of a fan, up to what they meet and through all media before it. */
static void follow(const lf_unscattered *e, int column, const lf_unscattered_rays *fan)
{
    const lf_visit *visit = e->visit;
    const int from = fan->from;
    lf_scratch *w = visit->worker;
    if (visit->triangles) {
        const lf_row_cut section = lf_visit_section(visit);
        lf_section_nearest(&section, &fan->lines, w->z_end + from, w->met.segment + from);
    }
    if (w->media.n_here > 0) {
        w->met.moments.distance = visit->rig->distance;
        w->met.moments.first = from;
        visit->extinction->march(visit, fan);
    }
    for (int k = from; k < fan->to && visit->prefix.along; k++)
        w->factor[k] = 1.0f;
    lf_prefix_along(e, fan);
    if (w->emission.emissive.n_here > 0)
        emission(visit, fan,
                 lf_sampler_radical(lf_hash64(lf_hash64(visit->number.key, 16), (uint64_t)column),
                                    visit->number.index));
}

/* Aims the fan of a column's film point, and finds which of its lanes [first, end) to follow. */
static lf_unscattered_rays begin_fan(const lf_unscattered *e, int column, int first, int end)
{
    const lf_visit *visit = e->visit;
    const lf_rig *rig = visit->rig;
    const lf_visit_number *number = &visit->number;
    const float film = lf_outlines_column(number->key, column, number->index, e->plane),
                xw = rig->x0 + ((float)column + film) * rig->dx;
    float lx = 0.0f;
    if (visit->plane.lens_chord > 0.0f)
        lx = (2.0f * lf_outlines_lens(number->key, column, number->index, e->plane) - 1.0f) *
             visit->plane.lens_chord;
    lf_unscattered_rays fan = {.off = {(e->quarter - film) * rig->dx / rig->distance, e->down}};
    lanes_of(&visit->worker->reach, rig->n_views, column, &fan.from, &fan.to);
    fan.from = fan.from > first ? fan.from : first;
    fan.to = fan.to < end ? fan.to : end;
    fan.rays = lf_visit_rays(visit, fan.from, fan.to);
    fan.lines = (lf_lines){meeting(rig, xw, lx), fan.rays.n, fan.rays.x0};
    aim(visit, xw, lx);
    return fan;
}

void lf_unscattered_fan(const lf_unscattered *e, int column, int first, int end)
{
    const lf_visit *visit = e->visit;
    const lf_rig *rig = visit->rig;
    lf_scratch *w = visit->worker;
    const lf_unscattered_rays fan = begin_fan(e, column, first, end);
    if (w->emission.emissive.n_here > 0)
        memset(w->emission.light, 0, sizeof w->emission.light);
    if (fan.from < fan.to)
        follow(e, column, &fan);
    for (int k = first; k < end && k < rig->n_views; k++) {
        if (e->only && !e->only[k])
            continue;
        bool reached = k >= fan.from && k < fan.to, met = reached && w->met.segment[k] >= 0;
        int material = met ? lf_section_material(&w->section, w->met.segment[k]) : -1;
        const lf_material *m = met ? &visit->scene->materials[material] : NULL;
        size_t pixel = (size_t)k * (size_t)rig->width + (size_t)column;
        lf_vec3 transmittance;
        const float factor = visit->prefix.along && reached ? w->factor[k] : 1.0f,
                    lost = visit->extinction->lost(visit, &fan, k, factor, &transmittance);
        w->met.material[k] = material;
        write_known(visit, pixel, k, m, lost, transmittance, e->constant ? &e->sky : NULL);
        if (e->has_alphas && w->mirrors && reached)
            w->mirrors[pixel] |= w->alpha.mirrored[k];
        if (e->has_alphas && !reached)
            w->alpha.seen[k].cover = 0.0f;
        if (visit->sums.feature)
            write_feature(e, pixel, k, m && m->has_lobe, fan.off);
    }
}
