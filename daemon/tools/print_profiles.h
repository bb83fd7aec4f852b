/* The commands of quiltprint: profiles of lens sheets and printers (quilt/profiles.h), and check,
 * which is in print_check.h. They print
 * to stdout and warn by the log. Files are written beside and renamed, in the user's folder or in
 * `folder`. Thread: one. */
#ifndef LF_DAEMON_PRINT_PROFILES_H
#define LF_DAEMON_PRINT_PROFILES_H

#include "quilt/profiles.h"

typedef struct lf_profiles_command {
    const char *folder;   /* holds lenses/ and printers/; NULL: the user's */
    const char *manifest; /* of check; NULL: beside the print */
    bool json;            /* print JSON */
    int n;                /* words after the command */
    char *const *words;
} lf_profiles_command;

/* list [lenses|printers]: one line per profile. LF_E_FORMAT: some could not be read; they are
 * named in the log. */
LF_NODISCARD lf_status lf_profiles_list(const lf_profiles_command *command, lf_error *err);
/* show [lens|printer] NAME */
LF_NODISCARD lf_status lf_profiles_show(const lf_profiles_command *command, lf_error *err);
/* set lens|printer NAME KEY=VALUE …: changes a profile, or makes one. A shipped one is copied. */
LF_NODISCARD lf_status lf_profiles_set(const lf_profiles_command *command, lf_error *err);
/* calibrate LENS PRINTER [RESULT.json] [KEY=VALUE …]: keeps what --read-chart wrote in the lens. */
LF_NODISCARD lf_status lf_profiles_calibrate(const lf_profiles_command *command, lf_error *err);
/* remove [lens|printer] NAME */
LF_NODISCARD lf_status lf_profiles_remove(const lf_profiles_command *command, lf_error *err);

#endif
