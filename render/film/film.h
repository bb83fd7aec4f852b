/* The film: what passes leave behind, and the three answers; private to render/.
 *
 * Row-major by epipolar row: [row][half][view][column]. All targets of a base path lie in its row
 * and a row belongs to one thread, so there are no atomics and no locks, and the sums do not depend
 * on the number of threads. Two independent halves; per view pixel and half
 * (docs/developer/estimators.md, "9. The film"):
 *
 *     N   radiance of pivots, weighted
 *     W   prefix weights, E = n q
 *     W'  directional weights, E = n q
 *     q   pivot probability, mean
 *
 * Where a pixel meets nothing but mirrors and smooth glass, all four are of what is scattered
 * behind these. Per view pixel, of both halves together: B + M/n, known light and native delta
 * lobes, mean (neither needs cross-fitting), with the halves' difference in few bits, which only
 * the error estimate reads. Per row and half: the count n, in native samples a view pixel (a real
 * number: expected, not tallied). Where every escaping ray finds the same light and nothing else is
 * known, B is sky (1 - q) and not stored. Bytes a view pixel: 40, 48 with W'; 56 and 64 with B; 16
 * more with features, 20 with albedo as well (film_feature.h), which the reconstruction reads.
 *
 * A visit sums a row in its worker's memory (lf_film_sums) and is merged when it is whole: what the
 * film holds is rounded once a visit, up or down at random in proportion (stochastic rounding), so
 * that sums and means have no bias and never stagnate. After V visits of a half the standard error
 * of rounding is at most 2^-24 sqrt(V/3) of the sum: 8e-6 at 1e5 native samples a view pixel. */
#ifndef LF_RENDER_FILM_H
#define LF_RENDER_FILM_H

#include "render/film/film_feature.h"
#include "render/render.h"

/* What scattering left in one view pixel: 16 bytes that are written together. */
typedef struct lf_film_scattered {
    float n[3], w;
} lf_film_scattered;

/* B + M/n of both halves, and its difference between them: half 0 minus half 1 (film_difference.h).
 */
typedef struct lf_film_known {
    float b[3];
    uint32_t difference;
} lf_film_known;

/* One half of one row; arrays [view][column]. */
typedef struct lf_film_half {
    lf_film_scattered *scattered;
    float *w2; /* W'; NULL where no lobe depends on the view */
    float *q;
    lf_packed_feature *feature; /* NULL where nobody wants them */
} lf_film_half;

/* What one visit of a row finds; arrays [view][column] in memory of the worker's own, but where
 * holes are filled: then `half` is the film's own. */
typedef struct lf_film_sums {
    lf_film_half half;   /* N, W, W' are sums, q the value of this visit */
    float (*known)[3];   /* B, the value of this visit; NULL where it is not stored */
    lf_feature *feature; /* of this visit; NULL where the film has none */
    float (*albedo)[LF_ALBEDO_NUMBERS]; /* likewise, or this visit does not look for it */
    float (*native)[3]; /* M, a sum; NULL without delta lobes, lights in media, veils that glow */
    size_t zeroed_bytes;
    unsigned char *data;
    /* q, B and features are interpolated: they are kept until a visit has found its own, and count
     * for nothing beside those */
    bool coarse;
} lf_film_sums;

/* What of a view pixel is kept. */
typedef struct lf_film_layout {
    int n_views, width, height;
    bool has_w2, has_native;
    bool has_known;  /* B is stored: always where M is */
    bool has_delta;  /* M is of delta lobes too */
    bool has_signed; /* N and W may cancel: correction weights of grids have both signs */
    bool has_features;
    bool has_albedo; /* has_features, and the albedo of some surface varies */
} lf_film_layout;

