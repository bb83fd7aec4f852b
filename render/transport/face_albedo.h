/* The albedo of a triangle, for many rays that meet it; private to render/.
 *
 * About how much of the light that arrives a surface sends on by lobes that are no delta: the
 * colour of its base, with its texture and the colours of vertices, and what a dielectric reflects
 * straight on. Roughness, normals, coats and sheen are not looked at: it is what the reconstruction
 * divides by (docs/reconstruct.md, "Albedo"), so that it has to be cheap and near, not exact. */
#ifndef LF_RENDER_FACE_ALBEDO_H
#define LF_RENDER_FACE_ALBEDO_H

#include "render/transport/track.h"

typedef struct lf_face_albedo {
    lf_vec3
        colour[3]; /* at the face's corner, and what it gains with each barycentric coordinate */
    lf_vec3 gloss; /* what is added */
    const lf_texture *texture; /* of the base; NULL: none */
    const lf_pyramid *pyramid;
    float place[2][3]; /* x and y in the picture, as colour */
    float texels2;     /* in a unit of the face's area */
} lf_face_albedo;

void lf_face_albedo_init(lf_face_albedo *albedo, const lf_face *face);
/* At the point p of the face, averaged over about `width`, scene units. */
lf_vec3 lf_face_albedo_at(const lf_face_albedo *albedo, const lf_face *face, lf_vec3 p,
                          float width);

#endif
