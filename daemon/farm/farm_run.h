/* What a machine of a farm does: one step of a job. Thread: the main thread of a program with no
 * others. */
#ifndef LF_DAEMON_FARM_RUN_H
#define LF_DAEMON_FARM_RUN_H

#include "daemon/farm/farm_job.h"

/* Runs a step until it is complete, from its saved states on. Two runs of the same step at once are
 * harmless. A complete step returns at once. quiet: what the programs print goes to the step's log
 * only. LF_E_CANCELLED: told to end (lf_farm_catch_signals), and saved. LF_E_STATE: tasks that a
 * finish needs are not complete. Other errors are failures, whose words are left in the folder. */
LF_NODISCARD lf_status lf_farm_run_step(const lf_farm_job *job, int step, bool quiet,
                                        lf_error *err);

#endif
