/* The program quiltmerge, with states that quiltrender made. */
#include "tests/daemon/states.h"

#define SIZE "-o p.png --view-size 8x10 --views 3 --threads 2 --denoise off"

typedef struct said {
    int code;
    char text[16384]; /* stdout and stderr */
} said;

/* Runs a program in the folder of the files; `before` is a shell command. */
static said run(const qr_files *f, const char *before, const char *program, const char *words)
{
    static char line[8 * PATH_MAX];
    said s = {.code = -1};
    snprintf(line, sizeof line, "cd '%s' && %s '%s' %s 2>&1", f->folder, before,
             lf_test_built(program), words);
    FILE *pipe = popen(line, "re"); /* NOLINT(cert-env33-c): fixed words */
    assert_non_null(pipe);
    s.text[fread(s.text, 1, sizeof s.text - 1, pipe)] = '\0';
    s.code = WEXITSTATUS(pclose(pipe));
    return s;
}

static void renders(const qr_files *f, const char *words)
{
    char line[4 * PATH_MAX];
    snprintf(line, sizeof line, "'%s' " SIZE " %s", f->scene, words);
    const said s = run(f, "", "quiltrender", line);
    if (s.code != 0)
        fail_msg("quiltrender %s: %s", words, s.text);
}

/* quiltmerge ends with this code and says these words; errors are one line. */
static void says(const qr_files *f, const char *words, int code, const char *text)
{
    const said s = run(f, "", "quiltmerge", words);
    if (s.code != code || !strstr(s.text, text))
        fail_msg("quiltmerge %s: exit status %d, \"%s\"; expected %d, \"%s\"", words, s.code,
                 s.text, code, text);
    if (code != 0) {
        assert_int_equal(strncmp(s.text, "quiltmerge: ", 12), 0);
        assert_true(strchr(s.text, '\n') == s.text + strlen(s.text) - 1);
    }
}

static json_t *info_of(const qr_files *f, const char *name)
{
    char words[64];
    snprintf(words, sizeof words, "--state-info %s", name);
    const said s = run(f, "", "quiltrender", words);
    json_t *info = json_loads(s.text, 0, NULL);
    assert_non_null(info);
    return info;
}

static void assert_holds(const qr_files *f, const char *name, const char *wanted)
{
    json_t *info = info_of(f, name), *want = json_loads(wanted, 0, NULL), *value;
    const char *key;
    assert_non_null(want);
    json_object_foreach(want, key, value) if (!json_equal(json_object_get(info, key), value) &&
                                              !(json_is_null(value) && !json_object_get(info, key)))
        fail_msg("%s of %s is not as expected", key, name);
    json_decref(info);
    json_decref(want);
}

/* The films of two states, behind their heads. */
static void assert_same_films(const qr_files *f, const char *a, const char *b)
{
    char *bytes[2], words[2][64];
    size_t n[2];
    snprintf(words[0], sizeof words[0], "%s", a);
    snprintf(words[1], sizeof words[1], "%s", b);
    for (int i = 0; i < 2; i++) {
        uint32_t text;
        lf_error err = {0};
        lf_assert_ok(
            lf_file_read(lf_test_path(f->folder, words[i]), NULL, 1 << 24, &bytes[i], &n[i], &err),
            &err);
        memcpy(&text, bytes[i] + 12, sizeof text);
        n[i] -= 20 + text;
        memmove(bytes[i], bytes[i] + 20 + text, n[i]);
    }
    assert_int_equal(n[0], n[1]);
    assert_memory_equal(bytes[0], bytes[1], n[0]);
    lf_free(bytes[0]);
    lf_free(bytes[1]);
}

/* Two bands and what one run makes. */
static int set_up(void **state)
{
    qr_set_up(state);
    const qr_files *f = *state;
    renders(f, "--spp 2 --state one.s");
    assert_int_equal(
        rename(lf_test_path(f->folder, "p_qs3x1a0.75.png"), lf_test_path(f->folder, "one.png")), 0);
    renders(f, "--spp 2 --rows 0:3 --state top.s");
    renders(f, "--spp 2 --rows 4:9 --state low.s");
    return 0;
}

static void bands_become_the_state_and_the_output_of_one_run(void **state)
{
    const qr_files *f = *state;
    says(f, "low.s top.s -o whole.s", 0, "wrote whole.s (2 parts, 10 of 10 rows, 2 spp, complete)");
    assert_same_films(f, "whole.s", "one.s");
    assert_holds(f, "whole.s",
                 "{\"complete\": true, \"passes\": 6, \"rows\": [0, 9], \"film_rows\": 10, "
                 "\"parts\": 2, \"streams\": null, \"stream\": 0, \"budget\": {\"passes\": 6}}");
    says(f, "top.s low.s -o other.s", 0, "wrote other.s");
    qr_assert_same_files(lf_test_path(f->folder, "whole.s"), lf_test_path(f->folder, "other.s"));
    renders(f, "--spp 2 --state whole.s");
    qr_assert_same_files(lf_test_path(f->folder, "p_qs3x1a0.75.png"),
                         lf_test_path(f->folder, "one.png"));
}

