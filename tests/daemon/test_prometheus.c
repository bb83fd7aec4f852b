/* What Prometheus is told, read as it reads it: every sample below the TYPE of its family, which
 * comes once; names and numbers of the text format's grammar. */
#include "tests/testing.h"

#include <regex.h>

#include "daemon/wire/prometheus.h"

#define NAME "quiltd_[a-z_]+"
#define LABEL "[a-z]+=\"([^\"\\\\\n]|\\\\[\\\\\"n])*\""

static char *said_of(const json_t *status)
{
    char *said = NULL;
    size_t n = 0;
    FILE *out = open_memstream(&said, &n);
    assert_non_null(out);
    lf_prometheus_write(status, out);
    fclose(out);
    return said;
}

static void assert_says(const char *said, const char *line)
{
    char whole[256];
    snprintf(whole, sizeof whole, "\n%s\n", line);
    if (!strstr(said, whole))
        fail_msg("\"%s\" is not said:\n%s", line, said);
}

static bool matches(const char *line, const char *pattern)
{
    regex_t regex;
    assert_int_equal(regcomp(&regex, pattern, REG_EXTENDED | REG_NOSUB), 0);
    bool fits = regexec(&regex, line, 0, NULL, 0) == 0;
    regfree(&regex);
    return fits;
}

static void assert_grammar(const char *said)
{
    char *copy = strdup(said), *rest = copy, *line, family[128] = "", seen[8192] = " ";
    while ((line = strsep(&rest, "\n")) && rest) {
        if (strncmp(line, "# HELP ", 7) == 0) {
            assert_true(matches(line, "^# HELP " NAME " [A-Z].*\\.$"));
            continue;
        }
        if (strncmp(line, "# TYPE ", 7) == 0) {
            char kind[16], word[132];
            assert_true(matches(line, "^# TYPE " NAME " (gauge|counter)$"));
            assert_int_equal(sscanf(line, "# TYPE %127s %15s", family, kind), 2);
            size_t n = strlen(family);
            assert_true((strcmp(kind, "counter") == 0) ==
                        (n > 6 && strcmp(family + n - 6, "_total") == 0));
            snprintf(word, sizeof word, " %s ", family);
            assert_null(strstr(seen, word));
            snprintf(seen + strlen(seen), sizeof seen - strlen(seen), "%s ", family);
            continue;
        }
        if (!matches(line, "^" NAME "(\\{" LABEL "(," LABEL ")*\\})? -?[0-9.]+(e[+-][0-9]+)?$"))
            fail_msg("no sample: %s", line);
        assert_int_equal(strncmp(line, family, strlen(family)), 0);
        assert_non_null(strchr(" {", line[strlen(family)]));
    }
    assert_string_equal(line, ""); /* the last line is ended, too */
    free(copy);
}

static void a_status_is_told_in_samples(void **state)
{
    (void)state;
    json_t *status = json_pack(
        "{s:s, s:s, s:I, s:f, s:f, s:n, s:b, s:{s:I, s:s}, s:{s:s, s:s, s:s, s:s, s:b}, s:I, s:I, "
        "s:i, s:[{}, {}]}",
        "state", "rendering", "scene", "/a \"b\"\\c\nd.json", "generation", (json_int_t)7, "passes",
        2.5, "target_error", 1e-4, "spp", "paused", 0, "shown", "generation", (json_int_t)6,
        "level", "coarse", "device", "spec", "drm:DP-1", "kind", "drm", "model", "m", "serial", "s",
        "present", 1, "updates", (json_int_t)12, "bytes", (json_int_t)5000000000, "clients", 3,
        "jobs");
    assert_non_null(status);
    json_object_set_new(status, "seconds_left", json_real(12.5));
    char *said = said_of(status);
    assert_grammar(said);
    assert_says(said, "quiltd_up 1");
    assert_says(said, "quiltd_state{state=\"rendering\"} 1");
    assert_says(said, "quiltd_state{state=\"converged\"} 0");
    assert_says(said, "quiltd_shown_level{level=\"coarse\"} 1");
    assert_says(said, "quiltd_scene_info{file=\"/a \\\"b\\\"\\\\c\\nd.json\"} 1");
    assert_says(said,
                "quiltd_device_info{spec=\"drm:DP-1\",kind=\"drm\",model=\"m\",serial=\"s\"} 1");
    assert_says(said, "quiltd_generation 7");
    assert_says(said, "quiltd_shown_generation 6");
    assert_says(said, "quiltd_passes 2.5");
    assert_says(said, "quiltd_paused 0");
    assert_says(said, "quiltd_seconds_left 12.5");
    assert_says(said, "quiltd_device_connected 1");
    assert_says(said, "# TYPE quiltd_pushed_bytes_total counter");
    assert_says(said, "quiltd_pushed_bytes_total 5000000000");
    assert_says(said, "quiltd_frames_pushed_total 12");
    assert_says(said, "quiltd_clients 3");
    assert_says(said, "quiltd_jobs 2");
    assert_says(said, "quiltd_error 0");
    assert_null(strstr(said, "samples_per_pixel")); /* not known yet */
    free(said);
    json_object_set_new(status, "error", json_pack("{s:s}", "message", "no"));
    said = said_of(status);
    assert_says(said, "quiltd_error 1");
    free(said);
    json_decref(status);
}

static void no_daemon_is_one_sample(void **state)
{
    (void)state;
    char *said = said_of(NULL);
    assert_string_equal(said, "# HELP quiltd_up Whether a daemon answers.\n"
                              "# TYPE quiltd_up gauge\n"
                              "quiltd_up 0\n");
    free(said);
}

/* quiltctl's own part: the exit status stays what it always is. */
static void a_scraper_gets_its_zero(void **state)
{
    (void)state;
    char command[PATH_MAX + 200], said[512] = "";
    const char *build = getenv("QUILTD_BUILD");
    snprintf(command, sizeof command,
             "%s/quiltctl --socket /nowhere/sock status --format prometheus 2>&1", build);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    said[fread(said, 1, sizeof said - 1, pipe)] = 0;
    assert_int_equal(WEXITSTATUS(pclose(pipe)), 3);
    assert_non_null(strstr(said, "quiltd_up 0\n"));
    assert_non_null(strstr(said, "no quiltd answers"));
    snprintf(command, sizeof command, "%s/quiltctl hello --format prometheus 2>&1", build);
    pipe = popen(command, "r");
    assert_non_null(pipe);
    said[fread(said, 1, sizeof said - 1, pipe)] = 0;
    assert_int_equal(WEXITSTATUS(pclose(pipe)), 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_status_is_told_in_samples),
        cmocka_unit_test(no_daemon_is_one_sample),
        cmocka_unit_test(a_scraper_gets_its_zero),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
