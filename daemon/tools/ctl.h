/* ctl: parts of quiltctl: the connection to the daemon, exports with the caller's rights, and
 * tables. Errors are lf_error; LF_E_NODEV means that no daemon answers. Thread: one. */
#ifndef LF_DAEMON_CTL_H
#define LF_DAEMON_CTL_H

#include <jansson.h>
#include <stdio.h>

#include "daemon/parts/doctor.h"
#include "daemon/wire/rpc.h"

typedef struct lf_ctl lf_ctl;

/* Connects to path, or (NULL) to the first default that answers. LF_E_NODEV: no daemon answers. */
LF_NODISCARD lf_status lf_ctl_connect(const char *path, lf_ctl **out, lf_error *err);
/* From now on each answer must arrive within `seconds` (0: no limit), otherwise LF_E_TIMEOUT. */
void lf_ctl_set_timeout(lf_ctl *ctl, double seconds);
/* Accepts NULL. */
void lf_ctl_close(lf_ctl *ctl);

/* Makes one call. Takes ownership of params. fds[n] are passed along and stay the caller's.
 * *out_result is a new reference. If the daemon answers with an error: LF_E_STATE, its message in
 * err->what, its code in *out_code (may be NULL). LF_E_NODEV: the connection broke. */
LF_NODISCARD lf_status lf_ctl_call(lf_ctl *ctl, const char *method, json_t *params, const int *fds,
                                   int n, json_t **out_result, int *out_code, lf_error *err);
/* The next notification (a new reference); notifications that arrived during calls come first. */
LF_NODISCARD lf_status lf_ctl_next(lf_ctl *ctl, json_t **out_message, lf_error *err);

/* Exports to a file or folder, which is opened here and published once the job has succeeded. Shows
 * progress if stderr is a terminal. params: of `export`, with kind and file; ownership is taken. */
LF_NODISCARD lf_status lf_ctl_export(lf_ctl *ctl, json_t *params, json_t **out_result,
                                     lf_error *err);
/* Exports on a farm, which writes by name: returns once the farm has the job, which then goes on
 * without us. params as above. */
LF_NODISCARD lf_status lf_ctl_export_farmed(lf_ctl *ctl, json_t *params, json_t **out_result,
                                            lf_error *err);
/* Calls frame.get or library.thumbnail with a file, which is opened here and published once it is
 * written. Takes ownership of params. LF_E_EXISTS: the file exists. */
LF_NODISCARD lf_status lf_ctl_image(lf_ctl *ctl, const char *method, const char *file,
                                    json_t *params, json_t **out_result, lf_error *err);
/* Calls quilt.show with an image file, which is opened here. Takes ownership of params. */
LF_NODISCARD lf_status lf_ctl_show_quilt(lf_ctl *ctl, const char *file, json_t *params,
                                         json_t **out_result, lf_error *err);
/* One status line for people: state, time, passes, error and estimated time to the target error.
 * Returns line. */
#define LF_CTL_LINE 512
char *lf_ctl_watch_line(const json_t *status, char line[LF_CTL_LINE]);
/* Prints that line until the connection ends or SIGINT. A terminal shows it in place; otherwise
 * prints it when the state changes and every 30 seconds. */
LF_NODISCARD lf_status lf_ctl_watch(lf_ctl *ctl, lf_error *err);

/* Checks this machine, panel and daemon and prints the findings. socket NULL: the defaults. False:
 * a finding must be fixed. */
bool lf_ctl_doctor(const char *socket);
/* Prints one line per finding, with the remedy, and then how many findings must be fixed. Returns
 * their number. */
int lf_ctl_print_findings(const lf_doctor_facts *facts, FILE *out);

/* Prints a `status` for people: what is shown, progress, the panel, problems; at most 24 lines. */
void lf_ctl_print_status(const json_t *status, FILE *out);
/* Prints the answer of a `playlist` method for people, in one line. */
void lf_ctl_print_slideshow(const json_t *list, FILE *out);
/* Writes a duration for people into buf, in s, min or h; returns buf. */
#define LF_CTL_TIME 32
char *lf_ctl_time(double seconds, char buf[LF_CTL_TIME]);
/* Prints a result for people: one "key  value" per line, nested keys as key.key, control characters
 * escaped. */
void lf_ctl_print(const json_t *result);

/* Words of quiltctl's command line for lf_options_rules. Operands: the methods, then its own
 * commands. Followers: kinds of export, "key=", or "key=word" if the schema lists the words. */
const char *lf_ctl_operand_at(int index);
bool lf_ctl_follower_at(int operand, int index, char *word, size_t size);

#endif
