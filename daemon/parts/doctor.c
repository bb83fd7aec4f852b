#include "daemon/parts/doctor.h"

#include <glob.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/number.h"
#include "daemon/wire/rpc.h"

typedef struct report {
    const lf_doctor_facts *facts;
    lf_doctor_tell_fn tell;
    void *context;
} report;

static void say(const report *r, lf_doctor_level level, const char *what, const char *detail)
{
    char text[1536];
    snprintf(text, sizeof text, "%s: %s", what, detail);
    r->tell(r->context, level, text);
}

static void say_ok(const report *r, const char *what, const char *detail)
{
    say(r, LF_DOCTOR_OK, what, detail);
}

static void say_bad(const report *r, const char *what, const char *remedy)
{
    say(r, LF_DOCTOR_FAIL, what, remedy);
}

static void say_note(const report *r, const char *what, const char *detail)
{
    say(r, LF_DOCTOR_NOTE, what, detail);
}

/* -------------------------------------------------------------------------------- the daemon -- */

/* "" if the daemon, possibly of another version, does not report it. */
static const char *text_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

static void judge_daemon(const report *r)
{
    const json_t *status = r->facts->status, *device = json_object_get(status, "device");
    if (!status) {
        char text[sizeof *r->facts->no_answer];
        say_note(r, "daemon", lf_error_format(r->facts->no_answer, text, sizeof text));
        return;
    }
    const char *problem = text_of(device, "problem");
    char text[1024];
    snprintf(text, sizeof text, "%s, shows on %s%s%s", text_of(status, "state"),
             text_of(device, "spec"), problem[0] != '\0' ? ": " : "", problem);
    say_ok(r, "daemon", text);
}

/* The spec of the panel that the daemon uses; "" = none. */
static const char *shown_on(const lf_doctor_facts *facts)
{
    const json_t *device = json_object_get(facts->status, "device");
    return json_is_true(json_object_get(device, "present")) ? text_of(device, "spec") : "";
}

/* -------------------------------------------------------------------------------- the system -- */

/* True if a file matches this pattern. */
static bool has(const report *r, const char *pattern)
{
    char path[PATH_MAX];
    glob_t found;
    snprintf(path, sizeof path, "%s%s", r->facts->root, pattern);
    bool there = glob(path, GLOB_NOSORT, NULL, &found) == 0;
    globfree(&found);
    return there;
}

static void judge_rule(const report *r)
{
    static const char *const rules[] = {"/etc/udev/rules.d/70-quiltd.rules",
                                        "/usr/lib/udev/rules.d/70-quiltd.rules",
                                        "/usr/local/lib/udev/rules.d/70-quiltd.rules"};
    for (size_t i = 0; i < sizeof rules / sizeof *rules; i++) {
        if (has(r, rules[i])) {
            say_ok(r, "udev rule", rules[i]);
            return;
        }
    }
    say_note(r, "udev rule",
             "70-quiltd.rules is not installed, so only root may open panels; run `make install` "
             "and `udevadm control --reload`");
}

static void judge_system(const report *r)
{
    judge_rule(r);
    if (!has(r, "/run/udev/control"))
        say_note(r, "udev",
                 "is not running, so quiltd does not notice new devices and the rule grants no "
                 "access; start udev");
    if (!has(r, "/sys/bus/usb")) {
        say_note(r, "USB", "the kernel reports no USB bus, so panels are not found over USB");
    } else if (!has(r, "/sys/bus/hid/drivers/hid-generic")) {
        say_note(
            r, "module hid-generic",
            "is not loaded; if a first-generation panel is not found, run `modprobe hid-generic`");
    }
    if (!has(r, "/dev/dri/card*"))
        say_note(r, "displays",
                 "/dev/dri/card* does not exist, so this machine has no display output that quiltd "
                 "can use");
}

/* ------------------------------------------------------------------------------- the service -- */

const char lf_doctor_unit_keys[] =
    "LoadState,Restart,StartLimitIntervalUSec,StartLimitBurst,OOMPolicy,MemoryMax,TasksMax";

/* Minimum for a picture of 45 views and a thread per processor. */
#define LEAST_MEMORY (UINT64_C(1) << 30)
enum { LEAST_TASKS = 64 };

/* The value of a key, "" if the unit does not have it; returns value. */
static char *unit_value(const char *unit, const char *key, char *value, size_t size)
{
    size_t n = strlen(key);
    value[0] = '\0';
    for (const char *line = unit; line && *line; line = strchr(line, '\n')) {
        line += *line == '\n';
        if (strncmp(line, key, n) == 0 && line[n] == '=')
            snprintf(value, size, "%.*s", (int)strcspn(line + n + 1, "\n"), line + n + 1);
    }
    return value;
}

/* UINT64_MAX: no limit, or an old systemd without this property. */
static uint64_t unit_number(const char *text)
{
    uint64_t number;
    return lf_whole_is(text, &number) ? number : UINT64_MAX;
}

static void judge_memory(const report *r, const char *memory, const char *oom)
{
    if (unit_number(memory) == UINT64_MAX)
        say_note(
            r, "service",
            "MemoryMax= is not set; a large scene can use up the machine's memory. Set it to 85%");
    else if (unit_number(memory) < LEAST_MEMORY)
        say_note(
            r, "service",
            "MemoryMax= is below 1 GiB, which is too little for an image of many views; raise it");
    if (strcmp(oom, "continue") != 0)
        say_note(r, "service",
                 "OOMPolicy= is not `continue`, so a file that is too large stops the daemon, not "
                 "only its reader; set it");
}

