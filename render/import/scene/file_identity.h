/* Which file it was that something was made of; private to render/. */
#ifndef LF_RENDER_FILE_IDENTITY_H
#define LF_RENDER_FILE_IDENTITY_H

#include "render/scene/scene.h"

/* What sharing compares, without reading: "PATH:INODE:SIZE:SECONDS.NANOSECONDS:SUFFIX" of an open
 * file. Caller releases with lf_free; NULL = out of memory or the descriptor is bad. */
char *lf_file_key(int fd, const char *path, const char *suffix);

/* Reads the file open at fd from its first byte to its last; where fd stands in it is neither asked
 * nor changed. path names it in errors: LF_E_IO, LF_E_NOMEM; LF_E_TIMEOUT and
 * LF_E_CANCELLED by what base/sandbox/import.h limits reading to. */
LF_NODISCARD lf_status lf_file_digest(int fd, const char *path, lf_digest *out, lf_error *err);

#endif
