/* The renderer as a machine: what it allocates, keeps, forgets, saves and refuses. */
#include "tests/testing.h"

#include <fcntl.h>
#include <malloc.h>

#include "base/alloc.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { WIDTH = 40, HEIGHT = 24, VIEWS = 5, VALUES = VIEWS * WIDTH * HEIGHT * 3 };

static float *resolved(const lf_renderer *r, lf_estimator estimator, uint8_t *flags)
{
    float *out = lf_calloc(VALUES, sizeof *out);
    assert_non_null(out);
    lf_assert_ok(lf_renderer_resolve(r, estimator, out, flags), NULL);
    return out;
}

static void assert_same_picture(const lf_renderer *a, const lf_renderer *b)
{
    for (int estimator = LF_ESTIMATOR_MWIS; estimator <= LF_ESTIMATOR_CV; estimator++) {
        float *x = resolved(a, (lf_estimator)estimator, NULL),
              *y = resolved(b, (lf_estimator)estimator, NULL);
        assert_memory_equal(x, y, VALUES * sizeof *x);
        lf_free(x);
        lf_free(y);
    }
}

static lf_renderer *mixed(lf_scene **out_scene)
{
    *out_scene = lf_test_scene(lf_test_scene_views("mixed", 5));
    return lf_test_renderer(*out_scene, "mvpt", WIDTH, HEIGHT, NULL);
}

