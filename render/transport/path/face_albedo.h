/* The albedo of a triangle, for many rays that meet it; private to render/.
 *
 * About how much of the light that arrives a surface sends on by lobes that are no delta: the
 * colour of its base, with its texture and the colours of vertices, and what a dielectric reflects
 * straight on. Roughness, normals, coats and sheen are not looked at: it is what the reconstruction
 * divides by (docs/developer/reconstruction.md, "Albedo"), so that it has to be cheap and near, not
 * exact. */
#ifndef LF_RENDER_FACE_ALBEDO_H
#define LF_RENDER_FACE_ALBEDO_H

#include "render/transport/path/track.h"
#include "render/transport/surface/albedo.h"

/* Of a material whose base has this colour, so much of it metal. */
void lf_material_albedo(const lf_material *m, lf_vec3 colour, float metal,
                        float out[LF_ALBEDO_NUMBERS]);

/* A texture on the triangle. */
typedef struct lf_face_texture {
    const lf_texture *texture; /* NULL: none */
    const lf_pyramid *pyramid;
    float place[2][3]; /* x and y in the picture: at the face's corner, and what they gain with each
                          barycentric coordinate */
    float texels2;     /* in a square of a scene unit */
} lf_face_texture;

typedef struct lf_face_albedo {
    lf_vec3 colour[3]; /* of the base, as place */
    float metal;
    lf_face_texture base, metals;
} lf_face_albedo;

void lf_face_albedo_init(lf_face_albedo *albedo, const lf_face *face);
/* At the point p of the face's plane, averaged over about `width`, scene units. Beside the face its
 * texture goes on, colours of vertices end. */
void lf_face_albedo_at(const lf_face_albedo *albedo, const lf_face *face, lf_vec3 p, float width,
                       float out[LF_ALBEDO_NUMBERS]);

#endif
