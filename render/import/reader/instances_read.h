/* quiltimport: where the instances of a mesh stand. A row a place, of these columns:
 *
 *     3   x y z                                       12   the rows of a 3x4 matrix
 *     4   x y z scale                                 16   the rows of a 4x4 matrix
 *     7   x y z, quaternion x y z w
 *     8   the same, scale                             10   the same, three scales
 *
 * NPY (what numpy.save writes): float32 or float64 of the machine's order, row by row, of the shape
 * (places, columns), (places, 3, 4) or (places, 4, 4). CSV: a line a place, numbers between commas,
 * semicolons or blanks; a first line without a number names columns; # begins a comment. */
#ifndef LF_RENDER_INSTANCES_READ_H
#define LF_RENDER_INSTANCES_READ_H

#include "base/status.h"
#include "render/scene/affine.h"

typedef struct lf_instance_list {
    size_t n, room;
    lf_affine *map; /* [n] malloc's */
} lf_instance_list;

/* Into a zeroed *out, which the caller frees by lf_instance_list_finish in any case. path: by its
 * ending it is NPY or CSV. LF_E_FORMAT: which place, and what is wrong; LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_instances_read(const char *path, int fd, lf_instance_list *out,
                                         lf_error *err);
void lf_instance_list_finish(lf_instance_list *places);

#endif
