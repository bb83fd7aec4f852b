/* Checks another frame of a scene, without loading it. */
#include <errno.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/file.h"
#include "render/import/scene/frame_hold.h"
#include "render/import/scene/keyframes.h"
#include "render/render.h"

static void check_file(lf_reader *reader, const lf_node *volumes, const lf_volume_desc *desc,
                       const char *folder)
{
    const lf_node volume = lf_node_child(volumes, desc->name), at = lf_node_child(&volume, "file");
    char *path = desc->file && !desc->absent ? lf_path_join(folder, desc->file) : NULL;
    lf_error err;
    if (path && access(path, R_OK) != 0) {
        (void)lf_error_set(&err, LF_E_IO, path, "cannot open: %s", lf_errno_text(errno));
        lf_read_fail_with(reader, &at, &err);
    }
    lf_free(path);
}

lf_status lf_scene_check_frame(const lf_scene *scene, int frame, lf_error *err)
{
    lf_reader reader = {scene->file.where, NULL, 0, LF_OK, err, NULL, 0, false};
    lf_node root = {NULL, NULL, 0, scene->json};
    lf_scene_desc desc = {0};
    bool keyed;
    json_t *still = lf_keyframes_still(&reader, &root, frame, &keyed);
    if (!still)
        return reader.status;
    root.value = still;
    lf_scene_parse(&reader, &root, &desc);
    if (reader.status == LF_OK && !lf_hold_frames(&desc, scene->file.folder, NULL))
        reader.status = lf_error_set(err, LF_E_NOMEM, scene->file.where, "out of memory");
    const lf_node volumes = lf_node_child(&root, "volumes");
    for (int i = 0; i < desc.n_volumes && reader.status == LF_OK; i++)
        check_file(&reader, &volumes, &desc.volumes[i], scene->file.folder);
    lf_scene_desc_finish(&desc);
    json_decref(still);
    return reader.status;
}
