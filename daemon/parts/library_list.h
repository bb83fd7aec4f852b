/* What is in a folder, for library.list and for slideshows. */
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

/* The files of a folder that a slideshow can show. */
typedef struct lf_library_files {
    char *folder; /* canonical */
    char **path;  /* [n] absolute, by lf_strdup, in the order of lf_library_list_of */
    int n;
    bool more; /* the folder has more than LF_LIBRARY_ENTRIES of them */
} lf_library_files;
/* Lists the files of an absolute folder that lf_library_list_of would list, except environments.
 * Release with lf_library_files_finish. Thread and errors as above; LF_E_FORMAT: there are none. */
LF_NODISCARD lf_status lf_library_files_of(const lf_roots *roots, const char *folder,
                                           const lf_cancel *cancel, lf_library_files *out,
                                           lf_error *err);
/* Accepts a zeroed struct. */
void lf_library_files_finish(lf_library_files *files);

#endif
