/* Small scenes rendered many times: what the statistical tests of the estimators share. Replicates
 * are seeds, never pixels: pixels of a row share the row's offset and views share paths. What is
 * compared are means over blocks of one view. */
#ifndef LF_TESTS_FIXTURE_H
#define LF_TESTS_FIXTURE_H

#include "tests/testing.h"

#include "render/renderer.h"
#include "render/rows/rows.h"
#include "tests/stat/stat.h"

/* A scene from text, as of tests/scene_file.h, in which ' stands for "; fails the test when it
 * cannot be loaded. */
lf_scene *lf_test_scene(const char *text);
/* The same, called "test.json" in warnings, with files in `folder` and what can be shared with a
 * scene before it (may be NULL). */
lf_scene *lf_test_scene_in(const char *folder, const char *text, const lf_scene *previous);
/* Fails the test unless such a scene is refused (LF_E_FORMAT) at this JSON pointer, in words that
 * hold these. */
void lf_test_assert_refused(const char *folder, const char *text, const char *pointer,
                            const char *words);

/* A renderer of it; integrator "vpt" or "mvpt"; pool NULL = the program's own, of two threads. */
lf_renderer *lf_test_renderer(lf_scene *scene, const char *integrator, int width, int height,
                              lf_pool *pool);

/* Renderers made from now on take so many light paths (lf_render_settings); at first none. */
void lf_test_light_paths(int n);
/* Likewise the suffixes of a diffuse pivot; at first 0. */
void lf_test_suffixes(int n, bool one_light, bool early_roulette);

/* The state of its integrator. */
static inline lf_rows *lf_test_rows(const lf_renderer *renderer)
{
    return renderer->state;
}

/* Group teardown of programs that use the program's own pool. */
int lf_test_finish(void **state);

/* Starts over with another seed. Faults stay. */
void lf_test_reseed(lf_renderer *renderer, uint64_t seed);

/* Fails unless the films of both, of the same shape, hold the same bytes. */
void lf_test_same_films(const lf_renderer *a, const lf_renderer *b);

/* n_passes passes by the offline schedule. */
void lf_test_passes(lf_renderer *renderer, int64_t n_passes);

/* What a replicate consists of: calls on a renderer that has just been started over. */
typedef void (*lf_test_schedule)(lf_renderer *renderer);

/* One picture: [row][view][column], the channels' mean with weights 0.5, 0.3, 0.2. Caller frees. */
double *lf_test_picture(const lf_renderer *renderer, lf_estimator estimator);

/* The same of four passes of mvpt, holes filled in the planes of earlier visits, by so many
 * threads.
 */
double *lf_test_picture_by(lf_scene *scene, int width, int height, int threads);

/* A whole cycle of passes n times: n native samples a view pixel. */
void lf_test_cycles(lf_renderer *renderer, int n);

/* The relative mean square error of n values: of d^2/(truth^2 + 0.01). */
double lf_test_rel_mse(const float *values, const float *truth, size_t n);

/* Means over blocks of block x block pixels (the last ones smaller) of each view, over replicates.
 */
typedef struct lf_blocks {
    int n_views, width, height, block, across, n;
    lf_moments *moments; /* [view][down][across], then one of the whole picture: n in all */
    double *last;        /* the block means added last */
} lf_blocks;

void lf_blocks_init(lf_blocks *blocks, int n_views, int width, int height, int block);
void lf_blocks_finish(lf_blocks *blocks);
/* picture as lf_test_picture has it. */
void lf_blocks_add(lf_blocks *blocks, const double *picture);
/* The picture of what the renderer holds. */
void lf_blocks_add_picture(lf_blocks *blocks, const lf_renderer *renderer, lf_estimator estimator);
/* From left to right, and the first view last: what the mirrored scene looks like. */
void lf_blocks_mirror(lf_blocks *blocks);
/* Smallest p of all blocks against the truth's block means (a picture), or against another set of
 * replicates; *out_where (may be NULL) is the block, blocks->n - 1 the whole picture. rounding:
 * relative difference that single precision may make. */
double lf_blocks_p(const lf_blocks *blocks, const double *truth, double rounding, int *out_where);
/* The same against 0 everywhere. */
double lf_blocks_p_zero(const lf_blocks *blocks, int *out_where);
double lf_blocks_welch(const lf_blocks *a, const lf_blocks *b, int *out_where);
/* The p of one block after its mean was multiplied by factor: what injecting a bias does. */
double lf_blocks_welch_injected(const lf_blocks *a, const lf_blocks *b, int which, double factor);

/* (W - n q)/n and q of both halves together, as pictures; second: W' for W. */
void lf_test_weights(const lf_renderer *renderer, bool second, double *out_difference,
                     double *out_q);

/* Replicates of the three pictures above, (W - n q)/n, (W' - n q)/n and q, in blocks of block x
 * block pixels: blocks are made here and finished by the caller. Replicate k starts from a seed of
 * its own. */
void lf_test_weight_blocks(lf_renderer *renderer, lf_test_schedule schedule, int replicates,
                           int block, lf_blocks blocks[3]);

/* Fails the test unless in every block W and W' are n q (p above level), and nothing was dropped.
 */
void lf_test_assert_weights(const char *scene, int width, int height, lf_test_schedule schedule,
                            int replicates, int block, double level);

/* Replicates of an integrator's pictures; salt keeps the seeds of several sets apart. Blocks are
 * made here. */
void lf_test_pictures(lf_renderer *renderer, lf_test_schedule schedule, lf_estimator estimator,
                      int replicates, uint64_t salt, int block, lf_blocks *out);
/* The same by mis, of so many native samples a view pixel. */
void lf_test_sampled_pictures(lf_renderer *renderer, int n_samples, int replicates, uint64_t salt,
                              int block, lf_blocks *out);
/* The same by mis of a scene, which is released: 12 replicates. */
void lf_test_pictures_of(lf_scene *scene, const char *integrator, int width, int height,
                         lf_test_schedule schedule, uint64_t salt, int block, lf_blocks *out);
/* Of a scene, which is released, the same by mis and by cv: out[2], of 18 passes each, 12 of them
 * or with lf_test_long 48. */
void lf_test_two_answers(lf_scene *scene, const char *integrator, int width, int height, int block,
                         uint64_t salt, lf_blocks out[2]);
/* Fails the test unless each of the two, which are then finished, agrees with the truth: p above
 * level; or unless each does not. */
void lf_test_assert_answers(lf_blocks seen[2], const lf_blocks *truth, double level, bool same);

/* Where pixel (column + x, row + y) of a view lies on the window plane, in camera space divided by
 * the distance: slopes of the pinhole ray of this view. */
void lf_test_slopes(const lf_renderer *renderer, int view, double column, double row,
                    double *out_mx, double *out_my);

#endif
