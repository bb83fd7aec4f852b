/* The film: the sums of passes, and the three estimates; private to render/.
 *
 * Layout by epipolar row: [row][half][view][column]. All targets of a base path lie in its row, and
 * a row belongs to one thread. So sums take no atomics and no locks, and the sums do not depend on
 * the number of threads. There are two independent halves. Per view pixel and half
 * (docs/developer/estimators.md, "9. The film"):
 *
 *     N   radiance of pivots, weighted
 *     W   prefix weights, E = n q
 *     W'  directional weights, E = n q
 *     q   pivot probability, mean
 *
 * In a pixel that meets only mirrors and smooth glass, all four are for light that is scattered
 * behind them. Per view pixel, for both halves together: the mean of B + M/n, known light and
 * native delta lobes (neither needs cross-fitting). The difference of the halves is also stored in
 * few bits; only the error estimate reads it. Per row and half: the count n, in native samples per
 * view pixel (a real number: expected, not tallied). If every escaping ray finds the same light and
 * there is no other known light, B is sky (1 - q) and not stored. Bytes per view pixel: 40, 48 with
 * W'; 56 and 64 with B; 16 more with features, 20 with albedo as well (film_feature.h), which the
 * reconstruction reads.
 *
 * A visit sums a row in its worker's memory (lf_film_sums), which is merged when the visit is
 * complete. So the film's numbers are rounded once per visit, up or down at random in proportion
 * (stochastic rounding). Sums and means then have no bias and never stagnate. After V visits of a
 * half the standard error of rounding is at most 2^-24 sqrt(V/3) of the sum: 8e-6 at 1e5 native
 * samples per view pixel. */
#ifndef LF_RENDER_FILM_H
#define LF_RENDER_FILM_H

#include "render/film/film_feature.h"
#include "render/render.h"

/* Sums of scattered light in one view pixel: 16 bytes that are written together. */
typedef struct lf_film_scattered {
    float n[3], w;
} lf_film_scattered;

/* B + M/n of both halves, and its difference, half 0 minus half 1 (film_difference.h). */
typedef struct lf_film_known {
    float b[3];
    uint32_t difference;
} lf_film_known;

/* One half of one row; arrays [view][column]. */
typedef struct lf_film_half {
    lf_film_scattered *scattered;
    float *w2; /* W'; NULL if no lobe depends on the view */
    float *q;
    lf_packed_feature *feature; /* NULL without features */
} lf_film_half;

/* The result of one visit of a row; arrays [view][column] in the worker's memory. While holes are
 * filled, `half` points into the film instead. */
typedef struct lf_film_sums {
    lf_film_half half;   /* N, W, W' are sums; q is the value of this visit */
    float (*known)[3];   /* B, the value of this visit; NULL if not stored */
    lf_feature *feature; /* of this visit; NULL if the film has none */
    /* of this visit; NULL if the film has none, or this visit does not look it up */
    float (*albedo)[LF_ALBEDO_NUMBERS];
    /* M, a sum; NULL without delta lobes, equiangular lights and emissive alpha surfaces */
    float (*native)[3];
    size_t zeroed_bytes;
    unsigned char *data;
    /* q, B and features are interpolated: they are kept until another visit computes its own, which
     * then replace them */
    bool coarse;
} lf_film_sums;

/* Which data of a view pixel are stored. */
typedef struct lf_film_layout {
    int n_views, width, height;
    bool has_w2, has_native;
    bool has_known;  /* B is stored: always if M is */
    bool has_delta;  /* M includes delta lobes */
    bool has_signed; /* N and W may cancel, because correction weights of grids have both signs */
    bool has_features;
    bool has_albedo; /* has_features, and the albedo of a surface varies */
} lf_film_layout;

