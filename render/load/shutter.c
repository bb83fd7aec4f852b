#include "render/load/shutter.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "render/load/keyframes.h"

/* One end, so many frames from the frame; root.value becomes its document. */
static void read_end(lf_reader *reader, const lf_node *root, double frames, int end,
                     lf_shutter *out)
{
    out->doc[end] = lf_keyframes_beside(reader, root, frames);
    out->own[end] = lf_calloc(1, sizeof *out->own[end]);
    out->desc[end] = out->own[end];
    if (reader->status == LF_OK && !out->own[end])
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
    if (reader->status != LF_OK)
        return;
    lf_node at = *root;
    at.value = out->doc[end];
    lf_scene_parse_beside(reader, &at, frames, out->own[end]);
}

void lf_shutter_read(lf_reader *reader, const lf_node *root, json_t *still,
                     const lf_scene_desc *desc, lf_shutter *out)
{
    const double open = desc->camera.shutter_open;
    *out = (lf_shutter){0};
    for (int end = 0; end < 2 && reader->status == LF_OK; end++) {
        if (desc->camera.shutter > 0) {
            read_end(reader, root, open + end * desc->camera.shutter, end, out);
            continue;
        }
        out->doc[end] = json_incref(still);
        out->desc[end] = desc;
    }
}

void lf_shutter_finish(lf_shutter *shutter)
{
    for (int end = 0; end < 2; end++) {
        json_decref(shutter->doc[end]);
        if (shutter->own[end])
            lf_scene_desc_finish(shutter->own[end]);
        lf_free(shutter->own[end]);
    }
    *shutter = (lf_shutter){0};
}

/* ---------------------------------------------------------------------------------- warnings -- */

/* Adds a name to the list of what stands still. */
static void add(char *list, size_t size, const char *section, const char *name)
{
    size_t at = strlen(list);
    snprintf(list + at, size - at, "%s%s%s%s", at ? ", " : "", section, name ? "." : "",
             name ? name : "");
}

/* Lights that are faces are meshes. */
static bool is_lamp(const lf_scene_desc *desc, const char *name)
{
    bool found = false;
    for (int i = 0; i < desc->n_meshes; i++)
        found = found || (desc->meshes[i].lamp && strcmp(desc->meshes[i].name, name) == 0);
    return found;
}

/* Whether a light shines differently: where its faces are moves. */
static bool shines_differently(const json_t *a, const json_t *b)
{
    static const char *const words[] = {"radiance", "power"};
    bool found = false;
    for (int i = 0; i < 2; i++) {
        const json_t *x = json_object_get(a, words[i]), *y = json_object_get(b, words[i]);
        found = found || (x && !json_equal(x, y));
    }
    return found;
}

void lf_shutter_warn(const lf_shutter *shutter, const char *where, lf_warnings *warnings)
{
    static const char *const sections[] = {"volumes", "materials", "lights"};
    static const char *const wholes[] = {"camera", "backdrop", "film"};
    char list[512] = "";
    if (json_equal(shutter->doc[0], shutter->doc[1]))
        return;
    for (int i = 0; i < 3; i++) {
        const json_t *whole = json_object_get(shutter->doc[0], wholes[i]);
        if (whole && !json_equal(whole, json_object_get(shutter->doc[1], wholes[i])))
            add(list, sizeof list, wholes[i], NULL);
    }
    for (int i = 0; i < 3; i++) {
        const json_t *closed = json_object_get(shutter->doc[1], sections[i]);
        const char *name;
        json_t *value;
        json_object_foreach(json_object_get(shutter->doc[0], sections[i]), name, value)
        {
            const json_t *other = json_object_get(closed, name);
            bool lamp = i == 2 && is_lamp(shutter->desc[0], name);
            if (lamp ? shines_differently(value, other) : !json_equal(value, other))
                add(list, sizeof list, sections[i], name);
        }
    }
    if (list[0])
        lf_warnings_add(warnings, where,
                        "what has keys stands still while the shutter is open, but for meshes and "
                        "where faces of lights are: %s",
                        list);
}
