/* The state of the integrators of papers/: one struct for all kinds; private to render/. */
#ifndef LF_RENDER_STATE_H
#define LF_RENDER_STATE_H

#include "render/integrator.h"
#include "render/papers/null_chain.h"
#include "render/papers/selection.h"
#include "render/plane/rig.h"
#include "render/rows/adaptive.h"
#include "render/transport/path/path.h"
#include "render/transport/sampler.h"

struct lf_general;
struct lf_prefix;

/* One worker's memory. */
typedef struct lf_general_worker {
    _Alignas(LF_CACHE_LINE) lf_tracer tracer;
    lf_film_sums sums;
    int64_t base_paths, contributions;
    float *expected;     /* [view][column] of the current row; NULL if the kind never makes a map */
    bool mapped;         /* expected comes from a map; otherwise it is 1 */
    lf_null_chain chain; /* of the current base prefix */
    /* of its pivot, per view: */
    int column[LF_MAX_VIEWS];       /* < 0: outside its frame */
    lf_vec3 to_pivot[LF_MAX_VIEWS]; /* unit */
    bool selected[LF_MAX_VIEWS];
    double ratio[LF_MAX_VIEWS];  /* rho; 0: the view does not share */
    double weight[LF_MAX_VIEWS]; /* of the suffix in N and W; 0: none */
} lf_general_worker;

/* Traits that all methods support, besides media. */
#define LF_GENERAL_SUPPORT                                                                         \
    (LF_TRAITS_PLAIN_SURFACES | LF_TRAITS_GLASS | LF_TRAIT_CATCHERS | LF_TRAIT_REFLECTIONS |       \
     (LF_TRAITS_LIGHT & ~LF_TRAIT_EQUIANGULAR) | LF_TRAIT_LENS | LF_TRAIT_VIEW_BLUR)

/* A method. One file may have several; one line each in the table of general.c. */
typedef struct lf_general_kind {
    lf_integrator_entry entry;
    bool mis;        /* W is n: every estimate is N/n */
    bool adaptive;   /* after a pilot, a map distributes the base samples */
    bool normalises; /* by K, lf_general.share_seen */
    /* Makes that map, repeatedly; NULL: rows/adaptive.h makes it, once. */
    lf_status (*map)(const lf_film *film, lf_counts *counts);
    /* For a shared pivot: which views receive the suffix, and with which weights (weight[]).
     * Returns false if a weight is not a number. */
    bool (*weigh)(const struct lf_general *g, lf_general_worker *w, const struct lf_prefix *p);
} lf_general_kind;

extern const lf_general_kind lf_general_mvpt2022, lf_general_mismvpt, lf_general_amvpt2022,
    lf_general_amv2019, lf_general_amv2019k;

typedef struct lf_general {
    const lf_general_kind *kind;
    lf_scene seen;
    lf_rig rig;
    lf_film *film;
    const lf_shift *shift;
    const lf_selection *selection;
    lf_sampler_kind sampler;
    int max_depth, n_workers;
    lf_pool *pool;
    lf_counts counts; /* of adaptive kinds: marks of the pilot, and the map */
    int n_maps;       /* made so far */
    double next_map;  /* native samples per view pixel of each half at which the next map is made */
    float *share_seen;          /* [base][view] K of 2019's equation 9; NULL: not used */
    lf_general_worker *workers; /* [n_workers] */
} lf_general;

#endif