typedef struct lf_film_row {
    double n[2];      /* expected native samples per view pixel in each half */
    double coarse[2]; /* the part of n from coarse visits */
    double passes;    /* n times views, both halves */
    uint32_t visits[2];
    /* nonzero: the plane of at least one visit contained a medium or mesh (reach.h) */
    uint32_t met;
    /* The row has no visit. B, and q and features of half 0, come from a fan without paths; all
     * other data are undefined. The first visit discards them. q < 0: the pixel lies between the
     * rows above and below, and nothing else is known. */
    bool provisional;
    /* Results of the last resolve: */
    double relative_error; /* sum over view pixels of var / (I^2 + epsilon), < 0 = unknown yet */
    int64_t holes;
} lf_film_row;

/* The samples of one random stream in a row; its next visit of a half has the number visits[half].
 */
typedef struct lf_film_counts {
    double n[2]; /* as in lf_film_row */
    uint32_t visits[2];
} lf_film_counts;

/* Limit for a row or a stream's part of it: more is neither added nor read. Two such numbers can be
 * added without overflow. */
#define LF_FILM_MAX_VISITS UINT32_C(0x7fffffff)
/* Whether any sequence of visits could have led to these counts. */
bool lf_film_counts_possible(const lf_film_counts *counts);
bool lf_film_row_possible(const lf_film_row *row);
/* The weights of the halves' means of q, B and features: n of all visits except coarse ones, or of
 * coarse visits if there were no others. If only one half had other visits, the other half uses its
 * q and features. A provisional row: 1 and 0. */
void lf_film_row_known(const lf_film_row *row, double out[2]);

/* Whether either half has a visit. */
static inline bool lf_film_visited(const uint32_t visits[2])
{
    return visits[0] || visits[1];
}

/* Whether a row holds B, q and features. */
static inline bool lf_film_is_known(const lf_film_row *row)
{
    return row->provisional || lf_film_visited(row->visits);
}

/* Per film. */
#define LF_FILM_MAX_STREAMS 65536

/* A stream is identified by a seed and a number (lf_part.stream). */
typedef struct lf_film_stream {
    uint64_t seed;
    uint32_t number;
    lf_film_counts *rows; /* [height] */
} lf_film_stream;

/* The key of its random numbers; for number 0 it is the seed. */
uint64_t lf_film_stream_random(const lf_film_stream *stream);
/* Random bits of its visits of a row; 0: none. Sums of several rounds are keyed by their sum, which
 * does not depend on an order. */
uint64_t lf_film_visits_key(uint64_t seed, uint32_t number, const uint32_t visits[2]);

#define LF_PICTURE_BYTES 32

/* Rows of a large film, of which few are open (film_pack.h). */
typedef struct lf_film_packed lf_film_packed;

typedef struct lf_film {
    lf_film_layout layout;
    /* Identifies the image: films with the same bytes may be added. Set by the owner. */
    uint8_t picture[LF_PICTURE_BYTES];
    int n_views, width, height; /* copies from the layout */
    float sky[3];               /* without has_known: the light of every escaping ray */
    size_t row_bytes;           /* both halves */
    unsigned char *data;        /* mapped, [height][row_bytes]; NULL: packed */
    lf_film_packed *packed;     /* NULL: all rows are open */
    size_t data_bytes;          /* of open rows */
    lf_film_row *rows;          /* [height] the sums over its streams */
    lf_film_stream *streams;    /* sorted by seed, then number */
    int n_streams, n_allocated;
} lf_film;

/* film must be zeroed or finished. sky is set to 0. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_film_init(lf_film *film, const lf_film_layout *layout);
/* The same, for films that use much memory: rows are packed while no one has them open, if the film
 * is large. No thread has more than four rows open at once, and the number of threads that open
 * rows is n_threads and one more. */
LF_NODISCARD lf_status lf_film_init_packed(lf_film *film, const lf_film_layout *layout,
                                           int n_threads);
/* Films from this size on are packed if at most a quarter of their rows are open; 0: all films.
 * Only tests change it. */
extern size_t lf_film_packed_from;
void lf_film_finish(lf_film *film);
/* Releases the numbers of all rows; the counts stay. Then no row may be opened. */
void lf_film_release(lf_film *film);
/* A row's numbers may be read and changed from open to close. changed: they were. Other functions
 * that take a film and a row open it themselves, unless they say that it must be open. A packed row
 * takes a lock for a moment. Thread: any. */
