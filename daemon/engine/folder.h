/* The folder in which *next* and *previous* choose files. */
#ifndef LF_DAEMON_FOLDER_H
#define LF_DAEMON_FOLDER_H

#include "base/paths.h"

/* The file `step` (not 0; -1 = previous) after `file` in its folder, in cyclic name order. Counts
 * scenes (.json) and quilt pictures: names with _qsCxR and an image ending. Skips hidden files.
 * `file` need not exist any more. *out_path (lf_free) is `file` itself if there is no other. roots:
 * NULL = anywhere. LF_E_IO: the folder cannot be read; LF_E_PATH: it lies outside the roots;
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_folder_neighbour(const char *file, int step, const lf_roots *roots,
                                           char **out_path, lf_error *err);

#endif
