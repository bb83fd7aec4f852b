/* The triangles of one mesh with one emissive material. One of them is drawn by its area. The point
 * is uniform over its solid angle or, if it appears small, over its area (spherical.h). */
#include <string.h>

#include "base/alloc.h"
#include "render/transport/light/light_tree.h"
#include "render/transport/light/light_types.h"
#include "render/transport/light/spherical.h"
#include "render/transport/surface/surface_texture.h"

/* Minimum number of triangles of an area light for a tree: a sphere has them, a disk does not. */
#define LEAST_FOR_TREE 512

static lf_vec3 vertex(const lf_mesh *mesh, uint32_t triangle, int corner)
{
    return lf_mesh_vertex(mesh, mesh->triangles[3 * (size_t)triangle + (size_t)corner]);
}

static lf_vec3 twice_area(const lf_mesh *mesh, uint32_t triangle)
{
    lf_vec3 a = vertex(mesh, triangle, 0);
    return lf_cross(lf_sub(vertex(mesh, triangle, 1), a), lf_sub(vertex(mesh, triangle, 2), a));
}

/* Per unit solid angle, of a point at d with normal ng that is drawn evenly from an area. */
static float pdf_of(lf_vec3 d, lf_vec3 ng, float area)
{
    float distance2 = lf_dot(d, d), cosine = fabsf(lf_dot(ng, d)) / sqrtf(distance2),
          k = area * cosine;
    return k > 0.0f ? distance2 / k : 0.0f;
}

static bool see(const lf_mesh *mesh, uint32_t triangle, lf_vec3 from, lf_spherical *out)
{
    return lf_spherical_init(out, from, vertex(mesh, triangle, 0), vertex(mesh, triangle, 1),
                             vertex(mesh, triangle, 2));
}

/* The probability of choosing a triangle of the light. */
static float share_of(const lf_light *light, uint32_t triangle)
{
    int first = 0, count = light->n_triangles;
    while (count > 1) {
        int half = count / 2;
        bool above = light->triangle[first + half] <= triangle;
        first = above ? first + half : first;
        count = above ? count - half : half;
    }
    return (float)(light->area_cdf[first + 1] - light->area_cdf[first]);
}

/* pdf if triangles are not chosen only by their current area: by emission, by a tree, or by their
 * area at shutter open. A light with a tree has all triangles of its mesh. */
static float chosen_pdf(const lf_light *light, lf_vec3 from, const lf_hit *hit)
{
    lf_spherical seen;
    float share = light->tree ? lf_light_tree_probability(light, from, (int)hit->triangle)
                              : share_of(light, hit->triangle);
    if (see(hit->mesh, hit->triangle, from, &seen))
        return share / (float)seen.solid_angle;
    return share * pdf_of(lf_sub(hit->p, from), hit->ng,
                          0.5f * lf_length(twice_area(hit->mesh, hit->triangle)));
}

static float hit_pdf(const lf_light *light, lf_vec3 from, const lf_hit *hit)
{
    lf_spherical seen;
    if (light->has_picture || light->tree || hit->mesh->close.vertices)
        return chosen_pdf(light, from, hit);
    if (see(hit->mesh, hit->triangle, from, &seen))
        return 0.5f * lf_length(twice_area(hit->mesh, hit->triangle)) /
               (light->area * (float)seen.solid_angle);
    /* A triangle is chosen in proportion to its area: the point is uniform over the whole light. */
    return pdf_of(lf_sub(hit->p, from), hit->ng, light->area);
}

uint32_t lf_mesh_light_choose(const lf_light *light, double place, float *out_probability)
{
    const double *cdf = light->area_cdf;
    int first = 0, count = light->n_triangles;
    while (count > 1) {
        int half = count / 2;
        bool above = cdf[first + half] <= place;
        first = above ? first + half : first;
        count = above ? count - half : half;
    }
    *out_probability = (float)(cdf[first + 1] - cdf[first]);
    return light->triangle[first];
}

/* Barycentric coordinates of the point where the direction w from p meets a triangle that it hits.
 */
