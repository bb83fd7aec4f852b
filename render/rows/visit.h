/* A visit of a row: from base samples to sums on the film; private to render/. Each way of
 * spreading a pivot over the views is a file (vpt.c, mvpt.c). They share everything else (visit.c).
 */
#ifndef LF_RENDER_VISIT_H
#define LF_RENDER_VISIT_H

#include "render/film/film.h"
#include "render/integrator.h"
#include "render/plane/alpha.h"
#include "render/plane/media.h"
#include "render/plane/reach.h"
#include "render/plane/row_emission.h"
#include "render/plane/section.h"
#include "render/rows/adaptive.h"
#include "render/rows/between.h"
#include "render/rows/equiangular_row.h"
#include "render/rows/shutter_time.h"
#include "render/rows/splitting.h"
#include "render/scene/fault.h"
#include "render/transport/lanes/suffix.h"
#include "render/transport/path/face_albedo.h"
#include "render/transport/path/path.h"
#include "render/transport/path/suffix_one.h"
#include "render/transport/path/sunlight.h"
#include "render/transport/sampler.h"
#include "render/visit_lattice.h"

struct lf_visit;
struct lf_visit_plan;
struct lf_pivot;
struct lf_suffix;
struct lf_queue;
struct lf_extinction;
struct lf_prefix_factor;
struct lf_light_paths;

/* All traits except cameras that form no rig. */
#define LF_ROWS_SUPPORT                                                                            \
    (LF_TRAITS_PLAIN_SURFACES | LF_TRAITS_GLASS | LF_TRAITS_SEEN_THROUGH | LF_TRAIT_CATCHERS |     \
     LF_TRAIT_REFLECTIONS | LF_TRAITS_PLAIN_MEDIA | LF_TRAIT_CHROMATIC_MEDIA |                     \
     LF_TRAIT_VOLUME_EMISSION | LF_TRAITS_LIGHT | LF_TRAIT_MOTION | LF_TRAIT_LENS |                \
     LF_TRAIT_VIEW_BLUR | LF_TRAIT_FEATURES)

/* How base samples are spread over the views. Each member of the table (rows.c) is one file. */
typedef struct lf_sharing {
    lf_integrator_entry entry; /* shares: other views receive contributions */
    int suffixes;              /* per pivot, if lanes trace them */
    bool adaptive;             /* after a pilot, base samples go where the error is (adaptive.h) */
    /* Spreads one pivot over the views that see it. given: its suffix; NULL: draw one. */
    void (*pivot)(struct lf_visit *visit, int view, int column, const struct lf_pivot *pivot,
                  const struct lf_suffix *given);
    /* Equiangular lights (equiangular_row.h): spreads a light sample at a point that was drawn
     * around the light, to `view` or to all views that see it. */
    void (*equiangular)(struct lf_visit *visit, int view, const struct lf_pivot *pivot,
                        const lf_light_sample *light);
    /* Light paths: the density with which base samples draw a pivot on a surface and a direction
     * from there, per unit area and solid angle, for one native sample of every view pixel. NULL:
     * this sharing takes no light paths. */
    float (*over)(struct lf_visit *visit, int view, int column, const struct lf_pivot *pivot,
                  lf_vec3 wi);
    /* Reweights the suffix of a base pivot in a medium for the points that equiangular sampling
     * draws. */
    void (*balance)(struct lf_visit *visit, int view, int column, const struct lf_pivot *pivot,
                    struct lf_suffix *suffix);
} lf_sharing;

extern const lf_sharing lf_sharing_vpt, lf_sharing_mvpt, lf_sharing_amvpt;

/* A cache of triangles that the fans of a row met recently; the index is the segment modulo this
 * size. */
enum { LF_FAN_FACES = 256 };
typedef struct lf_fan_face {
    int segment; /* -1: none */
    lf_face face;
    lf_sunlight_face sunlight;
    lf_face_albedo albedo; /* at the film point where the visit looks albedo up */
} lf_fan_face;

/* The outlines in a row (outlines.h). */
typedef struct lf_outlines {
    lf_section edge;   /* the meshes cut at its lower edge, without alpha surfaces */
    lf_section alphas; /* the alpha surfaces */
    uint32_t *groups;  /* [column] bits of view groups with an outline */
    bool *views;       /* [column][view] views with an outline */
} lf_outlines;

