/* batch: one output for each picture with depth of a folder. Thread: the main thread. */
#ifndef LF_DAEMON_BATCH_H
#define LF_DAEMON_BATCH_H

#include "daemon/tools/rendering.h"

/* Makes the outputs of arguments->depth.batch in the order of the names, each named like its
 * picture. Leaves out pictures whose outputs exist, unless --overwrite was given. Reports pictures
 * that fail and goes on. start: for each picture's lf_rendering. Returns an exit code:
 * LF_EXIT_FAILED if one failed, LF_EXIT_USAGE for an option that no picture can satisfy. */
int lf_batch_run(const lf_rendering *start);

#endif