static void meet(const lf_mesh *mesh, uint32_t triangle, lf_vec3 p, const double w[3], float *b1,
                 float *b2)
{
    lf_vec3 a = vertex(mesh, triangle, 0), ab = lf_sub(vertex(mesh, triangle, 1), a),
            ac = lf_sub(vertex(mesh, triangle, 2), a);
    lf_vec3 s = lf_sub(p, a), q = lf_cross(s, ab), d = lf_v3((float)w[0], (float)w[1], (float)w[2]),
            h = lf_cross(d, ac);
    float inverse = 1.0f / lf_dot(ab, h);
    *b1 = lf_min(lf_max(lf_dot(s, h) * inverse, 0.0f), 1.0f);
    *b2 = lf_min(lf_max(lf_dot(d, q) * inverse, 0.0f), 1.0f - *b1);
}

static lf_hit point_at(const lf_scene *scene, const lf_mesh *mesh, uint32_t triangle, float u,
                       float v)
{
    return (lf_hit){.mesh = mesh,
                    .triangle = triangle,
                    .u = u,
                    .v = v,
                    .material = &scene->materials[lf_mesh_material(mesh, triangle)]};
}

static lf_vec3 emission_at(const lf_scene *scene, const lf_mesh *mesh, uint32_t triangle, float u,
                           float v, float width)
{
    const lf_hit hit = point_at(scene, mesh, triangle, u, v);
    return lf_hit_emission(&hit, width);
}

/* The radiance of a point of the light: of an alpha surface its share, as rays find it. */
static lf_vec3 radiance_at(const lf_scene *scene, const lf_light *light, uint32_t triangle, float u,
                           float v)
{
    const lf_mesh *mesh = &scene->meshes[light->mesh];
    const lf_vec3 radiance =
        light->has_picture ? emission_at(scene, mesh, triangle, u, v, 0.0f) : light->radiance;
    if (!lf_has(scene, LF_TRAIT_ALPHA))
        return radiance;
    const lf_hit hit = point_at(scene, mesh, triangle, u, v);
    return lf_is_alpha_surface(hit.material) ? lf_scale(radiance, lf_hit_cover(&hit, 0.0f))
                                             : radiance;
}

static bool draw(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place,
                 const float u[2], lf_light_sample *out)
{
    const lf_mesh *mesh = &scene->meshes[light->mesh];
    float probability, root = sqrtf(u[0]), b1 = root * (1.0f - u[1]), b2 = root * u[1];
    int chosen = light->tree ? lf_light_tree_choose(light, p, place, &probability) : 0;
    if (chosen < 0)
        return false;
    uint32_t triangle =
        light->tree ? light->triangle[chosen] : lf_mesh_light_choose(light, place, &probability);
    lf_spherical seen;
    bool large = see(mesh, triangle, p, &seen);
    if (large) {
        double w[3];
        lf_spherical_draw(&seen, u, w);
        meet(mesh, triangle, p, w, &b1, &b2);
    }
    lf_vec3 cross = twice_area(mesh, triangle), q = lf_mesh_point(mesh, triangle, b1, b2);
    lf_vec3 d = lf_sub(q, p);
    float distance = lf_length(d), size = lf_length(cross);
    if (!(size > 0.0f) || !(distance > 0.0f))
        return false;
    lf_vec3 n = lf_scale(cross, 1.0f / size);
    if (light->one_sided && lf_dot(n, d) > 0.0f)
        return false;
    float pdf = probability * (large ? 1.0f / (float)seen.solid_angle : pdf_of(d, n, 0.5f * size));
    *out = (lf_light_sample){.wi = lf_scale(d, 1.0f / distance),
                             .distance = distance,
                             .point = q,
                             .normal = n,
                             .radiance = radiance_at(scene, light, triangle, b1, b2),
                             .pdf = pdf,
                             .mesh = mesh,
                             .triangle = triangle};
    return pdf > 0.0f && pdf < INFINITY;
}

