/* Errors of files that Assimp cannot read, and features that it drops from files that it reads. One
 * thread. */
#ifndef LF_RENDER_ASSIMP_WORDS_H
#define LF_RENDER_ASSIMP_WORDS_H

#include "render/import/reader/soup.h"

/* Fills err, LF_E_FORMAT, for the mesh behind fd, named path: for 3DS the incomplete chunk,
 * otherwise Assimp's message `source`. */
void lf_assimp_refuse(int fd, const char *path, const char *source, lf_error *err);

/* For a 3DS file that was read: warns of chunks that are not rendered and that Assimp skips
 * silently. Other formats: no effect. */
void lf_3ds_warn(int fd, const char *path, lf_warnings *warnings);

#endif
