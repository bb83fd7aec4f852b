/* Samples of a pixel's reservoir, and reservoirs put together (Lin, Wyman and Yuksel 2021,
 * supplement, algorithm 5); private to render/.
 *
 * Printed there, lines 14 and 15: p_sum += p-hat_s(lambda_i) r_i.M and k += r_i.M. It is M of the
 * stream s that belongs to its density, r_s.M: as printed shares come to sum M only where all M are
 * equal, which the reservoir of a visit and that of all visits before it are not. */
#ifndef LF_RENDER_REUSE_H
#define LF_RENDER_REUSE_H

#include "render/general/light_path.h"

/* What a pixel has kept. */
typedef struct lf_path_sample {
    lf_light_path path;
    int kept;      /* 0: no path has arrived, and weight is 0 */
    double target; /* p-hat along the pixel's own ray */
    double weight; /* W (reservoir.h) */
    double m;      /* M; 0: the pixel has not been visited */
} lf_path_sample;

/* One stream. */
typedef struct lf_reuse_input {
    const lf_path_sample *sample;
    const lf_camera_ray *ray; /* whose it is */
    double m;                 /* its M, capped */
} lf_reuse_input;

#define LF_MAX_REUSE 8

/* The best known weights, and the shortcut that reservoir.h tells of. */
typedef enum lf_reuse_weights { LF_REUSE_UNBIASED, LF_REUSE_BIASED } lf_reuse_weights;

/* Draws `n` random walks of one ray into a sample, their first collisions in n strata. */
void lf_path_sample_draw(const lf_path_space *space, const lf_camera_ray *ray, int n,
                         lf_tracer *tracer, lf_path_sample *out);

/* Of n <= LF_MAX_REUSE streams, that of the ray that is to have it first. out is none of theirs.
 * Unbiased if which streams there are does not depend on what they hold. */
void lf_path_sample_combine(const lf_path_space *space, int n, const lf_reuse_input *inputs,
                            lf_reuse_weights weights, lf_tracer *tracer, lf_path_sample *out);

#endif
