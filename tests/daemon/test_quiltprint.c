/* The program quiltprint: profiles that it keeps, and prints that quiltrender makes with them. */
#include "tests/testing.h"

#include <fcntl.h>
#include <jansson.h>
#include <sys/stat.h>
#include <sys/wait.h>

enum { WORDS = 40 };

typedef struct outcome {
    int code;
    char text[16384]; /* stdout and stderr */
} outcome;

static outcome got;

/* Runs a program in the folder; the words of `line` are parted by blanks, without quotes. */
static int run(const char *folder, const char *program, const char *line)
{
    char path[PATH_MAX], said[PATH_MAX], copy[2048];
    char *argv[WORDS] = {path};
    int n = 1, status = 0;
    snprintf(path, sizeof path, "%s", lf_test_built(program));
    snprintf(said, sizeof said, "%s", lf_test_path(folder, "said"));
    snprintf(copy, sizeof copy, "%s", line);
    for (char *word = strtok(copy, " "); word && n < WORDS - 1; word = strtok(NULL, " "))
        argv[n++] = word;
    const pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        const int fd = open(said, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
        umask(022);
        dup2(fd, STDOUT_FILENO);
        dup2(fd, STDERR_FILENO);
        execv(path, argv);
        _exit(127);
    }
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_true(WIFEXITED(status));
    FILE *file = fopen(said, "r");
    assert_non_null(file);
    got.text[fread(got.text, 1, sizeof got.text - 1, file)] = '\0';
    fclose(file);
    got.code = WEXITSTATUS(status);
    return got.code;
}

/* Runs quiltprint, which must end with this code and say these words. */
static void says(const char *folder, const char *line, int code, const char *words)
{
    if (run(folder, "quiltprint", line) != code || !strstr(got.text, words))
        fail_msg("quiltprint %s: exit status %d, \"%s\"; expected %d, \"%s\"", line, got.code,
                 got.text, code, words);
}

static int set_up(void **state)
{
    char *folder = lf_test_folder();
    char source[PATH_MAX];
    assert_non_null(realpath(lf_test_source("quilt/profiles"), source));
    setenv("XDG_CONFIG_HOME", folder, 1);
    setenv("QUILTD_PROFILES", source, 1);
    *state = folder;
    return 0;
}

static int tear_down(void **state)
{
    unsetenv("XDG_CONFIG_HOME");
    unsetenv("QUILTD_PROFILES");
    return lf_test_folder_teardown(state);
}

static json_t *loaded(const char *folder, const char *name)
{
    json_t *json = json_load_file(lf_test_path(folder, name), 0, NULL);
    if (!json)
        fail_msg("%s: no JSON", name);
    return json;
}

static double number_of(const json_t *json, const char *key)
{
    assert_true(json_is_number(json_object_get(json, key)));
    return json_number_value(json_object_get(json, key));
}

#define ACME "quiltd/lenses/acme.json"

static void a_profile_is_made_changed_shown_and_removed(void **state)
{
    const char *f = *state;
    struct stat st;
    says(f, "set lens acme pitch_lpi=60.2 thickness_mm=0.6 name=Acme lens_grid=linear", 0, "wrote");
    assert_int_equal(stat(lf_test_path(f, ACME), &st), 0);
    assert_int_equal(st.st_mode & 07777, 0644);
    assert_int_equal(st.st_nlink, 1);
    json_t *lens = loaded(f, ACME);
    assert_true(number_of(lens, "pitch_lpi") == 60.2 && number_of(lens, "thickness_mm") == 0.6);
    assert_string_equal(json_string_value(json_object_get(lens, "name")), "Acme");
    json_decref(lens);
    says(f, "set lens acme index=1.56 thickness_mm=", 0, "wrote");
    lens = loaded(f, ACME);
    assert_null(json_object_get(lens, "thickness_mm"));
    assert_true(number_of(lens, "index") == 1.56 && number_of(lens, "pitch_lpi") == 60.2);
    json_decref(lens);
    says(f, "show acme", 0, "pitch_lpi      60.2\n");
    says(f, "show lens acme --json", 0, "\"pitch_lpi\": 60.2");
    says(f, "show nominal-75", 0, "75.55 lpi"); /* with its source */
    says(f, "list", 0, "acme");
    assert_non_null(strstr(got.text, "Acme (yours)"));
    assert_non_null(strstr(got.text, "nominal-60"));
    assert_non_null(strstr(got.text, "epson-720"));
    says(f, "list printers", 0, "epson-720");
    assert_null(strstr(got.text, "acme"));
    says(f, "set printer ink dpi=720x1440 native_dpi=360,720 dot_gain=0.15", 0, "wrote");
    says(f, "show ink", 0, "[360,720]");
    says(f, "remove acme", 0, "removed");
    assert_int_not_equal(access(lf_test_path(f, ACME), F_OK), 0);
    says(f, "remove acme", 2, "there is no such lens");
    says(f, "remove nominal-60", 2, "only profiles of yours");
}