void lf_film_open(const lf_film *film, int row);
void lf_film_close(const lf_film *film, int row, bool changed);
/* lf_film_used_bytes of an open row. */
unsigned char *lf_film_row_at(const lf_film *film, int row);
bool lf_film_same_layout(const lf_film_layout *a, const lf_film_layout *b);
bool lf_film_has_layout(const lf_film *film, const lf_film_layout *layout);
/* Whether b can be added to film: the layouts are equal, and the skies bitwise equal (the sums
 * depend on the sky). */
bool lf_film_alike(const lf_film *film, const lf_film *b);
/* The reason why b is no film of the same image, as text after "it is": another image or layout, or
 * a sky that is not bitwise equal (the sums depend on the sky). NULL: it is one. Reads only these
 * fields of b. */
const char *lf_film_refusal(const lf_film *film, const lf_film *b);
/* Removes all visits. Touches only the row headers. */
void lf_film_clear(lf_film *film);
/* The index of a stream in film->streams, valid until the next call. A new stream is added without
 * visits. Allocates for every stream except the first one of a film. LF_E_NOMEM; LF_E_STATE: more
 * than LF_FILM_MAX_STREAMS. */
LF_NODISCARD lf_status lf_film_stream_at(lf_film *film, uint64_t seed, uint32_t number,
                                         int *out_index);
/* NULL: no such stream. */
const lf_film_stream *lf_film_find_stream(const lf_film *film, uint64_t seed, uint32_t number);
/* Adds `from` to film, of the same views (lf_film_alike): the result is the mean image, weighted by
 * samples. Rows that only one film has visited are copied; others are added (film_sum.h). Exact if
 * the result is a float; otherwise rounded up or down at random, without bias. LF_E_STATE, with no
 * change: they are not alike, a half of a row has visits of the same random stream in both, more
 * visits or samples of a row than possible, more than LF_FILM_MAX_STREAMS. LF_E_NOMEM; then film
 * may have additional streams without visits. */
LF_NODISCARD lf_status lf_film_mix(lf_film *film, const lf_film *from, lf_error *err);
/* Size of the used memory of a row: half 0, half 1, known light, albedo, 32 bits per number. */
size_t lf_film_used_bytes(const lf_film_layout *layout);
/* These, lf_film_row_at, lf_film_sums_of, lf_film_lend_known and lf_film_clear_known are for open
 * rows. */
lf_film_half lf_film_at(const lf_film *film, int row, int half);
/* NULL if B is not stored. */
lf_film_known *lf_film_known_at(const lf_film *film, int row);
/* Whether a row's next visit looks up albedo: the first visits do, and the first that is not
 * coarse. */
static inline bool lf_film_wants_albedo(const lf_film *film, int row)
{
    const lf_film_row *state = &film->rows[row];
    bool whole = state->n[0] + state->n[1] > state->coarse[0] + state->coarse[1];
    return film->layout.has_albedo &&
           (!whole || (uint64_t)state->visits[0] + state->visits[1] < LF_ALBEDO_VISITS);
}
/* [view][column], for both halves; NULL if no surface's albedo varies. */
lf_packed_albedo *lf_film_albedo_at(const lf_film *film, int row);

/* A worker's memory for visits of films of this layout. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_film_sums_init(lf_film_sums *sums, const lf_film_layout *layout);
void lf_film_sums_finish(lf_film_sums *sums);
/* Zeroes the sums; fields with one value per visit must be written. */
void lf_film_sums_begin(lf_film_sums *sums);
/* The film's own memory as sums, for samples after a visit (holes). Without B and M, whose means
 * cannot take samples beyond the count. */
lf_film_sums lf_film_sums_of(const lf_film *film, int row, int half);

/* Results of a visit, into its sums; pixel is [view][column]. lf_film_scatter adds weighted
 * radiance to N, lf_film_weigh adds to W, lf_film_weigh_direction to W' (which must not be NULL).
 */
