#include "render/transport/surface/surface_texture.h"

#include "render/transport/surface/instance_hit.h"

/* The triangle's corners and the point's position between them. */
typedef struct place {
    const lf_hit *hit;
    const lf_mesh *mesh;
    const uint32_t *corner;
    float weight[3];
} place;

static place place_of(const lf_hit *hit)
{
    return (place){.hit = hit,
                   .mesh = hit->mesh,
                   .corner = hit->mesh->triangles + 3 * (size_t)hit->triangle,
                   .weight = {1.0f - hit->u - hit->v, hit->u, hit->v}};
}

/* For arrays [n_vertices][n]. */
static void interpolate(const place *at, const float *values, int n, float *out)
{
    for (int i = 0; i < n; i++) {
        out[i] = 0.0f;
        for (int c = 0; c < 3; c++)
            out[i] += at->weight[c] * values[(size_t)n * at->corner[c] + (size_t)i];
    }
}

static lf_vec3 corner_of(const place *at, int i)
{
    return lf_mesh_vertex(at->mesh, at->corner[i]);
}

/* Texels per area of the scene on the triangle, at the finest level: area in the texture over area
 * of the triangle. */
static float density2(const place *at, const float *uvs, const lf_texture *t, const lf_pyramid *p)
{
    const float *a = uvs + 2 * (size_t)at->corner[0], *b = uvs + 2 * (size_t)at->corner[1],
                *c = uvs + 2 * (size_t)at->corner[2];
    float uv = fabsf((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
    float turned = fabsf(t->map[0][0] * t->map[1][1] - t->map[0][1] * t->map[1][0]);
    lf_vec3 o = corner_of(at, 0);
    float area =
        at->mesh->instances
            ? lf_instance_twice_area(at->hit)
            : lf_length(lf_cross(lf_sub(corner_of(at, 1), o), lf_sub(corner_of(at, 2), o)));
    return area > 0.0f ? uv * turned * (float)p->width[0] * (float)p->height[0] / area : 0.0f;
}

/* false: the material has no such texture. */
static bool look_up(const place *at, const lf_textures *textures, lf_slot slot, float width,
                    float out[4])
{
    const lf_texture *t = &textures->set.slot[slot];
    const lf_pyramid *p = textures->pyramid[slot];
    if (!p || !at->mesh->uvs)
        return false;
    const float *uvs = at->mesh->uvs + 2 * (size_t)t->set * (size_t)at->mesh->n_vertices;
    float uv[2], texels2 = density2(at, uvs, t, p) * width * width;
    interpolate(at, uvs, 2, uv);
    lf_texture_look_up(t, p, uv[0], uv[1], texels2 > 1.0f ? 0.5f * log2f(texels2) : 0.0f, out);
    return true;
}

/* The vertex colour that multiplies a material's colour. */
static lf_vec3 colour_of(const place *at)
{
    float colour[4];
    interpolate(at, at->mesh->colours, 4, colour);
    return lf_v3(colour[0], colour[1], colour[2]);
}

lf_vec3 lf_hit_emission(const lf_hit *hit, float width)
{
    const lf_material *m = hit->material;
    float texel[4];
    place at = place_of(hit);
    lf_vec3 out = m->emission;
    if (m->textures && look_up(&at, m->textures, LF_SLOT_EMISSION, width, texel))
        out = lf_mul(out, lf_v3(texel[0], texel[1], texel[2]));
    return m->tint == LF_TINT_ALL && at.mesh->colours ? lf_mul(out, colour_of(&at)) : out;
}

/* An image with a cutoff contains the result (LF_TEXELS_CUTS), with the material's alpha in its
 * threshold; vertex alpha is cut off separately. */
float lf_hit_cover(const lf_hit *hit, float width)
{
    const lf_material *m = hit->material;
    float alpha = m->alpha, share = 1.0f, texel[4], colour[4];
    place at = place_of(hit);
    if (m->cover == LF_COVER_OPAQUE)
        return 1.0f;
    if (m->textures && look_up(&at, m->textures, LF_SLOT_BASE, width, texel))
        share = texel[3];
    if (lf_is_coloured(hit->mesh, m)) {
        interpolate(&at, hit->mesh->colours, 4, colour);
        alpha *= colour[3];
    }
    return share *
           (m->cover == LF_COVER_MASK ? (float)(alpha >= m->alpha_cutoff) : lf_min(alpha, 1.0f));
}

/* Normals that vary around their mean, of length r, widen the lobe: alpha^2 grows by twice the
 * variance of slopes along one direction, (1 - r) / r (Toksvig 2005). */
static void widen(float scale, float lost, float *roughness)
{
    float r = *roughness, alpha2 = r * r * r * r,
          more = lf_max(lost - 2.0f / 65535.0f, 0.0f), /* except for rounding */
        spread = scale * scale * more / lf_max(1.0f - lost, 1e-3f);
    if (spread > 0.0f)
        *roughness = sqrtf(sqrtf(lf_min(alpha2 + 2.0f * spread, 1.0f)));
}

float lf_hit_stops(const lf_hit *hit, lf_vec3 w, float width)
{
    if (!hit->material->glass.is_thin)
        return lf_hit_cover(hit, width);
    return 1.0f - lf_thin_passes(hit->material, -lf_dot(hit->ns, w) / lf_length(w));
}

/* The file's tangent at the hit; hand: side of the bitangent, 1 or -1. */
static lf_vec3 file_tangent(const place *at, const lf_hit *hit, float *hand)
{
    float tangent[4];
    interpolate(at, at->mesh->tangents, 4, tangent);
    lf_vec3 along = lf_v3(tangent[0], tangent[1], tangent[2]);
    *hand = tangent[3] < 0.0f ? -1.0f : 1.0f;
    if (!at->mesh->instances)
        return along;
    *hand = lf_instance_is_mirrored(hit) ? -*hand : *hand;
    return lf_instance_tangent(hit, along);
}

/* The shading normal ns modified by a normal map; the other side of the surface sees the same dent
 * from behind. */
static lf_vec3 bent(const place *at, const lf_texture *t, const float texel[4], lf_vec3 ns,
                    const lf_hit *hit)
{
    float hand, side = hit->front ? 1.0f : -1.0f;
    lf_vec3 n = lf_scale(ns, side), along = file_tangent(at, hit, &hand),
            across = lf_scale(lf_cross(n, along), hand);
    lf_vec3 out = lf_madd(
        lf_madd(lf_scale(n, 2.0f * texel[2] - 1.0f), t->scale * (2.0f * texel[0] - 1.0f), along),
        t->scale * (2.0f * texel[1] - 1.0f), across);
    float length = lf_length(out);
    if (!(length > 1e-6f))
        return ns;
    out = lf_scale(out, side / length);
    return lf_dot(out, hit->ng) > 0.0f ? out : ns;
}

/* A coat uses its own normal map, or none, independent of the base below; smooth: the normal
 * without any map. */
static void lay_coat(const place *at, const lf_textures *textures, float width, lf_vec3 smooth,
                     lf_hit *hit)
{
    lf_material *m = &hit->own;
    lf_vec3 n = smooth, x, y;
    float texel[4];
    if (look_up(at, textures, LF_SLOT_COAT_NORMAL, width, texel)) {
        const lf_texture *t = &textures->set.slot[LF_SLOT_COAT_NORMAL];
        n = bent(at, t, texel, smooth, hit);
        widen(t->scale, texel[3], &m->coat_roughness);
    }
    lf_tangents(hit->ns, &x, &y);
    m->coat_normal = lf_to_frame(x, y, hit->ns, n);
}

/* Directions of a mesh's tangent and bitangent; around the scene's vertical, if it has none. false:
 * undefined, because the normal is vertical. */
static bool tangents_of(const place *at, const lf_hit *hit, lf_vec3 n, lf_vec3 *along,
                        lf_vec3 *across)
{
    float hand = 1.0f;
    lf_vec3 t = at->mesh->tangents ? file_tangent(at, hit, &hand) : lf_v3(n.z, 0.0f, -n.x);
    t = lf_madd(t, -lf_dot(t, n), n);
    float length = lf_length(t);
    if (!(length > 1e-6f))
        return false;
    *along = lf_scale(t, 1.0f / length);
    *across = lf_scale(lf_cross(n, *along), hand);
    return true;
}

/* Two alphas and a direction for the lobe (glTF's KHR_materials_anisotropy); the roughness becomes
 * the roughness of the isotropic lobe with the same albedo. */
static void anisotropic(const place *at, float width, lf_hit *hit)
{
    lf_material *m = &hit->own;
    lf_anisotropy *b = &m->anisotropic;
    lf_vec3 along, across, x, y;
    float texel[4], strength = m->anisotropy, c = m->anisotropy_rotation[0],
                    s = m->anisotropy_rotation[1];
    if (m->textures && look_up(at, m->textures, LF_SLOT_ANISOTROPY, width, texel)) {
        float u = 2.0f * texel[0] - 1.0f, v = 2.0f * texel[1] - 1.0f, length = sqrtf(u * u + v * v);
        strength *= length > 1e-6f ? texel[2] : 0.0f;
        c = length > 1e-6f
                ? (m->anisotropy_rotation[0] * u - m->anisotropy_rotation[1] * v) / length
                : c;
        s = length > 1e-6f
                ? (m->anisotropy_rotation[1] * u + m->anisotropy_rotation[0] * v) / length
                : s;
    }
    if (!(strength > 0.0f) ||
        !tangents_of(at, hit, lf_scale(hit->ns, hit->front ? 1.0f : -1.0f), &along, &across))
        return;
    lf_vec3 wider = lf_madd(lf_scale(along, c), s, across);
    lf_tangents(hit->ns, &x, &y);
    float alpha = m->roughness * m->roughness, wide = lf_lerp(alpha, 1.0f, strength * strength);
    b->along[0] = lf_dot(wider, x);
    b->along[1] = lf_dot(wider, y);
    b->alpha[0] = wide;
    b->alpha[1] = alpha;
    m->roughness = sqrtf(sqrtf(0.5f * (wide * wide + alpha * alpha)));
}

static lf_vec3 tinted(lf_vec3 colour, const float texel[4])
{
    return lf_mul(colour, lf_v3(texel[0], texel[1], texel[2]));
}

/* Updates the other layers of a layered surface. */
static void vary_layers(const place *at, const lf_textures *textures, float width, lf_material *m)
{
    float texel[4];
    if (look_up(at, textures, LF_SLOT_COAT, width, texel))
        m->coat *= texel[0];
    if (look_up(at, textures, LF_SLOT_COAT_ROUGH, width, texel))
        m->coat_roughness = lf_max(m->coat_roughness * texel[1], LF_LEAST_ROUGHNESS);
    if (look_up(at, textures, LF_SLOT_SHEEN, width, texel))
        m->sheen = tinted(m->sheen, texel);
    if (look_up(at, textures, LF_SLOT_SHEEN_ROUGH, width, texel))
        m->sheen_roughness *= texel[3];
    if (look_up(at, textures, LF_SLOT_TRANSMISSION, width, texel))
        m->transmission *= texel[0];
    if (look_up(at, textures, LF_SLOT_SPECULAR, width, texel))
        m->specular *= texel[3];
    if (look_up(at, textures, LF_SLOT_SPECULAR_TINT, width, texel))
        m->specular_tint = tinted(m->specular_tint, texel);
}

static void vary_by_textures(const place *at, const lf_textures *textures, float width, lf_hit *hit)
{
    lf_material *m = &hit->own;
    const lf_vec3 smooth = hit->ns;
    float texel[4];
    if (look_up(at, textures, LF_SLOT_BASE, width, texel))
        m->albedo = tinted(m->albedo, texel);
    if (look_up(at, textures, LF_SLOT_METAL_ROUGH, width, texel)) {
        m->roughness = lf_max(m->roughness * texel[1], LF_LEAST_ROUGHNESS);
        m->metallic *= texel[2];
    }
    if (look_up(at, textures, LF_SLOT_EMISSION, width, texel))
        m->emission = tinted(m->emission, texel);
    if (textures->layered)
        vary_layers(at, textures, width, m);
    if (at->mesh->tangents && look_up(at, textures, LF_SLOT_NORMAL, width, texel)) {
        hit->ns = bent(at, &textures->set.slot[LF_SLOT_NORMAL], texel, smooth, hit);
        widen(textures->set.slot[LF_SLOT_NORMAL].scale, texel[3], &m->roughness);
    }
    if (at->mesh->tangents && m->coat > 0.0f &&
        (textures->pyramid[LF_SLOT_NORMAL] || textures->pyramid[LF_SLOT_COAT_NORMAL]))
        lay_coat(at, textures, width, smooth, hit);
}

void lf_hit_vary(lf_hit *hit, float width)
{
    place at = place_of(hit);
    hit->varies = true;
    hit->width = width;
    hit->own = *hit->material;
    if (lf_is_coloured(hit->mesh, hit->material)) {
        lf_vec3 colour = colour_of(&at);
        hit->own.albedo = lf_mul(hit->own.albedo, colour);
        if (hit->own.tint == LF_TINT_ALL)
            hit->own.emission = lf_mul(hit->own.emission, colour);
    }
    if (hit->material->textures)
        vary_by_textures(&at, hit->material->textures, width, hit);
    if (hit->own.anisotropy > 0.0f)
        anisotropic(&at, width, hit);
    hit->own.kind->vary(&hit->own);
}
