/* File names of a sequence: "smoke_%04d.vdb" is smoke_0007.vdb in frame 7.
 *
 * The number field is "%d" or "%0Nd", N from 1 to 9: at least N digits, padded with zeros. Every
 * field in a name gets the number; any other % is literal. Thread: any. */
#ifndef LF_BASE_FRAME_NAME_H
#define LF_BASE_FRAME_NAME_H

#include <stdbool.h>

/* The number fields of a name. */
int lf_frame_name_fields(const char *name);
/* True if a name has a number field. */
bool lf_frame_name_varies(const char *name);
/* The name with number (>= 0) in all its fields; caller frees with lf_free. NULL = out of
 * memory. */
char *lf_frame_name(const char *name, int number);

#endif