static void a_shipped_profile_is_copied_and_hidden(void **state)
{
    const char *f = *state;
    says(f, "set lens nominal-60 pitch_lpi=60.2", 0, "a copy of");
    json_t *lens = loaded(f, "quiltd/lenses/nominal-60.json");
    assert_true(number_of(lens, "pitch_lpi") == 60.2);
    /* the new number is not the source's */
    assert_null(json_object_get(json_object_get(lens, "sources"), "pitch_lpi"));
    json_decref(lens);
    says(f, "remove nominal-60", 0, "nominal-60 is now");
    says(f, "show nominal-60", 0, "nominal, by its name");
}

static void mistakes_are_told_in_one_line(void **state)
{
    static const struct {
        const char *line, *words;
    } of[] = {
        {"", "COMMAND: is missing"},
        {"nothing", "unknown command; see --help"},
        {"calibrat", "unknown command; did you mean calibrate?"},
        {"list sheets", "expects lenses, printers or nothing"},
        {"show", "expected [lens|printer] NAME"},
        {"show sheet acme", "expected [lens|printer] NAME"},
        {"set lens acme", "expected lens|printer NAME KEY=VALUE"},
        {"set sheet acme a=1", "expected lens|printer NAME KEY=VALUE"},
        {"set lens acme pitch_lpi", "expected KEY=VALUE"},
        {"set lens acme index=1.5", "/pitch_lpi: is missing"},
        {"set lens acme pitch_lpi=60 thick=1", "/thick: unknown key"},
        {"set lens acme pitch_lpi=nan", "/pitch_lpi: expected a number"},
        {"set lens acme pitch_lpi=1e99", "/pitch_lpi: expected a number"},
        {"set lens ../acme pitch_lpi=60", "is not a name"},
        {"set lens a.json pitch_lpi=60", "is not a name"},
        {"set printer ink dpi=600 native_dpi=300,x", "/native_dpi: expected numbers"},
        {"calibrate nominal-60 epson-720", "expected LENS PRINTER RESULT.json"},
        {"calibrate nominal-6 epson-720 a=1", "did you mean nominal-60?"},
        {"calibrate nominal-60 epson-72 a=1", "did you mean epson-720?"},
        {"calibrate nominal-60 epson-720 visual_lpi=60.1", "/distance_mm: is missing"},
        {"calibrate nominal-60 epson-720 visual_lpi=75 distance_mm=400", "is another sheet"},
        {"calibrate nominal-60 epson-720 a b", "unexpected; give one file"},
        {"remove", "expected [lens|printer] NAME"},
        {"list --folder", "--folder"},
        {"list --nothing", "unknown option"},
    };
    const char *f = *state;
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        says(f, of[i].line, 2, of[i].words);
        if (strchr(got.text, '\n') != strrchr(got.text, '\n'))
            fail_msg("%s: %s", of[i].line, got.text);
    }
    assert_int_not_equal(access(lf_test_path(f, "quiltd/lenses/acme.json"), F_OK), 0);
}

#define READING(lpi, distance)                                                                     \
    "{\"quiltd_chart_reading\": 1, \"visual_lpi\": " lpi ", \"error_lpi\": 0.001, "                \
    "\"distance_mm\": " distance ", \"phase_mm\": 0.02, \"skew_deg\": 0.1, \"order\": "            \
    "\"reversed\", \"crosstalk\": [0.1, 0.8, 0.1], \"chart_sha256\": "                             \
    "\"0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef\", \"warnings\": [\"the "  \
    "photo is dark\"], \"other\": 1}"

