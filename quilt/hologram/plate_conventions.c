/* The conventions of a plate in words: members of plate.json and manifest.json. All of them are of
 * the files as written, after flips. */
#include "quilt/hologram/plate.h"

static json_t *flips_json(const lf_plate_flips *flips)
{
    return json_pack("{s:b, s:b, s:b, s:b, s:b, s:s}", "u", flips->u, "v", flips->v, "hx",
                     flips->hx, "hy", flips->hy, "transpose", flips->transpose, "order",
                     "axes are reversed, then transposed; other members are of the files as "
                     "written");
}

static json_t *samples_json(const lf_plate *plate)
{
    const bool is_linear = plate->format == LF_PLATE_EXR || plate->is_grey;
    return json_pack(
        "{s:s, s:i, s:s, s:s, s:s}", "channels", plate->is_grey ? "Y" : "RGB", "bits",
        plate->format == LF_PLATE_PNG ? 8 : 16, "type",
        plate->format == LF_PLATE_EXR ? "half" : "uint", "encoding", is_linear ? "linear" : "sRGB",
        "profile", is_linear ? "linear, primaries of Rec. 709, white D65" : "sRGB (IEC 61966-2-1)");
}

static const char *layout_words(const lf_plate *plate)
{
    const lf_plate_place n = lf_plate_size(plate);
    if (plate->form == LF_PLATE_RAW)
        return "plate.raw: [hy][hx][v][u][channel]";
    if (plate->form == LF_PLATE_HOGELS)
        return "hogels/rHY/cHX: row v, column u";
    if (n.v == 1 || n.u == 1)
        return n.v == 1 ? "views/view_U: row hy, column hx" : "views/view_V: row hy, column hx";
    return "views/rV/cU: row hy, column hx";
}

/* Where an axis of directions leads. */
static const char *across_words(const lf_plate_flips *flips)
{
    return flips->u ? "eyes from right to left" : "eyes from left to right";
}

static const char *down_words(const lf_plate_flips *flips)
{
    return flips->v ? "eyes from bottom to top" : "eyes from top to bottom";
}

static json_t *axes_json(const lf_plate_flips *flips)
{
    return json_pack("{s:s, s:s, s:s, s:s, s:s}", "hx",
                     flips->hx ? "cells from right to left" : "cells from left to right", "hy",
                     flips->hy ? "cells from bottom to top" : "cells from top to bottom", "u",
                     flips->transpose ? down_words(flips) : across_words(flips), "v",
                     flips->transpose ? across_words(flips) : down_words(flips), "seen",
                     "as the viewer sees the plate");
}

/* Rows of eyes: 1 for horizontal parallax only. */
static int rows_of_eyes(const lf_plate *plate)
{
    return plate->camera_is_cell ? plate->height : plate->rows;
}

static json_t *view_0_json(const lf_plate *plate)
{
    const lf_plate_flips *flips = &plate->flips;
    const char *eye = flips->u ? "the rightmost eye" : "the leftmost eye";
    return rows_of_eyes(plate) == 1
               ? json_string(eye)
               : json_sprintf("%s of the %s row", eye, flips->v ? "lowest" : "topmost");
}

/* Where cells and eyes are. */
static json_t *geometry_json(const lf_plate *plate)
{
    const bool is_cell = plate->camera_is_cell;
    const char *cameras = is_cell                  ? "columns are hx, rows are hy"
                          : plate->flips.transpose ? "columns are v, rows are u"
                                                   : "columns are u, rows are v";
    json_t *made = json_pack(
        "{s:s, s:s, s:s}", "cameras", cameras, "centre",
        is_cell ? "the middle of the cameras is the middle of the plate"
                : "the middle of the eyes is straight in front of the middle of the plate",
        "samples", "an index is the middle of its cell and of its direction");
    if (made && is_cell)
        json_object_set_new(made, "fov",
                            json_string("from edge to edge of the picture of a cell, in equal "
                                        "steps of the tangent"));
    if (made && !is_cell && plate->rows == 1)
        json_object_set_new(made, "vertical",
                            json_string("all cells are seen from the height of the plate's middle, "
                                        "at the distance of the eyes"));
    return made;
}

json_t *lf_plate_describe(const lf_plate *plate, const json_t *facts)
{
    const lf_plate_place n = lf_plate_size(plate);
    json_t *made = json_pack(
        "{s:i, s:s, s:s, s:s, s:s, s:[i,i], s:[i,i], s:o, s:o, s:o, s:o, s:o, s:s}",
        "quiltd_hologram", 1, "conventions", "docs/reference/holograms.md", "kind",
        plate->camera_is_cell ? "H" : "V", "form", lf_plate_forms[plate->form], "parallax",
        rows_of_eyes(plate) == 1 ? "hpo" : "full", "hogels", n.hx, n.hy, "directions", n.u, n.v,
        "flips", flips_json(&plate->flips), "axes", axes_json(&plate->flips), "view_0",
        view_0_json(plate), "geometry", geometry_json(plate), "samples", samples_json(plate),
        "layout", layout_words(plate));
    json_t *known = json_deep_copy(facts);
    if (!made || !known || json_object_update(made, known) != 0) {
        json_decref(made);
        made = NULL;
    }
    json_decref(known);
    return made;
}
