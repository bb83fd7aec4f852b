/* doctor: judges the facts about a machine, its panels and the daemon, and tells problems with
 * remedies. `quiltctl doctor` and the method `doctor` collect the facts; here only the existence of
 * files is checked. Thread: any but the event thread. */
#ifndef LF_DAEMON_DOCTOR_H
#define LF_DAEMON_DOCTOR_H

#include <jansson.h>

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
    const char *path; /* PATH, in which ffmpeg is looked for; NULL: it is not judged */
} lf_doctor_facts;

/* Properties for `systemctl show`, comma separated. */
extern const char lf_doctor_unit_keys[];

/* OK: works; NOTE: may matter; FAIL: must be fixed. */
typedef enum lf_doctor_level { LF_DOCTOR_OK, LF_DOCTOR_NOTE, LF_DOCTOR_FAIL } lf_doctor_level;
/* "ok", "note", "fail". */
const char *lf_doctor_level_name(lf_doctor_level level);

/* A finding: "WHAT: DETAIL", or for NOTE and FAIL "WHAT: what is wrong; remedy". In one line. */
typedef void (*lf_doctor_tell_fn)(void *context, lf_doctor_level level, const char *text);

/* Tells all findings in order. */
void lf_doctor_judge(const lf_doctor_facts *facts, lf_doctor_tell_fn tell, void *context);
/* The findings as an array of {level, text}. NULL = out of memory. */
json_t *lf_doctor_json(const lf_doctor_facts *facts);

#endif
