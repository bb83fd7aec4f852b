/* Integrators, as the renderer drives them; private to render/.
 *
 * An integrator takes a scene and a rig and adds visits of rows to a film; the renderer says which
 * rows, how many passes and when, and owns the film, the pool and the answers. What a worker needs
 * besides the film (a plane, slices, reservoirs, lists of cameras) is the integrator's own. One
 * that comes in several kinds (rows/: how pivots are shared) lists them as entries. A new one is a
 * folder or file with one of these, and a line of the table in integrator.c, or of those that a
 * library adds to it. Cameras listed one by one have an integrator of their own, with entries of
 * the same names. */
#ifndef LF_RENDER_INTEGRATOR_H
#define LF_RENDER_INTEGRATOR_H

#include "render/film/film.h"
#include "render/scene/scene.h"
#include "render/transport/path/track.h"

/* What one is made for. Borrowed; but for settings all of it outlives what is made. */
typedef struct lf_integrator_input {
    const lf_scene *scene;
    const lf_scene *seen; /* what it is to see of the scene (skip.h): copied */
    const lf_render_settings *settings;
    lf_pool *pool;
    const struct lf_lane_scene *lanes;  /* lanes/lane_scene.h; NULL: they do not serve it */
    const struct lf_suffixes *suffixes; /* of this machine's instruction set, for them */
    lf_film *film; /* to be visited; has the layout and sky of lf_integrator_needs by then */
} lf_integrator_input;

/* What it needs of the renderer. */
typedef struct lf_integrator_needs {
    lf_film_layout layout;
    float sky[3];     /* where B is not stored (film.h) */
    int visit_passes; /* passes in a visit of the offline schedule */
} lf_integrator_needs;

/* What a worker of a pool writes stands in no line of another's: where its struct begins. */
#define LF_CACHE_LINE 64

struct lf_sunlight;

/* What a pass asks of every row that it visits. */
typedef struct lf_visit_order {
    int subsets;     /* passes at once; 0: nothing but holes is sampled */
    int column_step; /* 1, or 2: only every other column (a pass split between the halves) */
    bool cover;      /* what is thin is to be found at once: the live picture */
    bool coarse;     /* B and q for a coarse frame: as in lf_renderer_pass_coarse */
    /* B, q and features alone, of rows that nothing has visited: lf_renderer_pass_fans */
    bool fans;
    int hole_reach;  /* as in lf_renderer_pass_filling; < 0: holes are left */
    int stream;      /* where its counts are: of film->streams */
    uint64_t random; /* its random numbers */
    /* of the scene, for the film's features (transport/path/sunlight.h); NULL: it has none */
    const struct lf_sunlight *sunlight;
    unsigned faults; /* lf_fault (rows/visit.h), in builds that have them */
} lf_visit_order;

/* The rows of a pass: first_row, first_row + row_step, … */
typedef struct lf_pass {
    const lf_visit_order *order;
    int first_row, row_step, n_rows;
} lf_pass;

typedef struct lf_integrator {
    /* Of what a scene does not need (lf_skip), what it can leave out: the rest is not offered. */
    unsigned skips;
    /* By index within this integrator; NULL behind the last. */
    const lf_integrator_entry *(*entry)(int index);
    /* Makes one for entry(index); *out_state is for the functions below. What fails for want of
     * memory is LF_E_NOMEM without words; other errors have set err. */
    lf_status (*create)(const lf_integrator_input *input, int index, void **out_state,
                        lf_integrator_needs *out_needs, lf_error *err);
    /* Before a pass, on its caller's thread: may use the pool. */
    void (*begin)(void *state, const lf_pass *pass);
    /* Adds a visit of a row to one half of the film, on a worker of the pool. false = cancelled:
     * the film is as before, but that a row whose holes were being filled may have some of them. */
    bool (*visit)(void *state, const lf_visit_order *order, int row, int half, int worker,
                  const lf_cancel *cancel);
    /* Behind a pass all of whose rows were visited, on its caller's thread: may use the pool. Of
     * what is cancelled some rows may be as they were. NULL: nothing is left to be done. */
    lf_status (*end)(void *state, const lf_pass *pass, const lf_cancel *cancel);
    /* Adds its workers' counters to *out; what does not apply becomes -1. */
    void (*count)(const void *state, lf_render_stats *out);
    /* Adds what it leaves out of its own accord, as in lf_renderer_skipped. NULL: nothing. */
    void (*skipped)(const void *state, json_t *out);
    /* Accepts NULL. */
    void (*destroy)(void *state);
} lf_integrator;

/* Integrators of a library behind those that are there, NULL behind the last, and the options that
 * they take (lf_integrator_params). Before any other call; what was added before goes. */
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

/* The one that settings->integrator names, of such a camera where there is one. LF_E_ARG for an
 * unknown name, with err naming those that exist; NULL is the default. */
LF_NODISCARD lf_status lf_integrator_find(const lf_render_settings *settings,
                                          const lf_integrator **out_integrator, int *out_index,
                                          lf_error *err);

/* What refusals call an integrator of cameras listed one by one, behind its name. */
#define LF_OF_LISTED_CAMERAS " with cameras listed one by one"
/* All of them, each with what it supports, those of cameras listed one by one last; NULL behind
 * them. */
const lf_integrator_entry *lf_support_at(int index, bool *out_listed);
/* The traits of a view. */
lf_traits lf_view_traits(const lf_render_settings *settings);
/* LF_E_ARG, naming what is missing and who has it, unless the integrator supports all traits of the
 * scene and its view. */
LF_NODISCARD lf_status lf_integrator_check(const lf_integrator_entry *entry, const lf_scene *scene,
                                           const lf_render_settings *settings, lf_error *err);

#endif
