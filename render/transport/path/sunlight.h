/* The direct light from the scene's lights at infinity at a point of a surface, by look-ups instead
 * of rays. It is a feature for the reconstruction: free of noise and the same in every visit, but
 * not exact. The film's sums must not depend on it. Private to render/.
 *
 * Suns: a shadow map per light stores the surfaces that it sees (sunlight_map.h). Shadow edges are
 * interpolated between its texels; penumbras of lights with an angle average a disk of texels. A
 * lattice of optical depths gives the transmittance of media (sunlight_media.h). Both belong to the
 * scene and do not depend on the camera. Mirrored and scattered light is ignored.
 *
 * Without suns, or with instances, which the maps do not support: a function of the normal for all
 * lights at infinity, without occlusion (sky_light.h). */
#ifndef LF_RENDER_SUNLIGHT_H
#define LF_RENDER_SUNLIGHT_H

#include "base/thread.h"
#include "render/transport/surface/surface.h"

typedef struct lf_sunlight lf_sunlight;

/* Maximum number of lights at infinity; the weakest further ones are ignored. */
#define LF_SUNLIGHT_LIGHTS 4

/* Whether the feature is useful: the scene has surfaces, and suns or a sky that distinguishes them.
 * A constant sky over materials of one albedo does not. */
bool lf_sunlight_needed(const lf_scene *scene);

/* Makes the maps on the pool, at most `texels` along a side (0: 2048, 16 MiB per light, 20 if there
 * are small objects on a wide one). Takes as long as a few look-ups per texel and triangle. Keeps a
 * reference to the scene. LF_E_NOMEM; LF_E_CANCELLED soon after cancel is set. Thread: the pool's
 * caller. The result does not depend on the number of its threads. */
LF_NODISCARD lf_status lf_sunlight_create(lf_scene *scene, int texels, lf_pool *pool,
                                          const lf_cancel *cancel, lf_sunlight **out);
/* Accepts NULL. */
void lf_sunlight_destroy(lf_sunlight *sunlight);

/* Switches to another scene if the maps would be the same: suns, surfaces and media are in the same
 * positions; colours may differ. false: it keeps its own scene. */
bool lf_sunlight_adopt(lf_sunlight *sunlight, lf_scene *scene);

/* For light number i, strongest first: the share of its irradiance that arrives at p on a surface
 * with the geometric unit normal n; 0 if n faces away from it. *out_light: the light. false: there
 * is no light i. Any thread. */
bool lf_sunlight_share(const lf_sunlight *sunlight, int i, lf_vec3 p, lf_vec3 n, float *out_share,
                       const lf_light **out_light);

/* The slope of a plane in a map: change of height towards the light per texel along x and y. bias:
 * surfaces higher by less than this cast no shadow on it. */
typedef struct lf_sunlight_slope {
    float dx, dy, bias;
} lf_sunlight_slope;

/* Data that is constant over a triangle. */
typedef struct lf_sunlight_face {
    lf_sunlight_slope slope[LF_SUNLIGHT_LIGHTS][2];
} lf_sunlight_face;

/* n: its unit normal, either side. */
void lf_sunlight_face_init(lf_sunlight_face *face, const lf_sunlight *sunlight, lf_vec3 n);

/* Radiance that the lobes of the surface reflect from suns along wo, mean of the channels. Reads p,
 * ng, ns and material of the hit. Without suns, lf_sunlight_of_sky. Any thread. */
float lf_sunlight_reflected(const lf_sunlight *sunlight, const lf_sunlight_face *face,
                            const lf_hit *hit, lf_vec3 wo);

/* Whether the light is from suns, so that it depends on position and textures of a surface. */
bool lf_sunlight_has_suns(const lf_sunlight *sunlight);
/* Without suns: the light that a matte surface with the normal n reflects, mean of the channels.
 * With LF_TRAIT_VARYING_ALBEDO films divide by albedo; then the surface is white, else it has the
 * material's albedo. */
float lf_sunlight_of_sky(const lf_sunlight *sunlight, lf_vec3 n, const lf_material *material);

/* Without suns: the mean over all normals of the light that a white matte surface reflects in this
 * scene. 0 with suns. Takes as long as lf_sky_light_init. */
float lf_sunlight_mean(const lf_scene *scene);

#endif
