/* One daemon that is given spoiled files of every kind, one after the other: whatever they hold, it
 * answers each, goes on showing what it showed, and keeps nothing of them. $QUILTD_LONG: more than
 * 5,000 (docs/lab/security.md has what came of them). */
#include "tests/testing.h"

#include "base/thread.h"
#include "tests/base/spoiled.h"
#include "tests/daemon/live.h"

enum { FEW = 6, MANY = 340 };

/* A scene of a file, by its use: what stands before its name. */
static const char *const scenes[] = {
    [LF_SPOILED_MESH] = "\"lights\":{\"sky\":{\"type\":\"environment\",\"radiance\":1}},"
                        "\"meshes\":{\"m\":{\"file\":\"",
    [LF_SPOILED_GRID] = "\"lights\":{\"sky\":{\"type\":\"environment\",\"radiance\":1}},"
                        "\"volumes\":{\"v\":{\"grid\":\"density\",\"file\":\"",
    [LF_SPOILED_SKY] = "\"volumes\":{\"fog\":{\"shape\":\"sphere\",\"density\":1}},"
                       "\"lights\":{\"sky\":{\"type\":\"environment\",\"file\":\"",
};

typedef struct outcome {
    int shown, refused, ended, late, large;
    double longest; /* seconds until the answer */
} outcome;

static json_t *export_print(live_client *c)
{
    json_t *answer =
        live_call(c, "export",
                  json_pack("{s:s, s:s, s:b, s:f, s:i, s:f, s:f, s:i, s:s}", "kind", "print",
                            "file", "p.tif", "overwrite", 1, "lpi", 60.0, "dpi", 600, "width", 10.0,
                            "height", 8.0, "views", 6, "icc", "a.icc"));
    const json_t *job = json_object_get(json_object_get(answer, "result"), "job");
    if (!job)
        return answer;
    /* the end of the job instead of its number */
    for (;;) {
        json_t *message = live_receive(c), *params = json_object_get(message, "params");
        const char *state = json_string_value(json_object_get(params, "state"));
        bool over = state && strcmp(state, "running") != 0 && strcmp(state, "waiting") != 0;
        if (over) {
            json_decref(answer);
            answer = json_pack("{s:O?}", "error", json_object_get(params, "error"));
        }
        json_decref(message);
        if (over)
            return answer;
    }
}

static json_t *give(live *l, live_client *c, const lf_spoiled_kind *kind)
{
    char spec[PATH_MAX];
    snprintf(spec, sizeof spec, "sim:%s/sim", l->exports);
    if (kind->use == LF_SPOILED_PROFILE)
        return export_print(c);
    if (kind->use == LF_SPOILED_CALIBRATION)
        return live_call(c, "device.set", json_pack("{s:s}", "spec", spec));
    return live_call(
        c, "scene.load",
        json_pack("{s:s}", "file", kind->use == LF_SPOILED_QUILT ? kind->name : "spoiled.json"));
}

static void note(outcome *to, json_t *answer, double seconds)
{
    const json_t *error = json_object_get(answer, "error");
    const char *message = json_string_value(json_object_get(error, "message"));
    to->longest = fmax(to->longest, seconds);
    if (!json_is_object(error))
        to->shown++;
    else if (!message || !message[0])
        fail_msg("an error without a word: %s", json_dumps(answer, 0));
    else if (strstr(message, "the file reader "))
        to->ended++;
    else if (strstr(message, "--import-time"))
        to->late++;
    else if (strstr(message, "--import-memory"))
        to->large++;
    else
        to->refused++;
    json_decref(answer);
}

static void show_fog(live_client *c)
{
    assert_int_equal(live_code(c, "scene.load", json_pack("{s:s}", "file", "fog.json")), 0);
    live_wait(c, "complete");
}

/* Where the file that is spoiled lies. */
static const char *place_of(const live *l, const lf_spoiled_kind *kind)
{
    char *place = lf_test_buffer();
    if (kind->use == LF_SPOILED_CALIBRATION)
        snprintf(place, PATH_MAX, "%s/sim/calibration.json", l->exports);
    else
        snprintf(place, PATH_MAX, "%s/scene/%s", l->folder, kind->file);
    return place;
}

static void give_spoiled(live *l, live_client *c, const lf_spoiled_kind *kind, int n)
{
    char spoiled[PATH_MAX];
    lf_bytes whole = kind->make();
    outcome out = {0};
    snprintf(spoiled, sizeof spoiled, "%s", place_of(l, kind));
    if (kind->use <= LF_SPOILED_SKY) {
        char text[1024];
        snprintf(text, sizeof text,
                 "{\"quiltd\":1,\"camera\":{\"target\":[0,0,0],\"position\":[0,0,9],\"views\":6},"
                 "%s%s\"}}}",
                 scenes[kind->use], kind->name);
        lf_test_write(l->folder, "scene/spoiled.json", text);
    }
    lf_bytes_write(spoiled, whole.data, whole.n);
    if (kind->use == LF_SPOILED_PROFILE)
        show_fog(c);
    json_t *answer = give(l, c, kind);
    if (json_is_object(json_object_get(answer, "error")))
        fail_msg("%s, whole: %s", kind->file, json_dumps(answer, 0));
    json_decref(answer);
    for (int i = 0; i < n; i++) {
        double start = lf_time_now();
        lf_spoil(&whole, i * MANY / n, MANY / 3, spoiled);
        json_t *answered = give(l, c, kind);
        note(&out, answered, lf_time_now() - start);
        assert_int_equal(waitpid(l->pid, NULL, WNOHANG), 0); /* it lives */
    }
    print_message("%-14s shown %3d, refused %3d, reader ended %3d, late %3d, too large %3d; "
                  "longest %.2f s\n",
                  kind->file, out.shown, out.refused, out.ended, out.late, out.large, out.longest);
    lf_bytes_write(spoiled, whole.data, whole.n);
    json_decref(give(l, c, kind));
    free(whole.data);
}

static void no_file_stops_a_daemon(void **state)
{
    (void)state;
    live l;
    live_client c;
    int n = lf_test_long() ? MANY : FEW;
    live_prepare(&l);
    lf_bytes obj = lf_spoiled_kinds[0].make();
    lf_bytes_write(lf_test_path(l.folder, "scene/b.obj"), obj.data, obj.n);
    free(obj.data);
    assert_int_equal(mkdir(l.exports, 0700), 0);
    assert_int_equal(mkdir(lf_test_path(l.exports, "sim"), 0700), 0);
    live_start(&l, l.scene, "--device", l.sim, "--import-time", "2", "--import-memory", "0.5",
               NULL);
    live_connect(&l, &c);
    for (const lf_spoiled_kind *kind = lf_spoiled_kinds; kind->name; kind++)
        give_spoiled(&l, &c, kind, FEW); /* what it keeps of each kind */
    show_fog(&c);
    long before = live_resident_kib(&l);
    for (const lf_spoiled_kind *kind = lf_spoiled_kinds; kind->name; kind++)
        give_spoiled(&l, &c, kind, n);
    show_fog(&c);
    long after = live_resident_kib(&l);
    print_message("resident %ld KiB, and %ld KiB in the end\n", before, after);
    /* sanitizers keep what was released for a while */
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    assert_true(after < before + before / 10);
#endif
    live_close(&c);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(no_file_stops_a_daemon)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
