/* doctor: what stands between a machine and a picture on a panel, and what to do about it, judged
 * from what was found out. Who finds it out is lf_ctl_doctor; here nothing is asked but which files
 * there are. Thread: any. */
#ifndef LF_DAEMON_DOCTOR_H
#define LF_DAEMON_DOCTOR_H

#include <jansson.h>
#include <stdio.h>

#include "device/device.h"
#include "device/find/find.h"

/* All borrowed. */
typedef struct lf_doctor_facts {
    const char *root;          /* before every path that is looked at: "" = this machine */
    const json_t *status;      /* what the daemon answered to `status`; NULL = none did … */
    const lf_error *no_answer; /* … for this reason */
    const lf_device_info *devices;
    int n_devices; /* lf_device_list */
    const lf_found *found;
    int n_found; /* lf_find_all */
    /* KEY=VALUE lines of `systemctl show quiltd.service` (lf_doctor_unit_keys); NULL or without
     * LoadState=loaded: no systemd runs, or the service is not installed, and nothing is said */
    const char *unit;
} lf_doctor_facts;

/* What `systemctl show` is asked for, parted by commas. */
extern const char lf_doctor_unit_keys[];

/* Writes a line each: "ok" what works, "note" what may matter, "FAIL" what has to be mended and
 * how. False: there was a FAIL. */
bool lf_doctor_judge(const lf_doctor_facts *facts, FILE *out);

#endif
