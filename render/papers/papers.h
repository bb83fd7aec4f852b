/* Reproductions of papers (docs/developer/papers.md) as integrators: a library of its own, for
 * programs that compare with them. Plain and slow; quiltd does not have it. */
#ifndef LF_RENDER_PAPERS_H
#define LF_RENDER_PAPERS_H

#include "render/render.h"

/* Adds them to those that lf_integrator_at knows, and their options to lf_integrator_params: at the
 * beginning of a program. */
void lf_papers_add(void);

/* Their choices: places in lf_choices. */
enum { LF_PAPERS_SHIFT, LF_PAPERS_SELECTION, LF_PAPERS_REUSE, LF_PAPERS_WEIGHTS };
/* The same in lf_integrator_entry.takes. */
#define LF_PAPERS_TAKES(choice) (1u << LF_PAPERS_##choice)

/* Words of each, as on the command line; NULL behind the last: mappings of null collisions and
 * selections of views (mvpt2022), what reservoirs are put together with, and with what weights
 * (restir). */
const char *lf_shift_name(int shift);
const char *lf_selection_name(int selection);
const char *lf_reuse_name(int reuse);
const char *lf_reuse_weights_name(int weights);

#endif
