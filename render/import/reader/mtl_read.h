/* Material libraries of OBJ files. One thread. */
#ifndef LF_RENDER_MTL_READ_H
#define LF_RENDER_MTL_READ_H

#include "render/import/reader/soup.h"

/* The number of what the soup says of a material; one that is new is grey and missing until a
 * library says more. LF_E_FORMAT: too many, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mtl_find(lf_soup *soup, const char *name, unsigned *out, lf_error *err);

/* Reads the library behind fd (the caller's), which lies in folder and is called so. Of statements
 * that no material of ours has, and of numbers that are none, there is a warning in the soup's;
 * pictures are noted alone. LF_E_FORMAT: too many materials, text that is not UTF-8; LF_E_NOMEM,
 * LF_E_IO. */
LF_NODISCARD lf_status lf_mtl_read(int fd, const char *folder, const char *name, lf_soup *soup,
                                   lf_error *err);

#endif