typedef struct lf_film_row {
    double n[2];      /* expected native samples a view pixel in each half */
    double coarse[2]; /* of these, those of coarse visits */
    double passes;    /* n times views, both halves */
    uint32_t visits[2];
    uint32_t met; /* nonzero: some visit's plane held something to be met (reach.h) */
    /* never visited: B, and q and features of half 0, are those of a fan without paths, and all
     * else is undefined; they are gone with the first visit. q < 0: the pixel lies between those
     * above and below it, nothing else is known of it */
    bool provisional;
    /* Left by the last resolve: */
    double relative_error; /* sum over view pixels of var / (I^2 + epsilon), < 0 = not known */
    int64_t holes;
} lf_film_row;

/* What one random stream has given a row: its next visit of a half is number visits[half]. */
typedef struct lf_film_counts {
    double n[2]; /* as in lf_film_row */
    uint32_t visits[2];
} lf_film_counts;

/* What no row or share of one goes beyond: more is neither added up nor read. Two such numbers have
 * a sum. */
#define LF_FILM_MAX_VISITS UINT32_C(0x7fffffff)
/* Whether some visits could have led to these counts. */
bool lf_film_counts_possible(const lf_film_counts *counts);
bool lf_film_row_possible(const lf_film_row *row);
/* What the halves' q, B and features are means over: n of all visits but coarse ones, or of these
 * where there were no others. Where one half had others and one had not, its q and features are
 * those of the other. A provisional row: 1 and 0. */
void lf_film_row_known(const lf_film_row *row, double out[2]);

/* Whether there was any of the halves' visits. */
static inline bool lf_film_visited(const uint32_t visits[2])
{
    return visits[0] || visits[1];
}

/* Whether a row holds B, q and features. */
static inline bool lf_film_is_known(const lf_film_row *row)
{
    return row->provisional || lf_film_visited(row->visits);
}

/* Of one film. */
#define LF_FILM_MAX_STREAMS 65536

/* A stream is a seed and a number (lf_part.stream). */
typedef struct lf_film_stream {
    uint64_t seed;
    uint32_t number;
    lf_film_counts *rows; /* [height] */
} lf_film_stream;

/* What its random numbers follow from; that of number 0 is the seed. */
uint64_t lf_film_stream_random(const lf_film_stream *stream);

#define LF_PICTURE_BYTES 32

typedef struct lf_film {
    lf_film_layout layout;
    /* What it is a picture of: films with the same bytes may be added. The owner's to set. */
    uint8_t picture[LF_PICTURE_BYTES];
    int n_views, width, height; /* the layout's */
    float sky[3];               /* without has_known: what every escaping ray finds */
    size_t row_bytes;           /* both halves */
    unsigned char *data;        /* mapped, [height][row_bytes] */
    size_t data_bytes;
    lf_film_row *rows;       /* [height] the sums over its streams */
    lf_film_stream *streams; /* ascending by seed, then number */
    int n_streams, n_allocated;
} lf_film;

/* film must be zeroed or finished. sky is left 0. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_film_init(lf_film *film, const lf_film_layout *layout);
void lf_film_finish(lf_film *film);
bool lf_film_has_layout(const lf_film *film, const lf_film_layout *layout);
/* Whether b's numbers can stand beside film's: their layouts are one, and their skies to the bit
 * (what was gathered under it is in the sums). */
bool lf_film_alike(const lf_film *film, const lf_film *b);
/* Why b's numbers cannot be film's, in words behind "it is": another picture or layout, or another
 * sky to the bit (what was gathered under it is in the sums). NULL: they can. Of b only what these
 * are is looked at. */
const char *lf_film_refusal(const lf_film *film, const lf_film *b);
/* Nothing has been visited. Touches only the row headers. */
void lf_film_clear(lf_film *film);
/* The place of a stream in film->streams, until the next call; one that is not there comes in with
 * nothing visited. Allocates for every stream but the first of a film. LF_E_NOMEM; LF_E_STATE: it
 * would be one more than LF_FILM_MAX_STREAMS. */
LF_NODISCARD lf_status lf_film_stream_at(lf_film *film, uint64_t seed, uint32_t number,
                                         int *out_index);
