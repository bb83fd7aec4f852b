/* How large a JSON document is, whatever way it is written; private to render/. */
#ifndef LF_RENDER_JSON_SIZE_H
#define LF_RENDER_JSON_SIZE_H

#include <jansson.h>

/* The fewest bytes that a text of this value can have: no text that says the same is shorter. It is
 * found without making the text, in a time that goes with the number of values. NULL has 0. */
size_t lf_json_least_bytes(const json_t *value);

#endif
