/* The slideshow of a quiltd that does not exist: what the gateway's Bridge asks for. Files below
 * /refused are outside, those below /missing are not there, and those below /bad cannot be shown.
 * Time does not pass. */
#ifndef LF_TESTS_WEB_FALSE_SLIDESHOW_H
#define LF_TESTS_WEB_FALSE_SLIDESHOW_H

#include <jansson.h>
#include <stdbool.h>

typedef struct lf_false_slideshow {
    bool on;         /* it answers */
    bool no_panel;   /* there is no calibration */
    bool is_hanging; /* nothing that is played is ever shown */
    bool is_spoilt;  /* no file can be shown any more */
    json_t *entries; /* NULL: none */
    int index, turn;
    bool playing, paused, loop;
} lf_false_slideshow;

/* What follows an answer: notifications before and after it. */
typedef struct lf_false_answer {
    json_t *result;      /* NULL: an error */
    const char *message; /* of the error, static */
    json_t *before, *after;
} lf_false_answer;

/* False: it is not on, or knows no such method. */
bool lf_false_slideshow_answer(lf_false_slideshow *s, const char *method, json_t *params,
                               lf_false_answer *out);
void lf_false_slideshow_finish(lf_false_slideshow *s);
/* {"jsonrpc", "method", "params"}. params: taken. */
json_t *lf_false_notification(const char *method, json_t *params);
json_t *lf_false_slideshow_json(const lf_false_slideshow *s);

#endif
