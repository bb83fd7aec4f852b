/* What is wrong with a file that Assimp does not read. One thread. */
#ifndef LF_RENDER_ASSIMP_WORDS_H
#define LF_RENDER_ASSIMP_WORDS_H

#include "base/status.h"

/* Fills err, LF_E_FORMAT, for the mesh behind fd that path names: of 3DS the chunk that is not
 * whole, else that Assimp said these words. */
void lf_assimp_refuse(int fd, const char *path, const char *said, lf_error *err);

#endif
