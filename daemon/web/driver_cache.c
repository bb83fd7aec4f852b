/* Images that programs have sent under a name, for `show` without sending them again. */
#include "daemon/web/driver_internal.h"

#include <string.h>

#include "base/alloc.h"

struct lf_cached {
    lf_cached *next; /* older */
    char *name;
    lf_bin *bin;
    json_t *settings;
};

static void drop_at(lf_cached **at)
{
    lf_cached *gone = *at;
    *at = gone->next;
    lf_bin_destroy(gone->bin);
    json_decref(gone->settings);
    lf_free(gone->name);
    lf_free(gone);
}

bool lf_cache_make_room(void *context)
{
    lf_driver *driver = context;
    lf_cached **at = &driver->cached;
    if (!*at)
        return false;
    while ((*at)->next)
        at = &(*at)->next;
    drop_at(at);
    return true;
}

bool lf_cache_drop(lf_driver *driver, const char *name)
{
    for (lf_cached **at = &driver->cached; *at; at = &(*at)->next) {
        if (strcmp((*at)->name, name) != 0)
            continue;
        drop_at(at);
        return true;
    }
    return false;
}

bool lf_cache_find(const lf_driver *driver, const char *name, const lf_bin **out_bin,
                   const json_t **out_settings)
{
    for (const lf_cached *c = driver->cached; c; c = c->next) {
        if (strcmp(c->name, name) != 0)
            continue;
        *out_bin = c->bin;
        *out_settings = c->settings;
        return true;
    }
    return false;
}

static int count(const lf_driver *driver)
{
    int n = 0;
    for (const lf_cached *c = driver->cached; c; c = c->next)
        n++;
    return n;
}

lf_status lf_cache_put(lf_driver *driver, const char *name, lf_bin *bin, const json_t *settings,
                       lf_error *err)
{
    const size_t n = strlen(name);
    if (n < 1 || n > LF_DRIVER_MAX_NAME)
        return lf_error_set(err, LF_E_ARG, "cache", "a name has 1 to %d bytes", LF_DRIVER_MAX_NAME);
    lf_cached *new = lf_calloc(1, sizeof *new);
    char *copy = lf_strdup(name);
    json_t *kept = settings ? json_deep_copy(settings) : json_object();
    if (!new || !copy || !kept) {
        lf_free(new);
        lf_free(copy);
        json_decref(kept);
        return lf_error_set(err, LF_E_NOMEM, "cache", "out of memory");
    }
    (void)lf_cache_drop(driver, name);
    while (count(driver) >= LF_DRIVER_MAX_CACHED)
        (void)lf_cache_make_room(driver);
    *new = (lf_cached){.next = driver->cached, .name = copy, .bin = bin, .settings = kept};
    driver->cached = new;
    return LF_OK;
}