/* Streams of a seed, one of them in bands, and another seed. */
static void streams_become_a_state_of_all_their_samples(void **state)
{
    const qr_files *f = *state;
    renders(f, "--spp 2 --stream 3 --state three.s");
    renders(f, "--spp 4 --seed 9 --state nine.s");
    says(f, "nine.s low.s three.s top.s -o sum.s", 0,
         "4 parts, 10 of 10 rows, 8 spp, 3 random streams, complete");
    says(f, "top.s three.s nine.s low.s -o again.s", 0, "complete");
    qr_assert_same_files(lf_test_path(f->folder, "sum.s"), lf_test_path(f->folder, "again.s"));
    assert_holds(f, "sum.s",
                 "{\"complete\": true, \"passes\": 24, \"rows\": [0, 9], \"parts\": 4, "
                 "\"streams\": 3, \"stream\": 0, \"seed\": 0, \"budget\": {\"passes\": 24}}");
    renders(f, "--spp 8 --state sum.s");
    qr_assert_different_files(lf_test_path(f->folder, "p_qs3x1a0.75.png"),
                              lf_test_path(f->folder, "one.png"));
    char line[2 * PATH_MAX];
    snprintf(line, sizeof line, "'%s' " SIZE " --spp 9 --state sum.s", f->scene);
    const said s = run(f, "", "quiltrender", line);
    assert_int_equal(s.code, 1);
    assert_non_null(strstr(s.text, "3 random streams, which cannot be continued"));
    /* a merge is a part like others */
    renders(f, "--spp 2 --stream 5 --state five.s");
    says(f, "sum.s five.s -o more.s", 0, "2 parts, 10 of 10 rows, 10 spp, 4 random streams");
    assert_holds(f, "more.s", "{\"parts\": 5, \"streams\": 4, \"passes\": 30}");
}

static void with_partial_quiltrender_renders_the_rest(void **state)
{
    const qr_files *f = *state;
    says(f, "low.s -o half.s", 1,
         "half.s: no part has rows 0 to 3; name all parts, or merge with --partial");
    says(f, "low.s -o half.s --partial", 0, "1 parts, 6 of 10 rows, 1.2 spp, not complete");
    assert_holds(f, "half.s", "{\"complete\": false, \"rows\": [0, 9], \"film_rows\": 6}");
    says(f, "half.s top.s -o whole.s", 1, "half.s: is not complete (1 spp so far); finish it");
    says(f, "half.s top.s -o whole.s --partial", 0, "complete");
    assert_same_films(f, "whole.s", "one.s");
    assert_holds(f, "whole.s", "{\"complete\": true, \"passes\": 6}");
    renders(f, "--spp 2 --state half.s");
    assert_same_films(f, "half.s", "one.s");
    qr_assert_same_files(lf_test_path(f->folder, "p_qs3x1a0.75.png"),
                         lf_test_path(f->folder, "one.png"));
    renders(f, "--spp 2 --rows 0:3 --stream 1 --state first.s");
    says(f, "half.s first.s -o x.s --partial", 1, "row 4 has 6 passes, but row 0 has 12");
}

static void parts_that_do_not_belong_together_are_named(void **state)
{
    const qr_files *f = *state;
    static const struct {
        const char *make, *merge, *words;
    } cases[] = {
        {"--spp 2 --rows 4:9 --views 2 --state bad.s", "top.s bad.s -o x.s",
         "bad.s: is of another job than top.s, which differs in the number of views (2, not 3)"},
        {"--spp 2 --rows 4:9 --max-depth 2 --state bad.s", "bad.s top.s -o x.s",
         "top.s: is of another job than bad.s, which differs in the render settings"},
        {"--spp 2 --rows 4:9 --seed 1 --max-depth 2 --state bad.s", "bad.s top.s -o x.s",
         "top.s: is of another scene, camera or settings than bad.s"},
        {"--spp 4 --rows 4:9 --state bad.s", "top.s bad.s -o x.s",
         "top.s: row 0 has 6 passes, but row 4 has 12; give all rows the same"},
        {"--spp 2 --rows 3:9 --state bad.s", "top.s bad.s -o x.s",
         "has row 3 of seed 0, stream 0, and so has"},
        {"--spp 2 --rows 5:9 --state bad.s", "top.s bad.s -o x.s", "no part has row 4; name"},
    };
    const int before = qr_count_files(f->folder);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        renders(f, cases[i].make);
        says(f, cases[i].merge, 1, cases[i].words);
        unlink(lf_test_path(f->folder, "bad.s"));
        assert_int_equal(qr_count_files(f->folder), before);
    }
}

static void parts_of_another_release_are_refused(void **state)
{
    const qr_files *f = *state;
    state_set(lf_test_path(f->folder, "low.s"), STATE_OF_0_1_7);
    says(f, "top.s low.s -o x.s", 1,
         "low.s: is of another job than top.s, which differs in the release of quiltd (\"0.1.7\", "
         "not \"");
    says(f, "low.s top.s -o x.s", 1, "the release of quiltd");
    assert_false(qr_exists(f->folder, "x.s"));
    state_set(lf_test_path(f->folder, "low.s"), STATE_OF_NOW);
    says(f, "top.s low.s -o x.s", 0, "complete");
    assert_int_equal(unlink(lf_test_path(f->folder, "x.s")), 0);
}

