/* What a section answers, found by rays: where a row's plane cuts so many triangles of instances
 * that their segments would take longer to find and more memory than rays do (section_instances.h).
 * Exact as segments are; a ray for each view in place of one look for all of them. Private to
 * render/rows/. */
#ifndef LF_RENDER_SECTION_RAYS_H
#define LF_RENDER_SECTION_RAYS_H

#include "render/plane/alpha.h"

/* From more segments of instances on. Finding so many takes about as long as the rays of a visit.
 */
#define LF_SECTION_MOST ((size_t)1 << 19)

/* lf_section_hide of a section without segments. */
void lf_section_hide_by_rays(const lf_row_cut *cut, lf_vec3 p, const lf_hit *on, int n,
                             const float *c, float *scale);
/* lf_section_nearest: what it meets becomes the section's segments. */
void lf_section_nearest_by_rays(const lf_row_cut *cut, const lf_lines *lines, float *z,
                                int *segment);
/* lf_alphas_along. */
void lf_section_alphas_by_rays(const lf_row_cut *alphas, const lf_lines *lines, const float *z_end,
                               float *through, bool *mirrors, lf_alpha_crossings *kept);
/* The veils of the rays that want them, from `first` on (lf_alphas_to). */
void lf_section_crossings_by_rays(const lf_row_cut *alphas, const lf_lines *lines,
                                  const float *z_end, lf_alpha_crossings *ray);

#endif
