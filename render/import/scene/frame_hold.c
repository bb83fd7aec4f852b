#include "render/import/scene/frame_hold.h"

#include "base/alloc.h"

static bool hold(lf_scene_desc *desc, lf_volume_desc *volume, const char *folder,
                 const lf_roots *roots)
{
    char *held = lf_frame_held(&volume->frame, folder, roots);
    if (!held)
        return true;
    char *lacks = lf_path_join(folder, volume->file);
    const bool done = lacks;
    if (done && volume->frame.hole == LF_HOLE_EMPTY)
        lf_warnings_add(&desc->warnings, lacks,
                        "the file is missing; volume \"%s\" is empty in frame %d", volume->name,
                        desc->frame);
    else if (done)
        lf_warnings_add(&desc->warnings, lacks,
                        "the file is missing; frame %d shows %s instead (set \"missing\" in the "
                        "volume's \"sequence\" to \"empty\" or \"error\" to change this)",
                        desc->frame, held);
    lf_free(lacks);
    if (volume->frame.hole == LF_HOLE_EMPTY) {
        volume->absent = true;
        lf_free(held);
    } else {
        lf_free(volume->file);
        volume->file = held;
    }
    return done;
}

bool lf_hold_frames(lf_scene_desc *desc, const char *folder, const lf_roots *roots)
{
    bool done = true;
    for (int i = 0; i < desc->n_volumes && done; i++)
        if (desc->volumes[i].frame.hole != LF_HOLE_ERROR)
            done = hold(desc, &desc->volumes[i], folder, roots);
    return done;
}
