/* ctl: what quiltctl is made of: a connection to the daemon, exports that write with the caller's
 * rights, and tables. Errors are lf_error; LF_E_NODEV means that no daemon answers. Thread: one. */
#ifndef LF_DAEMON_CTL_H
#define LF_DAEMON_CTL_H

#include <jansson.h>

#include "daemon/wire/rpc.h"

typedef struct lf_ctl lf_ctl;

/* Connects to path, or to the first default that answers (NULL). LF_E_NODEV when nobody does. */
LF_NODISCARD lf_status lf_ctl_connect(const char *path, lf_ctl **out, lf_error *err);
/* From now on all answers have to come within so many seconds (0: whenever they like), else
 * LF_E_TIMEOUT. */
void lf_ctl_set_timeout(lf_ctl *ctl, double seconds);
/* Accepts NULL. */
void lf_ctl_close(lf_ctl *ctl);

/* One call: params are taken over; fds[n] are passed along (still the caller's). *out_result is a
 * new reference. When the daemon answers with an error, err->what holds its message, *out_code (may
 * be NULL) its code, and LF_E_STATE is returned. LF_E_NODEV when the connection broke. */
LF_NODISCARD lf_status lf_ctl_call(lf_ctl *ctl, const char *method, json_t *params, const int *fds,
                                   int n, json_t **out_result, int *out_code, lf_error *err);
/* The next notification (a new reference), those that came during calls first. */
LF_NODISCARD lf_status lf_ctl_next(lf_ctl *ctl, json_t **out_message, lf_error *err);

/* Exports into a file or folder that is opened here and published when the job has ended well;
 * shows progress when stderr is a terminal. params: the export's, with kind and file; taken over.
 */
LF_NODISCARD lf_status lf_ctl_export(lf_ctl *ctl, json_t *params, json_t **out_result,
                                     lf_error *err);
/* What the daemon is doing, from its status, for people: state, time, passes, error and about how
 * long it is to the target error. look: zero at first, then of the line before. Returns line. */
#define LF_CTL_LINE 512
typedef struct lf_ctl_look {
    double error, seconds; /* the error estimate, and the time rendered when it was first seen */
} lf_ctl_look;
char *lf_ctl_watch_line(const json_t *status, lf_ctl_look *look, char line[LF_CTL_LINE]);
/* Prints that line until the connection ends or SIGINT: again and again in place on a terminal,
 * else whenever the state changes and every 30 seconds. */
LF_NODISCARD lf_status lf_ctl_watch(lf_ctl *ctl, lf_error *err);

/* Prints what stands between this machine and a picture on a panel, and what to do about it, a line
 * each. socket NULL: the defaults. False: something has to be mended. */
bool lf_ctl_doctor(const char *socket);

/* A result for people: one "key  value" a line, members of members as key.key, control characters
 * escaped. */
void lf_ctl_print(const json_t *result);

/* The words of quiltctl's command line, as lf_options_rules asks for them: the methods, then its
 * own commands; and what may follow each: kinds of export, "key=", or "key=word" where the schema
 * lists the words. */
const char *lf_ctl_operand_at(int index);
bool lf_ctl_follower_at(int operand, int index, char *word, size_t size);

#endif
