/* Surfaces that are not there whole (glTF's alpha: leaves, lace, curtains), cut by a row's plane:
 * how much of them lies between a point and each view, and along the rays of a fan; private to
 * render/. They are a section of their own. What they let through is a factor of D_k, evaluated for
 * each view and never a coin: where a base sample ends is chosen by chance, and that chance is part
 * of D_k (docs/estimators.md, "Veils"). */
#ifndef LF_RENDER_VEIL_H
#define LF_RENDER_VEIL_H

#include "render/rows/section.h"

/* A section of veils, and where it lies. */
typedef struct lf_veils {
    const lf_section *section;
    const lf_row_triangles *rows;
    const lf_scene *scene;
    const lf_rig *rig;
    const lf_row_plane *plane;
} lf_veils;

/* Multiplies scale[k] by what all veils between the point p and the camera position c[k] let
 * through; arguments as of lf_section_hide. */
void lf_veils_before(const lf_veils *veils, lf_vec3 p, const lf_hit *on, int n, const float *c,
                     float *scale);

/* Along the rays of lf_section_nearest, in front of z_end[k]: multiplies through[k] by what veils
 * let through, and sets mirrors[k] where one of them has delta lobes. */
void lf_veils_along(const lf_veils *veils, float s0, int n, const float *c, const float *z_end,
                    float *through, bool *mirrors);

#endif
