/* How a visit of a row turns base samples into sums on the film; private to render/. How a pivot is
 * spread over the views is a file each (vpt.c, mvpt.c); everything around it is shared (visit.c).
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

/* All but cameras that are no rig. */
#define LF_ROWS_SUPPORT                                                                            \
    (LF_TRAITS_PLAIN_SURFACES | LF_TRAITS_GLASS | LF_TRAITS_SEEN_THROUGH | LF_TRAIT_CATCHERS |     \
     LF_TRAIT_REFLECTIONS | LF_TRAITS_PLAIN_MEDIA | LF_TRAIT_CHROMATIC_MEDIA |                     \
     LF_TRAIT_VOLUME_EMISSION | LF_TRAITS_LIGHT | LF_TRAIT_MOTION | LF_TRAIT_LENS |                \
     LF_TRAIT_VIEW_BLUR | LF_TRAIT_FEATURES)

/* How what a base sample finds is spread over the views. A member of the table (rows.c) is one
 * file. */
typedef struct lf_sharing {
    lf_integrator_entry entry; /* shares: other views receive contributions */
    int suffixes;              /* of a pivot, where they are drawn in lanes */
    bool adaptive;             /* behind a pilot base samples go where the error is (adaptive.h) */
    /* Spreads one pivot over the views that see it; given: its suffix, NULL: it is drawn. */
    void (*pivot)(struct lf_visit *visit, int view, int column, const struct lf_pivot *pivot,
                  const struct lf_suffix *given);
    /* Lights in media (equiangular_row.h): spreads a sample of one of them at a point that was
     * drawn about it: to `view`, or to all that see it … */
    void (*equiangular)(struct lf_visit *visit, int view, const struct lf_pivot *pivot,
                        const lf_light_sample *light);
    /* … and makes room for such points in the suffix of a pivot in a medium that the base drew. */
    void (*balance)(struct lf_visit *visit, int view, int column, const struct lf_pivot *pivot,
                    struct lf_suffix *suffix);
} lf_sharing;

extern const lf_sharing lf_sharing_vpt, lf_sharing_mvpt, lf_sharing_amvpt;

/* Triangles that the fans of a row have met lately, by the segment modulo their number. */
enum { LF_FAN_FACES = 256 };
typedef struct lf_fan_face {
    int segment; /* -1: none */
    lf_face face;
    lf_sunlight_face sunlight;
    lf_face_albedo albedo; /* where a visit looks for it */
} lf_fan_face;

/* Where outlines run through a row (outlines.h). */
typedef struct lf_outlines {
    lf_section edge;   /* the meshes in its lower edge, but for veils */
    lf_section alphas; /* ... and those */
    uint32_t *groups;  /* [column] of views that have one there */
    bool *views;       /* [column][view] which they are */
} lf_outlines;

/* The same of all rows, found by the first visit of each that asked: for scenes and cameras that
 * stand still. All zero: nothing is kept. */
typedef struct lf_outline_map {
    uint32_t *bits; /* [row][words] of [column][view] */
    size_t words;
    uint8_t *found; /* [row] whether the row has been looked at, and has some */
} lf_outline_map;

/* What the fan's rays meet. */
typedef struct lf_fan_met {
    int segment[LF_MAX_LANES];  /* of the section, -1: no surface */
    int material[LF_MAX_LANES]; /* its, -1: no surface */
    lf_fan_face face[LF_FAN_FACES];
    lf_media_moments moments;       /* of its collisions, where features are wanted */
    uint32_t smooth[LF_MAX_CHUNKS]; /* of a row between two others: lf_between_mark */
    lf_outlines outlines;           /* where lf_visit.outlines */
} lf_fan_met;

/* The channels of a fan where media are chromatic: prefix densities are those of a base ray that
 * draws one of them and is tracked in that alone, D_k = h_k mean_c sigma_t T_k, and what a view
 * receives is each channel's own (docs/developer/estimators/coloured-media.md, "Prefixes").
 * [channel * lanes + lane], as many lanes as are in work. */
