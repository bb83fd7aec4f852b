/* Reading typed values out of a JSON document, with one line that says where and why when something
 * is wrong; private to render/. The first error sticks: after it every function returns its
 * fallback, so callers check reader->status once, at the end. Absent members give the fallback;
 * null is an error like any other wrong type. Ranges are closed. */
#ifndef LF_RENDER_JSON_READER_H
#define LF_RENDER_JSON_READER_H

#include <jansson.h>

#include "base/status.h"

/* A document that another one is merged of. */
typedef struct lf_json_source {
    const char *where; /* names it in errors */
    const char *text;  /* the file's text, to find lines in; NULL for documents in memory */
    size_t size;
    json_t *doc;
} lf_json_source;

typedef struct lf_reader {
    const char *where, *text; /* as in lf_json_source */
    size_t size;
    lf_status status;
    lf_error *err; /* may be NULL */
    /* What the document is merged of, if it is: what comes first wins. Errors are then reported in
     * the first of them that holds the value, or most of the way to it. */
    const lf_json_source *sources;
    int n_sources;
} lf_reader;

/* A value and the way to it. Lives on the stack of whoever walks; parents outlive children. */
typedef struct lf_node {
    const struct lf_node *parent; /* NULL for the root */
    const char *key;              /* NULL for members of arrays */
    size_t index;
    /* borrowed, never changed; NULL = absent (not const because Jansson's iterators are not) */
    json_t *value;
} lf_node;

lf_node lf_node_child(const lf_node *parent, const char *key);
lf_node lf_node_item(const lf_node *parent, size_t index);

/* Reports at a node (an absent one: at its nearest present parent, with the pointer of the absent
 * one). */
void lf_read_fail(lf_reader *reader, const lf_node *node, const char *fmt, ...) LF_PRINTF(3, 4);
/* Reports what a loader said about the file that a node names: same status, "FILE: WHAT", at the
 * node. */
void lf_read_fail_with(lf_reader *reader, const lf_node *node, const lf_error *inner);

/* Checks that node is an object whose keys are all among keys (ended by NULL). false: absent or
 * wrong. */
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

/* Line (1 = first) at which the value of a JSON pointer starts in text; where the pointer leads
 * nowhere, the line of its nearest parent. text must have been accepted by a JSON parser. */
int lf_json_line(const char *text, size_t size, const char *pointer);

#endif
