/* ctl_files: the files of a scene that quiltctl opens for the daemon, with the caller's rights.
 *
 * Only those that lie outside of the folders which the daemon reads itself, and only those that the
 * call or a scene names: in the JSON by a name with an ending that scenes read, and, beneath the
 * folder of a mesh, those that the mesh's file names (buffers, textures, material libraries; no
 * symbolic links). Meshes are asked for such names by the reader that the daemon uses, in its
 * sandbox. What cannot be opened is left to the daemon to refuse. Thread: one. */
#ifndef LF_DAEMON_CTL_FILES_H
#define LF_DAEMON_CTL_FILES_H

#include <jansson.h>

#include "base/passed.h"

typedef struct lf_ctl_files {
    int n;
    int fd[LF_MAX_PASSED];
    json_t *names; /* the daemon's parameter `files`; NULL: none */
} lf_ctl_files;

/* folders: those of the daemon (hello). named: the file of scene.load, a string, or the patch of
 * scene.patch, an object, whose relative names begin at the folder of `scene` (NULL: are left
 * alone). *out is zero or of use on LF_OK. LF_E_ARG: more than LF_MAX_PASSED; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_ctl_files_open(const json_t *folders, json_t *named, const char *scene,
                                         lf_ctl_files *out, lf_error *err);
/* Accepts zeroed structs. */
void lf_ctl_files_close(lf_ctl_files *files);

#endif
