/* ctl_files: files of a scene that quiltctl opens for the daemon with the caller's rights.
 *
 * It opens only files outside the folders that the daemon reads itself, and only files that the
 * call or a scene names: names in the JSON with an ending that scenes read. Files that a mesh file
 * names (buffers, textures, material libraries) must be inside the mesh's folder, without symbolic
 * links. The daemon's sandboxed reader extracts these names from meshes. Files that cannot be
 * opened are left for the daemon to refuse. Thread: one. */
#ifndef LF_DAEMON_CTL_FILES_H
#define LF_DAEMON_CTL_FILES_H

#include <jansson.h>

#include "base/passed.h"

typedef struct lf_ctl_files {
    int n;
    int fd[LF_MAX_PASSED];
    json_t *names; /* the daemon's parameter `files`; NULL: none */
} lf_ctl_files;

/* folders: the daemon's, from `hello`. named: the file of scene.load (a string), or the patch of
 * scene.patch (an object). Relative names of a patch start at the folder of `scene`; scene NULL:
 * they are skipped. *out is zeroed or valid on LF_OK. LF_E_ARG: more than LF_MAX_PASSED files;
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_ctl_files_open(const json_t *folders, json_t *named, const char *scene,
                                         lf_ctl_files *out, lf_error *err);
/* Accepts zeroed structs. */
void lf_ctl_files_close(lf_ctl_files *files);

#endif
