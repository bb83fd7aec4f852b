/* Paths of a block of pixels put together by vertex reuse; private to render/.
 *
 * Lin, Wyman and Yuksel (2021, supplement, section 2) have measured it against direction reuse and
 * left it, for its weights have a pole where the two vertices that are joined lie close together.
 * Here a path goes to all pixels of its block, and what it counts in each is balanced over them
 * all, which bounds it.
 *
 * Of a path (z_1, x_2, x_3, ... end) a ray takes the distance z_1 and all later vertices, which
 * stay where they are: its own first vertex x_1 is joined to x_2. In the coordinates of
 * light_path.h that is (w_1, z_2) of the segment from x_1 to x_2, with the Jacobian
 *
 *     |d(w_1, z_2)' / d(w_1, z_2)| = z_2^2 / z_2'^2.
 *
 * A path of one vertex takes its light sample or its direction along, as in direction reuse.
 *
 * What path i of n, whose reservoirs count M_i, brings pixel s: F*_s(lambda_i) W_i m_i,
 *
 *     m_i = M_i q_i / sum_k M_k q_k,
 *
 * q_k being F*_k in the measure dz_1 dx_2, the same for all. M_i W_i q_i z_2^2 is the sum of the
 * weights of stream i's candidates, so that what pixel s gets of it, times M_s, is never more than
 * that sum: there is no pole left. A path's F* along all n rays gives its shares and all that it
 * brings: n^2 joints a block, where n pixels with n neighbours of their own each take n^3. */
#ifndef LF_RENDER_VERTEX_REUSE_H
#define LF_RENDER_VERTEX_REUSE_H

#include "render/papers/reuse.h"

enum { LF_MAX_BLOCK = 16 };

typedef struct lf_block_pixel {
    const lf_camera_ray *ray;
    const lf_path_sample *sample;
    lf_path_sample *out; /* not among the samples */
} lf_block_pixel;

/* Of n <= LF_MAX_BLOCK pixels. Unbiased if which pixels there are does not depend on what they
 * hold. */
void lf_path_block_combine(const lf_path_space *space, int n, const lf_block_pixel *pixels,
                           lf_tracer *tracer);

#endif