typedef struct lf_channels {
    float tau[3 * LF_MAX_LANES], scale[3 * LF_MAX_LANES], density[3 * LF_MAX_LANES],
        factor[3 * LF_MAX_LANES];
    /* of a pivot: those in `density`, or lf_scratch.density three times where there is no colour */
    const float *received[3];
} lf_channels;

/* What a ray of the fan sees of veils and panes: how much of it they stop, what that is like, and
 * how much is left behind them. */
typedef struct lf_alpha_seen {
    float cover, left;
    float nearness, spread; /* mean and standard deviation, as of lf_media_moments */
    float light;            /* lf_feature */
    float albedo[LF_ALBEDO_NUMBERS];
} lf_alpha_seen;

/* Veils of a row's plane. */
enum { LF_ALPHA_FACES = 64 };
typedef struct lf_alpha_memory {
    lf_section section;
    lf_alpha_seen seen[LF_MAX_LANES]; /* where features are wanted */
    lf_fan_face face[LF_ALPHA_FACES]; /* as lf_fan_met has them */
    bool mirrored[LF_MAX_LANES];      /* whether one before ray k has a delta lobe */
    lf_alpha_walk walk;               /* of what volumes emit among them */
} lf_alpha_memory;

/* One worker's memory. */
typedef struct lf_scratch {
    _Alignas(LF_CACHE_LINE) lf_tracer tracer;
    lf_media media;
    lf_row_emission_memory emission; /* what they emit */
    lf_film_sums sums;               /* of the visit under way */
    lf_reach reach;                  /* of its row's plane */
    lf_section section;              /* the meshes in it, but for veils */
    lf_alpha_memory alpha;           /* ... and those */
    lf_equiangular_row equiangular;  /* the lights in its media */
    int64_t base_paths, contributions, base_hidden;
    /* Lanes of the fan in work. */
    float x0[LF_MAX_LANES], slope[LF_MAX_LANES], z_end[LF_MAX_LANES], tau[LF_MAX_LANES],
        sigma[LF_MAX_LANES];
    float scale[LF_MAX_LANES], density[LF_MAX_LANES], lobe[LF_MAX_LANES];
    /* expected counts of the lanes' pixels, as in lf_visit.expected */
    float count[LF_MAX_LANES];
    float strategy[LF_MAX_LANES]; /* count times density: what the pivot is drawn with */
    float factor[LF_MAX_LANES];   /* correction weights (correction.h) */
    lf_channels channels;
    float length[LF_MAX_LANES]; /* of the fan's rays, per unit of Z */
    lf_fan_met met;
    int column[LF_MAX_LANES];
    /* directions to the views in the frame of a surface's shading normal (z) */
    float local[3][LF_MAX_LANES];
    float term[LF_FAN_TERMS][LF_MAX_LANES]; /* of a surface's lobes: lf_fan_lobes.weight */
    /* [view][column]: where a visit keeps its row of the map */
    float *expected;
    /* [view][column]: B and q have found a delta lobe here or beside it; NULL without M */
    bool *mirrors;
} lf_scratch;

/* A shared pivot: where a base ray found something that scatters. */
typedef struct lf_pivot {
    lf_event event;
    int medium;          /* of a collision: index into the worker's media */
    float x, z;          /* camera space; y follows from the row's plane */
    float lx;            /* the base ray's lens offset, copied to every view */
    float forced_weight; /* 1, or q when the collision was forced (docs/developer/estimators.md, "3.
                    Passes, visits and expected counts") */
    bool is_thin; /* of a pane (lf_glass), which reflects natively: it weighs and sends nothing */
    lf_sampler *sampler; /* goes on with the pivot's own dimensions */
} lf_pivot;

/* Which visit of its row: all that it draws follows from this. */
typedef struct lf_visit_number {
    uint64_t key;   /* of its half's random numbers */
    uint32_t index; /* its number in its half */
} lf_visit_number;

/* The factors of a plane (prefix_factor.h). */
enum { LF_PREFIX_FACTORS = 3 };
typedef struct lf_prefix_list {
    int n;
    bool received, along; /* one of them has such a function */
    const struct lf_prefix_factor *factor[LF_PREFIX_FACTORS];
} lf_prefix_list;

