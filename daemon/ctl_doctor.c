/* quiltctl doctor: what stands between this machine and a picture on a panel, and what to do about it. Looks by itself, with the rights of
 * whoever calls it; a daemon need not run. */
#include <glob.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/ctl.h"
#include "daemon/server.h"
#include "device/find.h"

enum { MAX_DEVICES = 32, MAX_FOUND = 32 };

typedef struct report {
    bool failed;
    int n_panels, n_calibrations;
    char shown_on[512]; /* the daemon's panel; empty = there is none */
} report;

static void say_ok(const char *what, const char *detail)
{
    printf("ok    %s: %s\n", what, detail);
}

static void say_bad(report *r, const char *what, const char *remedy)
{
    r->failed = true;
    printf("FAIL  %s: %s\n", what, remedy);
}

static void say_note(const char *what, const char *detail)
{
    printf("note  %s: %s\n", what, detail);
}

static bool any_file(const char *pattern)
{
    glob_t found;
    bool there = glob(pattern, GLOB_NOSORT, NULL, &found) == 0;
    globfree(&found);
    return there;
}

static void check_daemon(report *r, const char *socket)
{
    lf_ctl *ctl = NULL;
    json_t *status = NULL;
    lf_error err;
    if (lf_ctl_connect(socket, &ctl, &err) != LF_OK ||
        lf_ctl_call(ctl, "status", json_object(), NULL, 0, &status, NULL, &err) != LF_OK) {
        char text[sizeof err];
        say_note("daemon", lf_error_format(&err, text, sizeof text));
    } else {
        const json_t *device = json_object_get(status, "device");
        const char *problem = json_string_value(json_object_get(device, "problem"));
        char text[1024];
        snprintf(text, sizeof text, "%s, shows on %s%s%s", json_string_value(json_object_get(status, "state")),
                 json_string_value(json_object_get(device, "spec")), problem[0] != '\0' ? ": " : "", problem);
        say_ok("daemon", text);
        if (json_is_true(json_object_get(device, "present"))) {
            snprintf(r->shown_on, sizeof r->shown_on, "%s", json_string_value(json_object_get(device, "spec")));
        }
    }
    json_decref(status);
    lf_ctl_close(ctl);
}

static void check_system(void)
{
    static const char *const rules[] = {"/etc/udev/rules.d/70-quiltd.rules", "/usr/lib/udev/rules.d/70-quiltd.rules",
                                        "/usr/local/lib/udev/rules.d/70-quiltd.rules"};
    const char *rule = NULL;
    for (size_t i = 0; i < sizeof rules / sizeof *rules && rule == NULL; i++) {
        rule = access(rules[i], F_OK) == 0 ? rules[i] : NULL;
    }
    if (rule != NULL) {
        say_ok("udev rule", rule);
    } else {
        say_note(
            "udev rule",
            "70-quiltd.rules is not installed: panels may belong to root alone; `make install`, then `udevadm control --reload`");
    }
    if (access("/run/udev/control", F_OK) != 0) {
        say_note("udev", "is not running: plugging in is not noticed, and devices get no rights from the rule");
    }
    if (access("/sys/bus/usb", F_OK) != 0) {
        say_note("USB", "this kernel shows no USB bus: panels are not found over USB");
    } else if (access("/sys/bus/hid/drivers/hid-generic", F_OK) != 0) {
        say_note("module hid-generic", "is not loaded: `modprobe hid-generic`, when a panel of the first generation is not found");
    }
    if (!any_file("/dev/dri/card*")) {
        say_note("displays", "there is no /dev/dri/card*: this machine has no display output that quiltd could use");
    }
}

static void check_panels(report *r)
{
    lf_device_info infos[MAX_DEVICES];
    int n = lf_device_list(infos, MAX_DEVICES);
    for (int i = 0; i < n; i++) {
        if (strcmp(infos[i].kind, "none") == 0) {
            continue;
        }
        char what[sizeof infos->spec + sizeof infos->model + 8];
        snprintf(what, sizeof what, "panel %s", infos[i].spec);
        r->n_panels++;
        if (strcmp(infos[i].spec, r->shown_on) == 0) {
            say_ok(what, "quiltd shows on it");
        } else if (infos[i].problem[0] != '\0') {
            say_bad(r, what, infos[i].problem);
        } else {
            say_ok(what, infos[i].model);
        }
    }
}

static void check_calibrations(report *r)
{
    lf_found *found = lf_calloc(MAX_FOUND, sizeof *found);
    int n = found != NULL ? lf_find_all(found, MAX_FOUND) : 0;
    for (int i = 0; i < n; i++) {
        char what[sizeof found->path + 16];
        snprintf(what, sizeof what, "calibration %s", found[i].path);
        if (found[i].problem[0] != '\0') {
            say_bad(r, what, found[i].problem);
            continue;
        }
        const lf_calibration *c = &found[i].calibration;
        char text[160];
        snprintf(text, sizeof text, "%s, %d x %d", c->serial, c->screen_width_px, c->screen_height_px);
        say_ok(what, text);
        r->n_calibrations++;
    }
    lf_free(found);
}

bool lf_ctl_doctor(const char *socket)
{
    report r = {0};
    check_daemon(&r, socket);
    check_system();
    check_panels(&r);
    check_calibrations(&r);
    if (r.n_panels == 0) {
        say_note("panels",
                 "no display of a Looking Glass is connected (its EDID name begins with LKG), nor a GUD display over USB");
    }
    if (r.n_calibrations == 0) {
        say_note("calibrations", "none was found: connect the panel's USB cable too, or give --calibration FILE");
    }
    return !r.failed;
}
