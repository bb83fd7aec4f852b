/* The queries of a section, answered by rays. They replace segments where a row's plane cuts so
 * many triangles of instances that rays take less time and memory (section_instances.h). As exact
 * as segments, but one ray per view instead of one search for all views. Private to render/plane/.
 */
#ifndef LF_RENDER_SECTION_RAYS_H
#define LF_RENDER_SECTION_RAYS_H

#include "render/plane/alpha.h"

/* Number of segments of instances from which rays are used. Finding this many takes about as long
 * as the rays of a visit. */
#define LF_SECTION_MOST ((size_t)1 << 19)

/* lf_section_hide for a section without segments. */
void lf_section_hide_by_rays(const lf_row_cut *cut, lf_vec3 p, const lf_hit *on, int n,
                             const float *c, float *scale);
/* lf_section_nearest; the hits become the section's segments. */
void lf_section_nearest_by_rays(const lf_row_cut *cut, const lf_lines *lines, float *z,
                                int *segment);
/* lf_alphas_along with rays. */
void lf_section_alphas_by_rays(const lf_row_cut *alphas, const lf_lines *lines, const float *z_end,
                               float *through, bool *mirrors, lf_alpha_crossings *kept);
/* The crossings of rays with `wanted` set, from `first` on (lf_alphas_to). */
void lf_section_crossings_by_rays(const lf_row_cut *alphas, const lf_lines *lines,
                                  const float *z_end, lf_alpha_crossings *ray);

#endif