/* The outlines of all rows, each found by the first visit that needs it; for static scenes and
 * cameras. All zero: not used. */
typedef struct lf_outline_map {
    uint32_t *bits; /* [row][words] of [column][view] */
    size_t words;
    uint8_t *found; /* [row] whether the row was searched, and has outlines */
} lf_outline_map;

/* The surfaces and media that the fan's rays meet. */
typedef struct lf_fan_met {
    int segment[LF_MAX_LANES];  /* of the section, -1: no surface */
    int material[LF_MAX_LANES]; /* of that segment, -1: no surface */
    lf_fan_face face[LF_FAN_FACES];
    lf_media_moments moments;       /* of collisions, if features are needed */
    uint32_t smooth[LF_MAX_CHUNKS]; /* for a row between two others: lf_between_mark */
    lf_outlines outlines;           /* valid if lf_visit.outlines */
} lf_fan_met;

/* The channels of a fan if media are chromatic. A base ray draws a channel and is tracked in its
 * extinction only; prefix densities are for such a ray, D_k = h_k mean_c sigma_t T_k. Each
 * view receives each channel with its own density (docs/developer/estimators/coloured-media.md,
 * "Prefixes"). Index [channel * lanes + lane], for the lanes in use. */
typedef struct lf_channels {
    float tau[3 * LF_MAX_LANES], scale[3 * LF_MAX_LANES], density[3 * LF_MAX_LANES],
        factor[3 * LF_MAX_LANES];
    /* of a pivot: the three parts of `density`, or three times lf_scratch.density without chromatic
     * media */
    const float *received[3];
} lf_channels;

/* What a ray of the fan sees of alpha surfaces and thin glass: the fraction that they stop, their
 * features, and the fraction left behind them. */
typedef struct lf_alpha_seen {
    float cover, left;
    float nearness, spread; /* mean and standard deviation, as in lf_media_moments */
    float light;            /* lf_feature */
    float albedo[LF_ALBEDO_NUMBERS];
} lf_alpha_seen;

/* Alpha surfaces of a row's plane. */
enum { LF_ALPHA_FACES = 64 };
typedef struct lf_alpha_memory {
    lf_section section;
    lf_alpha_seen seen[LF_MAX_LANES]; /* if features are needed */
    lf_fan_face face[LF_ALPHA_FACES]; /* as in lf_fan_met */
    bool mirrored[LF_MAX_LANES]; /* whether one in front of the end of ray k has a delta lobe */
    lf_alpha_walk walk;          /* for volume emission between them */
} lf_alpha_memory;

/* One worker's memory. */
typedef struct lf_scratch {
    _Alignas(LF_CACHE_LINE) lf_tracer tracer;
    lf_media media;
    lf_row_emission_memory emission; /* volume emission */
    lf_film_sums sums;               /* of the current visit */
    lf_reach reach;                  /* of its row's plane */
    lf_section section;              /* meshes without alpha surfaces */
    lf_alpha_memory alpha;           /* alpha surfaces */
    lf_equiangular_row equiangular;  /* equiangular lights */
    int64_t base_paths, contributions, base_hidden;
    /* Lanes of the current fan. */
    float x0[LF_MAX_LANES], slope[LF_MAX_LANES], z_end[LF_MAX_LANES], tau[LF_MAX_LANES],
        sigma[LF_MAX_LANES];
    float scale[LF_MAX_LANES], density[LF_MAX_LANES], lobe[LF_MAX_LANES];
    /* expected counts of the lanes' pixels, as in lf_visit.expected */
    float count[LF_MAX_LANES];
    /* count times density: the density with which the pivot is drawn */
    float strategy[LF_MAX_LANES];
    float factor[LF_MAX_LANES]; /* correction weights (correction.h) */
    lf_channels channels;
    float length[LF_MAX_LANES]; /* of the fan's rays, per unit of Z */
    lf_fan_met met;
    int column[LF_MAX_LANES];
    /* directions to the views in the frame of a surface's shading normal (z) */
    float local[3][LF_MAX_LANES];
    float f[3][LF_MAX_LANES]; /* of a surface's lobes: lf_fan_lobes.f */
    /* [view][column]: the visit's row of the map of counts */
    float *expected;
    /* [view][column]: B and q met a delta lobe here or in a neighbour; NULL without M */
    bool *mirrors;
} lf_scratch;

