/* What is wrong with a file that Assimp does not read, and what it drops of one that it reads. One
 * thread. */
#ifndef LF_RENDER_ASSIMP_WORDS_H
#define LF_RENDER_ASSIMP_WORDS_H

#include "render/import/reader/soup.h"

/* Fills err, LF_E_FORMAT, for the mesh behind fd that path names: of 3DS the chunk that is not
 * whole, else that Assimp said these words. */
void lf_assimp_refuse(int fd, const char *path, const char *source, lf_error *err);

/* Of a 3DS file that was read: a warning of its chunks that a picture lacks and Assimp keeps quiet
 * about. Of other formats none. */
void lf_3ds_warn(int fd, const char *path, lf_warnings *warnings);

#endif