static inline void lf_film_scatter(const lf_film_sums *sums, size_t pixel, float r, float g,
                                   float b)
{
    float *n = sums->half.scattered[pixel].n;
    n[0] += r;
    n[1] += g;
    n[2] += b;
}
static inline void lf_film_weigh(const lf_film_sums *sums, size_t pixel, float weight)
{
    sums->half.scattered[pixel].w += weight;
}
static inline void lf_film_weigh_direction(const lf_film_sums *sums, size_t pixel, float weight)
{
    sums->half.w2[pixel] += weight;
}
/* Adds `times` times `what` to N and W, in one vector addition of four. */
static inline void lf_film_add_times(const lf_film_sums *sums, size_t pixel, float times,
                                     const lf_film_scattered *what)
{
    typedef float four __attribute__((vector_size(16)));
    four sum, add;
    memcpy(&sum, &sums->half.scattered[pixel], sizeof sum);
    memcpy(&add, what, sizeof add);
    sum += times * add;
    memcpy(&sums->half.scattered[pixel], &sum, sizeof sum);
}
/* Adds to M, which must not be NULL. */
static inline void lf_film_add_native(const lf_film_sums *sums, size_t pixel, float r, float g,
                                      float b)
{
    float *m = sums->native[pixel];
    m[0] += r;
    m[1] += g;
    m[2] += b;
}
/* Sets q of this visit … */
static inline void lf_film_pivots(const lf_film_sums *sums, size_t pixel, float q)
{
    sums->half.q[pixel] = q;
}
/* … the feature of its ray, which must not be NULL … */
static inline void lf_film_note(const lf_film_sums *sums, size_t pixel, lf_feature feature)
{
    sums->feature[pixel] = feature;
}
/* … its albedo, likewise … */
static inline void lf_film_note_albedo(const lf_film_sums *sums, size_t pixel,
                                       const float albedo[LF_ALBEDO_NUMBERS])
{
    memcpy(sums->albedo[pixel], albedo, LF_ALBEDO_NUMBERS * sizeof *albedo);
}
/* … and B, which must not be NULL. */
static inline void lf_film_known_light(const lf_film_sums *sums, size_t pixel, float r, float g,
                                       float b)
{
    float *known = sums->known[pixel];
    known[0] = r;
    known[1] = g;
    known[2] = b;
}

/* Whether scattering is possible but no path has found any yet, in halves with these counts. */
static inline bool lf_film_is_hole(const lf_film_half half[2], const double n[2], size_t pixel)
{
    float q = 0.0f, w = 0.0f;
    for (int h = 0; h < 2; h++) {
        q += n[h] > 0.0 ? half[h].q[pixel] : 0.0f;
        w += n[h] > 0.0 ? half[h].scattered[pixel].w : 0.0f;
    }
    return q > 0.0f && w == 0.0f;
}
/* Marks a hole in which a search found nothing: it counts as dark until a path arrives, whose
 * weight is far larger. */
#define LF_FILM_SETTLED 1e-30f
/* The mark is in half h. What light paths have found in either half is lost, since its divisor
 * would be the mark. */
static inline void lf_film_settle(const lf_film_half half[2], int h, size_t pixel)
{
    half[h].scattered[pixel] = (lf_film_scattered){.w = LF_FILM_SETTLED};
    half[!h].scattered[pixel] = (lf_film_scattered){.w = 0.0f};
}
/* Whether light without a weight may go to half h, in halves with these counts: not if all weight
 * of the pixel is a mark. If the other half has a weight, the visit's sums take the mark of this
 * one back, because it would be the divisor of its light. */
static inline bool lf_film_takes_light(const lf_film_half half[2], const double n[2], int h,
                                       const lf_film_sums *sums, size_t pixel)
{
    const float own = n[h] > 0.0 ? half[h].scattered[pixel].w : 0.0f,
                other = n[!h] > 0.0 ? half[!h].scattered[pixel].w : 0.0f;
    if (own + other == LF_FILM_SETTLED)
        return false;
    float *w = &sums->half.scattered[pixel].w;
    if (own == LF_FILM_SETTLED && *w == 0.0f)
        *w = -LF_FILM_SETTLED;
    return true;
}

