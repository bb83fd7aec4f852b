/* quiltrender PRINT.tif --simulate: what an eye sees of a finished print. Thread: the main thread.
 */
#ifndef LF_DAEMON_SIMULATE_H
#define LF_DAEMON_SIMULATE_H

#include "base/param.h"
#include "base/thread.h"

typedef enum lf_both_eyes { LF_EYES_SIDE_BY_SIDE, LF_EYES_ANAGLYPH } lf_both_eyes;

/* Zeroed with lf_param_defaults is a valid start. */
typedef struct lf_simulate_options {
    bool on;         /* --simulate */
    const char *eye; /* "X,Y,D"; NULL: in front of the middle */
    bool has_stereo;
    lf_both_eyes stereo;
    double eyes_mm;    /* from eye to eye */
    int width;         /* of the picture; 0: one pixel per lens */
    bool marks;        /* mark parallax and what the edge cuts */
    bool untrimmed;    /* with bleed and marks */
    const char *first; /* the first of these options that was given */
} lf_simulate_options;
extern const lf_param lf_simulate_params[];

/* True if a command line asks for --simulate (or an unambiguous beginning of it). */
bool lf_simulate_is_wanted(int argc, char *const argv[]);
/* Runs the command; returns the exit status. */
int lf_simulate_run(int argc, char *const argv[], const lf_cancel *cancel);

#endif
