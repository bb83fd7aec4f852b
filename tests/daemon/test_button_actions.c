/* What the buttons of a panel do: their words on the command line, and the folder they walk
 * through. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "daemon/engine/folder.h"
#include "daemon/server/button_actions.h"

static lf_button_actions parsed(const char *text)
{
    lf_button_actions actions;
    lf_button_actions_default(&actions);
    lf_assert_ok(lf_button_actions_parse(text, &actions, NULL), NULL);
    return actions;
}

static void only_named_buttons_change(void **state)
{
    (void)state;
    lf_button_actions a = parsed("left=next,circle=none");
    assert_int_equal(a.of[LF_BUTTON_LEFT], LF_ACTION_NEXT);
    assert_int_equal(a.of[LF_BUTTON_CIRCLE], LF_ACTION_NONE);
    assert_int_equal(a.of[LF_BUTTON_SQUARE], LF_ACTION_PAUSE);
    assert_int_equal(a.of[LF_BUTTON_RIGHT], LF_ACTION_NEXT);
}

static void unknown_words_change_nothing(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "",          "left",     "left=",      "=next",
        "left=jump", "top=next", "left=next,", "right=none,left=jump"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lf_button_actions actions, before;
        lf_error err;
        lf_button_actions_default(&actions);
        before = actions;
        assert_int_equal(lf_button_actions_parse(bad[i], &actions, &err), LF_E_ARG);
        assert_string_equal(err.where, "--buttons");
        assert_memory_equal(&actions, &before, sizeof actions);
    }
}

static void expect(const char *folder, const char *from, int step, const char *to)
{
    char path[600];
    char *next = NULL;
    snprintf(path, sizeof path, "%s/%s", folder, from);
    lf_assert_ok(lf_folder_neighbour(path, step, NULL, &next, NULL), NULL);
    assert_string_equal(strrchr(next, '/') + 1, to);
    lf_free(next);
}

static void neighbours_go_round_by_name(void **state)
{
    (void)state;
    char *folder = lf_test_folder();
    static const char *const files[] = {"a.json",    "b_qs5x9a0.75.png", "c.json",     "notes.txt",
                                        "plain.png", ".hidden.json",     "d_qs8x6.JPG"};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++)
        lf_test_write(folder, files[i], "");
    expect(folder, "a.json", 1, "b_qs5x9a0.75.png");
    expect(folder, "b_qs5x9a0.75.png", 1, "c.json");
    expect(folder, "c.json", 1, "d_qs8x6.JPG");
    expect(folder, "d_qs8x6.JPG", 1, "a.json");
    expect(folder, "a.json", -1, "d_qs8x6.JPG");
    expect(folder, "c.json", -1, "b_qs5x9a0.75.png");
    expect(folder, "a.json", 2, "c.json");
    expect(folder, "a.json", -3, "b_qs5x9a0.75.png");
    expect(folder, "a.json", 4001, "b_qs5x9a0.75.png");
    expect(folder, "bb.json", 2, "d_qs8x6.JPG");
    expect(folder, "bb.json", -2, "a.json");
    /* One that has been deleted: on from where it was. */
    expect(folder, "bb.json", 1, "c.json");
    expect(folder, "bb.json", -1, "b_qs5x9a0.75.png");
    expect(folder, "z.json", 1, "a.json");
    lf_test_folder_remove(folder);
}

static void pictures_of_every_format_are_among_them(void **state)
{
    (void)state;
    char *folder = lf_test_folder();
    static const char *const files[] = {"a_qs2x2.hdr", "b_qs2x2.jpeg", "c_qs2x2.exr",
                                        "d_qs2x2.png", "c_qs2x2.tif",  ".b_qs2x2.hdr"};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++)
        lf_test_write(folder, files[i], "");
    for (int i = 0; i < 4; i++)
        expect(folder, files[i], 1, files[(i + 1) % 4]);
    lf_test_folder_remove(folder);
}

static void a_scene_alone_is_its_own_neighbour(void **state)
{
    (void)state;
    char *folder = lf_test_folder();
    lf_test_write(folder, "only.json", "");
    expect(folder, "only.json", 1, "only.json");
    expect(folder, "only.json", -1, "only.json");
    lf_test_folder_remove(folder);
}

static void a_folder_that_is_gone_is_an_error(void **state)
{
    (void)state;
    char *next = NULL;
    lf_error err;
    assert_int_equal(lf_folder_neighbour("/nowhere/at/all.json", 1, NULL, &next, &err), LF_E_IO);
    assert_null(next);
}

static void a_folder_outside_the_roots_is_not_listed(void **state)
{
    (void)state;
    char *folder = lf_test_folder(), *next = NULL;
    lf_roots roots = {0};
    lf_error err;
    const char *file = lf_test_write(folder, "a.json", "");
    lf_test_write(folder, "b.json", "");
    lf_assert_ok(lf_roots_add(&roots, "/usr", &err), &err);
    assert_int_equal(lf_folder_neighbour(file, 1, &roots, &next, &err), LF_E_PATH);
    assert_null(next);
    lf_assert_ok(lf_roots_add(&roots, folder, &err), &err);
    lf_assert_ok(lf_folder_neighbour(file, 1, &roots, &next, &err), &err);
    assert_string_equal(strrchr(next, '/'), "/b.json");
    lf_free(next);
    lf_roots_finish(&roots);
    lf_test_folder_remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_named_buttons_change),
        cmocka_unit_test(unknown_words_change_nothing),
        cmocka_unit_test(neighbours_go_round_by_name),
        cmocka_unit_test(pictures_of_every_format_are_among_them),
        cmocka_unit_test(a_scene_alone_is_its_own_neighbour),
        cmocka_unit_test(a_folder_that_is_gone_is_an_error),
        cmocka_unit_test(a_folder_outside_the_roots_is_not_listed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
