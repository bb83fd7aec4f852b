/* The albedo of a triangle, for many rays that meet it; private to render/.
 *
 * The approximate fraction of incident light that a surface scatters through non-delta lobes: its
 * base colour, with texture and vertex colours, and the normal-incidence reflectance of a
 * dielectric. Roughness, normals, coats and sheen are ignored. The reconstruction divides by it
 * (docs/developer/reconstruction.md, "Albedo"), so it must be cheap and approximate, not exact. */
#ifndef LF_RENDER_FACE_ALBEDO_H
#define LF_RENDER_FACE_ALBEDO_H

#include "render/transport/path/track.h"
#include "render/transport/surface/albedo.h"

/* For a material whose base has this colour and this metallic share. */
void lf_material_albedo(const lf_material *m, lf_vec3 colour, float metal,
                        float out[LF_ALBEDO_NUMBERS]);

/* A texture on the triangle. */
typedef struct lf_face_texture {
    const lf_texture *texture; /* NULL: none */
    const lf_pyramid *pyramid;
    /* x and y in the image: at the face's first corner, and their derivatives by each barycentric
     * coordinate */
    float place[2][3];
    float texels2; /* per square scene unit */
} lf_face_texture;

typedef struct lf_face_albedo {
    lf_vec3 colour[3]; /* of the base, in the layout of place */
    float metal;
    lf_face_texture base, metals;
} lf_face_albedo;

void lf_face_albedo_init(lf_face_albedo *albedo, const lf_face *face);
/* At the point p of the face's plane, averaged over about `width`, scene units. Outside the face
 * the texture is extrapolated, vertex colours are clamped. */
void lf_face_albedo_at(const lf_face_albedo *albedo, const lf_face *face, lf_vec3 p, float width,
                       float out[LF_ALBEDO_NUMBERS]);

#endif
