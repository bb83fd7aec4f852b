/* Private to the files of print_profiles.h. */
#ifndef LF_DAEMON_PRINT_PROFILES_INTERNAL_H
#define LF_DAEMON_PRINT_PROFILES_INTERNAL_H

#include "daemon/tools/print_profiles.h"

typedef struct lf_profile_place {
    lf_profile_kind kind;
    const char *name;
    char path[PATH_MAX]; /* of its file */
} lf_profile_place;

/* The profile that the words "[lens|printer] NAME" mean. LF_E_ARG: none, or both a lens and a
 * printer. */
LF_NODISCARD lf_status lf_profile_place_of(const lf_profiles_command *command,
                                           lf_profile_place *out, lf_error *err);

#endif
