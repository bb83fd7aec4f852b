/* Reading typed values from a JSON document, with one error line that names position and reason;
 * private to render/. The first error persists: after it every function returns its fallback, so
 * callers check reader->status once, at the end. Absent members give the fallback; null is an error
 * like any other wrong type. Ranges are closed. */
#ifndef LF_RENDER_JSON_READER_H
#define LF_RENDER_JSON_READER_H

#include <jansson.h>

#include "base/status.h"

/* A document that is merged into another. */
typedef struct lf_json_source {
    const char *where; /* its name in errors */
    const char *text;  /* the file's text, for line numbers; NULL for documents in memory */
    size_t size;
    json_t *doc;
} lf_json_source;

typedef struct lf_reader {
    const char *where, *text; /* as in lf_json_source */
    size_t size;
    lf_status status;
    lf_error *err; /* may be NULL */
    /* The sources of a merged document; earlier ones win. An error is reported in the first of them
     * that holds the value, or the longest part of its path. */
    const lf_json_source *sources;
    int n_sources;
    bool has_no_folder; /* relative file names are refused */
} lf_reader;

/* A value and its path. Lives on the caller's stack; parents must outlive children. */
typedef struct lf_node {
    const struct lf_node *parent; /* NULL for the root */
    const char *key;              /* NULL for array elements */
    size_t index;
    /* borrowed, never changed; NULL = absent (not const because Jansson's iterators are not) */
    json_t *value;
} lf_node;

lf_node lf_node_child(const lf_node *parent, const char *key);
lf_node lf_node_item(const lf_node *parent, size_t index);

/* Reports an error at a node. If it is absent: at its nearest present parent, with the pointer of
 * the absent one. */
void lf_read_fail(lf_reader *reader, const lf_node *node, const char *fmt, ...) LF_PRINTF(3, 4);
/* Reports a loader's error about the file that a node names: same status, "FILE: WHAT", at the
 * node. */
void lf_read_fail_with(lf_reader *reader, const lf_node *node, const lf_error *inner);

/* Checks that node is an object with keys from `keys` (ended by NULL) only. false: absent or wrong.
 */
bool lf_read_object(lf_reader *reader, const lf_node *node, const char *const keys[]);
double lf_read_number(lf_reader *reader, const lf_node *parent, const char *key, double fallback,
                      double lo, double hi);
int lf_read_int(lf_reader *reader, const lf_node *parent, const char *key, int fallback, int lo,
                int hi);
bool lf_read_bool(lf_reader *reader, const lf_node *parent, const char *key, bool fallback);
/* An array of exactly n numbers. false: absent or wrong, out untouched. */
bool lf_read_numbers(lf_reader *reader, const lf_node *parent, const char *key, int n, double *out,
                     double lo, double hi);
/* One number (grey) or three. false: absent or wrong, out untouched. */
bool lf_read_colour(lf_reader *reader, const lf_node *parent, const char *key, double out[3],
                    double lo, double hi);
/* A string of 1..max bytes, borrowed from the document. */
const char *lf_read_string(lf_reader *reader, const lf_node *parent, const char *key,
                           const char *fallback, size_t max);
/* Index of a string in names (ended by NULL). */
int lf_read_choice(lf_reader *reader, const lf_node *parent, const char *key,
                   const char *const names[], int fallback);

/* "a, b, c", cut to size. */
void lf_join_names(const char *const names[], char *out, size_t size);

/* Line (1 = first) at which the value of a JSON pointer starts in text; for an invalid pointer the
 * line of its nearest parent. text must have been accepted by a JSON parser. */
int lf_json_line(const char *text, size_t size, const char *pointer);

#endif
