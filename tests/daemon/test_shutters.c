/* Sequences whose shutters overlap: frames are what they would be alone, the mean of their parts,
 * and as long as everything moves along, whatever it does. */
#include "tests/daemon/quiltrender.h"
#include "tests/scene_file.h"

#include "daemon/output/frames.h"

#define SMALL "--view-size 12x16 --views 4 --seed 11 "

/* A ball of fog that turns round in frame 3, before a sky. */
static const char *puff(const qr_files *f, const char *name, const char *shutter)
{
    return lf_test_write(f->folder, name,
                         lf_test_scene_patched("moving-puff", "{'camera': {%s}}", shutter));
}

static float pixel_of(const lf_quilt_file *quilt, int view, int y, int x)
{
    return lf_views32_row(&quilt->views32, view, y)[3 * x];
}

static void read_frame(const qr_files *f, const char *name, lf_quilt_file *out)
{
    lf_error error = {0};
    *out = (lf_quilt_file){0};
    lf_assert_ok(lf_quilt_read(lf_test_path(f->folder, name), NULL, 0, 0, out, &error), &error);
}

/* Frame 3 of a scene that is given whole, of one view. */
static void render_third(const qr_files *f, const char *scene, const char *options,
                         lf_quilt_file *out)
{
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s", lf_test_write(f->folder, "third.json", scene));
    qr_succeed("%s -o %s/third_%%d_qs1x1.exr --overwrite --frames 3:3 --views 1 %s", path,
               f->folder, options);
    read_frame(f, "third_3_qs1x1.exr", out);
}

static void a_shutter_has_parts_where_frames_share_them(void **state)
{
    static const struct {
        double shutter;
        int parts, a_frame;
    } expected[] = {{0, 0, 0},   {0.5, 0, 0}, {1, 0, 0},         {2, 2, 1},
                    {2.5, 5, 2}, {1.5, 3, 2}, {4.0 / 3, 4, 3},   {1.25, 5, 4},
                    {1.1, 0, 0}, {10, 10, 1}, {1.0000001, 0, 0}, {9.75, 39, 4}};
    (void)state;
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        int a_frame = 0;
        const int parts = lf_frames_parts(expected[i].shutter, &a_frame);
        assert_int_equal(parts, expected[i].parts);
        if (parts > 0)
            assert_int_equal(a_frame, expected[i].a_frame);
    }
}

static void a_frame_is_the_same_alone_among_others_and_beside_one_that_is_there(void **state)
{
    const qr_files *f = *state;
    const char *name = "'shutter': 2.5, 'shutter_open': -1.2";
    char scene[PATH_MAX], a[PATH_MAX], b[PATH_MAX];
    snprintf(scene, sizeof scene, "%s", puff(f, "puff.json", name));
    qr_succeed("%s -o %s/all.exr --frames 2:6 --spp 4 --threads 2 " SMALL, scene, f->folder);
    qr_succeed("%s -o %s/one.exr --frames 5:5 --spp 4 --threads 1 " SMALL, scene, f->folder);
    snprintf(a, sizeof a, "%s/all_0005_qs2x2a0.75.exr", f->folder);
    snprintf(b, sizeof b, "%s/one_0005_qs2x2a0.75.exr", f->folder);
    qr_assert_same_files(a, b);
    qr_succeed("%s -o %s/one.exr --frames 3:6 --spp 4 --threads 2 " SMALL, scene, f->folder);
    for (int frame = 3; frame <= 6; frame++) {
        snprintf(a, sizeof a, "%s/all_%04d_qs2x2a0.75.exr", f->folder, frame);
        snprintf(b, sizeof b, "%s/one_%04d_qs2x2a0.75.exr", f->folder, frame);
        qr_assert_same_files(a, b);
    }
    snprintf(a, sizeof a, "%s/all_0004_qs2x2a0.75.exr", f->folder);
    qr_assert_different_files(a, b);
}

/* Parts rendered by themselves, as frames whose shutter is open for one frame: sums of N over n are
 * linear in what films add up. */
static void a_frame_is_the_mean_of_its_parts(void **state)
{
    const qr_files *f = *state;
    lf_quilt_file whole, part[2];
    char scene[PATH_MAX];
    float largest = 0;
    snprintf(scene, sizeof scene, "%s", puff(f, "two.json", "'shutter': 2, 'shutter_open': -0.5"));
    qr_succeed("%s -o %s/two.exr --frames 3:3 --spp 8 --estimator mis " SMALL, scene, f->folder);
    snprintf(scene, sizeof scene, "%s", puff(f, "one.json", "'shutter': 1, 'shutter_open': -0.5"));
    /* frame 3 has this seed and 2 more, which is that of part 3 */
    qr_succeed("%s -o %s/one.exr --frames 3:4 --spp 4 --estimator mis --view-size 12x16 --views 4 "
               "--seed %llu",
               scene, f->folder, (unsigned long long)(lf_parts_seed(11, 3) - 2));
    read_frame(f, "two_0003_qs2x2a0.75.exr", &whole);
    read_frame(f, "one_0003_qs2x2a0.75.exr", &part[0]);
    read_frame(f, "one_0004_qs2x2a0.75.exr", &part[1]);
    for (int view = 0; view < 4; view++)
        for (int y = 0; y < 16; y++)
            for (int x = 0; x < 12; x++) {
                const float a = pixel_of(&part[0], view, y, x), b = pixel_of(&part[1], view, y, x),
                            mean = 0.5F * (a + b), is = pixel_of(&whole, view, y, x);
                assert_true(fabsf(is - mean) <= 2e-6F * mean);
                largest = fmaxf(largest, fabsf(a - b));
            }
    assert_true(largest > 0.1F); /* the puff is not where it was */
    for (int i = 0; i < 2; i++)
        lf_quilt_finish(&part[i]);
    lf_quilt_finish(&whole);
}

