/* Combination of the paths of a block of pixels by vertex reuse; private to render/.
 *
 * Lin, Wyman and Yuksel (2021, supplement, section 2) compared it with direction reuse and rejected
 * it, because its weights have a pole if the two joined vertices lie close together. Here a path
 * goes to all pixels of its block, and its weight in each is balanced over all of them, which
 * bounds it.
 *
 * Of a path (z_1, x_2, x_3, ... end) a ray takes the distance z_1 and all later vertices, which do
 * not move: its own first vertex x_1 is joined to x_2. In the coordinates of light_path.h this is
 * (w_1, z_2) of the segment from x_1 to x_2, with the Jacobian
 *
 *     |d(w_1, z_2)' / d(w_1, z_2)| = z_2^2 / z_2'^2.
 *
 * A path of one vertex keeps its light sample or its direction, as in direction reuse.
 *
 * The contribution of path i of n, whose reservoirs count M_i, to pixel s is F*_s(lambda_i) W_i
 * m_i,
 *
 *     m_i = M_i q_i / sum_k M_k q_k,
 *
 * with q_k = F*_k in the measure dz_1 dx_2, which is the same for all. M_i W_i q_i z_2^2 is the sum
 * of the weights of stream i's candidates. So the contribution to pixel s, times M_s, never exceeds
 * that sum: there is no pole. A path's F* along all n rays gives its shares and all its
 * contributions: n^2 joints per block, where n pixels with n neighbours of their own each take n^3.
 */
#ifndef LF_RENDER_VERTEX_REUSE_H
#define LF_RENDER_VERTEX_REUSE_H

#include "render/papers/reuse.h"

enum { LF_MAX_BLOCK = 16 };

typedef struct lf_block_pixel {
    const lf_camera_ray *ray;
    const lf_path_sample *sample;
    lf_path_sample *out; /* not one of the samples */
} lf_block_pixel;

/* For n <= LF_MAX_BLOCK pixels. Unbiased if the choice of pixels does not depend on their content.
 */
void lf_path_block_combine(const lf_path_space *space, int n, const lf_block_pixel *pixels,
                           lf_tracer *tracer);

#endif