static void a_reading_of_a_chart_is_kept(void **state)
{
    const char *f = *state;
    char line[PATH_MAX];
    says(f, "set lens acme pitch_lpi=60.2", 0, "wrote");
    snprintf(line, sizeof line, "calibrate acme epson-720 %s",
             lf_test_write(f, "result.json", READING("60.13", "400")));
    says(f, line, 0, "the photo is dark");
    says(f, "calibrate acme epson-720 visual_lpi=60.17 distance_mm=1000 date=2026-01-02", 0, "");
    says(f, "calibrate acme canon-600 visual_lpi=60.2 distance_mm=400", 0, "");
    json_t *lens = loaded(f, ACME), *list = json_object_get(lens, "calibrations");
    assert_int_equal(json_array_size(list), 3);
    const json_t *first = json_array_get(list, 0);
    assert_true(number_of(first, "visual_lpi") == 60.13 && number_of(first, "phase_mm") == 0.02);
    assert_string_equal(json_string_value(json_object_get(first, "order")), "reversed");
    assert_int_equal(json_string_length(json_object_get(first, "chart_sha256")), 64);
    assert_int_equal(json_string_length(json_object_get(first, "date")), 10);
    assert_int_equal(json_array_size(json_object_get(first, "crosstalk")), 3);
    assert_string_equal(json_string_value(json_object_get(json_array_get(list, 1), "date")),
                        "2026-01-02");
    json_decref(lens);
    /* again with the same printer from the same distance: replaced, the others kept */
    (void)lf_test_write(f, "result.json", READING("60.14", "400.01"));
    says(f, line, 0, "wrote");
    lens = loaded(f, ACME);
    list = json_object_get(lens, "calibrations");
    assert_int_equal(json_array_size(list), 3);
    assert_true(number_of(json_array_get(list, 0), "visual_lpi") == 60.14);
    assert_true(number_of(json_array_get(list, 1), "visual_lpi") == 60.17);
    assert_true(number_of(json_array_get(list, 2), "visual_lpi") == 60.2);
    json_decref(lens);
    /* of the other lenses: its own; vertical is what says nothing */
    says(f, "calibrate acme canon-600 visual_lpi=60.3 distance_mm=400 orientation=horizontal", 0,
         "wrote");
    says(f, "calibrate acme canon-600 visual_lpi=60.4 distance_mm=400 orientation=vertical", 0,
         "wrote");
    lens = loaded(f, ACME);
    list = json_object_get(lens, "calibrations");
    assert_int_equal(json_array_size(list), 4);
    assert_true(number_of(json_array_get(list, 2), "visual_lpi") == 60.4);
    assert_true(number_of(json_array_get(list, 3), "visual_lpi") == 60.3);
    json_decref(lens);
    /* another file */
    (void)lf_test_write(f, "result.json", "{\"quiltd_lens\": 1, \"pitch_lpi\": 60}");
    says(f, line, 1, "is not the reading of a chart");
    (void)lf_test_write(f, "result.json", "{");
    says(f, line, 1, "result.json:1");
}

/* A link in the place of a profile is replaced, and what it leads to is left alone. */
static void links_are_not_written_through(void **state)
{
    const char *f = *state;
    struct stat st;
    says(f, "set lens acme pitch_lpi=60.2", 0, "wrote");
    assert_int_equal(unlink(lf_test_path(f, ACME)), 0);
    (void)lf_test_write(f, "other.json", "{\"quiltd_lens\": 1, \"pitch_lpi\": 10}");
    assert_int_equal(symlink(lf_test_path(f, "other.json"), lf_test_path(f, ACME)), 0);
    says(f, "set lens acme pitch_lpi=61", 0, "wrote");
    json_t *other = loaded(f, "other.json");
    assert_true(number_of(other, "pitch_lpi") == 10);
    json_decref(other);
    assert_int_equal(lstat(lf_test_path(f, ACME), &st), 0);
    assert_true(S_ISREG(st.st_mode));
    assert_int_equal(unlink(lf_test_path(f, ACME)), 0);
    assert_int_equal(symlink(lf_test_path(f, "other.json"), lf_test_path(f, ACME)), 0);
    says(f, "remove acme", 0, "removed");
    assert_int_equal(access(lf_test_path(f, "other.json"), F_OK), 0);
}

static void folders_of_others_are_not_written_to(void **state)
{
    const char *f = *state;
    char line[PATH_MAX];
    says(f, "set lens acme pitch_lpi=60.2", 0, "wrote");
    assert_int_equal(chmod(lf_test_path(f, "quiltd/lenses"), 0777), 0);
    says(f, "set lens acme pitch_lpi=61", 1, "can be written to by everybody");
    assert_int_equal(chmod(lf_test_path(f, "quiltd/lenses"), 0755), 0);
    if (geteuid() == 0) {
        assert_int_equal(chown(lf_test_path(f, "quiltd/lenses"), 12345, 12345), 0);
        says(f, "set lens acme pitch_lpi=61", 1, "belongs to another user");
        assert_int_equal(chown(lf_test_path(f, "quiltd/lenses"), 0, 0), 0);
    }
    json_t *lens = loaded(f, ACME);
    assert_true(number_of(lens, "pitch_lpi") == 60.2);
    json_decref(lens);
    /* another folder, and what is in it comes first */
    snprintf(line, sizeof line, "set lens acme pitch_lpi=50 --folder %s", lf_test_path(f, "etc"));
    says(f, line, 0, "wrote");
    snprintf(line, sizeof line, "set lens acme index=1.5 --folder %s", lf_test_path(f, "etc"));
    says(f, line, 0, "wrote");
    lens = loaded(f, "etc/lenses/acme.json");
    assert_true(number_of(lens, "pitch_lpi") == 50);
    json_decref(lens);
}

