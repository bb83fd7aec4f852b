/* allow: the methods of quiltd that a client of the gateway may call. What is not in the table is
 * refused: it ends quiltd, moves the panel, needs descriptors or writes files. `files` of
 * scene.load and scene.patch, and all of export, are for uploads.h and exports.h to check. Thread:
 * any. */
#ifndef LF_DAEMON_WEB_ALLOW_H
#define LF_DAEMON_WEB_ALLOW_H

#include <jansson.h>

#include "base/status.h"

/* LF_E_STATE: the method is not allowed. LF_E_ARG: one of its parameters is not. */
LF_NODISCARD lf_status lf_allow_check(const char *method, const json_t *params, lf_error *err);
/* The allowed method of this index; NULL after the last. */
const char *lf_allow_at(int index);

#endif
