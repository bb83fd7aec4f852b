/* Traits: properties of a scene, its camera and its output that an integrator must know of, one bit
 * each. The traits of a scene are found when it is committed (lf_scene.traits). The traits of a
 * view follow from its settings (lf_view_traits). Integrators and lanes list the traits that they
 * support; everything else is refused. So a new trait is never rendered wrong without an error.
 * Thread: any; no state. */
#ifndef LF_RENDER_TRAITS_H
#define LF_RENDER_TRAITS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef uint64_t lf_traits;

#define LF_TRAIT(bit) (UINT64_C(1) << (bit))

/* Surfaces of at least one mesh. */
#define LF_TRAIT_SURFACES LF_TRAIT(0)       /* a mesh */
#define LF_TRAIT_INSTANCES LF_TRAIT(1)      /* an instanced mesh */
#define LF_TRAIT_HIDDEN_MESHES LF_TRAIT(2)  /* a mesh hidden from the camera */
#define LF_TRAIT_VARYING LF_TRAIT(3)        /* a property varies over a mesh … */
#define LF_TRAIT_VARYING_ALBEDO LF_TRAIT(4) /* … the albedo … */
#define LF_TRAIT_VERTEX_COLOURS LF_TRAIT(5) /* … by vertex colours */
#define LF_TRAIT_MIRRORS LF_TRAIT(6)        /* a delta lobe */
/* A lobe depends on the view: media with g != 0, all surfaces except diffuse ones. */
#define LF_TRAIT_VIEW_LOBES LF_TRAIT(7)
#define LF_TRAIT_EMISSION LF_TRAIT(8) /* a surface emits */
/* Faces of area lights coincide with other faces: light sampling counts the one that a ray meets.
 */
#define LF_TRAIT_OVERLAPS LF_TRAIT(9)
#define LF_TRAIT_ALPHA LF_TRAIT(10)      /* an alpha surface */
#define LF_TRAIT_THIN_GLASS LF_TRAIT(11) /* thin glass (lf_glass.is_thin) */
#define LF_TRAIT_ROUGH_GLASS LF_TRAIT(12)
#define LF_TRAIT_FILLED_GLASS LF_TRAIT(13) /* with an absorbing or scattering interior */
#define LF_TRAIT_NESTED_GLASS LF_TRAIT(14) /* glass solids inside glass solids (nest.h) */
#define LF_TRAIT_SUBSURFACE LF_TRAIT(15)   /* subsurface.h */
#define LF_TRAIT_CATCHERS LF_TRAIT(16)     /* a shadow catcher … */
#define LF_TRAIT_REFLECTIONS LF_TRAIT(17)  /* … and a reflection catcher */
/* Volumes. */
#define LF_TRAIT_MEDIA LF_TRAIT(18)
#define LF_TRAIT_HOMOGENEOUS_MEDIA LF_TRAIT(19) /* constant density, no grid */
#define LF_TRAIT_NEAREST_VOXELS LF_TRAIT(20)    /* interpolation "nearest" */
#define LF_TRAIT_CHROMATIC_MEDIA LF_TRAIT(21)   /* sigma_t differs between channels */
#define LF_TRAIT_VARYING_MEDIA LF_TRAIT(22)     /* the albedo is a grid */
#define LF_TRAIT_TWO_LOBES LF_TRAIT(23)         /* in the phase function */
#define LF_TRAIT_VOLUME_EMISSION LF_TRAIT(24)
/* Light. */
#define LF_TRAIT_SUNS LF_TRAIT(25)         /* a light at infinity without an image */
#define LF_TRAIT_SKY_PICTURES LF_TRAIT(26) /* a light at infinity with an image */
#define LF_TRAIT_AREA_LIGHTS LF_TRAIT(27)  /* lights at a distance, including emissive meshes … */
#define LF_TRAIT_EQUIANGULAR LF_TRAIT(28)  /* … in or near media (equiangular.h) */
#define LF_TRAIT_BACKDROP LF_TRAIT(29)
/* Of the view; the first also of the scene. */
#define LF_TRAIT_MOTION LF_TRAIT(30) /* something moves while the shutter is open */
#define LF_TRAIT_LENS LF_TRAIT(31)
#define LF_TRAIT_VIEW_BLUR LF_TRAIT(32)
#define LF_TRAIT_LISTED_CAMERAS LF_TRAIT(33)
/* The film keeps the data for reconstruction (lf_render_settings.features). */
#define LF_TRAIT_FEATURES LF_TRAIT(34)
#define LF_N_TRAITS 35

/* Groups that loops test together. */
#define LF_TRAITS_SEEN_THROUGH (LF_TRAIT_ALPHA | LF_TRAIT_THIN_GLASS) /* lf_is_alpha_surface */
#define LF_TRAITS_FILLED (LF_TRAIT_FILLED_GLASS | LF_TRAIT_SUBSURFACE)
#define LF_TRAITS_SIDED (LF_TRAIT_ROUGH_GLASS | LF_TRAIT_SUBSURFACE) /* lf_is_sided */

/* Groups that the transport code supports for every integrator that uses its rays, light and lobes.
 */
#define LF_TRAITS_PLAIN_SURFACES                                                                   \
    (LF_TRAIT_SURFACES | LF_TRAIT_INSTANCES | LF_TRAIT_HIDDEN_MESHES | LF_TRAIT_VARYING |          \
     LF_TRAIT_VARYING_ALBEDO | LF_TRAIT_VERTEX_COLOURS | LF_TRAIT_VIEW_LOBES | LF_TRAIT_EMISSION | \
     LF_TRAIT_OVERLAPS)
/* Surfaces alone, seen by pinholes in rows. */
#define LF_TRAITS_SURFACE_SCENES                                                                   \
    (LF_TRAITS_PLAIN_SURFACES | LF_TRAIT_MIRRORS | LF_TRAIT_ROUGH_GLASS | LF_TRAIT_FILLED_GLASS |  \
     LF_TRAIT_ALPHA | LF_TRAIT_SUNS | LF_TRAIT_SKY_PICTURES | LF_TRAIT_AREA_LIGHTS |               \
     LF_TRAIT_BACKDROP | LF_TRAIT_FEATURES)
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
    lf_traits of;     /* trait without which this one need not be reported; 0: none */
    const char *name; /* a short noun, "participating media" */
    const char *has;  /* the reason, "the scene has some" */
} lf_trait_entry;

/* One for each bit, in their order; NULL after the last. */
const lf_trait_entry *lf_trait_at(int index);

/* Whether a trait in `has` is not in `supported`. If so, text is "WHO does not support
 * participating media; the scene has some"; otherwise it is unchanged. */
bool lf_traits_missing(lf_traits has, lf_traits supported, const char *who, char *text,
                       size_t size);

#endif
