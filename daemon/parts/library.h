/* library: lists folders and makes thumbnails of picture files for clients. Each request runs on a
 * thread of its own, because a file system may hang; few run at once, and the others wait. Nothing
 * outside of the roots is read. A request knows its client only as a number; its owner answers.
 * Thread: event. */
#ifndef LF_DAEMON_LIBRARY_H
#define LF_DAEMON_LIBRARY_H

#include <jansson.h>

#include "base/paths.h"
#include "daemon/threads/inbox.h"

typedef struct lf_library lf_library;

/* A request has ended. result: the answer, owned by the callee; NULL: err. call: of the owner. A
 * callback may add no request. */
typedef void (*lf_library_ended_fn)(void *context, void *call, json_t *result, const lf_error *err);

/* inbox and roots are borrowed and must outlive the library; roots must not change. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_library_create(lf_inbox *inbox, const lf_roots *roots,
                                         lf_library_ended_fn ended, void *context,
                                         lf_library **out_library);
/* To be called when no request is left. Accepts NULL. */
void lf_library_destroy(lf_library *library);
/* Checks that this client has no request yet. LF_E_BUSY. */
LF_NODISCARD lf_status lf_library_check_room(const lf_library *library, uint64_t client,
                                             const char *method, lf_error *err);
/* Lists a folder (absolute; NULL: the roots) as library.list does. Takes ownership of folder, also
 * on failure. LF_E_BUSY (errands.h), LF_E_NOMEM: `ended` is not called. */
LF_NODISCARD lf_status lf_library_list(lf_library *library, uint64_t client, char *folder,
                                       void *call, lf_error *err);
/* Writes a thumbnail of the file (absolute) to fd, which must be open for writing. Takes ownership
 * of file and fd, also on failure. The result has width, height and bytes. LF_E_BUSY
 * (errands.h), LF_E_NOMEM: `ended` is not called. */
LF_NODISCARD lf_status lf_library_thumbnail(lf_library *library, uint64_t client, char *file,
                                            int width, int fd, void *call, lf_error *err);
/* True while there is a request. */
bool lf_library_busy(const lf_library *library);
/* Cancels the request of a client that has left; `ended` is still called. */
void lf_library_end_of(lf_library *library, uint64_t client);
/* Cancels all. */
void lf_library_end(lf_library *library);

#endif
