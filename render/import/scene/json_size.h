/* The size of a JSON document, independent of its formatting; private to render/. */
#ifndef LF_RENDER_JSON_SIZE_H
#define LF_RENDER_JSON_SIZE_H

#include <jansson.h>

/* The size in bytes of the shortest text of this value. Computed without making the text, in time
 * proportional to the number of values. NULL has 0. */
size_t lf_json_least_bytes(const json_t *value);

#endif
