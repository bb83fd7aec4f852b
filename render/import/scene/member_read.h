/* Reading an object of a scene file by a table (base/param.h), into the fields of a struct or, for
 * kinds of lights and surfaces, key by key (render/scene/key.h); private to render/. Errors persist
 * in the reader, as in json_reader.h. */
#ifndef LF_RENDER_MEMBER_READ_H
#define LF_RENDER_MEMBER_READ_H

#include "render/import/scene/json_reader.h"
#include "render/scene/key.h"

#define LF_MAX_KINDS 16 /* of lights, of surfaces, of shapes */

/* The index in types (ended by NULL) of node's "type"; fallback if absent; a negative fallback
 * makes it mandatory. In range also after an error. */
int lf_read_type(lf_reader *reader, const lf_node *node, const char *const types[], int fallback);

/* Sets every field that has a row, to its default if absent in node. Keys other than these and
 * `also` (may be NULL) are an error. At most 32 rows. */
void lf_read_params(lf_reader *reader, const lf_node *node, const char *also,
                    const lf_param params[], void *object);

/* Reads every key of a kind. Keys other than these and "type" are an error. out has a value for
 * each of keys, in their order; strings are borrowed from the document. */
void lf_read_values(lf_reader *reader, const lf_node *node, const lf_param keys[], lf_value out[]);

/* Reads one key into *out. */
void lf_read_value(lf_reader *reader, const lf_node *node, const lf_param *key, lf_value *out);

/* For objects that need either a or b: whether it is a. */
bool lf_read_either(lf_reader *reader, const lf_node *node, const char *a, const char *b);

/* Whether a file name ends in a dot and one of endings (ended by NULL), ignoring case. */
bool lf_is_file_of(const char *file, const char *const endings[]);
/* The value of key if it is the name of such a file; NULL = absent or wrong. A relative name is
 * wrong if the reader has no folder. */
const char *lf_read_file(lf_reader *reader, const lf_node *node, const char *key,
                         const char *const endings[]);
/* Reports that this name is relative although the document has no folder. */
void lf_read_relative(lf_reader *reader, const lf_node *node, const char *file);

#endif
