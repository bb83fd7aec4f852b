/* Integrators, as the renderer drives them; private to render/.
 *
 * An integrator takes a scene and a rig and adds visits of rows to a film. The renderer decides
 * which rows to visit, how many passes and when. It owns the film, the pool and the resolved
 * images. The integrator owns what its workers need besides the film (a plane, slices, reservoirs,
 * camera lists). An integrator with variants lists them as entries (rows/: how pivots are shared).
 * A new integrator is a folder or file with one lf_integrator, and a line in the table in
 * integrator.c or in a list passed to lf_integrators_add. Cameras listed one by one have an
 * integrator of their own, with entries of the same names. */
#ifndef LF_RENDER_INTEGRATOR_H
#define LF_RENDER_INTEGRATOR_H

#include "render/film/film.h"
#include "render/scene/scene.h"
#include "render/transport/path/track.h"

/* Input of create. All pointers are borrowed. Everything except settings outlives the state. */
typedef struct lf_integrator_input {
    const lf_scene *scene;
    const lf_scene *seen; /* the part of the scene that the integrator uses (skip.h); copied */
    const lf_render_settings *settings;
    lf_pool *pool;
    /* lanes/lane_scene.h; NULL: lanes do not support this scene */
    const struct lf_lane_scene *lanes;
    const struct lf_suffixes *suffixes; /* of this machine's instruction set, for lanes */
    /* to be visited; has the layout and sky of lf_integrator_needs before the first visit */
    lf_film *film;
} lf_integrator_input;

/* What the integrator needs of the renderer. */
typedef struct lf_integrator_needs {
    lf_film_layout layout;
    float sky[3];     /* used if B is not stored (film.h) */
    int visit_passes; /* passes in a visit of the offline schedule */
} lf_integrator_needs;

/* Alignment of a worker's struct, so that two workers never write to the same cache line. */
#define LF_CACHE_LINE 64

struct lf_sunlight;

/* Parameters of a pass, the same for every row that it visits. */
typedef struct lf_visit_order {
    int subsets;     /* passes at once; 0: sample only holes */
    int column_step; /* 1, or 2: only every other column (a pass split between the halves) */
    bool cover;      /* force collisions, so that thin media appear at once: the live image */
    bool coarse;     /* B and q for a coarse frame: as in lf_renderer_pass_coarse */
    /* only B, q and features, of rows without visits: lf_renderer_pass_fans */
    bool fans;
    int hole_reach;  /* as in lf_renderer_pass_filling; < 0: do not fill holes */
    int stream;      /* index into film->streams of its counts */
    uint64_t random; /* key of its random numbers */
    /* of the scene, for the film's features (transport/path/sunlight.h); NULL: none */
    const struct lf_sunlight *sunlight;
    unsigned faults; /* lf_fault (rows/visit.h), in builds with LF_FAULTS */
    /* of lf_renderer_passes_after, for entries that spread: what every row had before this visit.
     * Rows that have more have had it; their paths are needed again, their sums are not. NULL: as
     * the film says */
    const lf_asked *at;
} lf_visit_order;

/* The rows of a pass: first_row, first_row + row_step, … */
typedef struct lf_pass {
    const lf_visit_order *order;
    int first_row, row_step, n_rows;
    int half; /* -1: of each row the one with fewer visits, half 0 on a tie */
    /* rows beyond it have had this visit and are not visited, unless order->at; NULL: none has */
    const lf_asked *at;
} lf_pass;

/* The half of a row's visit in a pass; given: the row's counts of the pass's stream. */
static inline int lf_pass_half(const lf_pass *pass, const lf_film_counts *given)
{
    return pass->half >= 0 ? pass->half : given->visits[0] > given->visits[1];
}
/* Whether the row has had the visit of this pass. */
static inline bool lf_pass_has_had(const lf_pass *pass, const lf_film_counts *given)
{
    const int half = lf_pass_half(pass, given);
    return pass->at && !pass->order->at && given->visits[half] > pass->at->visits[half];
}

typedef struct lf_integrator {
    /* The optimisations (lf_skip) that this integrator has. */
    unsigned skips;
    /* Entry by index within this integrator; NULL after the last. */
    const lf_integrator_entry *(*entry)(int index);
    /* Makes the state of entry(index); the functions below take *out_state. Out of memory is
     * LF_E_NOMEM and leaves err unset; other errors set err. */
    lf_status (*create)(const lf_integrator_input *input, int index, void **out_state,
                        lf_integrator_needs *out_needs, lf_error *err);
    /* Before a pass, on its caller's thread; may use the pool. LF_E_NOMEM, LF_E_CANCELLED: the pass
     * does not take place. */
    lf_status (*begin)(void *state, const lf_pass *pass, const lf_cancel *cancel);
    /* Adds a visit of a row to one half of the film, on a worker of the pool. false: cancelled, and
     * the film is as before, except that some holes may be filled if the visit filled holes. */
    bool (*visit)(void *state, const lf_visit_order *order, int row, int half, int worker,
                  const lf_cancel *cancel);
    /* After a pass that visited all of its rows, on its caller's thread; may use the pool. If it is
     * cancelled, some rows stay as they were. NULL: no work after a pass. */
    lf_status (*end)(void *state, const lf_pass *pass, const lf_cancel *cancel);
    /* Adds its workers' counters to *out; counters that do not apply become -1. */
    void (*count)(const void *state, lf_render_stats *out);
    /* Adds the optimisations of its own, as in lf_renderer_skipped. NULL: none. */
    void (*skipped)(const void *state, json_t *out);
    /* Accepts NULL. */
    void (*destroy)(void *state);
} lf_integrator;

/* Adds a library's integrators after the built-in ones, with their options (lf_integrator_params).
 * list ends with NULL. Call it before any other function. It replaces an earlier list. */
void lf_integrators_add(const lf_integrator *const *list, const lf_param *params);

/* Adds one worker's counters to *out. */
static inline void lf_integrator_count(lf_render_stats *out, const lf_tracer *tracer,
                                       int64_t base_paths, int64_t contributions)
{
    out->base_paths += base_paths;
    out->contributions += contributions;
    out->rays_traced += tracer->rays;
    out->volume_lookups += tracer->lookups;
    out->nonfinite_dropped += tracer->nonfinite;
    out->suffixes += tracer->suffixes;
    out->suffixes_cut += tracer->suffixes_cut;
}

/* Finds the integrator that settings->integrator names (NULL: the default), for the kind of camera
 * in settings. LF_E_ARG: unknown name; err lists the names. */
LF_NODISCARD lf_status lf_integrator_find(const lf_render_settings *settings,
                                          const lf_integrator **out_integrator, int *out_index,
                                          lf_error *err);

/* Follows the integrator's name in errors about cameras listed one by one. */
#define LF_OF_LISTED_CAMERAS " with cameras listed one by one"
/* Every entry with its supported traits, entries for cameras listed one by one last; NULL after the
 * last. */
const lf_integrator_entry *lf_support_at(int index, bool *out_listed);
/* The traits of a view. */
lf_traits lf_view_traits(const lf_render_settings *settings);
/* LF_E_ARG unless the integrator supports all traits of the scene and its view. err names the
 * missing trait and the integrators that support it. */
LF_NODISCARD lf_status lf_integrator_check(const lf_integrator_entry *entry, const lf_scene *scene,
                                           const lf_render_settings *settings, lf_error *err);

#endif
