/* The hot loops of a reconstruction, as a table of functions: the same loops (kernel_loops.h)
 * compiled for each instruction set, element by element, so that all give the same bits; private to
 * render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_KERNEL_H
#define LF_RENDER_RECONSTRUCT_KERNEL_H

#include "render/film/film.h"
#include "render/reconstruct/lattice.h"

/* Pixels with a smaller q are not fitted and do not contribute to the fit; their result is their
 * own N/W. */
#define LF_LEAST_Q 1e-4f

/* Arrays [view][column] of one row, as a reconstruction reads it from a film. */
typedef struct lf_pixels {
    float *f[LF_VARIANTS][LF_FEATURES]; /* absolute coordinates; some variants share arrays */
    int *u, *z;                         /* of the cell of level 0 */
    bool *second;                       /* N/W' is less noisy than N/W */
    /* of both halves; if it is not above LF_LEAST_Q all other fields except `second` are undefined
     */
    float *q;
    float (*albedo)[3]; /* above 0; NULL if the film has none */
    float *data;
    int *cells;
} lf_pixels;

static inline bool lf_q_is_fitted(float q)
{
    return q > LF_LEAST_Q && q < 2.0f;
}
static inline bool lf_pixel_is_fitted(const lf_pixels *pixels, size_t i)
{
    return lf_q_is_fitted(pixels->q[i]);
}

/* The halves of one row of one view. */
typedef struct lf_view_row {
    const float *q[2];
    const lf_packed_feature *feature[2];
    const lf_packed_albedo *albedo; /* NULL if the film has none */
    float share[2];                 /* of the samples; 0: q and features are not read */
    float row, view, shift, still;
    float deep;   /* number of finest cells in the depth of the plane Z = D */
    float white;  /* as in lf_reconstruct_view */
    int first, n; /* its pixels in lf_pixels */
} lf_view_row;

/* The planes of all nodes for one row, interpolated between the bands above and below it: constant
 * and slopes for absolute coordinates; the row's own term is included in the constant. */
#define LF_TABLE_TERMS 8 /* 1 and all features except the row */
typedef struct lf_row_table {
    int z0, nz;
    /* [nz]: nodes [u0, u0 + nu), including one without weight on either side; first: of its arrays.
     * A layer without nodes has two without weight. */
    lf_deck *layers;
    float *terms; /* of a layer: [LF_TABLE_TERMS][nu][4] R, G, B; fourth of term 0: weight */
    float *share; /* of a layer: [nu], multiplied by the weight */
    int n_layers; /* allocated */
    size_t size;
} lf_row_table;

/* R of one channel as it is shown: a blend of the prediction x and N/W by its share. n is the
 * received radiance over w, which is 0 if N/W is not valid. A negative prediction -x is wrong by at
 * least x, so its weight is reduced accordingly against the pixel's own N/W. */
static inline float lf_channel_show(float n, float w, float x, float share)
{
    const bool found = w > 0.0f;
    float own = n / (found ? w : 1.0f), least;
    own = found ? own : x;
    least = own < -x ? own : -x;
    least = own > 0.0f ? least : 0.0f;
    x = x < 0.0f ? least : x;
    float mixed = found ? x + share * (own - x) : x;
    return mixed > 0.0f ? mixed : 0.0f;
}

/* lf_channel_show for all channels. predicted: R, G, B and the share of N/W, below 0 if no node is
 * near. */
static inline void lf_pixel_show(const float n[3], float w, const float predicted[4], float out[3])
{
    const bool near = predicted[3] >= 0.0f;
    for (int c = 0; c < 3; c++)
        out[c] = lf_channel_show(n[c], w, near ? predicted[c] : 0.0f, near ? predicted[3] : 1.0f);
}

/* Input for showing pixels. */
typedef struct lf_to_show {
    const lf_film_scattered *scattered[2]; /* of the halves; NULL: no samples; [0] before [1] */
    const float *w2[2];                    /* NULL: W replaces W' */
    float n;                               /* samples of both halves */
    float least;                           /* N/W is valid if W is at least this share of n q */
} lf_to_show;

/* Number of fits that are solved together. */
#define LF_SOLVE_LANES 8

typedef struct lf_reconstruct_kernels {
    /* Features of both halves; with `halves` also of each. Without it, only u, z, q and f[LF_BOTH]
     * of lf_pixels. */
    void (*read)(const lf_view_row *in, bool halves, lf_pixels *out);
    /* Adds one pixel's weight and radiance to moments. */
    void (*add)(lf_moments *m, float w, const float n[3], const float f[LF_FEATURES]);
    /* Adds weight times the sums of `from`, translated by `shift`: f + shift, 0 except for the
     * first three features. Only wff on and above the diagonal is defined. */
    void (*move)(lf_moments *to, const lf_moments *from, float weight,
                 const float shift[LF_FEATURES]);
    /* Weighted least squares of N/W on features, one plane per channel, relative to the position of
     * the moments. Features are centred and scaled to a variance of about 1; ridge 4/W + 1e-3 (W
     * counts pivots). depth: of a finest cell, in pixels at Z = D. Without weight the result is 0.
     * Reads wff on and above the diagonal. */
    void (*solve)(const lf_moments *const moments[LF_SOLVE_LANES], double depth,
                  lf_plane (*const out[LF_SOLVE_LANES])[3]);
    /* The prediction of R for n pixels from `first` on, out [n][4]: R, G, B and the share of N/W,
     * -1 if there is no node. Pixels without features are skipped. */
    void (*predict)(const lf_row_table *table, const lf_pixels *pixels, int first, int n,
                    float (*out)[4]);
    /* R of the first n pixels of a row, as shown. Predictions for pixels without features are
     * ignored. */
    void (*show)(const lf_to_show *in, const lf_pixels *pixels, float (*predicted)[4], int n,
                 float (*out)[3]);
} lf_reconstruct_kernels;

extern const lf_reconstruct_kernels lf_reconstruct_kernels_c;
#if defined(__x86_64__)
extern const lf_reconstruct_kernels lf_reconstruct_kernels_avx2, lf_reconstruct_kernels_avx512;
#endif

#endif