/* Judges the limits of the service, and whether a picture fits into them. */
static void judge_service(const report *r)
{
    char restart[32], interval[32], burst[32], oom[32], memory[32], tasks[32], text[400];
    const char *unit = r->facts->unit;
    if (strcmp(unit_value(unit, "LoadState", text, sizeof text), "loaded") != 0)
        return;
    unit_value(unit, "Restart", restart, sizeof restart);
    unit_value(unit, "StartLimitIntervalUSec", interval, sizeof interval);
    unit_value(unit, "StartLimitBurst", burst, sizeof burst);
    unit_value(unit, "OOMPolicy", oom, sizeof oom);
    unit_value(unit, "MemoryMax", memory, sizeof memory);
    unit_value(unit, "TasksMax", tasks, sizeof tasks);
    const bool limited = strcmp(interval, "0") != 0;
    snprintf(text, sizeof text, "MemoryMax=%s OOMPolicy=%s TasksMax=%s Restart=%s, %s%s%s%s",
             memory, oom, tasks, restart, limited ? "at most " : "starts without limit",
             limited ? burst : "", limited ? " starts in " : "", limited ? interval : "");
    say_ok(r, "service", text);
    judge_memory(r, memory, oom);
    if (unit_number(tasks) < LEAST_TASKS)
        say_note(r, "service",
                 "TasksMax= is below 64, which is too low for the threads and readers; raise it");
    if (strcmp(restart, "on-failure") != 0 && strcmp(restart, "always") != 0)
        say_note(
            r, "service",
            "Restart= is not `on-failure`, so a crash of the daemon leaves the panel dark; set it");
    if (limited)
        say_note(r, "service",
                 "StartLimitIntervalSec= is not 0, so systemd gives up after several failed "
                 "starts; set it to 0");
}

/* -------------------------------------------------------------------------------- the panels -- */

static void judge_panels(const report *r)
{
    int n_panels = 0;
    for (int i = 0; i < r->facts->n_devices; i++) {
        const lf_device_info *info = &r->facts->devices[i];
        if (!lf_device_is_panel(info->spec))
            continue;
        char what[sizeof info->spec + 8];
        snprintf(what, sizeof what, "panel %s", info->spec);
        n_panels++;
        if (strcmp(info->spec, shown_on(r->facts)) == 0)
            say_ok(r, what, "quiltd shows its image on this panel");
        else if (info->problem[0] != '\0')
            say_bad(r, what, info->problem);
        else
            say_ok(r, what, info->model);
    }
    if (n_panels == 0)
        say_note(r, "panels",
                 "no Looking Glass display (EDID name LKG…) and no GUD display over USB is "
                 "connected; check both cables");
}

static void judge_calibrations(const report *r)
{
    int n_sound = 0;
    for (int i = 0; i < r->facts->n_found; i++) {
        const lf_found *found = &r->facts->found[i];
        char what[sizeof found->path + 16];
        snprintf(what, sizeof what, "calibration %s", found->path);
        if (found->problem[0] != '\0') {
            say_bad(r, what, found->problem);
            continue;
        }
        const lf_calibration *c = &found->calibration;
        char text[160];
        snprintf(text, sizeof text, "%s, %d x %d", c->serial, c->screen_width_px,
                 c->screen_height_px);
        say_ok(r, what, text);
        n_sound++;
    }
    if (n_sound == 0)
        say_note(r, "calibrations",
                 "none was found; connect the panel's USB cable too, or pass --calibration FILE");
}

/* ------------------------------------------------------------------------------ its programs -- */

static bool is_in_path(const char *path, const char *program)
{
    char file[PATH_MAX];
    for (size_t n; *path != '\0'; path += n + (path[n] == ':')) {
        n = strcspn(path, ":");
        const int length = snprintf(file, sizeof file, "%.*s/%s", (int)n, path, program);
        if (length > 0 && (size_t)length < sizeof file && access(file, X_OK) == 0)
            return true;
    }
    return false;
}

static void judge_programs(const report *r)
{
    const char *path = r->facts->path;
    if (path && !(is_in_path(path, "ffmpeg") && is_in_path(path, "ffprobe")))
        say_note(r, "ffmpeg",
                 "is not in PATH, so videos are not shown; install the package ffmpeg");
}

void lf_doctor_judge(const lf_doctor_facts *facts, lf_doctor_tell_fn tell, void *context)
{
    const report r = {.facts = facts, .tell = tell, .context = context};
    judge_daemon(&r);
    judge_system(&r);
    judge_service(&r);
    judge_panels(&r);
    judge_calibrations(&r);
    judge_programs(&r);
}

const char *lf_doctor_level_name(lf_doctor_level level)
{
    static const char *const names[] = {"ok", "note", "fail"};
    return names[level];
}

static void add_finding(void *context, lf_doctor_level level, const char *text)
{
    json_array_append_new(context, json_pack("{s:s, s:o}", "level", lf_doctor_level_name(level),
                                             "text", lf_rpc_text(text)));
}

json_t *lf_doctor_json(const lf_doctor_facts *facts)
{
    json_t *findings = json_array();
    if (findings)
        lf_doctor_judge(facts, add_finding, findings);
    return findings;
}
