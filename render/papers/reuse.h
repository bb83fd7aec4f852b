/* Samples of a pixel's reservoir, and combination of reservoirs (Lin, Wyman and Yuksel 2021,
 * supplement, algorithm 5); private to render/.
 *
 * The printed lines 14 and 15 are p_sum += p-hat_s(lambda_i) r_i.M and k += r_i.M. But the density
 * belongs to M of the stream s, r_s.M. As printed, shares sum to sum M only if all M are equal,
 * which is not the case for the reservoir of a visit and the reservoir of all earlier visits. */
#ifndef LF_RENDER_REUSE_H
#define LF_RENDER_REUSE_H

#include "render/papers/light_path.h"
#include "render/papers/reservoir.h"

/* The kept path of a pixel, and the light of all paths that were offered. F* W = sum of weights / M
 * has the colour of the kept path only; `brought` has the colours of all. Both are estimates of the
 * pixel's integral with the coarse grid. */
typedef struct lf_path_sample {
    lf_light_path path;
    lf_path_value value; /* of path along the pixel's own ray */
    lf_vec3 brought;
    int kept;      /* 0: no path was kept, and weight is 0 */
    double weight; /* W (reservoir.h) */
    double m;      /* M; 0: the pixel has no visit */
} lf_path_sample;

/* A sample during its combination. */
typedef struct lf_path_keeper {
    lf_reservoir reservoir;
    lf_path_sample *out;
} lf_path_keeper;

/* m: of all samples that will be offered. */
void lf_path_keeper_begin(lf_path_keeper *keeper, double m, lf_path_sample *out);
/* true: the sample is kept now, and the caller must copy its path to out->path. u in [0, 1). */
bool lf_path_keeper_offer(lf_path_keeper *keeper, const lf_path_value *value, double weight,
                          double u);
void lf_path_keeper_end(lf_path_keeper *keeper);

/* Final shading: `brought` plus F W - F* W, an estimate of the effect of exact transmittances, from
 * the kept path. depth: the exact optical depth of its segments. */
lf_vec3 lf_path_sample_radiance(const lf_path_sample *sample, double depth);

/* One stream. */
typedef struct lf_reuse_input {
    const lf_path_sample *sample;
    const lf_camera_ray *ray; /* of its pixel */
    double m;                 /* its M, capped */
} lf_reuse_input;

#define LF_MAX_REUSE 8

/* Unbiased weights, and the biased shortcut (reservoir.h). */
typedef enum lf_reuse_weights { LF_REUSE_UNBIASED, LF_REUSE_BIASED } lf_reuse_weights;

/* Combines walks of one ray into a sample: the first `taken` of n (0: the ray meets no media and
 * has no walks); M is n. */
void lf_path_sample_draw(int n, const lf_light_walk *walks, int taken, lf_tracer *tracer,
                         lf_path_sample *out);

/* Combines n <= LF_MAX_REUSE streams; the first must be the one of the receiving ray. out must not
 * be one of their samples. Unbiased if the choice of streams does not depend on their content. */
void lf_path_sample_combine(const lf_path_space *space, int n, const lf_reuse_input *inputs,
                            lf_reuse_weights weights, lf_tracer *tracer, lf_path_sample *out);

#endif
