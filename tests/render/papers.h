/* What the tests of the papers' estimators (render/papers/) share: pictures over seeds, held to
 * those of vpt tile by tile. */
#ifndef LF_TESTS_PAPERS_H
#define LF_TESTS_PAPERS_H

#include "tests/testing.h"

#include "render/papers/papers.h"
#include "tests/stat/fixture.h"

enum {
    papers_width = 24,
    papers_height = 16,
    papers_views = 5,
    papers_tile = 8,
    papers_tiles = papers_views * 6 + 1 /* the last is the whole picture */
};

static inline int papers_replicates(void)
{
    return getenv("QUILTD_LONG") ? 64 : 16;
}

static inline int papers_index_of(const char *(*name_at)(int), const char *name)
{
    int i = 0;
    while (name_at(i) && strcmp(name_at(i), name) != 0)
        i++;
    assert_non_null(name_at(i));
    return i;
}

static inline lf_renderer *papers_renderer(lf_scene *scene, const char *integrator, int w, int h,
                                           const char *shift, const char *selection)
{
    lf_renderer *r = lf_test_renderer(scene, integrator, w, h, NULL);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.choices.of[LF_PAPERS_SHIFT] = shift ? papers_index_of(lf_shift_name, shift) : 0;
    settings.choices.of[LF_PAPERS_SELECTION] =
        selection ? papers_index_of(lf_selection_name, selection) : 0;
    lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
    return r;
}

/* Pictures of so many passes each, by two answers. */
static inline void papers_pictures(lf_renderer *r, int passes, uint64_t salt,
                                   const lf_estimator by[2], lf_blocks out[2])
{
    for (int i = 0; i < 2; i++)
        lf_blocks_init(&out[i], papers_views, papers_width, papers_height, papers_tile);
    for (int k = 0; k < papers_replicates(); k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + salt, (uint64_t)k));
        lf_test_passes(r, passes);
        for (int i = 0; i < 2; i++)
            lf_blocks_add_picture(&out[i], r, by[i]);
    }
}

/* A scene natively; the caller finishes it. */
static inline lf_blocks papers_native(lf_scene *scene, int passes)
{
    static const lf_estimator mis[2] = {LF_ESTIMATOR_MIS, LF_ESTIMATOR_MIS};
    lf_blocks both[2];
    lf_renderer *r = lf_test_renderer(scene, "vpt", papers_width, papers_height, NULL);
    papers_pictures(r, passes, 100, mis, both);
    lf_renderer_destroy(r);
    lf_blocks_finish(&both[1]);
    return both[0];
}

/* What is to be seen of a tile and of the whole picture. */
typedef struct papers_power {
    double tile, share, picture; /* factors, and of how many tiles the first */
} papers_power;

/* Agreement, with what the test would see. */
static inline void papers_assert_agreement(const lf_blocks *seen, const lf_blocks *native,
                                           const char *what, double level, papers_power power)
{
    int where = 0, found = 0;
    double p = lf_blocks_welch(seen, native, &where);
    for (int j = 0; j < papers_tiles - 1; j++)
        found += lf_blocks_welch_injected(seen, native, j, power.tile) < level;
    double whole = lf_blocks_welch_injected(seen, native, papers_tiles - 1, power.picture);
    print_message("%s: p %.2g; %.0f %% seen in %d of %d tiles, %.1f %% of the whole with p %.2g\n",
                  what, p, 100 * (power.tile - 1), found, papers_tiles - 1,
                  100 * (power.picture - 1), whole);
    if (!(p > level))
        fail_msg("%s: block %d: %g, natively %g, p %.2g", what, where, seen->moments[where].mean,
                 native->moments[where].mean, p);
    assert_true(found >= power.share * (papers_tiles - 1));
    assert_true(whole < level);
}

#endif
