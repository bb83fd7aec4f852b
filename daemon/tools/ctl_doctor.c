/* quiltctl doctor: finds out what the judgement goes by, with the rights of whoever calls it; a
 * daemon need not run. */
#include <stdio.h>
#include <systemd/sd-daemon.h>

#include "base/alloc.h"
#include "daemon/tools/ctl.h"
#include "daemon/tools/doctor.h"

enum { MAX_DEVICES = 32, MAX_FOUND = 32 };

/* What the daemon says of itself; NULL = there is none that answers, with *err. */
static json_t *ask_daemon(const char *socket, lf_error *err)
{
    lf_ctl *ctl = NULL;
    json_t *status = NULL;
    if (lf_ctl_connect(socket, &ctl, err) == LF_OK &&
        lf_ctl_call(ctl, "status", json_object(), NULL, 0, &status, NULL, err) != LF_OK)
        status = NULL;
    lf_ctl_close(ctl);
    return status;
}

/* What systemd says of the service, into out; "" where there is none to ask. */
static void ask_systemd(char *out, size_t size)
{
    char command[256];
    out[0] = '\0';
    snprintf(command, sizeof command, "systemctl show quiltd.service -p %s 2> /dev/null",
             lf_doctor_unit_keys);
    FILE *pipe = sd_booted() > 0 ? popen(command, "re") : NULL;
    if (!pipe)
        return;
    out[fread(out, 1, size - 1, pipe)] = '\0';
    (void)pclose(pipe);
}

bool lf_ctl_doctor(const char *socket)
{
    lf_error no_answer = {0};
    lf_device_info devices[MAX_DEVICES];
    lf_found *found = lf_calloc(MAX_FOUND, sizeof *found);
    json_t *status = ask_daemon(socket, &no_answer);
    char unit[1024];
    ask_systemd(unit, sizeof unit);
    const lf_doctor_facts facts = {
        .root = "",
        .status = status,
        .no_answer = &no_answer,
        .devices = devices,
        .n_devices = lf_device_list(devices, MAX_DEVICES),
        .found = found,
        .n_found = found ? lf_find_all(found, MAX_FOUND) : 0,
        .unit = unit,
    };
    bool sound = lf_doctor_judge(&facts, stdout);
    json_decref(status);
    lf_free(found);
    return sound;
}