/* Records whether a visit's plane contains a medium or mesh. false: no plane of this row ever did,
 * and B is not stored; then the visit only needs to be counted. */
bool lf_film_meet(lf_film *film, int row, bool any);
/* Merges a complete visit of a row by a stream (lf_film_stream_at) into one half: adds the sums,
 * passes / n_views to the expected native samples per view pixel, and 1 to the visits. key: random
 * bits of this visit; passes > 0. Thread: the owner of the row. */
void lf_film_merge(lf_film *film, int stream, int row, int half, const lf_film_sums *sums,
                   double passes, uint64_t key);
/* Only counts a visit whose plane is empty (lf_film_meet). */
void lf_film_count(lf_film *film, int stream, int row, int half, double passes);
/* Makes a row without visits provisional, with B, q (< 0: as above) and features of sums. sums
 * NULL: a fan with an empty plane, if B is not stored. Its delta lobes count as `passes` passes. */
void lf_film_put_provisional(lf_film *film, int row, const lf_film_sums *sums, double passes);
/* If only one half of a row has visits that are not coarse, copies its q and features to the other
 * half (lf_film_row_known). lf_film_merge does this. */
void lf_film_lend_known(const lf_film *film, int row);
/* Removes a half's q and features. */
void lf_film_clear_known(const lf_film *film, int row, int half);

/* See lf_renderer_resolve_row. */
lf_status lf_film_resolve_row(const lf_film *film, lf_estimator estimator, int row, float *out,
                              uint8_t *flags);

/* The divisor of N, for a half or for both: W, or W' if that is less noisy (second). N/W is a
 * weighted mean of received radiance; N/W' is not. W' does not count light samples, and for a
 * narrow lobe without any direction yet it is almost 0, but N is not. In that case W is used. */
static inline float lf_film_weight(float w, float w2, bool second)
{
    return second && w2 > 0.25f * w ? w2 : w;
}
/* Whether N/W' is less noisy than N/W, decided per tile: for every pixel of a row, out
 * [view][column]. false without W', or unless both halves have visits. */
void lf_film_row_second(const lf_film *film, int row, bool *out);

/* For every pixel of a row with visits of both halves: the estimated relMSE of mwis, and q. Arrays
 * [view][column]; unchanged for a row without visits. */
void lf_film_row_errors(const lf_film *film, int row, float *out_error, float *out_q);

/* The estimated variance of every pixel and channel of a row's estimate, s_A s_B (x_A - x_B)^2,
 * into out[pixel * stride + channel]; unchanged unless both halves have visits. */
void lf_film_row_variances(const lf_film *film, lf_estimator estimator, int row, float *out,
                           size_t stride);

/* One row's contribution to the error of the image: means over its view pixels and channels. */
typedef struct lf_row_error {
    double square;    /* of the squared differences: the estimated relMSE of the row */
    double known;     /* the part of it from known light */
    double doubtful;  /* the part of it in pixels where the halves disagree about the brightness */
    double magnitude; /* of the absolute differences */
    double cross;     /* of the products with the next row's differences; 0 in the last row */
} lf_row_error;

/* For every pixel and channel of a row: sqrt(s_A s_B) (x_A - x_B) over the root of an estimate of
 * I^2 + epsilon. Here s are the halves' shares of the samples and x their estimates. The mean
 * square estimates the row's relMSE. Fills `out` [view][column][3], and known and doubtful of
 * *out_row. Returns false, with both unchanged, unless both halves have visits. Also reads the
 * neighbouring rows, so it must not run during their visits. */
bool lf_film_row_differences(const lf_film *film, lf_estimator estimator, int row, float *out,
                             lf_row_error *out_row);

/* rows [n]: an upper bound of the realised relMSE of the image at confidence 1 - alpha;
 * *out_estimate (may be NULL) is its estimate. */
double lf_error_bound(const lf_row_error *rows, int n, double alpha, double *out_estimate);
/* Upper quantile of Student's t with at least 2 degrees of freedom: the value exceeded with
 * probability alpha. */
double lf_upper_quantile(double alpha, double freedom);

#endif