static double power(const lf_light *light, double radius)
{
    (void)radius;
    double sides = light->one_sided ? 1.0 : 2.0;
    return sides * (double)LF_PI * (double)light->area * (double)lf_mean3(light->radiance);
}

static void extent(const lf_scene *scene, const lf_light *light, lf_vec3 *out_middle,
                   float *out_radius)
{
    const lf_mesh *mesh = &scene->meshes[light->mesh];
    lf_vec3 min = lf_v3(INFINITY, INFINITY, INFINITY), max = lf_scale(min, -1.0f);
    for (int i = 0; i < 3 * light->n_triangles; i++) {
        lf_vec3 v = vertex(mesh, light->triangle[i / 3], i % 3);
        min = lf_v3(lf_min(min.x, v.x), lf_min(min.y, v.y), lf_min(min.z, v.z));
        max = lf_v3(lf_max(max.x, v.x), lf_max(max.y, v.y), lf_max(max.z, v.z));
    }
    *out_middle = lf_scale(lf_add(min, max), 0.5f);
    *out_radius = 0.5f * lf_length(lf_sub(max, min));
}

/* In proportion to the cosine, and even over the area; with a picture even over a triangle, which
 * is chosen by its emission. */
static bool emit(const lf_scene *scene, const lf_light *light, const lf_emitter_square *square,
                 const float u[6], lf_emitted *out)
{
    (void)square;
    const lf_mesh *mesh = &scene->meshes[light->mesh];
    const float root = sqrtf(u[1]), sides = light->one_sided ? 1.0f : 2.0f;
    /* further digits for the choice among many triangles */
    const double place = (double)u[0] + (double)u[5] * 0x1p-24;
    float probability;
    out->mesh = mesh;
    out->triangle = lf_mesh_light_choose(light, place, &probability);
    const lf_vec3 cross = twice_area(mesh, out->triangle);
    const float size = lf_length(cross);
    if (!(size > 0.0f))
        return false;
    const float b1 = root * (1.0f - u[2]), b2 = root * u[2];
    out->p = lf_mesh_point(mesh, out->triangle, b1, b2);
    const bool behind = !light->one_sided && u[5] >= 0.5f;
    out->normal = lf_scale(cross, (behind ? -1.0f : 1.0f) / size);
    lf_vec3 t, b;
    lf_tangents(out->normal, &t, &b);
    const float r = sqrtf(u[3]), phi = 2.0f * LF_PI * u[4];
    out->w =
        lf_from_frame(t, b, out->normal, lf_v3(r * cosf(phi), r * sinf(phi), sqrtf(1.0f - u[3])));
    out->flux =
        lf_scale(radiance_at(scene, light, out->triangle, b1, b2),
                 LF_PI * sides * (light->has_picture ? 0.5f * size / probability : light->area));
    return true;
}

static float emit_density(const lf_scene *scene, const lf_light *light,
                          const lf_emitter_square *square, lf_vec3 p, const lf_light_end *end)
{
    (void)square, (void)p;
    const float sides = light->one_sided ? 1.0f : 2.0f;
    if (!light->has_picture)
        return 1.0f / (LF_PI * light->area * sides);
    const float twice = lf_length(twice_area(&scene->meshes[light->mesh], end->triangle));
    return twice > 0.0f ? share_of(light, end->triangle) / (LF_PI * 0.5f * twice * sides) : 0.0f;
}

const lf_light_kind lf_light_mesh = {
    .name = "mesh",
    .draw = draw,
    .power = power,
    .extent = extent,
    .hit_pdf = hit_pdf,
    .emit = emit,
    .emit_density = emit_density,
};

static int count_triangles(const lf_mesh *mesh, uint16_t material)
{
    int n = 0;
    for (int i = 0; i < mesh->n_triangles; i++)
        n += lf_mesh_material(mesh, (uint32_t)i) == material;
    return n;
}

/* Fills the light's triangles and areas; a mesh without area is left without power and so never
 * picked. */
