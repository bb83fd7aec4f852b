/* References that are drawn once and kept: block means of many replicates, a file a set in
 * tests/stat/kept. What is compared with them has no noise but its own. A check draws a quarter of
 * the passes, for a look at whether what is kept is still what this integrator renders;
 * QUILTD_LONG=1 (make verify) draws all anew and compares with that. QUILTD_KEEP=1 draws twice
 * as many and writes the files: after a test's scene or settings have changed, never because a test
 * fails. */
#ifndef LF_TESTS_KEPT_H
#define LF_TESTS_KEPT_H

#include "tests/stat/fixture.h"

typedef struct lf_kept {
    const char *name; /* of the file */
    int replicates;   /* under QUILTD_LONG four times as many */
    int cycles;       /* of each */
    uint64_t salt;    /* keeps the seeds of several sets apart */
    lf_estimator answer;
    int block;    /* pixels */
    double level; /* below which p says that what is kept is not what is drawn */
} lf_kept;

/* Replicates of what the renderer, which is destroyed, shows: those that are kept, or drawn anew.
 * Blocks are made here. Fails the test where none of this shape are kept, and where those that are
 * drawn differ from them in a block. */
void lf_test_kept(lf_renderer *renderer, const lf_kept *kept, lf_blocks *out);

/* What is kept of other means: n of them, of as many replicates each. Fails the test where a file
 * is not there or has another n. */
void lf_kept_read(const char *name, int n, lf_moments *out);
void lf_kept_write(const char *name, int n, const lf_moments *moments);
/* QUILTD_KEEP is set. */
bool lf_test_keeping(void);

#endif