/* One visit of one row: what the integrators need of it. */
typedef struct lf_visit {
    const struct lf_visit_plan *plan;
    const lf_scene *scene;
    const lf_rig *rig;
    const lf_kernels *kernels;
    /* of the visit's samples and points; and of what is drawn now: another where holes are filled
     */
    const lf_sharing *sharing, *acting;
    const lf_row_triangles *triangles; /* NULL: no meshes */
    lf_scratch *worker;
    struct lf_queue *queue; /* the plan's, while base samples are drawn; else NULL */
    lf_film_sums sums;      /* the worker's, or where holes are filled the film's own half */
    lf_row_plane plane;
    lf_prefix_list prefix; /* of this plane */
    const struct lf_extinction *extinction;
    int row, half;
    lf_visit_number number;
    bool outlines; /* this visit takes more film points where worker->met.outlines says so */
    int max_depth;
    int subsets;
    lf_visit_lattice lattice; /* of base pixels */
    uint64_t random;          /* this visit's own */
    float weight;             /* of every base sample: 1, but for holes */
    /* [view][column] expected base samples of a pixel, in units of subsets / n_views; NULL: 1
     * everywhere. 0 in pixels that nobody reads: they are sampled by nobody, missing in everybody's
     * sum, and receive nothing. */
    const float *expected;
    /* native samples of its own that each pixel of worker->mirrors gets, beyond base samples or in
     * their place (visit.c); and the same in units of subsets / n_views */
    int mirror_rounds;
    float more;
    /* 1 / expected at the base's own pixel: what a sample weighs that only its own pixel receives
     */
    float alone;
    unsigned faults; /* lf_fault: deliberate mistakes, for the negative controls of the tests */
} lf_visit;

/* The points that a visit draws about its lights in media; weight: its native samples a pixel.
 * false = cancelled. */
bool lf_equiangular_visit(lf_visit *visit, float weight, const lf_cancel *cancel);
/* lf_equiangular_row_ratio at a pivot where base samples have the density sum exp(-depth), as in
 * lf_kernels.densities. */
float lf_equiangular_ratio(const lf_visit *visit, const lf_pivot *pivot, const lf_light *light,
                           int view, float sum, float depth);
/* Raises the pdfs of the suffix's light and of what its direction found by the points that are
 * drawn about these lights. */
void lf_equiangular_balance(const lf_visit *visit, const lf_pivot *pivot, int view, float sum,
                            float depth, lf_suffix *suffix);

/* Sets worker->local to the directions from a hit to the views (mvpt.c). */
void lf_fan_look_back(const lf_visit *visit, const lf_hit *hit);

/* All of a pivot but where it will be. The hit, most of its memory, is left alone: rays write it.
 */
void lf_pivot_begin(lf_pivot *pivot, lf_vec3 w, float lens, lf_sampler *sampler);

/* Lanes [from, to) of the worker as rays from the cameras. */
lf_rays lf_visit_rays(const lf_visit *visit, int from, int to);

/* The meshes in the visit's plane, but for veils; and those. */
lf_row_cut lf_visit_section(const lf_visit *visit);
lf_row_cut lf_visit_alphas(const lf_visit *visit);

/* True when the pixel (view, column) has a base sample in this visit: each with probability subsets
 * / n_views, each column as often as any other, all of them after a whole cycle. */
bool lf_lattice_has(const lf_visit *visit, int view, int column);

/* Deliberate mistakes that tests switch on to show that they are caught: render's tests link a
 * second build of the sources that have them, with LF_FAULTS (tests/module.mk); in programs they
 * are not there. */