static lf_status mesh_light_init(lf_light *light, const lf_mesh *mesh, int n_triangles)
{
    light->n_triangles = n_triangles;
    light->triangle = lf_calloc((size_t)n_triangles, sizeof *light->triangle);
    light->area_cdf = lf_calloc((size_t)n_triangles + 1, sizeof *light->area_cdf);
    if (!light->triangle || !light->area_cdf)
        return LF_E_NOMEM;
    double total = 0.0, sum = 0.0;
    int n = 0, last = 0;
    for (int i = 0; i < mesh->n_triangles; i++) {
        if (lf_mesh_material(mesh, (uint32_t)i) != light->mesh_material)
            continue;
        double area = 0.5 * (double)lf_length(twice_area(mesh, (uint32_t)i));
        last = area > 0.0 ? n : last;
        light->triangle[n++] = (uint32_t)i;
        total += area;
    }
    for (int i = 0; i < n; i++) {
        sum += 0.5 * (double)lf_length(twice_area(mesh, light->triangle[i]));
        light->area_cdf[i + 1] = i >= last ? 1.0 : sum / total;
    }
    light->area = (float)total;
    if (!light->one_sided || n < LEAST_FOR_TREE || n < mesh->n_triangles)
        return LF_OK;
    light->tree = lf_light_tree_make(light, mesh);
    return light->tree ? LF_OK : LF_E_NOMEM;
}

/* Weights triangles by their total emission instead of only their area; dark ones are rarely
 * chosen. */
static void weigh_by_picture(lf_light *light, const lf_scene *scene)
{
    const lf_mesh *mesh = &scene->meshes[light->mesh];
    double total = 0.0, *cdf = light->area_cdf;
    lf_vec3 mean = {0}, factor = light->radiance;
    for (int i = 0; i < light->n_triangles; i++) {
        float area = 0.5f * lf_length(twice_area(mesh, light->triangle[i]));
        lf_vec3 e =
            emission_at(scene, mesh, light->triangle[i], 1.0f / 3.0f, 1.0f / 3.0f, sqrtf(area));
        mean = lf_madd(mean, area / light->area, e);
        total += (double)area * fmax((double)lf_mean3(e), 1e-3 * (double)lf_mean3(factor));
        cdf[i + 1] = total;
    }
    for (int i = 0; i < light->n_triangles; i++)
        cdf[i + 1] = total > 0.0 ? cdf[i + 1] / total : 1.0;
    light->radiance = mean;
    light->has_picture = true;
}

static lf_status append_one(lf_scene *scene, int mesh, uint16_t material, int n_triangles)
{
    lf_light *grown = lf_calloc((size_t)scene->n_lights + 1, sizeof *grown);
    if (!grown)
        return LF_E_NOMEM;
    if (scene->n_lights > 0)
        memcpy(grown, scene->lights, (size_t)scene->n_lights * sizeof *grown);
    lf_free(scene->lights);
    scene->lights = grown;
    lf_light *light = &scene->lights[scene->n_lights++];
    light->kind = &lf_light_mesh;
    light->mesh = mesh;
    light->mesh_material = material;
    light->radiance = scene->materials[material].emission;
    light->one_sided = scene->materials[material].one_sided;
    lf_status status = mesh_light_init(light, &scene->meshes[mesh], n_triangles);
    const lf_textures *textures = scene->materials[material].textures;
    bool varies = (textures && textures->pyramid[LF_SLOT_EMISSION]) ||
                  (scene->materials[material].tint == LF_TINT_ALL && scene->meshes[mesh].colours);
    if (status == LF_OK && varies && light->area > 0.0f)
        weigh_by_picture(light, scene);
    return status;
}

lf_status lf_mesh_lights_append(lf_scene *scene)
{
    for (int i = 0; i < scene->n_meshes; i++) {
        for (int m = 0; m < scene->n_materials; m++) {
            int n = lf_max3(scene->materials[m].emission) > 0.0f
                        ? count_triangles(&scene->meshes[i], (uint16_t)m)
                        : 0;
            lf_status status = n > 0 ? append_one(scene, i, (uint16_t)m, n) : LF_OK;
            if (status != LF_OK)
                return status;
        }
    }
    return LF_OK;
}