/* NULL: it is not there. */
const lf_film_stream *lf_film_find_stream(const lf_film *film, uint64_t seed, uint32_t number);
/* Adds what is on `from`: rows that one film alone has visited are copied, the others' sums are
 * added, halves to halves, and means taken by the counts. Exact, but for rounding up or down at
 * random, without bias and the same whichever film is added to which, where a sum or mean is no
 * float. LF_E_STATE, and nothing is changed: lf_film_refusal, a half of a row where both
 * have visits of the same random stream, more visits or samples of a row than is possible, more
 * than LF_FILM_MAX_STREAMS. LF_E_NOMEM, with streams that have no visits. */
LF_NODISCARD lf_status lf_film_add(lf_film *film, const lf_film *from, lf_error *err);
/* The same of films of whatever pictures, if they are alike: what comes out is the picture that
 * lies between, each having its share of the samples. LF_E_STATE also where they are not. */
LF_NODISCARD lf_status lf_film_mix(lf_film *film, const lf_film *from, lf_error *err);
/* The memory of a row that holds something: half 0, half 1, known light, albedo, 32 bits a number.
 */
size_t lf_film_used_bytes(const lf_film_layout *layout);
lf_film_half lf_film_at(const lf_film *film, int row, int half);
/* NULL where B is not stored. */
lf_film_known *lf_film_known_at(const lf_film *film, int row);
/* Whether a row's next visit is one of those that look for albedo: the first ones, and the first
 * that is not coarse. */
static inline bool lf_film_wants_albedo(const lf_film *film, int row)
{
    const lf_film_row *state = &film->rows[row];
    bool whole = state->n[0] + state->n[1] > state->coarse[0] + state->coarse[1];
    return film->layout.has_albedo &&
           (!whole || (uint64_t)state->visits[0] + state->visits[1] < LF_ALBEDO_VISITS);
}
/* [view][column], of both halves; NULL where no surface's albedo varies. */
lf_packed_albedo *lf_film_albedo_at(const lf_film *film, int row);

/* A worker's memory for visits of films of this layout. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_film_sums_init(lf_film_sums *sums, const lf_film_layout *layout);
void lf_film_sums_finish(lf_film_sums *sums);
/* Zeroes the sums; what has one value a visit is left to be written. */
void lf_film_sums_begin(lf_film_sums *sums);
/* The film's own memory as sums, for what is found behind a visit (holes): without B and M, whose
 * means take no samples beyond the count. */
lf_film_sums lf_film_sums_of(const lf_film *film, int row, int half);

/* What a visit finds, into its sums; pixel is [view][column]. To N: radiance, weighted; to W; to W'
 * (which must be there). */
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
/* To N and W, so many times as much, in one addition of four. */
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
/* To M, which must be there. */
static inline void lf_film_add_native(const lf_film_sums *sums, size_t pixel, float r, float g,
                                      float b)
{
    float *m = sums->native[pixel];
    m[0] += r;
    m[1] += g;
    m[2] += b;
}
/* q of this visit … */
static inline void lf_film_pivots(const lf_film_sums *sums, size_t pixel, float q)
{
    sums->half.q[pixel] = q;
}
/* … what its ray met, which must be there … */
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
/* … and B, which must be there. */
static inline void lf_film_known_light(const lf_film_sums *sums, size_t pixel, float r, float g,
                                       float b)
{
    float *known = sums->known[pixel];
    known[0] = r;
    known[1] = g;
    known[2] = b;
}

/* True where something scatters and none of it was found yet, in halves with these counts. */
static inline bool lf_film_is_hole(const lf_film_half half[2], const double n[2], size_t pixel)
{
    float q = 0.0f, w = 0.0f;
    for (int h = 0; h < 2; h++) {
        q += n[h] > 0.0 ? half[h].q[pixel] : 0.0f;
        w += n[h] > 0.0 ? half[h].scattered[pixel].w : 0.0f;
    }
    return q > 0.0f && w == 0.0f;
}
/* A hole that was looked into in vain counts as dark until a path arrives, whose weight is beyond
 * comparison. */
static inline void lf_film_settle(const lf_film_half *half, size_t pixel)
{
    half->scattered[pixel].w = 1e-30f;
}

