/* Names of the files of a sequence: "smoke_%04d.vdb" is smoke_0007.vdb in frame 7.
 *
 * The number's place is "%d" or "%0Nd", N from 1 to 9: at least N digits, zeros before. Every such
 * place in a name gets the number; any other % is itself. Thread: any. */
#ifndef LF_BASE_FRAME_NAME_H
#define LF_BASE_FRAME_NAME_H

#include <stdbool.h>

/* Whether a name has a place for a number. */
bool lf_frame_name_varies(const char *name);
/* The name with number (0 or more) in all its places; caller frees with lf_free. NULL = out of
 * memory. */
char *lf_frame_name(const char *name, int number);

#endif
