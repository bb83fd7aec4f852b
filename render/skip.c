#include "render/skip.h"

#include <stddef.h>
#include <string.h>

#include "render/rows/visit.h"
#include "render/scene/embree_commit.h"
#include "render/scene/geometry.h"

static const lf_skip_entry table[] = {
    {"surfaces", "no meshes: no Embree device, no rays", LF_SKIP_SURFACES, true},
    {"background", "view pixels whose rays meet nothing: no paths, no optical depths",
     LF_SKIP_BACKGROUND, false},
    {"delta-lobes", "no mirrors: no sum of native samples on the film", LF_SKIP_DELTA_LOBES, false},
    {"view-lobes", "no lobe depends on the view: no directional weights on the film",
     LF_SKIP_VIEW_LOBES, false},
    {"emission", "no surface emits: hits are not looked up among the lights", LF_SKIP_EMISSION,
     true},
    {"known-light", "all rays that escape find the same light: no look-ups, no storage",
     LF_SKIP_KNOWN_LIGHT, false},
    {"single-paths",
     "one grid, a sky and at most one far light: suffixes in media run in SIMD lanes",
     LF_SKIP_PATHS, false},
};
#define N_SKIPS (sizeof table / sizeof table[0])

const lf_skip_entry *lf_skip_at(int index)
{
    return index >= 0 && index < (int)N_SKIPS ? &table[index] : NULL;
}

unsigned lf_skip_found(const lf_scene *scene)
{
    float sky[3];
    unsigned found = LF_SKIP_BACKGROUND;
    found |= scene->embree ? 0 : LF_SKIP_SURFACES;
    found |= lf_has(scene, LF_TRAIT_MIRRORS) ? 0 : LF_SKIP_DELTA_LOBES;
    found |= lf_has(scene, LF_TRAIT_VIEW_LOBES) ? 0 : LF_SKIP_VIEW_LOBES;
    found |= lf_has(scene, LF_TRAIT_EMISSION) ? 0 : LF_SKIP_EMISSION;
    found |= !lf_has(scene, LF_TRAIT_MIRRORS) && scene->equiangular.n == 0 &&
                     lf_unscattered_uniform(scene, sky)
                 ? LF_SKIP_KNOWN_LIGHT
                 : 0;
    found |= lf_lane_scene_serves(scene) ? LF_SKIP_PATHS : 0;
    return found;
}

lf_status lf_skip_scene(const lf_scene *scene, unsigned skip, lf_scene *out,
                        lf_geometry **out_empty, lf_error *err)
{
    /* All but the count of references, which others may be changing. */
    const size_t from = offsetof(lf_scene, json);
    lf_geometry *empty = NULL;
    if (!(skip & LF_SKIP_SURFACES) && !scene->embree) {
        lf_status status = lf_geometry_create(0, scene->origin, NULL, &empty, err);
        if (status == LF_OK)
            status = lf_embree_commit(empty->embree, empty->device, err);
        if (status != LF_OK) {
            lf_geometry_unref(empty);
            return status;
        }
    }
    memcpy((char *)out + from, (const char *)scene + from, sizeof *scene - from);
    out->embree = empty ? empty->embree : scene->embree;
    out->traits |= skip & LF_SKIP_DELTA_LOBES ? 0 : LF_TRAIT_MIRRORS;
    out->traits |= skip & LF_SKIP_VIEW_LOBES ? 0 : LF_TRAIT_VIEW_LOBES;
    out->traits |= skip & LF_SKIP_EMISSION ? 0 : LF_TRAIT_EMISSION;
    *out_empty = empty;
    return LF_OK;
}
