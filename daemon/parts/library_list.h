/* What is in a folder, for library.list. Private to library. */
#ifndef LF_DAEMON_LIBRARY_LIST_H
#define LF_DAEMON_LIBRARY_LIST_H

#include <jansson.h>

#include "base/paths.h"
#include "base/thread.h"

/* Entries of one listing, and bytes of their JSON, at most. */
#define LF_LIBRARY_ENTRIES 1000
#define LF_LIBRARY_BYTES ((size_t)768 << 10)

/* The answer of library.list for this absolute folder; NULL: for the roots. Entries that cannot be
 * shown, are hidden, have names that are not UTF-8, or lead out of the roots are left out. Memory
 * is bounded for any folder. A new reference. Thread: any; it may hang with the file system. Errors
 * of lf_roots_open_folder; LF_E_IO, LF_E_CANCELLED, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_library_list_of(const lf_roots *roots, const char *folder,
                                          const lf_cancel *cancel, json_t **out, lf_error *err);

#endif
