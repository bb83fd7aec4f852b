/* param: the fields of a struct that people set, as a table.
 *
 * A row says what a field is called on the command line and in JSON, what it may be, what it means
 * and where it lies. Everything else is read from the rows: the options of getopt_long, the lines
 * of --help, the JSON Schema of a method, the checks and what their errors say, the JSON of a
 * manifest. A table ends with a row of zeros. Nothing here keeps state. Thread: any, but for
 * lf_param_print_help, which writes to stdout. */
#ifndef LF_BASE_PARAM_H
#define LF_BASE_PARAM_H

#include <stdint.h>

#include "base/status.h"

typedef enum lf_param_type {
    LF_PARAM_NUMBER, /* double */
    LF_PARAM_ANGLE,  /* double in radians; outside of the struct, and in the row, degrees */
    LF_PARAM_POINT,  /* double[3]; in JSON alone */
    LF_PARAM_WHOLE,  /* int */
    LF_PARAM_SWITCH, /* bool; no argument on the command line where it has no words */
    LF_PARAM_WORD,   /* an enum whose values count from 0 */
    LF_PARAM_TEXT,   /* const char *, borrowed from argv or from the JSON */
    LF_PARAM_NAME,   /* const char *, one of the words; NULL: not given */
    LF_PARAM_SEED,   /* uint64_t, any; on the command line alone */
    /* unsigned, bit k for word k: "all", "none" or words parted by commas; on the command line
     * alone */
    LF_PARAM_LIST,
    /* double[2], two numbers: "N", both the same, or "NxM"; in JSON a number, or a string of two. 0
     * as the second: that of the first */
    LF_PARAM_RASTER,
    /* in scene files alone: */
    LF_PARAM_COLOUR,    /* double[3], one number or three */
    LF_PARAM_DIRECTION, /* double[3], unit; of any length but 0 in the file */
    LF_PARAM_FILE,      /* const char *, whose name ends in a dot and one of word_at */
} lf_param_type;

typedef struct lf_param {
    const char *name;   /* key in JSON; NULL: not there */
    const char *option; /* long option; NULL: not there */
    /* What stands between this row's text and that of the next row of the same option; NULL: the
     * last row of its option. */
    const char *joined;
    const char *argument; /* how --help calls the text; NULL for a switch without words */
    const char *unit;     /* of a number, "mm"; NULL: none */
    const char *help;     /* the first row of an option has that of all; may be NULL with words */
    const char *about;    /* of the key alone, for the schema; NULL: help says it */
    /* Names of the values 0, 1 …, NULL after the last; of a WHOLE: the numbers that it may be; of
     * a NUMBER: what may stand in the place of one, the first for INFINITY, a second for -INFINITY.
     */
    const char *const *words;
    const char *(*word_at)(int index); /* or the same out of a table elsewhere; else NULL */
    const char *(*what_at)(int index); /* what --help says of each of the words; may be NULL */
    /* Words that are refused by what is said of them, "WORD REFUSAL", in place of the list of those
     * that may be; NULL after the last. NULL: there are none. */
    const char *(*refused_at)(int index);
    const char *refusal;
    lf_param_type type;
    bool required; /* by lf_param_missing and lf_param_check */
    size_t place;  /* offset in the struct */
    size_t has; /* of an option's first row: offset of a bool, true once given; 0: there is none */
    double low, high; /* range, of numbers */
    double initial;   /* 0 with a range above it: not given; -1: --help marks no word */
    double point[3];  /* the same of three numbers */
    /* Keys of what is said in one of two ways: 0, the key belongs to both; 1 or 2, to that one. The
     * first key of each must be there when the other's is not, and never beside it. */
    int form;
    bool watts;     /* of lights: W or W sr^-1 */
    bool or_object; /* of a WHOLE: an object may stand in its place, which others read */
    bool exclusive; /* an error where a thing of another kind says it (surfaces) */
    /* of a TEXT: the option may stand without its argument; the field is then NULL, and `has` says
     * that it was given */
    bool optional;
} lf_param;

/* Sets every field that has a row with a name to its initial value: texts, names and files to NULL.
 * Rows of an option alone leave their fields as they are: those share them with rows that have
 * names, or belong to structs in which 0 is what nobody gave. */
void lf_param_defaults(const lf_param *params, void *object);

/* Takes the text of an option, for its first row and those joined to it; NULL for a switch, and for
 * an option that stands without its optional argument.
 * LF_E_ARG with "--OPTION" as where and what was expected; *object untouched then. */
LF_NODISCARD lf_status lf_param_from_text(const lf_param *row, const char *text, void *object,
                                          lf_error *err);

struct json_t;
/* Takes the keys of a JSON object that have rows; others are left alone. LF_E_ARG with the key as
 * pointer. */
LF_NODISCARD lf_status lf_param_from_json(const lf_param *params, const struct json_t *values,
                                          void *object, const char *where, lf_error *err);
/* The first required key that is not in a JSON object; NULL = none. */
const char *lf_param_missing(const lf_param *params, const struct json_t *values);

/* Every field that has a name is within its range, or has its initial value where that is not
 * required. LF_E_ARG. */
LF_NODISCARD lf_status lf_param_check(const lf_param *params, const void *object, const char *where,
                                      lf_error *err);

/* {name: value}, of the rows with a name. A new reference; NULL = out of memory. */
struct json_t *lf_param_json(const lf_param *params, const void *object);
/* {name: JSON Schema}, the properties of an object: about or help as description, the unit, and the
 * initial value as default where it is one of those that may be said. A new reference; NULL = out
 * of memory. */
struct json_t *lf_param_schema(const lf_param *params);

/* The row behind those of this row's option. */
const lf_param *lf_param_next(const lf_param *row);
/* The first row of an option; NULL = none. */
const lf_param *lf_param_find(const lf_param *params, const char *option);
/* Whether a row's option is one of names, parted by blanks; NULL = all options. */
bool lf_param_among(const lf_param *row, const char *names);
/* "LPI@DPI": the argument of an option as --help names it, from its first row; returns buf. */
char *lf_param_argument(const lf_param *row, char *buf, size_t size);
/* A line of --help for every option that is among names (lf_param_among). */
void lf_param_print_help(const lf_param *params, const char *names);

#endif
