#include "render/import/scene/former_keys.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* {former, current}; the first is a key of the document, the second of a volume's emission. */
static const char *const names[][2] = {{"rate", "fps"}, {"kelvin", "temperature_scale"}};
enum { FPS, TEMPERATURE_SCALE, N_NAMES };

const char *lf_former_key(const char *key)
{
    for (int i = 0; i < N_NAMES; i++)
        if (strcmp(names[i][1], key) == 0)
            return names[i][0];
    return NULL;
}

const char *lf_former_key_now(const char *key)
{
    for (int i = 0; i < N_NAMES; i++)
        if (strcmp(names[i][0], key) == 0)
            return names[i][1];
    return NULL;
}

/* What to do with a former name next to the current one: leave both, or replace the current. */
typedef enum action { RENAME, REPLACE } action;

static bool has_former(const json_t *object, int name, action what)
{
    return json_object_get(object, names[name][0]) &&
           (what == REPLACE || !json_object_get(object, names[name][1]));
}

static bool rename_key(json_t *object, int name)
{
    return json_object_set(object, names[name][1], json_object_get(object, names[name][0])) == 0 &&
           json_object_del(object, names[name][0]) == 0;
}

static bool is_found(const json_t *doc, action what)
{
    const char *key;
    json_t *volume;
    bool found = has_former(doc, FPS, what);
    json_object_foreach(json_object_get(doc, "volumes"), key, volume)
    {
        found = found || has_former(json_object_get(volume, "emission"), TEMPERATURE_SCALE, what);
    }
    return found;
}

/* false: out of memory. */
static bool rename_all(json_t *doc, action what)
{
    const char *key;
    json_t *volume;
    bool done = !has_former(doc, FPS, what) || rename_key(doc, FPS);
    json_object_foreach(json_object_get(doc, "volumes"), key, volume)
    {
        json_t *emission = json_object_get(volume, "emission");
        done = done && (!has_former(emission, TEMPERATURE_SCALE, what) ||
                        rename_key(emission, TEMPERATURE_SCALE));
    }
    return done;
}

static json_t *renamed(const json_t *doc, action what)
{
    if (!is_found(doc, what))
        return json_incref((json_t *)(uintptr_t)doc);
    json_t *copy = json_deep_copy(doc);
    if (copy && rename_all(copy, what))
        return copy;
    json_decref(copy);
    return NULL;
}

json_t *lf_former_keys_renamed(const json_t *doc)
{
    return renamed(doc, RENAME);
}

json_t *lf_former_patch_renamed(const json_t *patch)
{
    return renamed(patch, REPLACE);
}
