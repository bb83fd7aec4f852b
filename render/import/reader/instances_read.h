/* quiltimport: the instances of a mesh. One row per instance, with these columns:
 *
 *     3   x y z                                       12   the rows of a 3x4 matrix
 *     4   x y z scale                                 16   the rows of a 4x4 matrix
 *     7   x y z, quaternion x y z w
 *     8   as 7, and a scale                           10   as 7, and three scales
 *
 * NPY (as numpy.save writes it): float32 or float64 in the machine's byte order, row by row, with
 * the shape (instances, columns), (instances, 3, 4) or (instances, 4, 4). CSV: one line per
 * instance, numbers separated by commas, semicolons or blanks. A first line without a number names
 * columns; # begins a comment. */
#ifndef LF_RENDER_INSTANCES_READ_H
#define LF_RENDER_INSTANCES_READ_H

#include "base/status.h"
#include "render/scene/affine.h"

typedef struct lf_instance_list {
    size_t n, room;
    lf_affine *map; /* [n] malloc's */
} lf_instance_list;

/* Reads into a zeroed *out, which the caller frees by lf_instance_list_finish, also after a
 * failure. The ending of path selects NPY or CSV. LF_E_FORMAT: names the instance and the problem;
 * LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_instances_read(const char *path, int fd, lf_instance_list *out,
                                         lf_error *err);
void lf_instance_list_finish(lf_instance_list *places);

#endif
