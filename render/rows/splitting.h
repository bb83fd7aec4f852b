/* How many suffixes a pivot on a diffuse surface draws, and from which throughput on roulette ends
 * paths: found by a pilot before the first pass. Private to render/rows/.
 * docs/developer/estimators/splitting.md.
 *
 * The pilot depends on the scene, the view and the integrator, and not on the seed, clocks, threads
 * or rows. So all parts of a rendering find the same. */
#ifndef LF_RENDER_SPLITTING_H
#define LF_RENDER_SPLITTING_H

#include "render/integrator.h"
#include "render/plane/rig.h"
#include "render/transport/path/suffix_one.h"

/* Whether the pilot can judge a scene and its view. Others have LF_SPLITTING_NONE. */
bool lf_splitting_serves(const lf_scene *scene, const lf_render_settings *settings);

/* Chooses as input->settings says. light_paths: there are some, and the pilot does not run. alone:
 * each pivot serves one view. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_splitting_choose(const lf_integrator_input *input, const lf_scene *seen,
                                           const lf_rig *rig, bool light_paths, bool alone,
                                           lf_splitting *out);

#endif
