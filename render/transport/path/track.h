/* Rays through the scene: surfaces by Embree, volumes by delta and ratio tracking over the grids'
 * bricks (local majorants, one value per brick; Woodcock 1965, Novak et al. 2014). Volumes may
 * overlap. Their collisions are independent processes, so the nearest of one sample each is a
 * collision of the sum. Private to render/. A tracer belongs to one worker; nothing here allocates
 * or locks. All estimates are unbiased for the true (interpolated) fields. */
#ifndef LF_RENDER_TRACK_H
#define LF_RENDER_TRACK_H

#include "render/transport/light/light.h"
#include "render/transport/surface/face.h"

typedef struct lf_tracer {
    const lf_scene *scene;
    /* Random stream of the current path: set before each base sample, and when a path leaves the
     * lanes. */
    uint64_t rng;
    /* Footprint of rays for textures: its diameter at the origin, and its growth per unit of t.
     * Zeroed: no filtering. */
    float width, spread;
    /* Shutter time of rays: 0 when the shutter opens, 1 when it closes. *scene must be at the same
     * time (rows/shutter_time.h). */
    float time;
    /* What lf_path_survives adds to its threshold: 0, or more if a pivot has several suffixes. */
    float roulette;
    int64_t rays; /* counters, never reset here */
    int64_t lookups;
    int64_t nonfinite;
    /* Suffix paths; and how many of them max_depth has ended, each counted by the throughput of its
     * largest channel. */
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

/* In (0, 1), with small numbers as fine as 2^-33, so that events of probability 1e-6 and less have
 * the right frequency. */
static inline float lf_rng_fine(lf_tracer *t)
{
    return lf_min(((float)lf_rng_bits(t) + 0.5f) * 0x1p-32f, 1.0f - 0x1p-24f);
}

/* Optical distance to the next event, -log(1 - u), with full precision also near 0, where thin
 * media collide. */
static inline float lf_exponential(float u)
{
    return u < 0x1p-8f ? u * (1.0f + u * (0.5f + u * (1.0f / 3.0f))) : -logf(1.0f - u);
}

static inline float lf_rng_exponential(lf_tracer *t)
{
    return lf_exponential(lf_rng_fine(t));
}

/* Nearest surface along o + t w, 0 < t < t_max; w need not be unit. true and *hit filled, or false.
 * An alpha surface (lf_cover) is met at random, with the probability of its alpha. */
bool lf_trace_surface(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max, lf_hit *hit);
/* lf_trace_surface with t_min < t. */
bool lf_trace_beyond(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_min, float t_max,
                     lf_hit *hit);
/* lf_trace_surface for camera rays, which pass through meshes hidden from the camera. */
bool lf_trace_seen(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max, lf_hit *hit);
/* Where a ray continues after a hit at t: far enough that Embree, whose threads flush denormals to
 * 0, does not find the same hit again, forever. */
static inline float lf_behind(float t)
{
    return lf_max(nextafterf(t, INFINITY), 1e-30f);
}
/* The nearest surface of any kind with t_min < t <= t_max, without a random decision; textures are
 * not looked up. */
bool lf_trace_next(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_min, float t_max, lf_hit *hit);
/* The nearest thin glass (lf_glass) with t_min < t <= t_max, without a random decision. */
bool lf_trace_thin(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_min, float t_max, lf_hit *hit);
/* The transmittance of surfaces up to t_max: 1 - alpha for each alpha surface (lf_cover), 0 for
 * opaque ones. */
float lf_trace_passed(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max);
/* lf_trace_passed for camera rays. */
float lf_trace_passed_seen(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max);
/* Whether any surface lies between, opaque or alpha. */
bool lf_trace_occluded(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max);
/* The start of a ray that leaves the surface point p towards w, or the end of a ray that comes from
 * there. It is moved off the surface along the unit normal n by the rounding of p and of the start
 * itself, by the rounding of a ray of this length that ends here, and by lf_geometry.offset. n = 0:
 * returns p. */
lf_vec3 lf_offset(const lf_scene *scene, lf_vec3 p, lf_vec3 n, lf_vec3 w, float length);

/* Maximum number of tentative collisions of a ray at the same t. If a grid is so dense that the
 * next collision is within the rounding of t, a ray does not advance, at a point that may itself be
 * empty. It ends there: tracking returns a collision, and the transmittance is 0. For steps of at
 * least half a unit in t's last place, this many at one t have a probability below 1e-12. */
#define LF_MOST_STILL 64

/* First collision with t < t_max, or INFINITY; *out_volume is its volume. w must be unit. */
float lf_track_collision(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max, int *out_volume);
/* Volume emission towards o along [0, t]: an unbiased estimate of int eps ds, or of its product
 * with the attenuation by the glass around the segment (dimming, coloured.h; NULL: none). If t is a
 * collision (or the surface, if there was no collision), the mean is int T eps ds up to the
 * surface, because a path reaches s with the probability T(s). It includes emission where nothing
 * collides. Shapes are exact; a grid is looked up at one point. */
typedef struct lf_dimming lf_dimming;
lf_vec3 lf_track_emission(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t,
                          const lf_dimming *dimming);
/* Unbiased estimate of the transmittance of the volumes along [0, t_max]. */
float lf_track_transmittance(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max);

/* lf_track_collision in chromatic media. One channel is drawn with a probability proportional to
 * the path's throughput (beta, not all 0), and tracked with the majorants of the largest. For each
 * channel, *out_channels is the density of all events of the tracking, real and null collisions,
 * over the mean of that density over the channels that could be drawn. This is the one-sample
 * balance heuristic (Veach 1997, 9.2; over channels Miller, Georgiev and Jarosz 2019): the sum of
 * beta times it is the sum of beta for any events. */
float lf_track_channels(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max, lf_vec3 beta,
                        int *out_volume, lf_vec3 *out_channels);
/* lf_track_transmittance per channel. */
lf_vec3 lf_track_transmittances(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max);

#endif
