#include "base/former.h"

#include <string.h>

#include "base/log.h"
#include "base/version.h"

bool lf_former_is_logged(const char *version)
{
    static const char since[] = LF_FORMER_SINCE ".";
    return strncmp(version, since, sizeof since - 1) != 0;
}

void lf_former_used(const char *old, const char *now)
{
    if (lf_former_is_logged(LF_VERSION))
        lf_log(LF_LOG_WARNING, "%s is the former name of %s; it will be removed", old, now);
}
