/* The checklist of a written print: of quiltrender after it has written, and of quiltprint check.
 * Thread: the main thread. */
#ifndef LF_DAEMON_PRINT_CHECK_H
#define LF_DAEMON_PRINT_CHECK_H

#include "base/param.h"
#include "daemon/tools/print_profiles.h"
#include "quilt/proof/check.h"

/* Options of quiltrender about the checklist; zeroed is the default. */
typedef struct lf_check_arguments {
    bool off; /* a print is not checked after it was written */
} lf_check_arguments;
extern const lf_param lf_check_params[];

/* Whether a print of this name is checked after it was written. Sets of frames are not. */
bool lf_print_check_wanted(const lf_check_arguments *arguments, const char *path);
/* The endings of what is written beside a print, ".check.txt"; NULL after the last. */
const char *lf_print_check_ending(int index);
/* LF_E_ARG: a report or job sheet of the print would replace a file that is none. */
LF_NODISCARD lf_status lf_print_check_room_beside(const char *path, lf_error *err);
/* Removes reports and the job sheet of an earlier print of this name, which say nothing true of one
 * that is not checked. Other files stay. */
void lf_print_check_forget(const char *path);
/* Checks a print right after it was written, logs one line, and writes NAME.check.txt,
 * NAME.check.json and the job sheet NAME.job.pdf beside it, each whole or not at all. *out_failed:
 * a point failed. Errors of lf_print_check_file; LF_E_IO: a report cannot be written. */
LF_NODISCARD lf_status lf_print_check_written(const char *path, const lf_print_witness *witness,
                                              bool *out_failed, lf_error *err);

/* check PRINT.tif, of quiltprint: prints the report, as JSON with `json`. LF_E_FORMAT: a point
 * fails; errors of lf_print_check_file; LF_E_ARG: not one name. */
LF_NODISCARD lf_status lf_print_check_command(const lf_profiles_command *command, lf_error *err);

#endif
