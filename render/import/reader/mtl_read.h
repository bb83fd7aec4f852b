/* Material libraries of OBJ files. One thread. */
#ifndef LF_RENDER_MTL_READ_H
#define LF_RENDER_MTL_READ_H

#include "render/import/reader/soup.h"

/* The number of a source material of the soup by its name. A new one is grey and marked missing
 * until a library defines it. LF_E_FORMAT: too many, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mtl_find(lf_soup *soup, const char *name, unsigned *out, lf_error *err);

/* Reads the library behind fd (owned by the caller), called name in folder. Adds warnings to the
 * soup for unsupported statements and invalid numbers. Images are only recorded. LF_E_FORMAT: too
 * many materials, text that is not UTF-8; LF_E_NOMEM, LF_E_IO. */
LF_NODISCARD lf_status lf_mtl_read(int fd, const char *folder, const char *name, lf_soup *soup,
                                   lf_error *err);

#endif