/* A shared pivot: the point where a base ray found something that scatters. */
typedef struct lf_pivot {
    lf_event event;
    int medium; /* of a collision: index into the worker's media */
    float x, z; /* camera space; y follows from the row's plane */
    float lx;   /* the base ray's lens offset, copied to every view */
    /* 1, or q if the collision was forced (docs/developer/estimators.md, "3. Passes, visits and
     * expected counts"), times lf_visit.weight */
    float forced_weight;
    /* on thin glass (lf_glass), which reflects natively: the pivot has weight, but sends no
     * radiance */
    bool is_thin;
    lf_sampler *sampler; /* continues with the pivot's own dimensions */
} lf_pivot;

/* Identifies the visit of a row; it determines all random numbers of the visit. */
typedef struct lf_visit_number {
    uint64_t key;   /* of its half's random numbers */
    uint32_t index; /* its number in its half */
} lf_visit_number;

/* The prefix factors that apply to a plane (prefix_factor.h). */
enum { LF_PREFIX_FACTORS = 3 };
typedef struct lf_prefix_list {
    int n;
    bool received, along; /* at least one factor has this function */
    const struct lf_prefix_factor *factor[LF_PREFIX_FACTORS];
} lf_prefix_list;

/* One visit of one row: the data that the integrators need. */
typedef struct lf_visit {
    const struct lf_visit_plan *plan;
    const lf_scene *scene;
    const lf_rig *rig;
    const lf_kernels *kernels;
    /* of the visit's samples and equiangular points; acting: the current one, which differs while
     * holes are filled */
    const lf_sharing *sharing, *acting;
    const lf_row_triangles *triangles; /* NULL: no meshes */
    lf_scratch *worker;
    struct lf_queue *queue; /* the plan's while base samples are drawn, else NULL */
    lf_film_sums sums;      /* the worker's; while holes are filled, the film's own half */
    lf_row_plane plane;
    lf_prefix_list prefix; /* of this plane */
    const struct lf_extinction *extinction;
    int row, half;
    lf_visit_number number;
    bool outlines; /* this visit takes more film points at worker->met.outlines */
    int max_depth;
    int subsets;
    lf_splitting splitting;   /* of a pivot on a surface that sends the same to every view */
    lf_visit_lattice lattice; /* of base pixels */
    uint64_t random;          /* this visit's own */
    float weight;             /* of every base sample: 1, except for holes */
    /* [view][column] expected base samples of a pixel, in units of subsets / n_views; NULL: 1
     * everywhere. 0 in pixels that no reader needs: no sample is drawn there, they are excluded
     * from every sum, and they receive no contributions. */
    const float *expected;
    /* Native samples that each pixel of worker->mirrors draws for itself, in addition to base
     * samples or instead of them (visit.c); more: the same in units of subsets / n_views. */
    int mirror_rounds;
    float more;
    /* 1 / expected at the base pixel: the weight of a sample that only its own pixel receives */
    float alone;
    unsigned faults; /* lf_fault: deliberate mistakes, for the negative controls of the tests */
} lf_visit;

/* Draws the visit's points around equiangular lights. weight: native samples per pixel of the
 * visit. false: cancelled. */
bool lf_equiangular_visit(lf_visit *visit, float weight, const lf_cancel *cancel);
/* lf_equiangular_row_ratio at a pivot where base samples have the density sum exp(-depth), as in
 * lf_kernels.densities. */
float lf_equiangular_ratio(const lf_visit *visit, const lf_pivot *pivot, const lf_light *light,
                           int view, float sum, float depth);
/* Adds the density of points around equiangular lights to the pdfs of the suffix: of its light
 * sample, and of the light that its direction hit. */
void lf_equiangular_balance(const lf_visit *visit, const lf_pivot *pivot, int view, float sum,
                            float depth, lf_suffix *suffix);

/* Sets worker->local to the directions from a hit to the views (mvpt.c). */
void lf_fan_look_back(const lf_visit *visit, const lf_hit *hit);

/* Initialises all of a pivot except its position. The hit, most of its memory, is not initialised:
 * rays write it. */
void lf_pivot_begin(lf_pivot *pivot, lf_vec3 w, float lens, lf_sampler *sampler);

/* Lanes [from, to) of the worker as rays from the cameras. */
lf_rays lf_visit_rays(const lf_visit *visit, int from, int to);

