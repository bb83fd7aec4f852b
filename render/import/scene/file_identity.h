/* Identity of a file from which an object was made; private to render/. */
#ifndef LF_RENDER_FILE_IDENTITY_H
#define LF_RENDER_FILE_IDENTITY_H

#include "render/scene/scene.h"

/* Key for sharing, without reading: "PATH:INODE:SIZE:SECONDS.NANOSECONDS:SUFFIX" of an open file.
 * The caller releases it with lf_free; NULL = out of memory or a bad descriptor. */
char *lf_file_key(int fd, const char *path, const char *suffix);

/* Hashes the whole file open at fd, independent of its file position, which does not change. Errors
 * name path: LF_E_IO, LF_E_NOMEM; LF_E_TIMEOUT and LF_E_CANCELLED by the limits of
 * base/sandbox/import.h. */
LF_NODISCARD lf_status lf_file_digest(int fd, const char *path, lf_digest *out, lf_error *err);

#endif
