#include "render/import/scene/shutter.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "render/import/scene/keyframes.h"

/* One end, `frames` frames from the frame; root.value becomes its document. */
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

void lf_shutter_shift(const lf_camera ends[2], lf_camera *camera)
{
    for (int end = 0; end < 2; end++) {
        const lf_camera *then = &ends[end];
        lf_camera_shift *shift = &camera->shift[end];
        for (int i = 0; i < 3; i++) {
            shift->position[i] = then->position[i] - camera->position[i];
            shift->target[i] = then->target[i] - camera->target[i];
        }
        shift->focus_distance = then->focus_distance - camera->focus_distance;
    }
    camera->moves = memcmp(&camera->shift[0], &camera->shift[1], sizeof camera->shift[0]) != 0;
    if (!camera->moves)
        memset(camera->shift, 0, sizeof camera->shift);
}

bool lf_shutter_light(const lf_value open[], const lf_value close[], const double origin[3],
                      lf_light *light)
{
    int n = 0;
    bool same = true;
    for (; light->kind->keys[n].name; n++)
        same = same && memcmp(open[n].number, close[n].number, sizeof open[n].number) == 0;
    if (same)
        return true;
    light->motion = lf_calloc(1, sizeof *light->motion);
    if (!light->motion)
        return false;
    for (int k = 0; k < n; k++) {
        light->motion->open[k] = open[k];
        light->motion->close[k] = close[k];
        light->motion->open[k].text = light->motion->close[k].text = NULL; /* the document's */
    }
    lf_light_move(light, origin, 0.5);
    return true;
}

/* ---------------------------------------------------------------------------------- warnings -- */

/* Adds a name to the list of static objects. */
static void add(char *list, size_t size, const char *section, const char *name)
{
    size_t at = strlen(list);
    snprintf(list + at, size - at, "%s%s%s%s", at ? ", " : "", section, name ? "." : "",
             name ? name : "");
}

/* Lights that are faces are meshes. */
static bool is_area_light(const lf_scene_desc *desc, const char *name)
{
    bool found = false;
    for (int i = 0; i < desc->n_meshes; i++)
        found = found || (desc->meshes[i].lamp && strcmp(desc->meshes[i].name, name) == 0);
    return found;
}

/* Whether objects differ in a member that is none of these (ended by NULL). */
static bool differ_but_for(json_t *a, const json_t *b, const char *const *moving)
{
    const char *key;
    json_t *value;
    json_object_foreach(a, key, value)
    {
        int i = 0;
        while (moving[i] && strcmp(moving[i], key) != 0)
            i++;
        if (!moving[i] && !json_equal(value, json_object_get(b, key)))
            return true;
    }
    return false;
}

/* A sky that is painted for the frame. */
static bool is_sky(const json_t *light)
{
    const char *type = json_string_value(json_object_get(light, "type"));
    return type && strcmp(type, lf_light_sky.name) == 0;
}

/* Moving keys of a light, NULL: all. */
static const char *const *moving_of_light(const lf_scene_desc *desc, const char *name,
                                          const json_t *light)
{
    static const char *const lamps[] = {"position", "direction", "rotate", "width",
                                        "height",   "radius",    NULL},
                             *const skies[] = {"azimuth", "scale", NULL};
    return is_area_light(desc, name) ? lamps : is_sky(light) ? skies : NULL;
}

/* Moving keys of a section's objects, and of the camera. */
static const char *const *moving_of(const char *section)
{
    static const char *const camera[] = {"position", "target", "focus_distance", NULL},
                             *const volumes[] = {"transform", NULL}, *const nothing[] = {NULL};
    if (strcmp(section, "camera") == 0)
        return camera;
    return strcmp(section, "volumes") == 0 ? volumes : nothing;
}

void lf_shutter_warn(const lf_shutter *shutter, const char *where, lf_warnings *warnings)
{
    static const char *const sections[] = {"volumes", "materials", "lights"};
    static const char *const wholes[] = {"camera", "backdrop", "film"};
    char list[512] = "";
    if (json_equal(shutter->doc[0], shutter->doc[1]))
        return;
    for (int i = 0; i < 3; i++) {
        json_t *open = json_object_get(shutter->doc[0], wholes[i]),
               *close = json_object_get(shutter->doc[1], wholes[i]);
        bool differ = json_is_object(open) ? differ_but_for(open, close, moving_of(wholes[i]))
                                           : open && !json_equal(open, close);
        if (differ)
            add(list, sizeof list, wholes[i], NULL);
    }
    for (int i = 0; i < 3; i++) {
        const json_t *closed = json_object_get(shutter->doc[1], sections[i]);
        const char *name;
        json_t *value;
        json_object_foreach(json_object_get(shutter->doc[0], sections[i]), name, value)
        {
            const char *const *moving =
                i == 2 ? moving_of_light(shutter->desc[0], name, value) : moving_of(sections[i]);
            if (moving && differ_but_for(value, json_object_get(closed, name), moving))
                add(list, sizeof list, sections[i], name);
        }
    }
    if (list[0])
        lf_warnings_add(
            warnings, where,
            "keyframes without motion blur while the shutter is open (only meshes, lights, "
            "positions of volumes, and the camera's position, target and focus have it): %s",
            list);
}