/* The meshes in the visit's plane without alpha surfaces, and the alpha surfaces. */
lf_row_cut lf_visit_section(const lf_visit *visit);
lf_row_cut lf_visit_alphas(const lf_visit *visit);

/* Whether the pixel (view, column) has a base sample in this visit. Each pixel has one with
 * probability subsets / n_views, each column equally often, and every pixel after a whole cycle. */
bool lf_lattice_has(const lf_visit *visit, int view, int column);

/* The suffixes of a pivot, if each draws for one view: in vpt, and where the lobe does not depend
 * on the view. */
static inline lf_splitting lf_visit_splitting(const lf_visit *visit, const lf_event *event)
{
    const bool splits =
        event->kind == LF_EVENT_SURFACE && !lf_is_view_dependent(visit->scene, event);
    return splits ? visit->splitting : LF_SPLITTING_NONE;
}
/* Ends the mean over n suffixes. */
static inline lf_vec3 lf_visit_mean(const lf_visit *visit, lf_vec3 sum, int n)
{
    return n > 1 && !lf_has_fault(visit, LF_FAULT_NO_MEAN) ? lf_scale(sum, 1.0f / (float)n) : sum;
}

/* The film index [view][column] at which view k of the worker's lanes receives a pivot's light. */
static inline size_t lf_visit_pixel(const lf_visit *visit, int k)
{
    int view = lf_has_fault(visit, LF_FAULT_SWAPPED_VIEWS) ? visit->rig->n_views - 1 - k : k;
    return (size_t)view * (size_t)visit->rig->width + (size_t)visit->worker->column[k];
}

/* All inputs of a visit of a row. */
typedef struct lf_visit_plan {
    const lf_scene *scene;
    const lf_rig *rig;
    /* owns scene and rig, and is set by the visit; moving: its source; NULL: static scene */
    lf_shutter_time *shutter;
    const lf_moving *moving;
    const lf_media_frame *frame, *emissive; /* of the scene's volumes, and of their emission */
    const lf_kernels *kernels;
    /* pivots whose suffixes lanes trace; NULL: suffixes are traced one at a time */
    struct lf_queue *queue;
    const lf_sharing *sharing;
    const lf_sharing *native;          /* fills holes: shares nothing */
    const lf_row_triangles *triangles; /* as in lf_visit */
    lf_outline_map outlines;           /* borrowed */
    lf_film *film;
    lf_sampler_kind sampler;
    int max_depth;
    lf_splitting splitting;             /* of diffuse pivots, and of roulette */
    unsigned skip;                      /* lf_skip: optimisations in use */
    const struct lf_light_paths *light; /* NULL: no light paths */
    lf_visit_order order;               /* `cover` forces collisions */
    const lf_counts *pilot;             /* where a pilot stores its marks; NULL: no pilot */
    /* expected counts of base samples; NULL: uniform. Needs order.column_step 1 */
    const lf_counts *counts;
} lf_visit_plan;

/* Runs a visit on one worker; false: cancelled in the middle, and the row's sums must be discarded.
 */
bool lf_visit_row(const lf_visit_plan *plan, int row, int half, lf_scratch *worker,
                  const lf_cancel *cancel);

/* The film point of a pixel column in this visit, in [0, 1) of its width; key is the half's stream.
 * Together with the row offset of the visit, the first of lf_hash64(key, 0), these points form a
 * net over the pixel. */
float lf_unscattered_film_point(uint64_t key, int column, uint32_t index);

/* B and q of one row for this visit (unscattered_row.c), into the visit's sums. A coarse visit uses
 * slices without correction. Between two fans (LF_UNSCATTERED_COARSE) it interpolates in views
 * without an edge there, between the film points that the columns would have had. between: of a
 * coarse visit; pixels marked in worker->met.smooth are not computed (between.h), and their q is
 * -1. */
void lf_unscattered_row(const lf_visit *visit, bool between);

/* Takes the film points of the row's outlines in another plane, which has been cut (outlines.h). */
void lf_unscattered_outlines(const lf_visit *visit, int plane);

/* Whether every camera ray that meets nothing sees the same light. */
bool lf_unscattered_constant(const lf_scene *scene, float out_sky[3]);
/* Whether, in addition, the sky does not change while the shutter is open, and every object
 * scatters to all views and emits nothing, also volumes. B is then sky (1 - q) in every pixel.
 * false with chromatic media. */
bool lf_unscattered_uniform(const lf_scene *scene, float out_sky[3]);

#endif
