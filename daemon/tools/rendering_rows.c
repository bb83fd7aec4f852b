/* A row of a camera grid as the light field of a job: --camera-rows. */
#include "daemon/tools/rendering.h"

/* Checks that a camera, of the scene or the print, has all rows of --camera-rows. */
static lf_status check_rows(const lf_rendering *r, const lf_camera *camera, lf_error *err)
{
    const bool of_print = r->arguments->kind->check_print;
    const char *of = of_print ? "print" : "scene";
    if (camera->n_rows == 0)
        return lf_error_set(err, LF_E_ARG, "--camera-rows", "the %s has no camera grid; %s", of,
                            of_print ? "add --lens-grid" : "set camera.views");
    if (r->arguments->frames.last < camera->n_rows)
        return LF_OK;
    return lf_error_set(err, LF_E_ARG, "--camera-rows",
                        "the %s has a %s of %d x %d cameras; expected rows within 0:%d", of,
                        camera->has_parts ? "track" : "grid", camera->n_views, camera->n_rows,
                        camera->n_rows - 1);
}

bool lf_rendering_is_print_row(const lf_rendering *r)
{
    const lf_render_arguments *a = r->arguments;
    return a->frames.of_rows && a->kind->check_print && lf_state_is_all(&a->state);
}

lf_status lf_rendering_scene_row(const lf_rendering *r, lf_camera *out, lf_error *err)
{
    const lf_camera *camera = lf_scene_camera(r->scene);
    const lf_options *o = &r->arguments->options;
    const lf_output_kind *kind = r->arguments->kind;
    if (kind->needs_panel || kind->check_print)
        return lf_error_set(err, LF_E_ARG, "--camera-rows",
                            "cannot be combined with --%s, which defines its own cameras",
                            kind->option);
    const bool one = r->sequence.plate && camera->n_rows == 0; /* a plate of one row */
    if (one && r->arguments->frames.last > 0)
        return lf_error_set(err, LF_E_ARG, "--camera-rows",
                            "the plate has one row of cameras; expected 0:0");
    if (!one && check_rows(r, camera, err) != LF_OK)
        return LF_E_ARG;
    const bool own_views = one || r->arguments->hologram.options.preset;
    if ((o->views > 0 && !own_views) || o->preset)
        return lf_error_set(err, LF_E_ARG, o->preset ? "--preset" : "--views",
                            "cannot be combined with --%s, because the scene defines the rows",
                            r->sequence.plate ? "hologram" : "camera-rows");
    *out = *camera;
    if (!one)
        lf_camera_deepen(out); /* the whole grid, as without --camera-rows */
    *out = lf_camera_row(out, r->sequence.frame);
    return LF_OK;
}

lf_status lf_rendering_print_row(lf_rendering *r, lf_error *err)
{
    const lf_status status = check_rows(r, &r->settings.camera, err);
    if (status == LF_OK)
        r->settings.camera = lf_camera_row(&r->settings.camera, r->sequence.frame);
    return status;
}
