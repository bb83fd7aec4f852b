/* Keys of finished pictures that a file has no use for. */
#include <stdio.h>
#include <string.h>

#include "daemon/server/server_internal.h"

/* Whether a value is that of a picture as it is. */
static bool is_usual(const json_t *usual, const json_t *value)
{
    if (!json_is_number(value))
        return json_equal(usual, value);
    const double difference = json_number_value(usual) - json_number_value(value);
    return !(difference < 0) && !(difference > 0);
}

/* The first of the keys that changes the picture; NULL: none. of_depth: only keys of depth. */
static const char *first_of(const json_t *keys, bool of_depth)
{
    static const char *const depth[] = {"depth_inversion", "chroma_depth", "depthiness",
                                        "depth_cutoff", NULL};
    lf_standing standing = {0};
    const char *found = NULL;
    lf_param_defaults(lf_standing_params, &standing);
    json_t *usual = lf_param_json(lf_standing_params, &standing);
    for (const lf_param *row = lf_standing_params; row->name && !found; row++) {
        bool counts = !of_depth;
        for (int i = 0; depth[i] && !counts; i++)
            counts = strcmp(row->name, depth[i]) == 0;
        const json_t *value = json_object_get(keys, row->name);
        if (counts && value && strcmp(row->name, "rgbd_in") != 0 &&
            !is_usual(json_object_get(usual, row->name), value))
            found = row->name;
    }
    json_decref(usual);
    return found;
}

lf_status lf_server_check_standing(const json_t *keys, const char *file, lf_load_words *words,
                                   const char *where, lf_error *err)
{
    const bool is_picture = !lf_alone_kind(file),
               has_depth = is_picture && lf_rgbd_side_of(&words->standing, file) != LF_RGBD_IN_OFF;
    char pointer[64];
    if (has_depth && words->columns == 1 && words->rows == 1)
        words->columns = words->rows = 0; /* it is one picture, and becomes many views */
    const char *key = has_depth ? NULL : first_of(keys, is_picture);
    if (!key)
        return LF_OK;
    snprintf(pointer, sizeof pointer, "/%s", key);
    return lf_error_set_at(err, LF_E_ARG, where, 0, pointer, "%s",
                           is_picture
                               ? "applies only to pictures with depth; rgbd_in says where it is"
                               : "applies only to finished pictures and videos");
}
