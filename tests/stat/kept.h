/* References that are drawn once and kept: block means of many replicates, a file a set in
 * tests/stat/kept. What is compared with them has no noise but its own. A check draws a part of
 * the passes, by other random numbers, for a look at whether what is kept is still what this
 * integrator renders: 5 % would be seen in half of the blocks, 1 % of the whole. QUILTD_LONG=1
 * (make verify) draws pictures anew and compares with those. QUILTD_KEEP=1 draws twice as many and
 * writes the files: after a test's scene or settings have changed, never because a test fails. */
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
    int parts;    /* a check draws one of so many parts of the cycles; 0: four */
} lf_kept;

/* Replicates of what the renderer, which is destroyed, shows: those that are kept, or drawn anew.
 * Blocks are made here. Fails the test where none of this shape are kept, and where those that are
 * drawn differ from them in a block. */
void lf_test_kept(lf_renderer *renderer, const lf_kept *kept, lf_blocks *out);

/* p of two means of one distribution, of which a replicate of those drawn has 1/share of the cycles
 * of one that is kept. Both tell its spread, which is pooled: where little but the sky is seen, few
 * replicates may all have missed the rest and tell none. What differs by rounding is the same. */
double lf_kept_p(const lf_moments *drawn, const lf_moments *kept, double share);

/* What is kept of other means: n of them, of as many replicates each. Fails the test where a file
 * is not there or has another n. */
void lf_kept_read(const char *name, int n, lf_moments *out);
void lf_kept_write(const char *name, int n, const lf_moments *moments);
/* QUILTD_KEEP is set. */
bool lf_test_keeping(void);

#endif
