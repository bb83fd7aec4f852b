#include "daemon/stage.h"

#include <string.h>

#include "base/alloc.h"
#include "base/log.h"

static lf_stage *stage_create(const char *file)
{
    lf_stage *stage = lf_calloc(1, sizeof *stage);
    char *copy = lf_strdup(file);
    if (stage == NULL || copy == NULL) {
        lf_free(stage);
        lf_free(copy);
        return NULL;
    }
    atomic_init(&stage->references, 1);
    stage->file = copy;
    strcpy(stage->film.tonemap, "srgb");
    return stage;
}

lf_status lf_stage_from_scene(lf_scene *scene, const char *file, const lf_options *options, const lf_calibration *calibration,
                              lf_stage **out_stage, lf_error *err)
{
    lf_stage *stage = stage_create(file);
    if (stage == NULL) {
        return lf_error_set(err, LF_E_NOMEM, file, "out of memory");
    }
    stage->scene = lf_scene_ref(scene);
    stage->film = *lf_scene_film_settings(scene);
    lf_status status = lf_resolve_view(options, lf_scene_camera(scene), calibration, &stage->settings, &stage->layout, err);
    if (status != LF_OK) {
        lf_stage_unref(stage);
        return status;
    }
    *out_stage = stage;
    return LF_OK;
}

lf_status lf_stage_from_quilt(const char *file, const lf_roots *roots, const lf_options *options, lf_stage **out_stage,
                              lf_error *err)
{
    lf_stage *stage = stage_create(file);
    if (stage == NULL) {
        return lf_error_set(err, LF_E_NOMEM, file, "out of memory");
    }
    lf_status status = lf_quilt_read(file, roots, options->columns, options->rows, &stage->quilt, err);
    if (status != LF_OK) {
        lf_stage_unref(stage);
        return status;
    }
    stage->layout = stage->quilt.layout;
    *out_stage = stage;
    return LF_OK;
}

static bool has_warned(const lf_scene *scene, const char *line)
{
    for (int i = 0; scene != NULL && lf_scene_warning(scene, i) != NULL; i++) {
        if (strcmp(lf_scene_warning(scene, i), line) == 0) {
            return true;
        }
    }
    return false;
}

void lf_log_warnings(const lf_scene *scene, const lf_scene *before)
{
    for (int i = 0; lf_scene_warning(scene, i) != NULL; i++) {
        if (!has_warned(before, lf_scene_warning(scene, i))) {
            lf_log(LF_LOG_WARNING, "%s", lf_scene_warning(scene, i));
        }
    }
}

lf_stage *lf_stage_ref(lf_stage *stage)
{
    atomic_fetch_add_explicit(&stage->references, 1, memory_order_relaxed);
    return stage;
}

void lf_stage_unref(lf_stage *stage)
{
    if (stage == NULL || atomic_fetch_sub_explicit(&stage->references, 1, memory_order_acq_rel) != 1) {
        return;
    }
    if (stage->scene != NULL) {
        lf_scene_unref(stage->scene);
    } else {
        lf_quilt_finish(&stage->quilt);
    }
    lf_free(stage->file);
    lf_free(stage);
}
