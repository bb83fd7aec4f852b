/* How much light comes straight from the scene's lights at infinity to a point of a surface, by
 * look-ups instead of rays: a feature that pictures are reconstructed from, without noise and the
 * same at every visit, but not exact; nothing that is summed on the film may depend on it. Private
 * to render/.
 *
 * Suns: a map per light says which surfaces it sees (sunlight_map.h): edges of shadows are
 * interpolated between its texels, half-shadows of lights with an angle are made of a disk of them.
 * A lattice of optical depths says what media leave of the light (sunlight_media.h). Both belong to
 * the scene: cameras may move. Mirrored and scattered light is not counted.
 *
 * Where there are no suns, or instances, of which no map is made: what the normal tells of all
 * lights at infinity, as if nothing stood in their way (sky_light.h). */
#ifndef LF_RENDER_SUNLIGHT_H
#define LF_RENDER_SUNLIGHT_H

#include "base/thread.h"
#include "render/transport/surface/surface.h"

typedef struct lf_sunlight lf_sunlight;

/* More lights at infinity than this are left out, the weakest. */
#define LF_SUNLIGHT_LIGHTS 4

/* Whether there is anything to be made: surfaces, and suns, or a sky that tells something of them:
 * not one that is the same in all directions over materials of one albedo. */
bool lf_sunlight_needed(const lf_scene *scene);

/* Makes the maps on the pool, at most `texels` along a side (0: 2048, 16 MiB a light, 20 where
 * small things stand on something wide). Takes as long as a few looks at every texel and triangle.
 * Keeps a reference to the scene. LF_E_NOMEM; LF_E_CANCELLED soon after cancel is set.
 * Thread: the pool's caller. The result does not depend on the number of its threads. */
LF_NODISCARD lf_status lf_sunlight_create(lf_scene *scene, int texels, lf_pool *pool,
                                          const lf_cancel *cancel, lf_sunlight **out);
/* Accepts NULL. */
void lf_sunlight_destroy(lf_sunlight *sunlight);

/* Goes over to another scene where the maps would be the same: suns, surfaces and media stand where
 * they stood; colours may have changed. false: it stays with its own. */
bool lf_sunlight_adopt(lf_sunlight *sunlight, lf_scene *scene);

/* Of light number i of those that are kept, strongest first: the share of its irradiance that
 * arrives at p on a surface with the geometric unit normal n; 0 where n looks away from it.
 * *out_light: which it is. false: there is no such light. Any thread. */
bool lf_sunlight_share(const lf_sunlight *sunlight, int i, lf_vec3 p, lf_vec3 n, float *out_share,
                       const lf_light **out_light);

/* How a plane lies on a map: height towards the light, with the texels along x and y, and how much
 * higher than that nothing casts a shadow on it. */
typedef struct lf_sunlight_slope {
    float dx, dy, bias;
} lf_sunlight_slope;

/* What is the same all over a triangle. */
typedef struct lf_sunlight_face {
    lf_sunlight_slope slope[LF_SUNLIGHT_LIGHTS][2];
} lf_sunlight_face;

/* n: its unit normal, to either side. */
void lf_sunlight_face_init(lf_sunlight_face *face, const lf_sunlight *sunlight, lf_vec3 n);

/* Radiance that the lobes of the surface reflect of suns along wo, mean of the channels; of the hit
 * p, ng, ns and material are read. Without suns lf_sunlight_of_sky. Any thread. */
float lf_sunlight_reflected(const lf_sunlight *sunlight, const lf_sunlight_face *face,
                            const lf_hit *hit, lf_vec3 wo);

/* Whether it is of suns, so that place and textures of a surface count. */
bool lf_sunlight_has_suns(const lf_sunlight *sunlight);
/* Without suns: what a matte surface with the normal n reflects, mean of the channels. Where
 * LF_TRAIT_VARYING_ALBEDO, films divide by albedo: then it is white, else as the material. */
float lf_sunlight_of_sky(const lf_sunlight *sunlight, lf_vec3 n, const lf_material *material);

/* Without suns: the mean over all normals of what a white matte surface reflects in this scene. 0
 * with suns. Takes as long as lf_sky_light_init. */
float lf_sunlight_mean(const lf_scene *scene);

#endif
