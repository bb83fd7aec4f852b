/* JSON Merge Patch, RFC 7396 section 2. */
#include <stdint.h>

#include "render/render.h"

static json_t *merged(json_t *member, const json_t *value)
{
    if (!json_is_object(value))
        return json_deep_copy(value);
    json_t *target = json_is_object(member) ? json_incref(member) : json_object();
    if (target && lf_json_merge_into(target, value))
        return target;
    json_decref(target);
    return NULL;
}

bool lf_json_merge_into(json_t *target, const json_t *patch)
{
    json_t *borrowed = (json_t *)(uintptr_t)patch;
    for (void *it = json_object_iter(borrowed); it; it = json_object_iter_next(borrowed, it)) {
        const char *key = json_object_iter_key(it);
        const json_t *value = json_object_iter_value(it);
        if (json_is_null(value)) {
            json_object_del(target, key);
            continue;
        }
        json_t *member = merged(json_object_get(target, key), value);
        if (!member || json_object_set_new(target, key, member) != 0)
            return false;
    }
    return true;
}

json_t *lf_json_merge_patch(const json_t *doc, const json_t *patch)
{
    json_t *copy = json_deep_copy(json_is_object(patch) && json_is_object(doc) ? doc : NULL);
    json_t *target = merged(copy, patch);
    json_decref(copy);
    return target;
}
