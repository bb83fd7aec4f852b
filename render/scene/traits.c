#include "render/scene/traits.h"

#include <stdio.h>
#include <string.h>

#define SOME "the scene has some"
#define OF_SURFACES LF_TRAIT_SURFACES
#define OF_MEDIA LF_TRAIT_MEDIA

static const lf_trait_entry table[] = {
    {LF_TRAIT_SURFACES, 0, "surfaces", SOME},
    {LF_TRAIT_INSTANCES, OF_SURFACES, "instances", SOME},
    {LF_TRAIT_HIDDEN_MESHES, OF_SURFACES, "meshes hidden from the camera", SOME},
    {LF_TRAIT_VARYING, OF_SURFACES, "textures, vertex colours and anisotropy", SOME},
    {LF_TRAIT_VARYING_ALBEDO, OF_SURFACES, "albedo that varies along a mesh", SOME},
    {LF_TRAIT_VERTEX_COLOURS, OF_SURFACES, "vertex colours", SOME},
    {LF_TRAIT_MIRRORS, OF_SURFACES, "mirrors, smooth coats and smooth glass", SOME},
    {LF_TRAIT_VIEW_LOBES, 0, "lobes that depend on the view", SOME},
    {LF_TRAIT_EMISSION, OF_SURFACES, "surfaces that emit", SOME},
    {LF_TRAIT_OVERLAPS, OF_SURFACES, "lamps in one place with other faces", SOME},
    {LF_TRAIT_ALPHA, OF_SURFACES, "alpha", "the scene has such surfaces"},
    {LF_TRAIT_THIN_GLASS, OF_SURFACES, "thin glass", SOME},
    {LF_TRAIT_ROUGH_GLASS, OF_SURFACES, "rough glass", SOME},
    {LF_TRAIT_FILLED_GLASS, OF_SURFACES, "glass that absorbs or scatters", SOME},
    {LF_TRAIT_NESTED_GLASS, OF_SURFACES, "glass within glass", SOME},
    {LF_TRAIT_SUBSURFACE, OF_SURFACES, "subsurface scattering", SOME},
    {LF_TRAIT_CATCHERS, OF_SURFACES, "shadow catchers", SOME},
    {LF_TRAIT_REFLECTIONS, OF_SURFACES | LF_TRAIT_CATCHERS, "reflections on shadow catchers", SOME},
    {LF_TRAIT_MEDIA, 0, "participating media", SOME},
    {LF_TRAIT_HOMOGENEOUS_MEDIA, OF_MEDIA, "homogeneous media", SOME},
    {LF_TRAIT_NEAREST_VOXELS, OF_MEDIA, "grids without interpolation", SOME},
    {LF_TRAIT_CHROMATIC_MEDIA, OF_MEDIA, "chromatic extinction", "the scene has such media"},
    {LF_TRAIT_VARYING_MEDIA, OF_MEDIA, "grids of albedo", SOME},
    {LF_TRAIT_TWO_LOBES, OF_MEDIA, "phase functions of two lobes", SOME},
    {LF_TRAIT_VOLUME_EMISSION, OF_MEDIA, "volumes that emit", SOME},
    {LF_TRAIT_SUNS, 0, "suns", SOME},
    {LF_TRAIT_SKY_PICTURES, 0, "skies that vary", SOME},
    {LF_TRAIT_AREA_LIGHTS, 0, "lights at a distance", SOME},
    {LF_TRAIT_EQUIANGULAR, LF_TRAIT_AREA_LIGHTS | OF_MEDIA, "lights within media", SOME},
    {LF_TRAIT_BACKDROP, 0, "backdrops", "the scene has one"},
    {LF_TRAIT_MOTION, 0, "motion", "something moves while the shutter is open"},
    {LF_TRAIT_LENS, 0, "depth of field", "the camera has a lens_radius"},
    {LF_TRAIT_VIEW_BLUR, 0, "view_blur", "the camera has some"},
    {LF_TRAIT_LISTED_CAMERAS, 0, "cameras listed one by one", SOME},
    {LF_TRAIT_FEATURES, 0, "reconstruction and depth", "the picture is reconstructed or has depth"},
};
#define N_ROWS (int)(sizeof table / sizeof table[0])
_Static_assert(N_ROWS == LF_N_TRAITS, "a row for every bit");

const lf_trait_entry *lf_trait_at(int index)
{
    return index >= 0 && index < N_ROWS ? &table[index] : NULL;
}

/* Appends words, after a separator unless they are the first; skips words that are already there.
 */
static void add(char *text, size_t size, const char *separator, const char *words)
{
    const size_t used = strlen(text);
    if (!strstr(text, words))
        snprintf(text + used, size - used, "%s%s", used > 0 ? separator : "", words);
}

bool lf_traits_missing(lf_traits has, lf_traits supported, const char *who, char *text, size_t size)
{
    const lf_traits missing = has & ~supported;
    char names[256] = "", reasons[256] = "";
    for (int i = 0; i < N_ROWS; i++)
        if (missing & table[i].bit && !(missing & table[i].of)) {
            add(names, sizeof names, ", ", table[i].name);
            add(reasons, sizeof reasons, ", ", table[i].has);
        }
    if (missing)
        snprintf(text, size, "%s does not support %s; %s", who, names, reasons);
    return missing;
}
