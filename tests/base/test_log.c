#include "tests/testing.h"

#include <pthread.h>
#include <sys/stat.h>

#include "base/log.h"

/* stderr into a file while one of these tests runs */
typedef struct fixture {
    char *folder;
    int saved;
} fixture;

static int redirect(void **state)
{
    static fixture f;
    f.folder = lf_test_folder();
    fflush(stderr);
    f.saved = dup(STDERR_FILENO);
    FILE *file = fopen(lf_test_path(f.folder, "log"), "wb");
    assert_non_null(file);
    dup2(fileno(file), STDERR_FILENO);
    fclose(file);
    unsetenv("QUILTD_DEBUG");
    unsetenv("JOURNAL_STREAM");
    *state = &f;
    return 0;
}

static int restore(void **state)
{
    fixture *f = *state;
    dup2(f->saved, STDERR_FILENO);
    close(f->saved);
    lf_test_folder_remove(f->folder);
    return 0;
}

/* What was logged so far, in a static buffer. */
static const char *logged(void **state)
{
    static char text[1 << 20];
    const fixture *f = *state;
    FILE *file = fopen(lf_test_path(f->folder, "log"), "rb");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    fclose(file);
    return text;
}

static void lines_carry_the_program_and_levels_hold_back(void **state)
{
    lf_log_init("quiltd", LF_LOG_WARNING);
    lf_log(LF_LOG_ERROR, "no %s", "luck");
    lf_log(LF_LOG_WARNING, "careful");
    lf_log(LF_LOG_INFO, "hidden");
    lf_log(LF_LOG_DEBUG, "hidden too");
    assert_string_equal(logged(state), "quiltd: no luck\nquiltd: careful\n");
}

static void the_environment_can_ask_for_debug(void **state)
{
    setenv("QUILTD_DEBUG", "1", 1);
    lf_log_init("quiltctl", LF_LOG_INFO);
    lf_log(LF_LOG_DEBUG, "seen");
    assert_string_equal(logged(state), "quiltctl: seen\n");
}

static void the_journal_gets_levels_and_other_streams_do_not(void **state)
{
    struct stat st;
    char stream[64];
    assert_int_equal(fstat(STDERR_FILENO, &st), 0);
    snprintf(stream, sizeof stream, "%ju:%ju", (uintmax_t)st.st_dev, (uintmax_t)st.st_ino);
    setenv("JOURNAL_STREAM", stream, 1);
    lf_log_init("quiltd", LF_LOG_INFO);
    lf_log(LF_LOG_ERROR, "a");
    lf_log(LF_LOG_INFO, "b");
    snprintf(stream, sizeof stream, "%ju:%ju", (uintmax_t)st.st_dev, (uintmax_t)st.st_ino + 1);
    setenv("JOURNAL_STREAM", stream, 1);
    lf_log_init("quiltd", LF_LOG_INFO);
    lf_log(LF_LOG_ERROR, "c");
    assert_string_equal(logged(state), "<3>quiltd: a\n<6>quiltd: b\nquiltd: c\n");
}

static void a_line_stays_one_line(void **state)
{
    lf_log_init("quiltd", LF_LOG_INFO);
    lf_log(LF_LOG_INFO, "%s", "one\ntwo\x1b[2J");
    assert_string_equal(logged(state), "quiltd: one\\ntwo\\x1b[2J\n");
}

static void an_error_is_one_line_with_all_its_parts(void **state)
{
    lf_error err;
    lf_log_init("quiltd", LF_LOG_INFO);
    lf_error_set_at(&err, LF_E_FORMAT, "s.json", 3, "/film", "unknown key");
    lf_log_error(&err);
    assert_string_equal(logged(state), "quiltd: s.json:3: /film: unknown key\n");
}

static void *log_many(void *argument)
{
    for (int i = 0; i < 200; i++)
        lf_log(LF_LOG_INFO, "%0*d", 300, *(int *)argument);
    return NULL;
}

static void lines_of_several_threads_stay_whole(void **state)
{
    pthread_t threads[4];
    int digits[4] = {1, 2, 3, 4};
    lf_log_init("q", LF_LOG_INFO);
    for (int i = 0; i < 4; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, log_many, &digits[i]), 0);
    for (int i = 0; i < 4; i++)
        pthread_join(threads[i], NULL);
    const char *line = logged(state);
    int n = 0;
    for (; *line != 0; n++) {
        assert_int_equal(strcspn(line, "\n"), 303);
        assert_memory_equal(line, "q: 0", 4);
        line += 304;
    }
    assert_int_equal(n, 800);
}

