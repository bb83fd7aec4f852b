#include "render/transport/face_albedo.h"

#include "render/transport/surface_texture.h"

/* Of a dielectric, straight on. Where a texture says what is metal, half of it. */
static float reflected_straight(const lf_material *m)
{
    const bool mixed = m->textures && m->textures->pyramid[LF_SLOT_METAL_ROUGH];
    float r = (m->ior - 1.0f) / (m->ior + 1.0f),
          metal = m->metallic > 0.0f && mixed ? 0.5f : m->metallic;
    if (m->kind == &lf_surface_plastic)
        return r * r;
    return m->kind == &lf_surface_principled ? (1.0f - metal) * m->specular * r * r : 0.0f;
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

static void lay_texture(lf_face_albedo *a, const lf_face *face)
{
    const lf_textures *textures = face->material->textures;
    const lf_mesh *mesh = face->mesh;
    a->pyramid = textures && mesh->uvs ? textures->pyramid[LF_SLOT_BASE] : NULL;
    if (!a->pyramid)
        return;
    a->texture = &textures->set.slot[LF_SLOT_BASE];
    const float *uvs = mesh->uvs + 2 * (size_t)a->texture->set * (size_t)mesh->n_vertices;
    for (int i = 0; i < 2; i++) {
        const float *m = a->texture->map[i];
        for (int corner = 0; corner < 3; corner++) {
            const float *uv =
                uvs + 2 * (size_t)mesh->triangles[3 * (size_t)face->triangle + (size_t)corner];
            float x = m[0] * uv[0] + m[1] * uv[1] + m[2];
            a->place[i][corner] = corner == 0 ? x : x - a->place[i][0];
        }
    }
    /* gradients of barycentric coordinates span the inverse of twice the triangle's area */
    float turned = a->place[0][1] * a->place[1][2] - a->place[0][2] * a->place[1][1];
    a->texels2 = fabsf(turned) * (float)a->pyramid->width[0] * (float)a->pyramid->height[0] *
                 lf_length(lf_cross(face->to_uv[0], face->to_uv[1]));
}

void lf_face_albedo_init(lf_face_albedo *albedo, const lf_face *face)
{
    const float gloss = reflected_straight(face->material);
    *albedo = (lf_face_albedo){.gloss = lf_v3(gloss, gloss, gloss)};
    for (int i = 0; i < 3; i++) {
        lf_vec3 colour = corner_colour(face, i);
        albedo->colour[i] = i == 0 ? colour : lf_sub(colour, albedo->colour[0]);
    }
    lay_texture(albedo, face);
}

lf_vec3 lf_face_albedo_at(const lf_face_albedo *albedo, const lf_face *face, lf_vec3 p, float width)
{
    const lf_vec3 d = lf_sub(p, face->a), *c = albedo->colour;
    float texel[3], u = lf_min(lf_max(lf_dot(face->to_uv[0], d), 0.0f), 1.0f),
                    v = lf_min(lf_max(lf_dot(face->to_uv[1], d), 0.0f), 1.0f - u);
    lf_vec3 out = lf_madd(lf_madd(c[0], u, c[1]), v, c[2]);
    if (albedo->pyramid) {
        const float *x = albedo->place[0], *y = albedo->place[1];
        lf_texture_glance(albedo->texture, albedo->pyramid, x[0] + u * x[1] + v * x[2],
                          y[0] + u * y[1] + v * y[2], albedo->texels2 * width * width, texel);
        out = lf_mul(out, lf_v3(texel[0], texel[1], texel[2]));
    }
    return lf_add(out, albedo->gloss);
}
