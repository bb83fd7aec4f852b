/* Rigs of printers and services of holograms. None of them publishes a file format: numbers of
 * views and angles are what is known. */
#include <math.h>
#include <string.h>

#include "daemon/output/hologram.h"

/* litiholo: the published specification as read by github.com/Flux-Frontiers/quiltwright
 * (docs/lfd.md): horizontal parallax, 23 views over 45 degrees, 4x5 inch, hogels of 1 mm; that
 * program sends 1600x2000 pixels. track: rabbitholes.com, "rendering & printing a hologram": a
 * camera on a straight track, up to 1280 frames; the angle is the scene's, 768 rows are ours. */
static const lf_hologram_preset presets[] = {
    {.name = "litiholo",
     .what = "23 views, 45 degrees, 4x5 in, nominal",
     .views = 23,
     .width = 1600,
     .height = 2000,
     .cone = 45,
     .pitch_mm = 1,
     .note = "nominal, not tried on a printer: the pixels of a view and the shifted windows of "
             "cameras are not published; hogels of 1 mm are",
     .width_mm = 101.6,
     .height_mm = 127},
    {.name = "track",
     .what = "1280 frames on a straight track, nominal",
     .views = 1280,
     .height = 768,
     .on_track = true,
     .note = "nominal, not tried on a printer: the height of a frame is not published"},
};

const lf_hologram_preset *lf_hologram_preset_at(int index)
{
    return index < (int)(sizeof presets / sizeof presets[0]) ? &presets[index] : NULL;
}

const lf_hologram_preset *lf_hologram_preset_of(const lf_hologram_options *options)
{
    const lf_hologram_preset *preset = NULL;
    for (int i = 0; options->preset && (preset = lf_hologram_preset_at(i)); i++)
        if (strcmp(preset->name, options->preset) == 0)
            return preset;
    return NULL;
}

void lf_hologram_complete(lf_hologram_options *options)
{
    const lf_hologram_preset *preset = lf_hologram_preset_of(options);
    if (!preset || options->width_mm > 0)
        return;
    options->width_mm = preset->width_mm;
    options->height_mm = preset->height_mm;
}

/* The members of the camera that place the preset's views. */
static json_t *rig_of(const lf_hologram_preset *preset, const lf_camera *camera, int views)
{
    const double *p = camera->position, *t = camera->target;
    const double distance = sqrt((t[0] - p[0]) * (t[0] - p[0]) + (t[1] - p[1]) * (t[1] - p[1]) +
                                 (t[2] - p[2]) * (t[2] - p[2]));
    const double cone = preset->cone > 0 ? preset->cone : camera->cone * (180 / M_PI);
    if (preset->on_track)
        return json_pack("{s:{s:{s:i, s:f, s:s}}}", "views", "track", "count", views, "length",
                         2 * distance * tan(0.5 * cone * (M_PI / 180)), "window", "shared");
    json_t *rig =
        json_pack("{s:i, s:f, s:s}", "views", views, "cone", cone, "placement", "inclusive");
    if (preset->cone > 0) /* the printer's angle, whatever the scene's depthiness */
        json_object_set_new(rig, "depthiness", json_integer(1));
    return rig;
}

lf_status lf_hologram_patch(const lf_hologram_options *options, const lf_camera *camera, int views,
                            json_t **out_patch, lf_error *err)
{
    const lf_hologram_preset *preset = lf_hologram_preset_of(options);
    const bool is_cell = !preset && camera->track > 0 && camera->own_windows;
    *out_patch = NULL;
    if (camera->list)
        return lf_error_set(err, LF_E_ARG, "--hologram",
                            "cameras listed one by one do not form a plate; use an arc, a track or "
                            "a grid of cameras");
    json_t *rig =
        preset ? rig_of(preset, camera, views > 0 ? views : preset->views) : json_object();
    if (options->width_mm > 0 && !is_cell)
        json_object_set_new(rig, "aspect", json_real(options->width_mm / options->height_mm));
    if (json_object_size(rig) > 0)
        *out_patch = json_pack("{s:o}", "camera", rig);
    else
        json_decref(rig);
    return LF_OK;
}