/* A lamp of side 1 comes to the middle from two sides away and goes back, in two frames each: it
 * lights the middle for a quarter of four frames. On a straight way from where it is when the
 * shutter opens to where it is when that closes it would stay away. */
static void what_turns_round_while_the_shutter_is_open_is_seen_where_it_was(void **state)
{
    lf_quilt_file frame;
    render_third(*state, lf_test_scene_text("light-that-turns-round"), "--spp 1024 --view-size 2x2",
                 &frame);
    /* parts of one frame; half of two of them, of 128 moments each a half of the film */
    lf_assert_close((double)pixel_of(&frame, 0, 1, 1), 2.0, 0, 8.0 / 128);
    lf_quilt_finish(&frame);
}

/* The sky of the first part stands still, that of the second does not. */
static void a_sky_that_changes_is_the_mean_over_the_shutter(void **state)
{
    lf_quilt_file frame;
    render_third(*state, lf_test_scene_text("fog-under-changing-sky"), "--spp 256 --view-size 8x8",
                 &frame);
    /* a furnace: as bright in the fog as beside it; moments are spread evenly */
    lf_assert_close((double)pixel_of(&frame, 0, 0, 0), 2.0, 0, 0.02);
    lf_assert_close((double)pixel_of(&frame, 0, 4, 4), 2.0, 0, 0.1);
    lf_quilt_finish(&frame);
}

/* Fog that only scatters, in light from everywhere, is not to be told from it, wherever it goes:
 * also not where nothing was found at first. */
static void a_furnace_has_no_dark_pixels(void **state)
{
    const qr_files *f = *state;
    const char *scene =
        lf_test_write(f->folder, "furnace.json", lf_test_scene_text("moving-furnace"));
    qr_succeed("%s -o %s/f.exr --frames 3:4 --spp 1 --view-size 96x48 --views 1 --quilt 1x1", scene,
               f->folder);
    for (int frame = 3; frame <= 4; frame++) {
        lf_quilt_file picture;
        char name[32];
        snprintf(name, sizeof name, "f_%04d_qs1x1a2.exr", frame);
        read_frame(f, name, &picture);
        for (int i = 0; i < 96 * 48; i++)
            lf_assert_close((double)pixel_of(&picture, 0, i / 96, i % 96), 0.5, 1e-5, 0);
        lf_quilt_finish(&picture);
    }
}

/* A part that is dear, under a sky of 1, and a cheap one under a sky that goes from there to 5:
 * beside the fog the mean is 2, whatever there is time for. */
#define STEP_OF_FOG                                                                                \
    "{'volumes': {'fog': {'density': {'keys': [[4, 20], [5, 0.05]], 'interpolation': 'step'}, "    \
    "'transform': null}}}"

static void timed_parts_have_equal_shares(void **state)
{
    lf_quilt_file picture;
    render_third(*state, lf_test_scene_patched("fog-under-changing-sky", STEP_OF_FOG),
                 "--time 1 --view-size 12x12", &picture);
    print_message("%g\n", (double)pixel_of(&picture, 0, 0, 0));
    lf_assert_close((double)pixel_of(&picture, 0, 0, 0), 2.0, 0, 0.15);
    lf_quilt_finish(&picture);
}

static const char *const alone[] = {
    "lobe-in-one-part",
    /* what catchers get is looked for in the frame's own scene */
    "ball-over-catcher",
};

/* The frame is then one picture, as that of a shutter that has no parts. */
static void assert_alone(const qr_files *f, const char *scene)
{
    static const char *const shutters[] = {"2", "2.00002"};
    lf_quilt_file frames[2];
    for (int i = 0; i < 2; i++)
        render_third(f, lf_test_scene_patched(scene, "{'camera': {'shutter': %s}}", shutters[i]),
                     "--spp 8 --view-size 8x8", &frames[i]);
    for (int i = 0; i < 64; i++)
        lf_assert_close((double)pixel_of(&frames[0], 0, i / 8, i % 8),
                        (double)pixel_of(&frames[1], 0, i / 8, i % 8), 1e-6, 0);
    for (int i = 0; i < 2; i++)
        lf_quilt_finish(&frames[i]);
}

static void what_parts_cannot_tell_is_rendered_as_one(void **state)
{
    for (size_t i = 0; i < sizeof alone / sizeof alone[0]; i++) {
        print_message("%s\n", alone[i]);
        assert_alone(*state, alone[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_shutter_has_parts_where_frames_share_them),
        cmocka_unit_test_setup_teardown(
            a_frame_is_the_same_alone_among_others_and_beside_one_that_is_there, qr_set_up,
            qr_tear_down),
        cmocka_unit_test_setup_teardown(a_frame_is_the_mean_of_its_parts, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(
            what_turns_round_while_the_shutter_is_open_is_seen_where_it_was, qr_set_up,
            qr_tear_down),
        cmocka_unit_test_setup_teardown(a_sky_that_changes_is_the_mean_over_the_shutter, qr_set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(a_furnace_has_no_dark_pixels, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(timed_parts_have_equal_shares, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(what_parts_cannot_tell_is_rendered_as_one, qr_set_up,
                                        qr_tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
