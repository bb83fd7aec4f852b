/* The folder that next and previous walk through. */
#ifndef LF_DAEMON_FOLDER_H
#define LF_DAEMON_FOLDER_H

#include "base/paths.h"

/* The file that comes `step` (not 0; -1 = the one before) after `file` among the scenes (.json) and
 * quilt pictures (a name with _qsCxR and a picture's ending) of its folder, in the order of their
 * names, round and round; hidden files are left out. file need not be there any more. *out_path
 * (lf_free) is file itself when there is no other. roots: NULL = anywhere. LF_E_IO: the folder
 * cannot be read; LF_E_PATH: it lies outside the roots; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_folder_neighbour(const char *file, int step, const lf_roots *roots,
                                           char **out_path, lf_error *err);

#endif
