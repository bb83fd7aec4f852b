/* The scalars of a material, from file to hit: one struct of floats, and one table of their ranges;
 * private to render/. File readers clamp by the table, answers of reader processes are checked by
 * it, and scene files are parsed by it.
 *
 * A row is a field: its name, which is also its key in scene files, its range, its default value,
 * and its name in warnings. NULL: no warning if a file's value is clamped. */
#ifndef LF_RENDER_PRINCIPLED_H
#define LF_RENDER_PRINCIPLED_H

#include "render/scene/key.h"
#include "render/scene/vec.h"

#define LF_MAX_ABSORPTION 1e9
#define LF_LEAST_SUBSURFACE 1e-6 /* its inverse square must be a float */

/* clang-format off */
/* For all kinds of surfaces. */
#define LF_PRINCIPLED_COMMON(NUMBER, COLOUR, ANGLE)                                                \
    COLOUR(emission, 0, LF_MAX_RADIANCE, 0, "emission") /* radiance from both sides */             \
    NUMBER(alpha, 0, 1, 1, "alpha")                     /* opacity */                              \
    NUMBER(alpha_cutoff, 0, 1, 0.5, NULL)               /* LF_COVER_MASK: opaque from here on */

/* For layered surfaces; other kinds have some of them. Names are from Blender and glTF. */
#define LF_PRINCIPLED_LAYERS(NUMBER, COLOUR, ANGLE)                                                \
    COLOUR(albedo, 0, 1, 0.5, "colour")                                                            \
    /* perceptual: alpha = roughness^2; alpha below LF_ALPHA_MIN is a delta lobe (mirror) */       \
    NUMBER(roughness, 0, 1, 0.3, "roughness")                                                      \
    NUMBER(metallic, 0, 1, 0, "metallic")                                                          \
    NUMBER(ior, 1, LF_MAX_INDEX, 1.5, "index of refraction")                                       \
    NUMBER(specular, 0, 1, 1, "specular")             /* of the dielectric reflection ... */       \
    COLOUR(specular_tint, 0, 1, 1, "specular colour") /* ... and its colour */                     \
    NUMBER(coat, 0, 1, 0, "clear coat")               /* top layer, of index 1.5 */                \
    NUMBER(coat_roughness, 0, 1, 0, "roughness of the clear coat")                                 \
    COLOUR(sheen, 0, 1, 0, "sheen")                   /* fibres perpendicular to the surface */    \
    NUMBER(sheen_roughness, 0, 1, 0.5, "roughness of the sheen")                                   \
    /* of the dielectric part, share of transmitted instead of diffuse light */                    \
    NUMBER(transmission, 0, 1, 0, "transmission")                                                  \
    /* interior medium of a solid, per scene unit, and its Henyey-Greenstein asymmetry */          \
    COLOUR(absorption, 0, LF_MAX_ABSORPTION, 0, "absorption")                                      \
    COLOUR(scattering, 0, LF_MAX_ABSORPTION, 0, "scattering")                                      \
    NUMBER(g, -0.999, 0.999, 0, "g")                                                               \
    /* share of the part that is neither metal nor glass that scatters below the surface, and      \
     * the mean free path of each channel there, in scene units */                                 \
    NUMBER(subsurface, 0, 1, 0, "subsurface")                                                      \
    COLOUR(subsurface_radius, LF_LEAST_SUBSURFACE, LF_MAX_COORDINATE, 0.1, "subsurface radius")    \
    /* along the grooves alpha is lerp(alpha, 1, anisotropy^2); rotation: from the tangent to      \
     * the wider direction */                                                                      \
    NUMBER(anisotropy, 0, 1, 0, "anisotropy")                                                      \
    ANGLE(anisotropy_rotation, -3600, 3600, 0, NULL)                                               \
    NUMBER(priority, -1000, 1000, 0, "priority") /* the highest wins where solids overlap */
/* clang-format on */

#define LF_PRINCIPLED(NUMBER, COLOUR, ANGLE)                                                       \
    LF_PRINCIPLED_LAYERS(NUMBER, COLOUR, ANGLE)                                                    \
    LF_PRINCIPLED_COMMON(NUMBER, COLOUR, ANGLE)

#define LF_NUMBER_FIELD(name, ...) float name;
#define LF_COLOUR_FIELD(name, ...) lf_vec3 name;
#define LF_ANGLE_FIELD(name, ...) float name[2]; /* cosine, sine */

/* Contains only floats. */
typedef struct lf_principled {
    LF_PRINCIPLED(LF_NUMBER_FIELD, LF_COLOUR_FIELD, LF_ANGLE_FIELD)
} lf_principled;

#define LF_PRINCIPLED_FLOATS (sizeof(lf_principled) / sizeof(float))

/* Members of a struct that has these scalars: by name, and all of them as `p`. */
#define LF_PRINCIPLED_MEMBERS                                                                      \
    union {                                                                                        \
        lf_principled p;                                                                           \
        struct {                                                                                   \
            LF_PRINCIPLED(LF_NUMBER_FIELD, LF_COLOUR_FIELD, LF_ANGLE_FIELD)                        \
        };                                                                                         \
    }

/* One row per scalar. Types are LF_PARAM_NUMBER, _COLOUR and _ANGLE. The place is the offset in
 * lf_principled of a float, or of an angle's two floats. help is the name in warnings. */
#define LF_DECLARE_PRINCIPLED(name, ...) extern const lf_param lf_principled_##name;
LF_PRINCIPLED(LF_DECLARE_PRINCIPLED, LF_DECLARE_PRINCIPLED, LF_DECLARE_PRINCIPLED)
#undef LF_DECLARE_PRINCIPLED

/* The rows as a list, ended by NULL. */
extern const lf_param *const lf_principled_rows[];

/* All default values. */
lf_principled lf_principled_usual(void);

/* The first row whose value is out of range, is NaN or, for an angle, is not on the unit circle
 * (except for rounding). NULL: all are valid. */
const lf_param *lf_principled_wrong(const lf_principled *p);

/* Whether a key belongs to a row. If so, sets its field to the value from the scene file. */
bool lf_principled_take(lf_principled *p, const lf_param *key, const lf_value *value);

/* The n floats of a row's field. */
static inline float *lf_principled_at(lf_principled *p, const lf_param *row, int *out_n)
{
    *out_n = row->type == LF_PARAM_COLOUR ? 3 : row->type == LF_PARAM_ANGLE ? 2 : 1;
    return (float *)p + row->place / sizeof(float);
}

#endif