/* Notes whether a visit's plane holds anything to be met. false: no plane of this row ever did, and
 * B is not stored: the visit is only to be counted. */
bool lf_film_meet(lf_film *film, int row, bool any);
/* Adds a whole visit of a row by a stream (lf_film_stream_at) to one half: the sums, passes /
 * n_views expected native samples a view pixel, one to its visits. key: random bits of this visit's
 * own; passes > 0. Thread: whoever owns the row. */
void lf_film_merge(lf_film *film, int stream, int row, int half, const lf_film_sums *sums,
                   double passes, uint64_t key);
/* The same for a visit that could meet nothing (lf_film_meet): it only counts. */
void lf_film_count(lf_film *film, int stream, int row, int half, double passes);
/* A row that was never visited becomes provisional: with B, q (< 0: as above) and features of sums
 * (NULL: a fan that could meet nothing, where B is not stored), whose delta lobes stand for so many
 * passes. */
void lf_film_put_provisional(lf_film *film, int row, const lf_film_sums *sums, double passes);
/* Where one half of a row has had other visits than coarse ones and one has not: gives this what
 * lf_film_row_known says. A merge does. */
void lf_film_lend_known(const lf_film *film, int row);
/* Forgets a half's q and features. */
void lf_film_clear_known(const lf_film *film, int row, int half);

/* See lf_renderer_resolve_row. */
lf_status lf_film_resolve_row(const lf_film *film, lf_estimator estimator, int row, float *out,
                              uint8_t *flags);

/* What N is divided by, of a half or of both: W, or W' where that is the less noisy one (second).
 * N/W is a weighted mean of what was found, N/W' is not: W' does not count light samples, and where
 * no direction of a narrow lobe has arrived yet it is next to nothing and N is not. W stands in
 * there. */
static inline float lf_film_weight(float w, float w2, bool second)
{
    return second && w2 > 0.25f * w ? w2 : w;
}
/* Where N/W' is less noisy than N/W, by tiles: of every pixel of a row, out [view][column]. Without
 * W', or unless both halves have been visited, nowhere. */
void lf_film_row_second(const lf_film *film, int row, bool *out);

/* Of every pixel of a row that both halves have seen: the estimated relMSE of mwis, and q. Arrays
 * [view][column]; left as they are for a row that was never visited. */
void lf_film_row_errors(const lf_film *film, int row, float *out_error, float *out_q);

/* The estimated variance of every pixel and channel of a row's answer, s_A s_B (x_A - x_B)^2, into
 * out[pixel * stride + channel]; untouched unless both halves have been visited. */
void lf_film_row_variances(const lf_film *film, lf_estimator estimator, int row, float *out,
                           size_t stride);

/* What one row tells about the error of the picture: means over its view pixels
 * and channels. */
typedef struct lf_row_error {
    double square;    /* of the differences: the row's relMSE, estimated */
    double known;     /* the part of it that known light alone makes */
    double doubtful;  /* the part of it where the halves do not agree how bright a pixel is */
    double magnitude; /* mean of their absolute values */
    double cross;     /* of their products with the next row's; 0 in the last row */
} lf_row_error;

/* Of every pixel and channel of a row: sqrt(s_A s_B) (x_A - x_B) over the root of what stands for
 * I^2 + epsilon, s the halves' shares of the samples and x their answers; its mean square estimates
 * the row's relMSE. out [view][column][3]; of *out_row known and doubtful. false, and both
 * untouched, unless both halves have been visited. Reads the rows beside it, too: not while one of
 * them is being visited. */
bool lf_film_row_differences(const lf_film *film, lf_estimator estimator, int row, float *out,
                             lf_row_error *out_row);

/* rows [n]: an upper bound of the realised relMSE of the picture at confidence 1 - alpha;
 * *out_estimate (may be NULL) its estimate. */
double lf_error_bound(const lf_row_error *rows, int n, double alpha, double *out_estimate);
/* Of Student's t with 2 degrees of freedom or more: what it is above with probability alpha. */
double lf_upper_quantile(double alpha, double freedom);

#endif
