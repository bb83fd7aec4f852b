/* Reading a part of a scene file by the table of its struct (base/param.h); private to render/.
 * Errors stick to the reader, as in json_reader.h. */
#ifndef LF_RENDER_PARAM_READ_H
#define LF_RENDER_PARAM_READ_H

#include "base/param.h"
#include "render/load/json_reader.h"

#define LF_MAX_PARAMS 32 /* of a struct */

/* Sets every field that has a row, to its initial value where node says nothing; any other key is
 * an error. Rows of texts are not for scene files. */
void lf_read_params(lf_reader *reader, const lf_node *node, const lf_param params[], void *object);

#endif
