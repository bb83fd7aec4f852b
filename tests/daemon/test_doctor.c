/* The doctor: what it says of machines that are made up, folders and all. */
#include "tests/testing.h"

#include <sys/stat.h>

#include "daemon/parts/doctor.h"

typedef struct machine {
    char *root;
    json_t *status;
    lf_error no_answer;
    lf_device_info devices[4];
    lf_found found[4];
    lf_doctor_facts facts;
    bool sound;
    char *said;
    size_t n_said;
} machine;

static void add_file(const machine *m, const char *path)
{
    char folder[PATH_MAX];
    snprintf(folder, sizeof folder, "%s%s", m->root, path);
    for (char *at = folder + strlen(m->root) + 1; (at = strchr(at, '/')); at++) {
        *at = 0;
        mkdir(folder, 0700);
        *at = '/';
    }
    lf_test_write(m->root, path + 1, "");
}

/* One with all that a panel needs, but neither panel nor daemon. */
static machine *make_machine(void)
{
    machine *m = calloc(1, sizeof *m);
    assert_non_null(m);
    m->root = lf_test_folder();
    add_file(m, "/usr/lib/udev/rules.d/70-quiltd.rules");
    add_file(m, "/run/udev/control");
    add_file(m, "/sys/bus/usb/devices/1-1");
    add_file(m, "/sys/bus/hid/drivers/hid-generic/bind");
    add_file(m, "/dev/dri/card1");
    lf_error_set(&m->no_answer, LF_E_NODEV, "/run/quiltd/control.sock", "no daemon answers");
    m->facts = (lf_doctor_facts){
        .root = m->root, .no_answer = &m->no_answer, .devices = m->devices, .found = m->found};
    return m;
}

static void add_device(machine *m, const char *kind, const char *spec, const char *problem)
{
    lf_device_info *info = &m->devices[m->facts.n_devices++];
    snprintf(info->kind, sizeof info->kind, "%s", kind);
    snprintf(info->spec, sizeof info->spec, "%s", spec);
    snprintf(info->model, sizeof info->model, "Looking Glass");
    snprintf(info->problem, sizeof info->problem, "%s", problem);
}

static void add_calibration(machine *m, const char *path, const char *problem)
{
    lf_found *found = &m->found[m->facts.n_found++];
    snprintf(found->path, sizeof found->path, "%s", path);
    snprintf(found->problem, sizeof found->problem, "%s", problem);
    lf_calibration_portrait(&found->calibration);
}

typedef struct listener {
    FILE *out;
    bool failed;
} listener;

static void note(void *context, lf_doctor_level level, const char *text)
{
    static const char *const heads[] = {"ok   ", "note ", "FAIL "};
    listener *l = context;
    l->failed = l->failed || level == LF_DOCTOR_FAIL;
    fprintf(l->out, "%s %s\n", heads[level], text);
}

static void examine(machine *m)
{
    free(m->said);
    m->said = NULL;
    listener l = {.out = open_memstream(&m->said, &m->n_said)};
    assert_non_null(l.out);
    m->facts.status = m->status;
    lf_doctor_judge(&m->facts, note, &l);
    m->sound = !l.failed;
    fclose(l.out);
}

static void assert_says(const machine *m, const char *line)
{
    if (!strstr(m->said, line))
        fail_msg("\"%s\" is not said:\n%s", line, m->said);
}

static void assert_does_not_say(const machine *m, const char *words)
{
    if (strstr(m->said, words))
        fail_msg("\"%s\" is said:\n%s", words, m->said);
}

static void destroy_machine(machine *m)
{
    json_decref(m->status);
    lf_test_folder_remove(m->root);
    free(m->said);
    free(m);
}

static void a_machine_with_its_panel_has_nothing_but_ok(void **state)
{
    (void)state;
    machine *m = make_machine();
    m->status = json_pack("{s:s, s:{s:s, s:s, s:b}}", "state", "rendering", "device", "spec",
                          "drm:DP-1", "problem", "", "present", 1);
    add_device(m, "drm", "drm:DP-1", "used by quiltd"); /* which is the daemon: no problem */
    add_device(m, "none", "none", "");
    add_calibration(m, "/dev/hidraw0", "");
    examine(m);
    assert_true(m->sound);
    assert_string_equal(m->said, "ok    daemon: rendering, shows on drm:DP-1\n"
                                 "ok    udev rule: /usr/lib/udev/rules.d/70-quiltd.rules\n"
                                 "ok    panel drm:DP-1: quiltd shows its image on this panel\n"
                                 "ok    calibration /dev/hidraw0: LKG-PORT-NOMINAL, 1536 x 2048\n");
    destroy_machine(m);
}

