/* Formats of meshes that are read by ourselves, a file each; private to render/reader. */
#ifndef LF_RENDER_FORMATS_H
#define LF_RENDER_FORMATS_H

#include "render/reader/soup.h"

/* The mesh file behind fd (the caller's) into a zeroed soup, which the caller finishes. desc->file
 * is its name. LF_E_FORMAT: which line or byte, and what was expected; LF_E_NOMEM, LF_E_IO. */
typedef lf_status lf_format_read_fn(const lf_mesh_desc *desc, int fd, lf_soup *soup, lf_error *err);

lf_format_read_fn lf_ply_read, lf_stl_read, lf_obj_read;

#endif
