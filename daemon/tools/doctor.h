/* doctor: judges the facts about a machine, its panels and the daemon, and prints problems with
 * remedies. lf_ctl_doctor collects the facts; here only the existence of files is checked. Thread:
 * any. */
#ifndef LF_DAEMON_DOCTOR_H
#define LF_DAEMON_DOCTOR_H

#include <jansson.h>
#include <stdio.h>

#include "device/device.h"
#include "device/find/find.h"

/* All borrowed. */
typedef struct lf_doctor_facts {
    const char *root;          /* prefix of every checked path: "" = this machine */
    const json_t *status;      /* the daemon's answer to `status`; NULL = none … */
    const lf_error *no_answer; /* … for this reason */
    const lf_device_info *devices;
    int n_devices; /* lf_device_list */
    const lf_found *found;
    int n_found; /* lf_find_all */
    /* KEY=VALUE lines of `systemctl show quiltd.service` (lf_doctor_unit_keys). NULL, or without
     * LoadState=loaded: systemd does not run or the service is not installed, and the service is
     * not judged. */
    const char *unit;
} lf_doctor_facts;

/* Properties for `systemctl show`, comma separated. */
extern const char lf_doctor_unit_keys[];

/* Writes one line per finding: "ok" works, "note" may matter, "FAIL" must be fixed, with the
 * remedy. False: there was a FAIL. */
bool lf_doctor_judge(const lf_doctor_facts *facts, FILE *out);

#endif
