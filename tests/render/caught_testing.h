/* What tests of catchers in pictures that grow share. */
#ifndef LF_TESTS_RENDER_CAUGHT_TESTING_H
#define LF_TESTS_RENDER_CAUGHT_TESTING_H

#include "tests/testing.h"

#include "tests/stat/fixture.h"

enum { SIDE = 24, MOST_VIEWS = 45, MOST = SIDE * SIDE * MOST_VIEWS };

typedef struct caught_pictures {
    int n_views;
    float plain[3 * MOST];  /* without what is caught */
    float whole[3 * MOST];  /* with that of a picture that is done */
    float live[3 * MOST];   /* and with what is sampled beside it */
    float smooth[3 * MOST]; /* the same, smooth */
    float layers[5 * MOST]; /* up to 5 channels a pixel */
} caught_pictures;

static inline void caught_add_to_all(lf_caught *caught, int samples)
{
    for (int row = 0; row < SIDE; row++)
        while (lf_caught_samples(caught, row) < samples) {
            const int before = lf_caught_samples(caught, row);
            lf_caught_add(caught, row);
            assert_true(lf_caught_samples(caught, row) > before);
        }
}

static inline void caught_take_all(const lf_caught *caught, bool smooth, int n_views,
                                   float *picture)
{
    for (int row = 0; row < SIDE; row++)
        lf_caught_take(caught, row, smooth, picture + (size_t)row * (size_t)(n_views * SIDE * 3));
}

/* After so many cycles of a picture, and of so many steps of catchers in every row; layers as
 * lf_renderer_layers has them. */
static inline void caught_make(const char *text, int cycles, int samples, unsigned layers,
                               caught_pictures *out)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
    lf_caught *caught = NULL;
    lf_test_cycles(r, cycles);
    out->n_views = lf_renderer_settings(r)->camera.n_views;
    assert_true(out->n_views <= MOST_VIEWS);
    const size_t bytes = sizeof(float) * 3 * (size_t)(SIDE * SIDE * out->n_views);
    lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MWIS, out->plain, NULL), NULL);
    memcpy(out->whole, out->plain, bytes);
    memcpy(out->live, out->plain, bytes);
    memcpy(out->smooth, out->plain, bytes);
    lf_assert_ok(lf_renderer_catch(r, out->whole, NULL), NULL);
    lf_assert_ok(lf_renderer_layers(r, LF_ESTIMATOR_MWIS, layers, out->layers, NULL), NULL);
    lf_assert_ok(lf_caught_begin(&caught, r), NULL);
    assert_non_null(caught);
    caught_add_to_all(caught, samples);
    caught_take_all(caught, false, out->n_views, out->live);
    lf_assert_ok(lf_caught_smooth(caught, NULL), NULL);
    caught_take_all(caught, true, out->n_views, out->smooth);
    lf_caught_destroy(caught);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

#endif
