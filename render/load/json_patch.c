/* JSON Merge Patch, RFC 7396 section 2. */
#include <stdint.h>

#include "render/render.h"

/* Members of target (an object of our own) after patch; false = out of memory. */
static bool merge_members(json_t *target, const json_t *patch)
{
    json_t *borrowed = (json_t *)(uintptr_t)patch;
    for (void *it = json_object_iter(borrowed); it; it = json_object_iter_next(borrowed, it)) {
        const char *key = json_object_iter_key(it);
        const json_t *value = json_object_iter_value(it);
        if (json_is_null(value)) {
            json_object_del(target, key);
            continue;
        }
        json_t *merged = lf_json_merge_patch(json_object_get(target, key), value);
        if (!merged || json_object_set_new(target, key, merged) != 0)
            return false;
    }
    return true;
}

json_t *lf_json_merge_patch(const json_t *doc, const json_t *patch)
{
    if (!json_is_object(patch))
        return json_deep_copy(patch);
    json_t *target = json_is_object(doc) ? json_deep_copy(doc) : json_object();
    if (!target || !merge_members(target, patch)) {
        json_decref(target);
        return NULL;
    }
    return target;
}