static void a_bad_profile_is_told_and_the_rest_listed(void **state)
{
    const char *f = *state;
    says(f, "set lens acme pitch_lpi=60.2", 0, "wrote");
    (void)lf_test_write(f, "quiltd/lenses/bad.json", "{\"quiltd_lens\": 1, \"pitch_lp\": 1}");
    says(f, "list lenses", 1, "bad.json: /pitch_lp: unknown key; did you mean");
    assert_non_null(strstr(got.text, "acme"));
    says(f, "show bad", 1, "bad.json: /pitch_lp: unknown");
    says(f, "set lens bad pitch_lpi=60", 1,
         "bad.json: /pitch_lp: unknown"); /* nothing is lost unseen */
}

/* ------------------------------------------------------------------------------- quiltrender -- */

static int render(const char *folder, const char *words)
{
    char line[2048];
    snprintf(line, sizeof line, "%s -o %s/out.tif --print-size 12x10 --passes 1 %s",
             lf_test_built("../scenes/spheres.json"), folder, words);
    return run(folder, "quiltrender", line);
}

static json_t *options_of(const char *folder)
{
    json_t *manifest = loaded(folder, "out.json");
    json_t *options = json_incref(json_object_get(manifest, "options"));
    json_decref(manifest);
    return options;
}

static const char *pitch_kind_of(const json_t *manifest)
{
    return json_string_value(json_object_get(json_object_get(manifest, "lens"), "pitch_kind"));
}

static void a_print_takes_what_is_not_given_from_profiles(void **state)
{
    const char *f = *state;
    says(f, "set lens acme pitch_lpi=60.2 thickness_mm=0.6 index=1.56", 0, "wrote");
    says(f, "calibrate acme epson-720 visual_lpi=60.13 distance_mm=400 phase_mm=0.05", 0, "wrote");
    assert_int_equal(render(f, "--lens acme --printer epson-720"), 0);
    assert_non_null(strstr(got.text, "lens acme: 60.1300 lpi at 400 mm, measured on "));
    assert_non_null(strstr(got.text, "printer epson-720: 720 dpi"));
    json_t *options = options_of(f);
    assert_true(number_of(options, "lpi") == 60.13 && number_of(options, "dpi") == 720);
    assert_true(number_of(options, "distance") == 400 && number_of(options, "phase") == 0);
    json_decref(options);
    assert_non_null(strstr(got.text, "phase +0.05 mm not applied, because epson-720"));
    /* a printer of the user's with a jig */
    says(f, "set printer jig dpi=720 registered=true", 0, "wrote");
    says(f, "set printer jig registered=yes", 2, "/registered");
    says(f, "calibrate acme jig visual_lpi=60.13 distance_mm=400 phase_mm=0.05", 0, "wrote");
    assert_int_equal(render(f, "--lens acme --printer jig"), 0);
    options = options_of(f);
    assert_true(number_of(options, "phase") == 0.05);
    json_decref(options);
    assert_int_equal(render(f, "--lens acme --printer epson-720"), 0);
    json_t *manifest = loaded(f, "out.json"), *profiles = json_object_get(manifest, "profiles");
    assert_int_equal(
        json_string_length(json_object_get(json_object_get(profiles, "lens"), "sha256")), 64);
    assert_int_equal(json_array_size(json_object_get(profiles, "used")), 2);
    assert_null(json_object_get(profiles, "warnings"));
    assert_string_equal(pitch_kind_of(manifest), "visual, as measured");
    json_decref(manifest);
    /* the user's numbers, and another distance */
    assert_int_equal(render(f, "--lens acme --printer epson-720 --print 59.5@600 --phase 0"), 0);
    assert_non_null(strstr(got.text, "600 dpi is not a native resolution of epson-720"));
    options = options_of(f);
    assert_true(number_of(options, "lpi") == 59.5 && number_of(options, "dpi") == 600);
    assert_true(number_of(options, "phase") == 0);
    json_decref(options);
    assert_int_equal(render(f, "--lens acme --printer epson-720 --distance 1000"), 0);
    options = options_of(f);
    lf_assert_close(number_of(options, "lpi"),
                    60.13 * (1 + 0.6 / (1.56 * 400)) / (1 + 0.6 / (1.56 * 1000)), 1e-12, 0);
    json_decref(options);
    /* not measured: a warning, also in the manifest */
    assert_int_equal(render(f, "--lens acme --printer canon-600 --distance 400"), 0);
    assert_non_null(strstr(got.text, "acme: the pitch is not measured"));
    manifest = loaded(f, "out.json");
    char *text = json_dumps(json_object_get(manifest, "warnings"), 0);
    assert_non_null(strstr(text, "not measured"));
    assert_string_equal(pitch_kind_of(manifest), "visual, computed, not measured");
    free(text);
    json_decref(manifest);
}