static void what_is_missing_is_noted_but_fails_nothing(void **state)
{
    (void)state;
    machine *m = make_machine();
    add_device(m, "none", "none", "");
    examine(m);
    assert_true(m->sound);
    assert_says(m, "note  daemon: /run/quiltd/control.sock: no daemon answers\n");
    assert_says(m, "note  panels: no Looking Glass display");
    assert_says(m, "note  calibrations: none was found");
    assert_does_not_say(m, "FAIL");
    destroy_machine(m);
}

static void every_part_of_the_system_is_looked_for(void **state)
{
    (void)state;
    static const struct {
        const char *removed, *line;
    } cases[] = {
        {"usr/lib/udev/rules.d/70-quiltd.rules",
         "note  udev rule: 70-quiltd.rules is not installed"},
        {"run/udev/control", "note  udev: is not running"},
        {"sys/bus/hid", "note  module hid-generic: is not loaded"},
        {"sys/bus/usb", "note  USB: the kernel reports no USB bus"},
        {"dev/dri/card1", "note  displays: /dev/dri/card* does not exist"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        machine *m = make_machine();
        char away[PATH_MAX];
        examine(m);
        assert_does_not_say(m, cases[i].line);
        snprintf(away, sizeof away, "%s/away", m->root);
        assert_int_equal(rename(lf_test_path(m->root, cases[i].removed), away), 0);
        examine(m);
        assert_says(m, cases[i].line);
        assert_true(m->sound);
        destroy_machine(m);
    }
}

static void a_rule_of_the_administrator_goes_before_the_others(void **state)
{
    (void)state;
    machine *m = make_machine();
    add_file(m, "/etc/udev/rules.d/70-quiltd.rules");
    examine(m);
    assert_says(m, "ok    udev rule: /etc/udev/rules.d/70-quiltd.rules\n");
    destroy_machine(m);
}

static void panels_and_calibrations_that_cannot_be_used_fail(void **state)
{
    (void)state;
    machine *m = make_machine();
    add_device(m, "drm", "drm:DP-1", "may not be opened: the user has to be in the group video");
    add_calibration(m, "/dev/hidraw0", "may not be opened");
    examine(m);
    assert_false(m->sound);
    assert_says(m,
                "FAIL  panel drm:DP-1: may not be opened: the user has to be in the group video\n");
    assert_says(m, "FAIL  calibration /dev/hidraw0: may not be opened\n");
    assert_says(m, "note  calibrations: none was found"); /* that could be used */
    assert_does_not_say(m, "note  panels");
    destroy_machine(m);
}

static void a_daemon_that_has_no_panel_owns_none(void **state)
{
    (void)state;
    machine *m = make_machine();
    m->status = json_pack("{s:s, s:{s:s, s:s, s:b}}", "state", "rendering", "device", "spec",
                          "drm:DP-1", "problem", "unplugged", "present", 0);
    add_device(m, "drm", "drm:DP-1", "used by another program");
    examine(m);
    assert_says(m, "ok    daemon: rendering, shows on drm:DP-1: unplugged\n");
    assert_says(m, "FAIL  panel drm:DP-1: used by another program\n");
    assert_false(m->sound);
    destroy_machine(m);
}

static void a_daemon_that_says_other_things_is_put_up_with(void **state)
{
    (void)state;
    static const char *const answers[] = {
        "{}", "{\"device\":null}", "{\"device\":{\"spec\":1,\"problem\":[],\"present\":true}}",
        "[]"};
    for (size_t i = 0; i < sizeof answers / sizeof answers[0]; i++) {
        machine *m = make_machine();
        m->status = json_loads(answers[i], 0, NULL);
        assert_non_null(m->status);
        add_device(m, "drm", "drm:DP-1", "");
        examine(m);
        assert_says(m, "ok    daemon: ");
        assert_says(m, "ok    panel drm:DP-1: Looking Glass\n");
        destroy_machine(m);
    }
}

/* As `systemctl show` says it of the unit that is shipped, on a machine of 16 GB. */
#define UNIT(restart, interval, oom, memory, tasks)                                                \
    "Restart=" restart "\nOOMPolicy=" oom "\nMemoryMax=" memory "\nTasksMax=" tasks                \
    "\nLoadState=loaded\nStartLimitIntervalUSec=" interval "\nStartLimitBurst=5\n"

static void the_limits_of_the_service_are_told(void **state)
{
    (void)state;
    machine *m = make_machine();
    examine(m);
    assert_does_not_say(m, "service");
    m->facts.unit = "LoadState=not-found\nMemoryMax=infinity\n";
    examine(m);
    assert_does_not_say(m, "service");
    m->facts.unit = UNIT("on-failure", "0", "continue", "14209286144", "4915");
    examine(m);
    assert_says(m, "ok    service: MemoryMax=14209286144 OOMPolicy=continue TasksMax=4915 "
                   "Restart=on-failure, starts without limit\n");
    assert_does_not_say(m, "note  service");
    m->facts.unit = UNIT("no", "10s", "stop", "infinity", "32");
    examine(m);
    assert_says(m, "Restart=no, at most 5 starts in 10s\n");
    assert_says(m, "note  service: MemoryMax= is not set");
    assert_says(m, "note  service: OOMPolicy= is not `continue`");
    assert_says(m, "note  service: TasksMax= is below 64");
    assert_says(m, "note  service: Restart= is not `on-failure`");
    assert_says(m, "note  service: StartLimitIntervalSec= is not 0");
    m->facts.unit = UNIT("always", "0", "continue", "500000000", "infinity");
    examine(m);
    assert_says(m, "note  service: MemoryMax= is below 1 GiB");
    assert_true(m->sound);
    destroy_machine(m);
}

static void videos_need_ffmpeg(void **state)
{
    (void)state;
    static const char words[] =
        "note  ffmpeg: is not in PATH, so videos are not shown; install the "
        "package ffmpeg\n";
    machine *m = make_machine();
    char path[PATH_MAX];
    examine(m); /* no PATH: not judged */
    assert_does_not_say(m, "ffmpeg");
    snprintf(path, sizeof path, "/nowhere::%s/bin", m->root);
    m->facts.path = path;
    examine(m);
    assert_says(m, words);
    for (int i = 0; i < 2; i++) {
        const char *const program = i == 0 ? "/bin/ffmpeg" : "/bin/ffprobe";
        char file[PATH_MAX];
        assert_says(m, words);
        add_file(m, program);
        snprintf(file, sizeof file, "%s%s", m->root, program);
        assert_int_equal(chmod(file, 0700), 0);
        examine(m);
    }
    assert_does_not_say(m, "ffmpeg");
    assert_true(m->sound);
    destroy_machine(m);
}

static void as_json_the_findings_are_the_same(void **state)
{
    (void)state;
    machine *m = make_machine();
    add_device(m, "drm", "drm:DP-1", "may not be opened");
    add_calibration(m, "/media/\xff/visual.json", "");
    examine(m);
    json_t *findings = lf_doctor_json(&m->facts), *finding;
    char said[4096] = "";
    size_t i, n = 0;
    json_array_foreach(findings, i, finding)
    {
        const char *level = json_string_value(json_object_get(finding, "level"));
        n += (size_t)snprintf(said + n, sizeof said - n, "%-5s %s\n",
                              strcmp(level, "fail") == 0 ? "FAIL" : level,
                              json_string_value(json_object_get(finding, "text")));
    }
    char *name = strchr(m->said, '\xff'); /* JSON is UTF-8 */
    assert_non_null(name);
    assert_memory_equal(said, m->said, (size_t)(name - m->said));
    assert_non_null(strstr(said, "ok    calibration /media/\\xff/visual.json: LKG-PORT-NOMINAL"));
    json_decref(findings);
    destroy_machine(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_machine_with_its_panel_has_nothing_but_ok),
        cmocka_unit_test(what_is_missing_is_noted_but_fails_nothing),
        cmocka_unit_test(every_part_of_the_system_is_looked_for),
        cmocka_unit_test(a_rule_of_the_administrator_goes_before_the_others),
        cmocka_unit_test(panels_and_calibrations_that_cannot_be_used_fail),
        cmocka_unit_test(a_daemon_that_has_no_panel_owns_none),
        cmocka_unit_test(a_daemon_that_says_other_things_is_put_up_with),
        cmocka_unit_test(the_limits_of_the_service_are_told),
        cmocka_unit_test(videos_need_ffmpeg),
        cmocka_unit_test(as_json_the_findings_are_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
