#include "render/load/frame_file.h"

#include <errno.h>
#include <math.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/file.h"
#include "base/frame_name.h"
#include "render/scene/scene.h"

/* 0.29 * 100 is less than 29. */
#define ROUNDING 1e-6

char *lf_frame_file(lf_reader *reader, const lf_node *node, const char *file, int frame)
{
    static const char *const keys[] = {"first", "step", NULL};
    const lf_node sequence = lf_node_child(node, "sequence");
    bool stated = lf_read_object(reader, &sequence, keys), varies = lf_frame_name_varies(file);
    int first = lf_read_int(reader, &sequence, "first", 1, 0, LF_MAX_FRAME);
    double step = lf_read_number(reader, &sequence, "step", 1, -1000, 1000),
           number = varies ? floor(first + (frame - 1) * step + ROUNDING) : 0;
    if (stated && !varies)
        lf_read_fail(reader, &sequence,
                     "the file's name has no place for a number, such as %%04d: %s", file);
    else if (number < 0 || number > INT32_MAX)
        lf_read_fail(reader, node, "in frame %d the file's number would be %.0f", frame, number);
    if (reader->status != LF_OK)
        return NULL;
    char *name = lf_frame_name(file, (int)number);
    if (!name)
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
    return name;
}

bool lf_scene_has_frames(const lf_scene *scene)
{
    const char *name;
    json_t *volume;
    json_object_foreach(json_object_get(scene->json, "volumes"), name, volume)
    {
        const char *file = json_string_value(json_object_get(volume, "file"));
        if (file && lf_frame_name_varies(file))
            return true;
    }
    return false;
}

static void check_file(lf_reader *reader, const lf_node *volume, const char *folder, int frame)
{
    const lf_node at = lf_node_child(volume, "file");
    const char *file = json_string_value(at.value);
    char *name = file ? lf_frame_file(reader, volume, file, frame) : NULL,
         *path = name ? lf_path_join(folder, name) : NULL;
    lf_error err;
    if (path && access(path, R_OK) != 0) {
        (void)lf_error_set(&err, LF_E_IO, path, "cannot open: %s", lf_errno_text(errno));
        lf_read_fail_with(reader, &at, &err);
    }
    lf_free(path);
    lf_free(name);
}

lf_status lf_scene_check_frame(const lf_scene *scene, int frame, lf_error *err)
{
    lf_reader reader = {scene->file.where, NULL, 0, LF_OK, err, NULL, 0};
    const lf_node root = {NULL, NULL, 0, scene->json}, volumes = lf_node_child(&root, "volumes");
    const char *name;
    json_t *value;
    json_object_foreach(volumes.value, name, value)
    {
        const lf_node volume = lf_node_child(&volumes, name);
        check_file(&reader, &volume, scene->file.folder, frame);
    }
    return reader.status;
}