static void the_last_lines_are_kept_with_their_numbers(void **state)
{
    (void)state;
    lf_log_line line;
    lf_log_init("q", LF_LOG_INFO);
    const int64_t before = lf_log_last();
    lf_log(LF_LOG_DEBUG, "held back");
    assert_int_equal(lf_log_last(), before);
    for (int i = 1; i <= LF_LOG_KEPT + 5; i++)
        lf_log(i % 2 ? LF_LOG_INFO : LF_LOG_WARNING, "line\n%d", i);
    const int64_t last = lf_log_last();
    assert_int_equal(last, before + LF_LOG_KEPT + 5);
    for (int64_t n = last - LF_LOG_KEPT + 1; n <= last; n++) {
        char text[32];
        snprintf(text, sizeof text, "line\\n%d", (int)(n - before));
        assert_true(lf_log_line_at(n, &line));
        assert_int_equal(line.number, n);
        assert_int_equal(line.level, (n - before) % 2 ? LF_LOG_INFO : LF_LOG_WARNING);
        assert_string_equal(line.text, text);
        assert_true(line.time > 1e9);
    }
    assert_false(lf_log_line_at(last - LF_LOG_KEPT, &line));
    assert_false(lf_log_line_at(last + 1, &line));
    assert_false(lf_log_line_at(0, &line));
}

static void a_long_line_is_kept_up_to_a_whole_character(void **state)
{
    (void)state;
    char text[2 * LF_LOG_KEPT_TEXT + 1] = "x";
    lf_log_line line;
    for (size_t i = 1; i + 2 < sizeof text; i += 2)
        memcpy(text + i, "\xc3\xa9", 3);
    lf_log(LF_LOG_INFO, "%s", text);
    assert_true(lf_log_line_at(lf_log_last(), &line));
    assert_int_equal(strlen(line.text), LF_LOG_KEPT_TEXT - 1);
    assert_memory_equal(line.text, text, LF_LOG_KEPT_TEXT - 1);
    lf_log(LF_LOG_INFO, "%s", text + 1); /* the last character would not be whole */
    assert_true(lf_log_line_at(lf_log_last(), &line));
    assert_int_equal(strlen(line.text), LF_LOG_KEPT_TEXT - 2);
}

static void count(void *context)
{
    ++*(int *)context;
}

static void every_line_is_told_until_nobody_listens(void **state)
{
    (void)state;
    int n = 0;
    lf_log_tell(count, &n);
    lf_log(LF_LOG_INFO, "one");
    lf_log(LF_LOG_ERROR, "two");
    lf_log(LF_LOG_DEBUG, "held back");
    assert_int_equal(n, 2);
    lf_log_tell(NULL, NULL);
    lf_log(LF_LOG_INFO, "three");
    assert_int_equal(n, 2);
}

static void take(void *context, lf_log_level level, const char *text)
{
    snprintf(context, 64, "%d %s", (int)level, text);
}

static void lines_can_be_taken_instead_of_written(void **state)
{
    (void)state;
    char taken[64] = "";
    const int64_t last = lf_log_last();
    lf_log_take(take, taken);
    lf_log(LF_LOG_DEBUG, "held back");
    assert_string_equal(taken, "");
    lf_log(LF_LOG_WARNING, "a %s", "line");
    assert_string_equal(taken, "4 a line");
    assert_int_equal(lf_log_last(), last);
    lf_log_take(NULL, NULL);
    lf_log(LF_LOG_INFO, "another");
    assert_string_equal(taken, "4 a line");
    assert_int_equal(lf_log_last(), last + 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(lines_carry_the_program_and_levels_hold_back, redirect,
                                        restore),
        cmocka_unit_test_setup_teardown(the_environment_can_ask_for_debug, redirect, restore),
        cmocka_unit_test_setup_teardown(the_journal_gets_levels_and_other_streams_do_not, redirect,
                                        restore),
        cmocka_unit_test_setup_teardown(a_line_stays_one_line, redirect, restore),
        cmocka_unit_test_setup_teardown(an_error_is_one_line_with_all_its_parts, redirect, restore),
        cmocka_unit_test_setup_teardown(lines_of_several_threads_stay_whole, redirect, restore),
        cmocka_unit_test_setup_teardown(the_last_lines_are_kept_with_their_numbers, redirect,
                                        restore),
        cmocka_unit_test_setup_teardown(a_long_line_is_kept_up_to_a_whole_character, redirect,
                                        restore),
        cmocka_unit_test_setup_teardown(every_line_is_told_until_nobody_listens, redirect, restore),
        cmocka_unit_test_setup_teardown(lines_can_be_taken_instead_of_written, redirect, restore),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