static void passes_allocate_nothing(void **state)
{
    (void)state;
    lf_scene *scene;
    lf_renderer *r = mixed(&scene);
    lf_test_passes(r, 2 * VIEWS);
    uint64_t ours = lf_alloc_count();
    size_t heap = mallinfo2().uordblks;
    for (int i = 0; i < 20; i++)
        lf_assert_ok(lf_renderer_pass_filling(r, NULL, 1, 0, NULL, NULL, NULL), NULL);
    lf_test_passes(r, VIEWS);
    assert_int_equal(lf_alloc_count(), ours);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    assert_int_equal(mallinfo2().uordblks, heap);
#endif
    (void)heap;
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void a_restart_leaves_nothing_of_the_old_picture(void **state)
{
    (void)state;
    lf_scene *scene, *again;
    lf_error err;
    lf_renderer *fresh = mixed(&scene), *used = mixed(&again);
    lf_test_passes(used, 3 * VIEWS);
    lf_render_settings settings = *lf_renderer_settings(used);
    lf_assert_ok(lf_renderer_restart(used, again, &settings, &err), &err);
    lf_test_passes(fresh, VIEWS + 2);
    lf_test_passes(used, VIEWS + 2);
    assert_same_picture(fresh, used);
    lf_renderer_destroy(fresh);
    lf_renderer_destroy(used);
    lf_scene_unref(scene);
    lf_scene_unref(again);
}

static void settings_out_of_range_are_refused_and_change_nothing(void **state)
{
    (void)state;
    lf_scene *scene;
    lf_error err;
    lf_renderer *r = mixed(&scene);
    lf_test_passes(r, VIEWS);
    float *before = resolved(r, LF_ESTIMATOR_MIS, NULL);
    lf_render_settings good = *lf_renderer_settings(r), bad[5] = {good, good, good, good, good};
    bad[0].integrator = "bdpt";
    bad[1].camera.n_views = 0;
    bad[2].width = LF_MAX_VIEW_SIDE + 1;
    bad[3].camera.fov_y = -1.0;
    memcpy(bad[4].camera.position, bad[4].camera.target, sizeof bad[4].camera.target);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        lf_assert_status(lf_renderer_restart(r, scene, &bad[i], &err), LF_E_ARG, &err);
        assert_true(err.what[0] != '\0');
    }
    float *after = resolved(r, LF_ESTIMATOR_MIS, NULL);
    assert_memory_equal(before, after, VALUES * sizeof *before);
    lf_free(before);
    lf_free(after);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void a_cancelled_pass_says_so(void **state)
{
    (void)state;
    lf_scene *scene;
    lf_cancel cancel = 1;
    lf_renderer *r = mixed(&scene);
    lf_assert_status(lf_renderer_pass(r, NULL, 1, NULL, NULL, &cancel), LF_E_CANCELLED, NULL);
    lf_assert_status(lf_renderer_passes(r, NULL, 7, false, NULL, NULL, &cancel), LF_E_CANCELLED,
                     NULL);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* A slab whose upper and lower sides run along rows: a visit's plane meets it or passes it by.
 * Whatever the last plane did, a pixel that an earlier one found something in gets a path there. */
static void holes_are_filled_where_something_was_found(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("slab-along-rows"));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", WIDTH, HEIGHT, NULL);
    int64_t filled = 0;
    for (uint64_t seed = 0; seed < 100; seed++) {
        lf_render_stats stats;
        lf_test_reseed(r, lf_hash64(lf_test_seed(), seed));
        lf_test_passes(r, 2);
        free(lf_test_picture(r, LF_ESTIMATOR_MWIS));
        lf_renderer_stats(r, &stats);
        filled += stats.holes;
        lf_assert_ok(lf_renderer_fill_holes(r, NULL, NULL), NULL);
        for (int row = 0; row < HEIGHT; row++) {
            const lf_film_half a = lf_film_at(&r->film, row, 0), b = lf_film_at(&r->film, row, 1);
            for (int i = 0; i < VIEWS * WIDTH; i++)
                assert_true(a.q[i] + b.q[i] < 1e-3f ||
                            a.scattered[i].w + b.scattered[i].w > 1e-20f);
        }
    }
    assert_true(filled > 100);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* Largest distance along a row from a hole to a pixel of its view that is none. */
static int farthest_hole(const uint8_t *flags)
{
    int farthest = 0;
    for (int line = 0; line < VIEWS * HEIGHT; line++) {
        for (int x = 0; x < WIDTH; x++) {
            int nearest = WIDTH;
            for (int other = 0; other < WIDTH; other++)
                if (flags[line * WIDTH + other] != LF_PIXEL_HOLE)
                    nearest = abs(other - x) < nearest ? abs(other - x) : nearest;
            farthest = nearest > farthest ? nearest : farthest;
        }
    }
    return farthest;
}

static void filling_leaves_no_hole_beyond_its_reach(void **state)
{
    (void)state;
    static const int reach[3] = {-1, 2, 0};
    int farthest[3];
    for (int i = 0; i < 3; i++) {
        uint8_t flags[VIEWS * WIDTH * HEIGHT];
        lf_scene *scene = lf_test_scene(lf_test_scene_views("fogs", 5));
        lf_renderer *r = lf_test_renderer(scene, "vpt", WIDTH, HEIGHT, NULL);
        lf_assert_ok(lf_renderer_pass_filling(r, NULL, 1, reach[i], NULL, NULL, NULL), NULL);
        lf_free(resolved(r, LF_ESTIMATOR_MWIS, flags));
        farthest[i] = farthest_hole(flags);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
    assert_true(farthest[0] > 2);
    assert_true(farthest[1] > 0 && farthest[1] <= 2);
    assert_int_equal(farthest[2], 0);
}

static void unseen_rows_are_said_to_be(void **state)
{
    (void)state;
    lf_scene *scene;
    uint8_t flags[VIEWS * WIDTH];
    float out[VIEWS * WIDTH * 3];
    lf_renderer *r = mixed(&scene);
    lf_assert_ok(
        lf_renderer_pass(r, &(lf_part){.first_row = 2, .row_step = 4}, 1, NULL, NULL, NULL), NULL);
    lf_assert_status(lf_renderer_resolve_row(r, LF_ESTIMATOR_MWIS, 3, out, flags), LF_E_STATE,
                     NULL);
    for (int i = 0; i < VIEWS * WIDTH; i++)
        assert_int_equal(flags[i], LF_PIXEL_UNSEEN);
    lf_assert_ok(lf_renderer_resolve_row(r, LF_ESTIMATOR_MWIS, 6, out, flags), NULL);
    for (int i = 0; i < VIEWS * WIDTH; i++)
        assert_int_not_equal(flags[i], LF_PIXEL_UNSEEN);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* The accumulation in a file under folder. */
static const char *saved(const lf_renderer *r, const char *folder)
{
    const char *path = lf_test_path(folder, "state");
    lf_outfile file;
    lf_error err;
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    lf_cancel cancel = 1;
    assert_int_equal(lf_renderer_save(r, &file, &cancel, &err), LF_E_CANCELLED);
    assert_int_equal(lseek(file.fd, 0, SEEK_SET), 0);
    assert_int_equal(ftruncate(file.fd, 0), 0);
    lf_assert_ok(lf_renderer_save(r, &file, NULL, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    return path;
}

static lf_status restored(lf_renderer *r, const char *path)
{
    lf_error err;
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    lf_status status = lf_renderer_restore(r, fd, &err);
    close(fd);
    return status;
}

static void a_saved_picture_goes_on_as_if_nothing_had_happened(void **state)
{
    (void)state;
    lf_scene *scene, *again;
    char *folder = lf_test_folder();
    lf_renderer *steady = mixed(&scene), *resumed = mixed(&again);
    lf_assert_ok(lf_renderer_pass(steady, &(lf_part){.row_step = 2}, 2, NULL, NULL, NULL), NULL);
    const char *path = saved(steady, folder);
    lf_assert_ok(restored(resumed, path), NULL);
    assert_same_picture(steady, resumed);
    lf_test_passes(steady, VIEWS);
    lf_test_passes(resumed, VIEWS);
    assert_same_picture(steady, resumed);
    lf_renderer_destroy(steady);
    lf_renderer_destroy(resumed);
    lf_scene_unref(scene);
    lf_scene_unref(again);
    lf_test_folder_remove(folder);
}

static void another_picture_or_half_a_file_is_refused(void **state)
{
    (void)state;
    lf_scene *scene, *other = lf_test_scene(lf_test_scene_views("fogs", 5));
    char *folder = lf_test_folder();
    lf_renderer *r = mixed(&scene),
                *stranger = lf_test_renderer(other, "mvpt", WIDTH, HEIGHT, NULL);
    lf_test_passes(r, VIEWS);
    const char *path = saved(r, folder);
    lf_assert_status(restored(stranger, path), LF_E_STATE, NULL);
    float *before = resolved(r, LF_ESTIMATOR_CV, NULL);
    assert_int_equal(truncate(path, 5000), 0);
    lf_assert_status(restored(r, path), LF_E_FORMAT, NULL);
    float *after = resolved(r, LF_ESTIMATOR_CV, NULL);
    assert_memory_equal(before, after, VALUES * sizeof *before);
    lf_free(before);
    lf_free(after);
    lf_renderer_destroy(r);
    lf_renderer_destroy(stranger);
    lf_scene_unref(scene);
    lf_scene_unref(other);
    lf_test_folder_remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(holes_are_filled_where_something_was_found),
        cmocka_unit_test(passes_allocate_nothing),
        cmocka_unit_test(a_restart_leaves_nothing_of_the_old_picture),
        cmocka_unit_test(settings_out_of_range_are_refused_and_change_nothing),
        cmocka_unit_test(a_cancelled_pass_says_so),
        cmocka_unit_test(filling_leaves_no_hole_beyond_its_reach),
        cmocka_unit_test(unseen_rows_are_said_to_be),
        cmocka_unit_test(a_saved_picture_goes_on_as_if_nothing_had_happened),
        cmocka_unit_test(another_picture_or_half_a_file_is_refused),
    };
    return cmocka_run_group_tests_name("renderer", tests, NULL, lf_test_finish);
}
