/* What tests of the reconstruction share. tests/stat/stat.h has another lf_moments than
 * render/reconstruct/lattice.h. */
#ifndef LF_TESTS_RENDER_RECONSTRUCT_TESTING_H
#define LF_TESTS_RENDER_RECONSTRUCT_TESTING_H

#include "tests/testing.h"

#define lf_moments lf_stat_moments
#include "tests/stat/fixture.h"
#undef lf_moments

#include "render/reconstruct/moments.h"
#include "render/renderer.h"

/* With a film that has features; the scene is given away. */
static inline lf_renderer *reconstruct_renderer_of(lf_scene *scene, int width, int height,
                                                   lf_pool *pool)
{
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, pool);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.features = true;
    lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
    lf_scene_unref(scene);
    return r;
}
static inline lf_renderer *reconstruct_renderer(const char *text, int width, int height,
                                                lf_pool *pool)
{
    return reconstruct_renderer_of(lf_test_scene(text), width, height, pool);
}

/* As on a display: n visits of one pass. part: NULL = all rows. */
static inline void reconstruct_visits(lf_renderer *r, const lf_part *part, int n)
{
    for (int i = 0; i < n; i++)
        lf_assert_ok(lf_renderer_pass(r, part, 1, NULL, NULL, NULL), NULL);
}

/* The sums of the finest cells, which the fit has given back; their nodes are 0 then. */
static inline void reconstruct_gather(lf_renderer *r)
{
    lf_reconstruct_scratch *scratch = lf_scratch_take(r->shown);
    assert_non_null(scratch);
    for (int b = 0; b < r->shown->level[0].n_bands; b++)
        lf_assert_ok(lf_moments_gather(r->shown, &r->film, b, scratch), NULL);
    lf_scratch_give(r->shown, scratch);
}

#endif
