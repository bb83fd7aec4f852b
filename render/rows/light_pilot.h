/* How many light paths a rendering takes, and where they start: found by a pilot before the first
 * pass. Private to render/rows/. docs/developer/estimators/light-paths.md, "The pilot".
 *
 * The pilot depends on the scene, the view and the integrator, and not on the seed, clocks, threads
 * or rows. So all parts of a rendering find the same. */
#ifndef LF_RENDER_LIGHT_PILOT_H
#define LF_RENDER_LIGHT_PILOT_H

#include "base/thread.h"
#include "render/rows/pilot_path.h"
#include "render/transport/path/forward_path.h"

typedef struct lf_light_plan {
    const lf_emitters *emitters;
    int per_pass;           /* light paths for each pass, even; 0: none */
    lf_splitting splitting; /* of camera paths */
    float m;                /* for one native sample of every view that a path serves */
    /* Roulette: a vertex survives with the probability of its light, relative to the brightness,
     * over this; 0: all survive. */
    float cut;
    /* 1 over the brightness of a tile plus a tenth */
    float importance[LF_PILOT_PARTS];
} lf_light_plan;

static inline float lf_light_importance(const lf_light_plan *plan, const lf_rig *rig, int row,
                                        int column)
{
    return plan->importance[lf_pilot_part(rig, row, column)];
}

/* Input of the pilot. */
typedef struct lf_light_pilot {
    const lf_scene *scene;
    const lf_rig *rig;
    lf_pool *pool;
    int max_depth;
    bool alone; /* each path serves one view */
} lf_light_pilot;

/* Sets plan->importance. *out_serves: whether light paths would reduce the error, by the share of
 * their class in the variance of camera paths, and by what the balance takes of it; NULL: they are
 * wanted anyway. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_light_pilot_asks(const lf_light_pilot *pilot, lf_light_plan *plan,
                                           bool *out_serves);
/* Teaches the cells of the emitters, and sets plan->cut and *out_splats: the view pixels that a
 * path reaches. plan has a number of paths. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_light_pilot_learns(const lf_light_pilot *pilot, lf_emitters *emitters,
                                             lf_light_plan *plan, double *out_splats);

#endif