/* Crosstalk comes from a chart only; the profile's thickness makes the map exact. */
static void a_measured_crosstalk_is_compensated(void **state)
{
    const char *f = *state;
    char line[PATH_MAX];
    says(f, "set lens acme pitch_lpi=60.2 thickness_mm=0.6 index=1.56", 0, "wrote");
    snprintf(line, sizeof line, "calibrate acme epson-720 %s",
             lf_test_write(f, "result.json", READING("60.13", "400")));
    says(f, line, 0, "wrote");
    if (render(f, "--lens acme --printer epson-720 --compensate on --views 9") != 0)
        fail_msg("%s", got.text);
    assert_non_null(strstr(got.text, "compensated: ghosts of"));
    json_t *manifest = loaded(f, "out.json"), *crosstalk = json_object_get(manifest, "crosstalk");
    assert_int_equal(json_integer_value(json_object_get(crosstalk, "views")), 8);
    assert_true(json_number_value(json_array_get(json_object_get(crosstalk, "shares"), 1)) == 0.8);
    assert_string_equal(
        json_string_value(json_object_get(json_object_get(manifest, "lens"), "map")), "exact");
    assert_non_null(json_object_get(manifest, "compensation"));
    json_decref(manifest);
}

/* Which kinds of prints need no --print. */
static void every_kind_of_print_takes_profiles(void **state)
{
    static const char *const outs[] = {"out.tif", "out.tiff", "out.pdf", "frames/ --frame-set 72"};
    const char *f = *state;
    char line[2048];
    says(f, "set lens acme pitch_lpi=60.2", 0, "wrote");
    for (size_t i = 0; i < sizeof outs / sizeof *outs; i++) {
        snprintf(line, sizeof line,
                 "%s --lens acme --printer epson-720 --distance 400 --print-size 12x10 --passes 1 "
                 "-o %s/%s",
                 lf_test_built("../scenes/spheres.json"), f, outs[i]);
        if (run(f, "quiltrender", line) != 0)
            fail_msg("%s: %s", outs[i], got.text);
        assert_non_null(strstr(got.text, "lens acme: "));
    }
}

static void what_cannot_be_printed_with_profiles_is_told(void **state)
{
    const char *f = *state;
    assert_int_equal(render(f, "--lens nominal-6 --printer epson-720"), 2);
    assert_non_null(strstr(got.text, "did you mean nominal-60?"));
    assert_int_equal(render(f, "--lens nominal-60 --printer epson-720"), 2);
    assert_non_null(strstr(got.text, "--distance: is needed"));
    assert_int_equal(render(f, "--lens nominal-60"), 2);
    assert_non_null(strstr(got.text, "--lens: the raster is unknown"));
    assert_int_equal(render(f, "--printer epson-720"), 2);
    (void)lf_test_write(f, "bad.json", "{\"quiltd_lens\": 1}");
    assert_int_equal(run(f, "quiltrender", "x.json -o a.png --lens nominal-60"), 2);
    assert_non_null(strstr(got.text, "--lens: needs --print"));
    char words[PATH_MAX + 64];
    snprintf(words, sizeof words, "--printer epson-720 --lens %s", lf_test_path(f, "bad.json"));
    assert_int_equal(render(f, words), 1);
    assert_non_null(strstr(got.text, "bad.json: /pitch_lpi: is missing"));
}

#define in_folder(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        in_folder(a_profile_is_made_changed_shown_and_removed),
        in_folder(a_shipped_profile_is_copied_and_hidden),
        in_folder(mistakes_are_told_in_one_line),
        in_folder(a_reading_of_a_chart_is_kept),
        in_folder(links_are_not_written_through),
        in_folder(folders_of_others_are_not_written_to),
        in_folder(a_bad_profile_is_told_and_the_rest_listed),
        in_folder(a_print_takes_what_is_not_given_from_profiles),
        in_folder(a_measured_crosstalk_is_compensated),
        in_folder(every_kind_of_print_takes_profiles),
        in_folder(what_cannot_be_printed_with_profiles_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