typedef enum lf_fault {
    LF_FAULT_NO_H = 1,          /* h_k left out of D_k: a missing r_j/r_i */
    LF_FAULT_NO_VISIBILITY = 2, /* one view's visibility forgotten */
    LF_FAULT_REALISED = 4,      /* realised instead of expected counts in the weights */
    LF_FAULT_SWAPPED_VIEWS = 8, /* contributions land in mirrored views */
    LF_FAULT_NO_LIGHT_PDF = 16, /* the p_L term left out of the direction's weights */
    /* B and q taken in another plane of the row than the base samples, with other random numbers */
    LF_FAULT_OTHER_ROW = 32,
    LF_FAULT_NO_COUNTS = 64, /* c_k of an adaptive pass left out of the sums */
    /* directions drawn below a surface's horizon do not count in W' */
    LF_FAULT_HORIZON = 128,
    LF_FAULT_NO_EQUIANGULAR_BALANCE = 256, /* no room made for points drawn about lights in media */
    LF_FAULT_NO_CORRECTION = 512, /* what is drawn from slices counts as if they were the grid */
    /* rays meet what moves at another moment than the one at which views are asked whether they
     * see it */
    LF_FAULT_OTHER_TIME = 1024,
    LF_FAULT_NO_TIME = 2048, /* all visits are of the middle of the shutter */
} lf_fault;

#ifdef LF_FAULTS
#define lf_has_fault(holder, fault) (((holder)->faults & (unsigned)(fault)) != 0)
#else
#define lf_has_fault(holder, fault) ((void)(holder), false)
#endif

/* Where view k of the worker's lanes receives what a pivot sends it: [view][column]. */
static inline size_t lf_visit_pixel(const lf_visit *visit, int k)
{
    int view = lf_has_fault(visit, LF_FAULT_SWAPPED_VIEWS) ? visit->rig->n_views - 1 - k : k;
    return (size_t)view * (size_t)visit->rig->width + (size_t)visit->worker->column[k];
}

/* Everything that one visit of a row does. */
typedef struct lf_visit_plan {
    const lf_scene *scene;
    const lf_rig *rig;
    /* the owner of both, which the visit sets, and what that was made of; NULL: nothing moves */
    lf_shutter_time *shutter;
    const lf_moving *moving;
    const lf_media_frame *frame, *emissive; /* of the scene's volumes, and of what they emit */
    const lf_kernels *kernels;
    struct lf_queue *queue; /* of pivots whose suffixes lanes draw; NULL: they go one by one */
    const lf_sharing *sharing;
    const lf_sharing *native;          /* what fills holes: shares nothing */
    const lf_row_triangles *triangles; /* as in lf_visit */
    lf_outline_map outlines;           /* borrowed */
    lf_film *film;
    lf_sampler_kind sampler;
    int max_depth;
    unsigned skip;          /* lf_skip: what is left out where nothing needs it */
    lf_visit_order order;   /* `cover` forces collisions */
    const lf_counts *pilot; /* what a pilot leaves its marks in; NULL: this is none */
    /* where base samples go; NULL: the same number everywhere. Needs order.column_step 1 */
    const lf_counts *counts;
} lf_visit_plan;

/* Runs it on one worker; false = cancelled in the middle (the row's sums are then worthless). */
bool lf_visit_row(const lf_visit_plan *plan, int row, int half, lf_scratch *worker,
                  const lf_cancel *cancel);

/* The film point of a pixel column in this visit, in [0, 1) of its width; key is the half's stream.
 * With the row offset of the visit, the first of lf_hash64(key, 0), it covers the pixel as a net.
 */
float lf_unscattered_film_point(uint64_t key, int column, uint32_t index);

/* B and q of one row for this visit (unscattered_row.c), into the visit's sums. What a coarse visit
 * finds is that of slices, which nothing corrects; between two fans (LF_UNSCATTERED_COARSE) it is
 * interpolated in views without an edge there, between the film points that columns would have had.
 * between: of a coarse visit, nothing is looked for where worker->met.smooth says so (between.h); q
 * is -1 there. */
void lf_unscattered_row(const lf_visit *visit, bool between);

/* The film points of the row's outlines in another of their planes, which has been cut
 * (outlines.h). */
void lf_unscattered_outlines(const lf_visit *visit, int plane);

/* True when the camera sees the same light wherever it meets nothing. */
bool lf_unscattered_constant(const lf_scene *scene, float out_sky[3]);
/* True when moreover the sky stays as it is, and everything that can be hit scatters to all views
 * and emits nothing: B is then sky (1 - q) in every pixel. */
bool lf_unscattered_uniform(const lf_scene *scene, float out_sky[3]);

#endif
