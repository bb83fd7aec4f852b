#include "daemon/web/panel_info.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "quilt/quilt.h"

/* What programs call a model, by the start of its serial number, or by its pixels. */
static const struct model {
    const char *serial;
    int width_px, height_px;
    const char *version; /* hardwareVersion */
    const char *preset;  /* of its quilt (quilt.h) */
} models[] = {
    {"LKG-2K", 2560, 1600, "standard", "8.9"},  {"LKG-4K", 3840, 2160, "large", "15.6"},
    {"LKG-8K", 7680, 4320, "8k", "8k"},         {"LKG-P", 1536, 2048, "portrait", "portrait"},
    {"LKG-A", 3840, 2160, "4k_gen2", "15.6"},   {"LKG-B", 7680, 4320, "8k", "8k"},
    {"LKG-D", 7680, 4320, "65_gen2", "65"},     {"LKG-E", 1440, 2560, "go_p", "go"},
    {"LKG-F", 1536, 2048, "portrait", "kiosk"}, {"LKG-H", 2160, 3840, "16_gen3_p", "16p"},
    {"LKG-J", 3840, 2160, "16_gen3_l", "16l"},  {"LKG-K", 4320, 7680, "32_gen3_p", "32p"},
    {"LKG-L", 7680, 4320, "32_gen3_l", "32l"},
};

enum { N_MODELS = sizeof models / sizeof models[0] };

static double number(const json_t *object, const char *key)
{
    return json_number_value(json_object_get(object, key));
}

/* The first of a size is the one that is known best. NULL: a panel of another size. */
static const struct model *find_model(const char *serial, double width, double height)
{
    for (int i = 0; i < N_MODELS; i++)
        if (strncasecmp(models[i].serial, serial, strlen(models[i].serial)) == 0)
            return &models[i];
    for (int i = 0; i < N_MODELS; i++)
        if (models[i].width_px == width && models[i].height_px == height)
            return &models[i];
    return NULL;
}

static json_t *wrapped(const json_t *calibration, const char *key)
{
    json_t *value = json_object_get(calibration, key);
    return json_pack("{s:o}", "value",
                     json_is_number(value) ? json_incref(value) : json_integer(0));
}

static json_t *make_calibration(const json_t *from, const char *serial)
{
    static const char *const keys[] = {
        "pitch",    "slope",         "center",  "viewCone",       "invView",
        "DPI",      "screenW",       "screenH", "flipImageX",     "flipImageY",
        "flipSubp", "verticalAngle", "fringe",  "CellPatternMode"};
    const char *version = json_string_value(json_object_get(from, "configVersion"));
    json_t *cells = json_object_get(from, "subpixelCells");
    json_t *made = json_pack("{s:s, s:s}", "configVersion", version && *version ? version : "3.0",
                             "serial", serial);
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++)
        if (json_object_set_new(made, keys[i], wrapped(from, keys[i])) != 0) {
            json_decref(made);
            return NULL;
        }
    if (json_array_size(cells) > 0)
        json_object_set(made, "subpixelCells", cells);
    return made;
}

/* A panel of no known model has the quilt of a Portrait, with its own aspect. */
static json_t *make_quilt(const json_t *calibration, const struct model *model)
{
    const json_t *own = json_object_get(calibration, "defaultQuilt");
    const double aspect = number(calibration, "screenW") / number(calibration, "screenH");
    const lf_preset *preset = NULL;
    if (own)
        return json_pack("{s:I, s:I, s:I, s:I, s:f}", "quiltX", (json_int_t)number(own, "quiltX"),
                         "quiltY", (json_int_t)number(own, "quiltY"), "tileX",
                         (json_int_t)number(own, "tileX"), "tileY",
                         (json_int_t)number(own, "tileY"), "quiltAspect", aspect);
    if (lf_preset_find(model ? model->preset : "portrait", &preset, NULL) != LF_OK)
        return NULL;
    const lf_layout *layout = &preset->layout;
    return json_pack("{s:i, s:i, s:i, s:i, s:f}", "quiltX", layout->columns * layout->view_width,
                     "quiltY", layout->rows * layout->view_height, "tileX", layout->columns,
                     "tileY", layout->rows, "quiltAspect", aspect);
}

json_t *lf_panel_info(const json_t *calibration, const json_t *device)
{
    const char *serial = json_string_value(json_object_get(calibration, "serial"));
    const double width = number(calibration, "screenW"), height = number(calibration, "screenH");
    char hwid[80];
    if (width < 1 || height < 1 || !json_is_true(json_object_get(device, "present")))
        return NULL;
    serial = serial ? serial : "";
    const struct model *model = find_model(serial, width, height);
    snprintf(hwid, sizeof hwid, "%s%s", strncmp(serial, "LKG", 3) == 0 ? "" : "LKG-", serial);
    return json_pack("{s:s, s:s, s:s, s:i, s:i, s:i, s:[i,i,i,i], s:[i,i], s:o, s:o}", "hwid", hwid,
                     "state", "ok", "hardwareVersion", model ? model->version : "standard", "index",
                     0, "unityIndex", 1, "joystickIndex", -1, "buttons", 0, 0, 0, 0, "windowCoords",
                     0, 0, "calibration", make_calibration(calibration, serial), "defaultQuilt",
                     make_quilt(calibration, model));
}
