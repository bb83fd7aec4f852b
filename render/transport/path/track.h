/* Rays through the scene: surfaces by Embree, volumes by delta and ratio tracking over the grids'
 * bricks (local majorants, one value a brick; Woodcock 1965, Novak et al. 2014). Several volumes
 * overlap freely: their collisions are independent processes, so the nearest of one sample each is
 * a collision of the sum. Private to render/; a tracer belongs to one worker; nothing here
 * allocates or locks. Everything is unbiased for the true (interpolated) fields. */
#ifndef LF_RENDER_TRACK_H
#define LF_RENDER_TRACK_H

#include "render/transport/light/light.h"
#include "render/transport/surface/face.h"

typedef struct lf_tracer {
    const lf_scene *scene;
    /* Stream of the path in progress: set before each base sample, and where lanes leave a path. */
    uint64_t rng;
    /* What rays average, where anything varies along surfaces: the diameter where they begin, and
     * what it gains with each unit of t. Zeroed: nothing. */
    float width, spread;
    /* Of rays: 0 when the shutter opens, 1 when it closes. What moves stands there in *scene, too
     * (rows/moment.h). */
    float time;
    int64_t rays; /* counters, never reset here */
    int64_t lookups;
    int64_t nonfinite;
    /* Paths that were followed behind pivots; and how many of them max_depth has ended, each
     * counted as what its largest channel still carried. */
    int64_t suffixes;
    double suffixes_cut;
} lf_tracer;

/* PCG-XSH-RR (O'Neill 2014): 32 bits. */
static inline uint32_t lf_rng_bits(lf_tracer *t)
{
    uint64_t old = t->rng;
    t->rng = old * 6364136223846793005u + 1442695040888963407u;
    uint32_t x = (uint32_t)(((old >> 18) ^ old) >> 27), r = (uint32_t)(old >> 59);
    return (x >> r) | (x << ((32u - r) & 31u));
}

/* In [0, 1), multiples of 2^-24. */
static inline float lf_rng(lf_tracer *t)
{
    return (float)(lf_rng_bits(t) >> 8) * 0x1p-24f;
}

/* In (0, 1), small numbers as fine as 2^-33: events of probability 1e-6 and less come as often as
 * they should. */
static inline float lf_rng_fine(lf_tracer *t)
{
    return lf_min(((float)lf_rng_bits(t) + 0.5f) * 0x1p-32f, 1.0f - 0x1p-24f);
}

/* Optical distance to the next event, -log(1 - u): to full precision also near 0, where thin media
 * collide. */
static inline float lf_exponential(float u)
{
    return u < 0x1p-8f ? u * (1.0f + u * (0.5f + u * (1.0f / 3.0f))) : -logf(1.0f - u);
}

static inline float lf_rng_exponential(lf_tracer *t)
{
    return lf_exponential(lf_rng_fine(t));
}

/* Nearest surface along o + t w, 0 < t < t_max; w need not be unit. true and *hit filled, or false.
 * A veil (lf_cover) is met by chance, as much as is there of it. */
bool lf_trace_surface(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max, lf_hit *hit);
/* The same of those with t_min < t. */
bool lf_trace_beyond(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_min, float t_max,
                     lf_hit *hit);
/* lf_trace_surface for rays of the camera, which pass through meshes that are hidden from it. */
bool lf_trace_seen(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max, lf_hit *hit);
/* Where a ray goes on behind what it has met at t: far enough that Embree, whose threads flush what
 * is smaller to 0, does not find the same again, for ever. */
static inline float lf_behind(float t)
{
    return lf_max(nextafterf(t, INFINITY), 1e-30f);
}
/* The nearest surface of any kind with t_min < t <= t_max, met for sure; what varies along it is
 * not looked up. */
bool lf_trace_next(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_min, float t_max, lf_hit *hit);
/* The nearest pane (lf_glass) with t_min < t <= t_max, met for sure. */
bool lf_trace_thin(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_min, float t_max, lf_hit *hit);
/* What surfaces between let through: of veils (lf_cover) their share. */
float lf_trace_passed(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max);
/* The same for rays of the camera. */
float lf_trace_passed_seen(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max);
/* True when a surface lies between, be it there whole or not. */
bool lf_trace_occluded(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max);
/* The start of a ray that leaves the surface point p towards w, or the end of one that comes from
 * there: moved off the surface along its unit normal n by what p and the start itself are rounded
 * by, by the rounding of a ray of this length that ends here, and by lf_geometry.offset. n = 0: p.
 */
lf_vec3 lf_offset(const lf_scene *scene, lf_vec3 p, lf_vec3 n, lf_vec3 w, float length);

/* How many tentative collisions a ray meets at one and the same t at most. Where a grid is so dense
 * that the next one is within the rounding of t, a ray stands still, at a place that may be empty
 * itself. It ends there: what is tracked collides, and nothing passes. Where steps are half of a
 * unit in t's last place and longer, so many at one t have a probability below 1e-12. */
#define LF_MOST_STILL 64

/* First collision with t < t_max, or INFINITY; *out_volume says whose. w unit. */
float lf_track_collision(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max, int *out_volume);
/* What volumes emit towards o along [0, t], an unbiased estimate of int eps ds, or times what the
 * glass in which the segment lies leaves of it (dimming, coloured.h; NULL: none). Where t is that
 * of a collision (or of the surface, where there was none before it) its mean is int T eps ds up to
 * the surface, since a path comes to s with the probability T(s); it sees flames where nothing
 * collides, too. Shapes are exact, of a grid one point is looked up. */
typedef struct lf_dimming lf_dimming;
lf_vec3 lf_track_emission(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t,
                          const lf_dimming *dimming);
/* Unbiased estimate of the transmittance of the volumes along [0, t_max]. */
float lf_track_transmittance(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max);

/* lf_track_collision in chromatic media: one channel is drawn with a probability in proportion to
 * what of it the path carries (beta, not all 0), and tracked with the majorants of the largest.
 * *out_channels: for each the density of all that tracking has met, real and null collisions, over
 * its mean over the channels that might have been drawn. The balance heuristic for one sample
 * (Veach 1997, 9.2; over channels Miller, Georgiev and Jarosz 2019): beta times it has the sum of
 * beta, whatever was met. */
float lf_track_channels(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max, lf_vec3 beta,
                        int *out_volume, lf_vec3 *out_channels);
/* lf_track_transmittance of each channel. */
lf_vec3 lf_track_transmittances(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max);

#endif
