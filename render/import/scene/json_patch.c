/* JSON Merge Patch, RFC 7396 section 2. Unpatched values are shared with the original. */
#include <stdint.h>

#include "render/import/scene/former_keys.h"
#include "render/render.h"

static json_t *shared(const json_t *value)
{
    return json_incref((json_t *)(uintptr_t)value);
}

/* A new reference to an object without other owners: member itself, if only its parent holds it, or
 * a copy of its first level; an empty object if it is not an object. */
static json_t *own_object(json_t *member)
{
    if (!json_is_object(member))
        return json_object();
    return __atomic_load_n(&member->refcount, __ATOMIC_ACQUIRE) == 1 ? json_incref(member)
                                                                     : json_copy(member);
}

static bool merge_members(json_t *target, const json_t *patch);

static json_t *merged(json_t *member, const json_t *value)
{
    if (!json_is_object(value))
        return shared(value);
    json_t *target = own_object(member);
    if (target && merge_members(target, value))
        return target;
    json_decref(target);
    return NULL;
}

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
        json_t *member = merged(json_object_get(target, key), value);
        if (!member || json_object_set_new(target, key, member) != 0)
            return false;
    }
    return true;
}

bool lf_json_merge_into(json_t *target, const json_t *patch)
{
    json_t *current = lf_former_patch_renamed(patch);
    bool done = current && merge_members(target, current);
    json_decref(current);
    return done;
}

json_t *lf_json_merge_patch(const json_t *doc, const json_t *patch)
{
    if (!json_is_object(patch))
        return shared(patch);
    json_t *target = json_is_object(doc) ? json_copy((json_t *)(uintptr_t)doc) : json_object();
    if (target && lf_json_merge_into(target, patch))
        return target;
    json_decref(target);
    return NULL;
}
