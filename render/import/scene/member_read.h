/* Reading what a scene file says of one thing by a table (base/param.h), into the fields of a
 * struct or, of a kind of lights or surfaces, key by key (render/scene/key.h); private to render/.
 * Errors stick to the reader, as in json_reader.h. */
#ifndef LF_RENDER_MEMBER_READ_H
#define LF_RENDER_MEMBER_READ_H

#include "render/import/scene/json_reader.h"
#include "render/scene/key.h"

#define LF_MAX_KINDS 16 /* of lights, of surfaces, of shapes */

/* The place in types (ended by NULL) of what node's "type" says; fallback where it says nothing,
 * below 0: it must. In range whatever went wrong. */
int lf_read_type(lf_reader *reader, const lf_node *node, const char *const types[], int fallback);

/* Sets every field that has a row, to its initial value where node says nothing; any other key but
 * `also` (may be NULL) is an error. At most 32 rows. */
void lf_read_params(lf_reader *reader, const lf_node *node, const char *also,
                    const lf_param params[], void *object);

/* Reads every key of a kind; any other key than these and "type" is an error. out has a value for
 * each of keys, in their order; texts are borrowed from the document. */
void lf_read_values(lf_reader *reader, const lf_node *node, const lf_param keys[], lf_value out[]);

/* Reads one key into *out. */
void lf_read_value(lf_reader *reader, const lf_node *node, const lf_param *key, lf_value *out);

/* Things need a or b, and not both: whether it is a. */
bool lf_read_either(lf_reader *reader, const lf_node *node, const char *a, const char *b);

/* Whether a file's name ends in a dot and one of endings (ended by NULL), whatever the case of the
 * letters. */
bool lf_is_file_of(const char *file, const char *const endings[]);
/* The name under key when it is that of such a file; NULL = absent or wrong. */
const char *lf_read_file(lf_reader *reader, const lf_node *node, const char *key,
                         const char *const endings[]);

#endif
