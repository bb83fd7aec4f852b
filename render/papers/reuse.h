/* Samples of a pixel's reservoir, and reservoirs put together (Lin, Wyman and Yuksel 2021,
 * supplement, algorithm 5); private to render/.
 *
 * Printed there, lines 14 and 15: p_sum += p-hat_s(lambda_i) r_i.M and k += r_i.M. It is M of the
 * stream s that belongs to its density, r_s.M: as printed shares come to sum M only where all M are
 * equal, which the reservoir of a visit and that of all visits before it are not. */
#ifndef LF_RENDER_REUSE_H
#define LF_RENDER_REUSE_H

#include "render/papers/light_path.h"
#include "render/papers/reservoir.h"

/* What a pixel has kept, and what all that it was offered bring: F* W = sum of weights / M has one
 * colour, that of the path which is kept; `brought` has all of theirs. Both are estimates of the
 * pixel's integral by the coarse grid. */
typedef struct lf_path_sample {
    lf_light_path path;
    lf_path_value value; /* of path along the pixel's own ray */
    lf_vec3 brought;
    int kept;      /* 0: no path has arrived, and weight is 0 */
    double weight; /* W (reservoir.h) */
    double m;      /* M; 0: the pixel has not been visited */
} lf_path_sample;

/* While a sample is put together. */
typedef struct lf_path_keeper {
    lf_reservoir reservoir;
    lf_path_sample *out;
} lf_path_keeper;

/* m: of all that it is going to be offered. */
void lf_path_keeper_begin(lf_path_keeper *keeper, double m, lf_path_sample *out);
/* true: it is the one that is kept now, and the path is to be copied to out->path. u in [0, 1). */
bool lf_path_keeper_offer(lf_path_keeper *keeper, const lf_path_value *value, double weight,
                          double u);
void lf_path_keeper_end(lf_path_keeper *keeper);

/* Final shading: `brought`, and what exact transmittances add to it, of which the kept path is an
 * estimate: F W - F* W. depth: the exact one of its segments. */
lf_vec3 lf_path_sample_radiance(const lf_path_sample *sample, double depth);

/* One stream. */
typedef struct lf_reuse_input {
    const lf_path_sample *sample;
    const lf_camera_ray *ray; /* whose it is */
    double m;                 /* its M, capped */
} lf_reuse_input;

#define LF_MAX_REUSE 8

/* The best known weights, and the shortcut that reservoir.h tells of. */
typedef enum lf_reuse_weights { LF_REUSE_UNBIASED, LF_REUSE_BIASED } lf_reuse_weights;

/* Puts walks of one ray into a sample: the first `taken` of n (0: the ray meets nothing and has had
 * none), and M is n. */
void lf_path_sample_draw(int n, const lf_light_walk *walks, int taken, lf_tracer *tracer,
                         lf_path_sample *out);

/* Of n <= LF_MAX_REUSE streams, that of the ray that is to have it first. out is none of theirs.
 * Unbiased if which streams there are does not depend on what they hold. */
void lf_path_sample_combine(const lf_path_space *space, int n, const lf_reuse_input *inputs,
                            lf_reuse_weights weights, lf_tracer *tracer, lf_path_sample *out);

#endif
