/* Traits: what a scene, its camera and its picture have that an integrator must know of, a bit
 * each. A scene's are found while it is committed (lf_scene.traits); those of a view follow from
 * its settings (lf_view_traits). Integrators and lanes say what they support, in the same bits and
 * positively: what a mask does not name is refused, so that a new trait is never rendered wrong in
 * silence. Thread: any; no state. */
#ifndef LF_RENDER_TRAITS_H
#define LF_RENDER_TRAITS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef uint64_t lf_traits;

#define LF_TRAIT(bit) (UINT64_C(1) << (bit))

/* Surfaces that some mesh is made of. */
#define LF_TRAIT_SURFACES LF_TRAIT(0)       /* a mesh */
#define LF_TRAIT_INSTANCES LF_TRAIT(1)      /* a mesh that stands in many places */
#define LF_TRAIT_HIDDEN_MESHES LF_TRAIT(2)  /* hidden from the camera */
#define LF_TRAIT_VARYING LF_TRAIT(3)        /* something varies along a mesh … */
#define LF_TRAIT_VARYING_ALBEDO LF_TRAIT(4) /* … the albedo … */
#define LF_TRAIT_VERTEX_COLOURS LF_TRAIT(5) /* … by colours of vertices */
#define LF_TRAIT_MIRRORS LF_TRAIT(6)        /* a delta lobe */
/* A lobe depends on the view: g != 0 of media, all surfaces but diffuse ones. */
#define LF_TRAIT_VIEW_LOBES LF_TRAIT(7)
#define LF_TRAIT_EMISSION LF_TRAIT(8) /* a surface emits */
/* Faces of lamps share their place with others: next event counts the one that a ray meets. */
#define LF_TRAIT_OVERLAPS LF_TRAIT(9)
#define LF_TRAIT_ALPHA LF_TRAIT(10)      /* a surface that may not be there whole */
#define LF_TRAIT_THIN_GLASS LF_TRAIT(11) /* a clear sheet (lf_glass.is_thin) */
#define LF_TRAIT_ROUGH_GLASS LF_TRAIT(12)
#define LF_TRAIT_FILLED_GLASS LF_TRAIT(13) /* it absorbs or scatters */
#define LF_TRAIT_NESTED_GLASS LF_TRAIT(14) /* solid glass stands in solid glass (nest.h) */
#define LF_TRAIT_SUBSURFACE LF_TRAIT(15)   /* subsurface.h */
#define LF_TRAIT_CATCHERS LF_TRAIT(16)     /* a catcher of shadows … */
#define LF_TRAIT_REFLECTIONS LF_TRAIT(17)  /* … and one of what it reflects */
/* Volumes. */
#define LF_TRAIT_MEDIA LF_TRAIT(18)
#define LF_TRAIT_HOMOGENEOUS_MEDIA LF_TRAIT(19) /* of one density, no grid */
#define LF_TRAIT_NEAREST_VOXELS LF_TRAIT(20)    /* interpolation "nearest" */
#define LF_TRAIT_CHROMATIC_MEDIA LF_TRAIT(21)   /* sigma_t is not the same for all channels */
#define LF_TRAIT_VARYING_MEDIA LF_TRAIT(22)     /* the albedo is a grid's */
#define LF_TRAIT_TWO_LOBES LF_TRAIT(23)         /* of the phase function */
#define LF_TRAIT_VOLUME_EMISSION LF_TRAIT(24)
/* Light. */
#define LF_TRAIT_SUNS LF_TRAIT(25)         /* a light at infinity that is no picture */
#define LF_TRAIT_SKY_PICTURES LF_TRAIT(26) /* one that is */
#define LF_TRAIT_AREA_LIGHTS LF_TRAIT(27)  /* lights at a distance, emissive meshes too … */
#define LF_TRAIT_EQUIANGULAR LF_TRAIT(28)  /* … within media (equiangular.h) */
#define LF_TRAIT_BACKDROP LF_TRAIT(29)
/* Of the view, the first of the scene as well. */
#define LF_TRAIT_MOTION LF_TRAIT(30) /* something is elsewhere when the shutter closes */
#define LF_TRAIT_LENS LF_TRAIT(31)
#define LF_TRAIT_VIEW_BLUR LF_TRAIT(32)
#define LF_TRAIT_LISTED_CAMERAS LF_TRAIT(33)
/* The film keeps what reconstruction needs (lf_render_settings.features). */
#define LF_TRAIT_FEATURES LF_TRAIT(34)
#define LF_N_TRAITS 35

/* What loops ask together. */
#define LF_TRAITS_SEEN_THROUGH (LF_TRAIT_ALPHA | LF_TRAIT_THIN_GLASS) /* lf_is_alpha_surface */
#define LF_TRAITS_FILLED (LF_TRAIT_FILLED_GLASS | LF_TRAIT_SUBSURFACE)
#define LF_TRAITS_SIDED (LF_TRAIT_ROUGH_GLASS | LF_TRAIT_SUBSURFACE) /* lf_is_sided */

/* What the transport code does for whoever asks it for rays, light and lobes: masks name it
 * together. */
#define LF_TRAITS_PLAIN_SURFACES                                                                   \
    (LF_TRAIT_SURFACES | LF_TRAIT_INSTANCES | LF_TRAIT_HIDDEN_MESHES | LF_TRAIT_VARYING |          \
     LF_TRAIT_VARYING_ALBEDO | LF_TRAIT_VERTEX_COLOURS | LF_TRAIT_VIEW_LOBES | LF_TRAIT_EMISSION | \
     LF_TRAIT_OVERLAPS)
#define LF_TRAITS_PLAIN_MEDIA                                                                      \
    (LF_TRAIT_MEDIA | LF_TRAIT_HOMOGENEOUS_MEDIA | LF_TRAIT_NEAREST_VOXELS |                       \
     LF_TRAIT_VARYING_MEDIA | LF_TRAIT_TWO_LOBES | LF_TRAIT_VIEW_LOBES)
#define LF_TRAITS_GLASS                                                                            \
    (LF_TRAIT_MIRRORS | LF_TRAIT_ROUGH_GLASS | LF_TRAIT_FILLED_GLASS | LF_TRAIT_NESTED_GLASS |     \
     LF_TRAIT_SUBSURFACE)
#define LF_TRAITS_LIGHT                                                                            \
    (LF_TRAIT_SUNS | LF_TRAIT_SKY_PICTURES | LF_TRAIT_AREA_LIGHTS | LF_TRAIT_EQUIANGULAR |         \
     LF_TRAIT_BACKDROP)

typedef struct lf_trait_entry {
    lf_traits bit;
    lf_traits of;     /* where that is missing as well, this one is not worth a word; 0: nothing */
    const char *name; /* in a few words, "participating media" */
    const char *has;  /* why it is there, "the scene has some" */
} lf_trait_entry;

/* One for each bit, in their order; NULL behind the last. */
const lf_trait_entry *lf_trait_at(int index);

/* Whether something that is there is not supported; text is then "WHO does not support
 * participating media; the scene has some", else it stays as it is. */
bool lf_traits_missing(lf_traits has, lf_traits supported, const char *who, char *text,
                       size_t size);

#endif
