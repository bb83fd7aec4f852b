/* param: tables that describe the user-visible fields of a struct.
 *
 * A row gives a field's name on the command line and in JSON, its range, its meaning and its
 * offset. Everything else follows from the rows: the options of getopt_long, the lines of --help,
 * the JSON Schema of a method, checks and their errors, the JSON of a manifest. A table ends with a
 * row of zeros. No state. Thread: any, except lf_param_print_help, which writes to stdout. */
#ifndef LF_BASE_PARAM_H
#define LF_BASE_PARAM_H

#include <stdint.h>

#include "base/status.h"

typedef enum lf_param_type {
    LF_PARAM_NUMBER, /* double */
    LF_PARAM_ANGLE,  /* double in radians; degrees in the row and outside the struct */
    LF_PARAM_POINT,  /* double[3]; only in JSON */
    LF_PARAM_WHOLE,  /* int */
    LF_PARAM_SWITCH, /* bool; without words it takes no argument on the command line */
    LF_PARAM_WORD,   /* an enum whose values count from 0 */
    LF_PARAM_TEXT,   /* const char *, borrowed from argv or from the JSON */
    LF_PARAM_NAME,   /* const char *, one of the words; NULL: not given */
    LF_PARAM_SEED,   /* uint64_t, any value; only on the command line */
    /* unsigned, bit k for word k: "all", "none" or words separated by commas; only on the command
     * line */
    LF_PARAM_LIST,
    /* double[2]: "N" (both the same) or "NxM"; in JSON a number or such a string. 0 as the second:
     * equal to the first. */
    LF_PARAM_RASTER,
    /* only in scene files: */
    LF_PARAM_COLOUR,    /* double[3], one number or three */
    LF_PARAM_DIRECTION, /* double[3], a unit vector; of any length except 0 in the file */
    LF_PARAM_FILE,      /* const char *, a file name that ends in a dot and one of word_at */
} lf_param_type;

typedef struct lf_param {
    const char *name;   /* key in JSON; NULL: not in JSON */
    const char *option; /* long option; NULL: no option */
    /* Separator between this row's text and the next row of the same option; NULL: the last row of
     * its option. */
    const char *joined;
    const char *argument; /* name of the argument in --help; NULL for a switch without words */
    const char *unit;     /* unit of a number, "mm"; NULL: none */
    /* The first row of an option has the text for all; may be NULL with words. A default that is
     * not a value is in brackets at the end: "number of views (the scene's)". */
    const char *help;
    const char *about; /* about the JSON key, for the schema; NULL: use help */
    /* Names of the values 0, 1 …, NULL after the last. WHOLE: the allowed numbers. NUMBER: words
     * accepted instead of a number, the first for INFINITY, a second for -INFINITY. */
    const char *const *words;
    const char *(*word_at)(int index); /* or words from another table; otherwise NULL */
    const char *(*what_at)(int index); /* help text for each word; may be NULL */
    /* Words that are refused with the text "WORD REFUSAL" instead of the list of allowed words;
     * NULL after the last. NULL: none. */
    const char *(*refused_at)(int index);
    const char *refusal;
    /* The name that replaced this row's name and option (former.h); NULL: they are current. The row
     * is read like any other, but --help and completions leave it out. */
    const char *former;
    const char *needs; /* the option without which this one has no effect; NULL: none */
    lf_param_type type;
    bool required; /* by lf_param_missing and lf_param_check */
    size_t place;  /* offset in the struct */
    size_t has; /* for the first row of an option: offset of a bool that is set when it was given;
                 * 0: none */
    double low, high; /* range of numbers */
    double initial;   /* default; 0 below the range: not given; -1: --help marks no word */
    double point[3];  /* default of three numbers */
    /* For alternatives: 0, the key belongs to both forms; 1 or 2, to that form. The first key of
     * one form is required if that of the other is absent, and forbidden otherwise. */
    int form;
    bool watts;     /* for lights: W or W sr^-1 */
    bool or_object; /* WHOLE: an object, which other code reads, may replace it */
    bool exclusive; /* an error in an object of another kind (surfaces) */
    /* TEXT: the argument is optional; without it the field is NULL and `has` is set. WORD: without
     * it the value is the word with the index `low` */
    bool optional;
} lf_param;

/* Sets every field whose row has a name to its default: texts, names and files to NULL. Fields of
 * rows that have only an option keep their values: they share the field with a named row, or are in
 * structs in which 0 means "not given". */
void lf_param_defaults(const lf_param *params, void *object);

/* Sets the fields of an option's first row and of the rows joined to it from its text. text NULL:
 * for a switch, or an omitted optional argument. LF_E_ARG with "--OPTION" as where and the expected
 * value; *object is then untouched. */
LF_NODISCARD lf_status lf_param_from_text(const lf_param *row, const char *text, void *object,
                                          lf_error *err);

/* The option of a first row and the rows joined to it as one word, "--print-size=190x277": what
 * lf_param_from_text reads back. A switch without words is "--NAME" whatever its value. Not for an
 * angle. The caller frees it with lf_free; NULL = out of memory. */
char *lf_param_word(const lf_param *row, const void *object);
/* True if the option was given (`has`), or without `has`: a field of its rows differs in the
 * objects. */
bool lf_param_differs(const lf_param *row, const void *object, const void *other);

struct json_t;
/* Sets fields from the keys of a JSON object that have rows; ignores other keys. LF_E_ARG with the
 * key as pointer. */
LF_NODISCARD lf_status lf_param_from_json(const lf_param *params, const struct json_t *values,
                                          void *object, const char *where, lf_error *err);
/* The first required key missing in a JSON object; NULL = none. */
const char *lf_param_missing(const lf_param *params, const struct json_t *values);

/* Checks that every named field is within its range, or has its default if it is not required.
 * LF_E_ARG. */
LF_NODISCARD lf_status lf_param_check(const lf_param *params, const void *object, const char *where,
                                      lf_error *err);

/* {name: value} of the rows with a name. A new reference; NULL = out of memory. */
struct json_t *lf_param_json(const lf_param *params, const void *object);
/* {name: JSON Schema}: the properties of an object, with about or help as description, the unit,
 * and the default if it is an allowed value. A new reference; NULL = out of memory. */
struct json_t *lf_param_schema(const lf_param *params);

/* The first row after all rows of this row's option. */
const lf_param *lf_param_next(const lf_param *row);
/* The first row of an option; NULL = none. */
const lf_param *lf_param_find(const lf_param *params, const char *option);
/* True if a row's option is in names, separated by blanks; NULL = all options. */
bool lf_param_among(const lf_param *row, const char *names);
/* "LPI@DPI": the argument of an option in --help, from its first row; returns buf. */
char *lf_param_argument(const lf_param *row, char *buf, size_t size);
/* Prints a line of --help for every option in names (lf_param_among). */
void lf_param_print_help(const lf_param *params, const char *names);

#endif
