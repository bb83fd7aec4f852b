#include "base/former.h"

#include <jansson.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"

enum { MOST_NAMES = 32, NAME_LENGTH = 48 };

bool lf_former_is_logged(const char *version)
{
    static const char since[] = LF_FORMER_SINCE ".";
    return strncmp(version, since, sizeof since - 1) != 0;
}

/* False if it was noted before, or there is no room. */
static bool note(const char *name)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    static char noted[MOST_NAMES][NAME_LENGTH];
    static int n;
    bool is_new = true;
    pthread_mutex_lock(&lock);
    for (int i = 0; i < n; i++)
        is_new = is_new && strcmp(noted[i], name) != 0;
    is_new = is_new && n < MOST_NAMES;
    if (is_new)
        snprintf(noted[n++], NAME_LENGTH, "%s", name);
    pthread_mutex_unlock(&lock);
    return is_new;
}

bool lf_former_used(const char *version, const char *where, const char *old, const char *now)
{
    if (!lf_former_is_logged(version) || !note(old))
        return false;
    lf_log(LF_LOG_WARNING, "%s%s%s is the former name of %s and will be removed",
           where ? where : "", where ? ": " : "", old, now);
    return true;
}

bool lf_former_mark(json_t *schema, const char *now)
{
    char name[NAME_LENGTH];
    snprintf(name, sizeof name, "%s", now);
    for (char *c = name; *c; c++)
        *c = *c == '-' ? '_' : *c;
    return json_object_set_new(schema, "deprecated", json_true()) == 0 &&
           json_object_set_new(schema, "former_name_of", json_string(name)) == 0;
}

const char *lf_former_name_of(const json_t *schema)
{
    return json_string_value(json_object_get(schema, "former_name_of"));
}
