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

static bool has_former(const json_t *object, int name)
{
    return json_object_get(object, names[name][0]) && !json_object_get(object, names[name][1]);
}

static bool rename_key(json_t *object, int name)
{
    return json_object_set(object, names[name][1], json_object_get(object, names[name][0])) == 0 &&
           json_object_del(object, names[name][0]) == 0;
}

/* Renames the keys (copy), or tells whether there are any (!copy). false: out of memory. */
static bool visit(json_t *doc, bool copy, bool *found)
{
    const char *key;
    json_t *volume;
    bool done = true;
    if (has_former(doc, FPS)) {
        *found = true;
        done = !copy || rename_key(doc, FPS);
    }
    json_object_foreach(json_object_get(doc, "volumes"), key, volume)
    {
        json_t *emission = json_object_get(volume, "emission");
        if (!has_former(emission, TEMPERATURE_SCALE))
            continue;
        *found = true;
        done = done && (!copy || rename_key(emission, TEMPERATURE_SCALE));
    }
    return done;
}

json_t *lf_former_keys_renamed(const json_t *doc)
{
    json_t *borrowed = (json_t *)(uintptr_t)doc;
    bool found = false;
    (void)visit(borrowed, false, &found);
    if (!found)
        return json_incref(borrowed);
    json_t *copy = json_deep_copy(doc);
    if (copy && visit(copy, true, &found))
        return copy;
    json_decref(copy);
    return NULL;
}
