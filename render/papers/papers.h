/* Reproductions of papers (docs/developer/papers.md) as integrators: a separate library for
 * programs that compare with them. Simple and slow; quiltd does not contain it. */
#ifndef LF_RENDER_PAPERS_H
#define LF_RENDER_PAPERS_H

#include "render/render.h"

/* Adds them to the integrators of lf_integrator_at, and their options to lf_integrator_params. Call
 * it at the start of a program. */
void lf_papers_add(void);

/* Their options: indices in lf_choices. */
enum { LF_PAPERS_SHIFT, LF_PAPERS_SELECTION, LF_PAPERS_REUSE, LF_PAPERS_WEIGHTS };
/* The corresponding bit of lf_integrator_entry.takes. */
#define LF_PAPERS_TAKES(choice) (1u << LF_PAPERS_##choice)

/* Words of each option, as on the command line; NULL after the last: mappings of null collisions
 * and selections of views (mvpt2022), reuse of reservoirs and its weights (restir). */
const char *lf_shift_name(int shift);
const char *lf_selection_name(int selection);
const char *lf_reuse_name(int reuse);
const char *lf_reuse_weights_name(int weights);

#endif
