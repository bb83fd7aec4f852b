/* The hot loops of a reconstruction, behind a table of functions: the same loops (kernel_loops.h)
 * compiled for each instruction set, element by element, so that all give the same bits; private to
 * render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_KERNEL_H
#define LF_RENDER_RECONSTRUCT_KERNEL_H

#include "render/film/film.h"
#include "render/reconstruct/lattice.h"

/* What has less is not fitted, nor fitted to: N/W of the pixel itself is its answer. */
#define LF_LEAST_Q 1e-4f

/* Arrays [view][column] of one row, as a reconstruction reads it from a film. */
typedef struct lf_pixels {
    float *f[LF_VARIANTS][LF_FEATURES]; /* absolute coordinates; some variants share arrays */
    int *u, *z;                         /* of the cell of level 0 */
    bool *second;                       /* N/W' is less noisy than N/W */
    /* of both halves; where it is not above LF_LEAST_Q all else but `second` is undefined */
    float *q;
    float (*albedo)[3]; /* above 0; NULL where the film has none */
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
    const lf_packed_albedo *albedo; /* NULL: the film has none */
    float share[2];                 /* of the samples; 0: q and features are not looked at */
    float row, view, shift, still;
    float deep;   /* finest cells in the depth of the plane Z = D */
    float white;  /* lf_reconstruct_view's */
    int first, n; /* its pixels in lf_pixels */
} lf_view_row;

/* The planes of all nodes as one row sees them, in between the bands above and below it: constant
 * and slopes for absolute coordinates; the row's own is in the constant. */
#define LF_TABLE_TERMS 8 /* 1 and all features but the row */
typedef struct lf_row_table {
    int z0, nz;
    /* [nz]: nodes [u0, u0 + nu), one more to either side of those that are there; first: of its
     * arrays. Without nodes: two that have no weight. */
    lf_deck *layers;
    float *terms; /* of a layer: [LF_TABLE_TERMS][nu][4] R, G, B; fourth of term 0: weight */
    float *share; /* of a layer: [nu], times the weight */
    int n_layers; /* allocated */
    size_t size;
} lf_row_table;

/* R of one channel as it is shown: the prediction x, and N/W by its share. n was found, over w,
 * which is 0 where that is no answer. A prediction of -x is off by x at least: of what the pixel
 * itself has found it does not outweigh as much. */
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

/* All of them. predicted: R, G, B and the share of N/W, below 0 where no node is near. */
static inline void lf_pixel_show(const float n[3], float w, const float predicted[4], float out[3])
{
    const bool near = predicted[3] >= 0.0f;
    for (int c = 0; c < 3; c++)
        out[c] = lf_channel_show(n[c], w, near ? predicted[c] : 0.0f, near ? predicted[3] : 1.0f);
}

/* What pixels are shown from. */
typedef struct lf_to_show {
    const lf_film_scattered *scattered[2]; /* of the halves; NULL: it has nothing; [0] before [1] */
    const float *w2[2];                    /* NULL: W stands for W' */
    float n;                               /* samples of both */
    float least;                           /* W is an answer from this share of n q on */
} lf_to_show;

/* Fits that are made side by side. */
#define LF_SOLVE_LANES 8

typedef struct lf_reconstruct_kernels {
    /* Features of both halves; with `halves` also of each. Without, of lf_pixels alone u, z, q and
     * f[LF_BOTH]. */
    void (*read)(const lf_view_row *in, bool halves, lf_pixels *out);
    /* Adds one pixel's weight and radiance to moments. */
    void (*add)(lf_moments *m, float w, const float n[3], const float f[LF_FEATURES]);
    /* Adds weight times the sums of `from` as seen from a place `shift` away: f + shift, 0 but
     * for the first three features. wff on and above the diagonal alone; below it is undefined. */
    void (*move)(lf_moments *to, const lf_moments *from, float weight,
                 const float shift[LF_FEATURES]);
    /* Weighted least squares of N/W on features, a plane a channel, from where the moments are
     * seen. Features are centred and scaled to a variance of about 1; ridge 4/W + 1e-3 (W counts
     * pivots). depth: of a finest cell, in pixels at Z = D. Without weight: 0. Looks at wff on and
     * above the diagonal. */
    void (*solve)(const lf_moments *const moments[LF_SOLVE_LANES], double depth,
                  lf_plane (*const out[LF_SOLVE_LANES])[3]);
    /* The prediction of R for n pixels from `first` on, out [n][4]: R, G, B and the share of N/W,
     * -1 where there is no node. Pixels without features are left out. */
    void (*predict)(const lf_row_table *table, const lf_pixels *pixels, int first, int n,
                    float (*out)[4]);
    /* R of n pixels, a row's from the first on, as they are shown; what is predicted of pixels
     * without features is not looked at. */
    void (*show)(const lf_to_show *in, const lf_pixels *pixels, float (*predicted)[4], int n,
                 float (*out)[3]);
} lf_reconstruct_kernels;

extern const lf_reconstruct_kernels lf_reconstruct_kernels_c;
#if defined(__x86_64__)
extern const lf_reconstruct_kernels lf_reconstruct_kernels_avx2, lf_reconstruct_kernels_avx512;
#endif

#endif
