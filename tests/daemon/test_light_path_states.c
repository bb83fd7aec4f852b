/* Parts of an image with light paths: bands and streams hold the sums of one whole run, because a
 * light path belongs to a stream, a half and a visit, and not to a program. test_state_kinds has
 * jobs that are stopped. */
#include "tests/daemon/states.h"

#include "tests/scene_file.h"

typedef struct files {
    const qr_files *of;
    const char *how; /* options of all runs */
} files;

static void renders(const files *f, const char *name, const char *words)
{
    qr_succeed("%s/corner.json -o %s/o.png --view-size 12x9 --threads 2 --state %s/%s %s %s",
               f->of->folder, f->of->folder, f->of->folder, name, f->how, words);
}

static void merges(const files *f, const char *name, const char *parts)
{
    char line[4 * PATH_MAX];
    snprintf(line, sizeof line, "cd '%s' && '%s' %s -o %s >merged 2>&1", f->of->folder,
             lf_test_built("quiltmerge"), parts, name);
    assert_int_equal(system(line), 0); /* NOLINT(cert-env33-c): fixed words */
}

static bool same(const files *f, const char *a, const char *b)
{
    lf_film x, y;
    json_decref(state_read(lf_test_path(f->of->folder, a), &x));
    json_decref(state_read(lf_test_path(f->of->folder, b), &y));
    bool all = x.height == y.height && x.row_bytes == y.row_bytes;
    for (int row = 0; row < x.height && all; row++)
        all = state_same_rows(&x, &y, row);
    lf_film_finish(&x);
    lf_film_finish(&y);
    return all;
}

static void assert_parts(const files *f)
{
    renders(f, "one.s", "--spp 3");
    renders(f, "top.s", "--spp 3 --rows 0:2");
    renders(f, "low.s", "--spp 3 --rows 3:8");
    merges(f, "bands.s", "low.s top.s");
    assert_true(same(f, "one.s", "bands.s"));
    renders(f, "next.s", "--spp 3 --stream 1");
    renders(f, "next_top.s", "--spp 3 --stream 1 --rows 0:4");
    renders(f, "next_low.s", "--spp 3 --stream 1 --rows 5:8");
    merges(f, "all.s", "one.s next.s");
    merges(f, "parts.s", "next_low.s top.s next_top.s low.s");
    assert_true(same(f, "all.s", "parts.s"));
    /* negative controls: streams differ, and the scene takes light paths */
    assert_false(same(f, "one.s", "next.s"));
    renders(f, "none.s", "--spp 3 --light-paths none");
    assert_false(same(f, "one.s", "none.s"));
}

/* The film of an image that is denoised has light paths in another sum. */
static void bands_and_streams_are_the_whole(void **state)
{
    static const char *const how[] = {"--denoise off", "--denoise on", "--integrator vpt"},
                             *const names[] = {"one.s",      "top.s",      "low.s", "next.s",
                                               "next_top.s", "next_low.s", "none.s"};
    const qr_files *of = *state;
    lf_test_write(of->folder, "corner.json", lf_test_scene_text("glossy-corner"));
    for (size_t i = 0; i < sizeof how / sizeof *how; i++) {
        const files f = {of, how[i]};
        assert_parts(&f);
        for (size_t k = 0; k < sizeof names / sizeof *names; k++)
            assert_int_equal(unlink(lf_test_path(of->folder, names[k])), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bands_and_streams_are_the_whole),
    };
    return cmocka_run_group_tests(tests, qr_set_up, qr_tear_down);
}
