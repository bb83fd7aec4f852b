/* Material libraries of OBJ files. One thread. */
#ifndef LF_RENDER_MTL_READ_H
#define LF_RENDER_MTL_READ_H

#include "render/reader/soup.h"

/* The number of what the soup says of a material; one that is new is grey and missing until a
 * library says more. LF_E_FORMAT: too many, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mtl_find(lf_soup *soup, const char *name, unsigned *out, lf_error *err);

/* Reads the library behind fd (the caller's), which lies in folder. Lines that say nothing of a
 * material are left out; pictures are noted alone. LF_E_FORMAT: too many materials; LF_E_NOMEM,
 * LF_E_IO. */
LF_NODISCARD lf_status lf_mtl_read(int fd, const char *folder, lf_soup *soup, lf_error *err);

#endif
