/* What a PNG file says about how it was rendered (lf_output_settings), to find frames of one
 * sequence that were rendered with different settings. Cameras, seeds and sizes are not compared.
 * Thread safe. */
#ifndef LF_DAEMON_MADE_WITH_H
#define LF_DAEMON_MADE_WITH_H

#include <jansson.h>

#include "base/image_io.h"

enum { LF_MADE_WITH_KEYS = 9 };

/* Values of the keys that are compared; "": not known. */
typedef struct lf_made_with {
    char value[LF_MADE_WITH_KEYS][LF_PNG_TEXT];
} lf_made_with;

/* Of a file; nothing is known of other formats, and of files that cannot be read. */
void lf_made_with_read(const char *path, lf_made_with *out);
/* Of the settings that a file will have. */
void lf_made_with_settings(const json_t *settings, lf_made_with *out);
/* The first key that both know and that differs: "exposure -3, not 0", the value of `is` first.
 * False: there is none. Scenes are compared without their folders, exposures unless they have keys,
 * and values that may have been cut not at all. */
bool lf_made_with_differs(const lf_made_with *is, const lf_made_with *expected, char *words,
                          size_t size);

#endif
