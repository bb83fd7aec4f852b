#include "render/transport/path/face_albedo.h"

#include "render/transport/surface/surface_texture.h"

void lf_material_albedo(const lf_material *m, lf_vec3 colour, float metal,
                        float out[LF_ALBEDO_NUMBERS])
{
    const float r = (m->ior - 1.0f) / (m->ior + 1.0f);
    float gloss = 0.0f;
    if (m->eta.x > 0.0f)
        colour = lf_v3(1.0f, 1.0f, 1.0f);
    else if (m->kind == &lf_surface_plastic)
        gloss = r * r;
    else if (m->kind == &lf_surface_principled)
        gloss = (1.0f - metal) * m->specular * r * r;
    const float channels[3] = {colour.x, colour.y, colour.z};
    for (int c = 0; c < 3; c++)
        out[c] = lf_min(lf_max(channels[c] + gloss, LF_LEAST_ALBEDO), 1.0f);
    out[LF_ALBEDO_METAL] = metal;
}

/* Its metallic share, without a texture. */
static float metal_of(const lf_material *m)
{
    if (m->kind == &lf_surface_conductor)
        return 1.0f;
    return m->kind == &lf_surface_principled ? m->metallic : 0.0f;
}

static lf_vec3 corner_colour(const lf_face *face, int corner)
{
    const lf_mesh *mesh = face->mesh;
    if (!lf_is_coloured(mesh, face->material))
        return face->material->albedo;
    const float *c =
        mesh->colours + 4 * (size_t)mesh->triangles[3 * (size_t)face->triangle + (size_t)corner];
    return lf_mul(face->material->albedo, lf_v3(c[0], c[1], c[2]));
}

static void lay_texture(lf_face_texture *out, const lf_face *face, lf_slot slot)
{
    const lf_textures *textures = face->material->textures;
    const lf_mesh *mesh = face->mesh;
    out->pyramid = textures && mesh->uvs ? textures->pyramid[slot] : NULL;
    if (!out->pyramid)
        return;
    out->texture = &textures->set.slot[slot];
    const float *uvs = mesh->uvs + 2 * (size_t)out->texture->set * (size_t)mesh->n_vertices;
    for (int i = 0; i < 2; i++) {
        const float *m = out->texture->map[i];
        for (int corner = 0; corner < 3; corner++) {
            const float *uv =
                uvs + 2 * (size_t)mesh->triangles[3 * (size_t)face->triangle + (size_t)corner];
            float x = m[0] * uv[0] + m[1] * uv[1] + m[2];
            out->place[i][corner] = corner == 0 ? x : x - out->place[i][0];
        }
    }
    /* gradients of barycentric coordinates span the inverse of twice the triangle's area */
    float turned = out->place[0][1] * out->place[1][2] - out->place[0][2] * out->place[1][1];
    out->texels2 = fabsf(turned) * (float)out->pyramid->width[0] * (float)out->pyramid->height[0] *
                   lf_length(lf_cross(face->to_uv[0], face->to_uv[1]));
}

void lf_face_albedo_init(lf_face_albedo *albedo, const lf_face *face)
{
    const lf_material *m = face->material;
    *albedo = (lf_face_albedo){.metal = metal_of(m)};
    for (int i = 0; i < 3; i++) {
        lf_vec3 colour = corner_colour(face, i);
        albedo->colour[i] = i == 0 ? colour : lf_sub(colour, albedo->colour[0]);
    }
    lay_texture(&albedo->base, face, LF_SLOT_BASE);
    if (albedo->metal > 0.0f)
        lay_texture(&albedo->metals, face, LF_SLOT_METAL_ROUGH);
}

/* Clamps a barycentric coordinate of a point that may lie outside the triangle. */
static float beside(float x)
{
    const float most = 1000.0f;
    return lf_min(lf_max(x, -most), most);
}

static void look_up(const lf_face_texture *t, float u, float v, float width, float out[3])
{
    const float *x = t->place[0], *y = t->place[1];
    lf_texture_glance(t->texture, t->pyramid, x[0] + u * x[1] + v * x[2],
                      y[0] + u * y[1] + v * y[2], t->texels2 * width * width, out);
}

void lf_face_albedo_at(const lf_face_albedo *albedo, const lf_face *face, lf_vec3 p, float width,
                       float out[LF_ALBEDO_NUMBERS])
{
    const lf_vec3 d = lf_sub(p, face->a), *c = albedo->colour;
    const float u = beside(lf_dot(face->to_uv[0], d)), v = beside(lf_dot(face->to_uv[1], d)),
                within_u = lf_min(lf_max(u, 0.0f), 1.0f),
                within_v = lf_min(lf_max(v, 0.0f), 1.0f - within_u);
    float texel[3], metal = albedo->metal;
    lf_vec3 colour = lf_madd(lf_madd(c[0], within_u, c[1]), within_v, c[2]);
    if (albedo->base.texture) {
        look_up(&albedo->base, u, v, width, texel);
        colour = lf_mul(colour, lf_v3(texel[0], texel[1], texel[2]));
    }
    if (albedo->metals.texture) {
        look_up(&albedo->metals, u, v, width, texel);
        metal *= texel[2];
    }
    lf_material_albedo(face->material, colour, metal, out);
}