/* A job of a time that was stopped in the middle of a pass is sound, though it cannot be merged. */
static void rows_of_a_timed_state_may_differ(void **state)
{
    const qr_files *f = *state;
    renders(f, "--spp 4 --rows 4:9 --state twice.s");
    says(f, "top.s twice.s -o timed.s --partial", 0, "not complete");
    state_set(lf_test_path(f->folder, "timed.s"),
              "{\"budget\": {\"seconds\": 1.0}, \"complete\": true}");
    says(f, "timed.s -o x.s", 1, "row 0 has 6 passes, but row 4 has 12; give all rows the same");
    state_set(lf_test_path(f->folder, "timed.s"), "{\"budget\": {\"passes\": 12}}");
    says(f, "timed.s -o x.s", 1, "is damaged: its head and its film differ about being complete");
}

static void mistakes_of_callers_are_one_line(void **state)
{
    const qr_files *f = *state;
    says(f, "top.s low.s", 2, "-o: is missing");
    says(f, "-o x.s", 2, "PART: is missing");
    says(f, "top.s -o ''", 2, "-o: is empty");
    says(f, "top.s -o x.s --wait soon", 2, "--wait");
    says(f, "top.s -o x.s --wait -1", 2, "--wait");
    says(f, "top.s low.s -o x.s --rows 0:3", 2, "--rows: unknown option");
    says(f, "top.s none.s -o x.s", 1, "none.s: cannot open: No such file");
    says(f, "top.s . -o x.s", 1, ".: not a regular file");
    says(f, "top.s fog.json -o x.s", 1,
         "fog.json: is not the state of a job; make this part again");
    says(f, "top.s --files-from none.txt -o x.s", 1, "none.txt");
    says(f, "top.s low.s -o top.s", 1, "top.s: is also the part top.s; name another output");
    says(f, "top.s low.s -o none/x.s", 1, "none/x.s");
    assert_false(qr_exists(f->folder, "x.s"));
}

static void copies_count_once_and_are_named(void **state)
{
    const qr_files *f = *state;
    says(f, "top.s low.s ./low.s top.s -o x.s", 0, "has the same samples as");
    says(f, "top.s low.s -o y.s", 0, "2 parts");
    qr_assert_same_files(lf_test_path(f->folder, "x.s"), lf_test_path(f->folder, "y.s"));
}

static void names_come_from_a_list_and_need_few_descriptors(void **state)
{
    const qr_files *f = *state;
    FILE *list = fopen(lf_test_path(f->folder, "list"), "we");
    assert_non_null(list);
    for (int i = 0; i < 300; i++)
        fprintf(list, "low.s\n\n");
    fclose(list);
    const said s = run(f, "ulimit -n 12 &&", "quiltmerge", "top.s --files-from list -o x.s");
    assert_int_equal(s.code, 0);
    assert_non_null(strstr(s.text, "has the same samples as"));
    assert_non_null(strstr(s.text, "296 more parts have the same samples as others"));
    assert_same_films(f, "x.s", "one.s");
}

static void parts_that_come_later_are_waited_for(void **state)
{
    const qr_files *f = *state;
    const said s = run(f, "mv low.s later.s && { (sleep 1; mv later.s low.s) & } &&", "quiltmerge",
                       "top.s low.s -o x.s --wait 60");
    if (s.code != 0)
        fail_msg("%s", s.text);
    assert_same_films(f, "x.s", "one.s");
}

static void a_full_disk_leaves_the_old_file(void **state)
{
    const qr_files *f = *state;
    says(f, "top.s low.s -o x.s", 0, "complete");
    const int before = qr_count_files(f->folder);
    const said s = run(f, "ulimit -f 4 &&", "quiltmerge", "top.s low.s -o x.s");
    assert_int_equal(s.code, 1);
    assert_non_null(strstr(s.text, "File too large"));
    assert_same_films(f, "x.s", "one.s");
    assert_int_equal(qr_count_files(f->folder), before);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bands_become_the_state_and_the_output_of_one_run),
        cmocka_unit_test(streams_become_a_state_of_all_their_samples),
        cmocka_unit_test(with_partial_quiltrender_renders_the_rest),
        cmocka_unit_test(parts_that_do_not_belong_together_are_named),
        cmocka_unit_test(parts_of_another_release_are_refused),
        cmocka_unit_test(rows_of_a_timed_state_may_differ),
        cmocka_unit_test(mistakes_of_callers_are_one_line),
        cmocka_unit_test(copies_count_once_and_are_named),
        cmocka_unit_test(names_come_from_a_list_and_need_few_descriptors),
        cmocka_unit_test(parts_that_come_later_are_waited_for),
        cmocka_unit_test(a_full_disk_leaves_the_old_file),
    };
    return cmocka_run_group_tests(tests, set_up, qr_tear_down);
}
