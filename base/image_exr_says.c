/* Reads attributes of OpenEXR's ImfStandardAttributes.h, and a few of other programs about the
 * meaning of pixels: names of colour spaces (colorInteropID of the Color Interop Forum,
 * OpenImageIO's oiio:ColorSpace) and OpenImageIO's Orientation. */
#include <stdio.h>
#include <string.h>

#include <math.h>

#include "base/image_exr.h"

/* ACES2065-1 and ACEScg (SMPTE ST 2065-1, S-2014-004), Rec. ITU-R BT.2020, SMPTE RP 431-2 with D65,
 * Adobe RGB (1998). */
static const lf_chromaticities ap0 = {
    {0.7347, 0.2653}, {0, 1}, {0.0001, -0.0770}, {0.32168, 0.33767}};
static const lf_chromaticities ap1 = {
    {0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, {0.32168, 0.33767}};
static const lf_chromaticities rec2020 = {
    {0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, {0.3127, 0.3290}};
static const lf_chromaticities p3 = {
    {0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, {0.3127, 0.3290}};
static const lf_chromaticities adobe = {{0.64, 0.33}, {0.21, 0.71}, {0.15, 0.06}, {0.3127, 0.3290}};

static const struct {
    const char *name;
    const lf_chromaticities *space; /* NULL: no information */
} spaces[] = {
    {"lin_rec709_scene", &lf_rec709},
    {"lin_ap1_scene", &ap1},
    {"lin_ap0_scene", &ap0},
    {"lin_rec2020_scene", &rec2020},
    {"lin_p3d65_scene", &p3},
    {"lin_adobergb_scene", &adobe},
    {"lin_ciexyzd65_scene", &lf_xyz}, /* with D65 as neutral */
    {"unknown", NULL},
    /* names of OpenImageIO */
    {"lin_rec709", &lf_rec709},
    {"lin_srgb", &lf_rec709},
    {"Linear", &lf_rec709},
    {"linear", &lf_rec709},
    {"scene_linear", &lf_rec709},
    {"lin_ap1", &ap1},
    {"ACEScg", &ap1},
    {"lin_ap0", &ap0},
    {"ACES2065-1", &ap0},
    {"lin_rec2020", &rec2020},
    {"lin_p3d65", &p3},
    {"lin_adobergb", &adobe},
};

static lf_image_notes *notes_of(const lf_exr_input *in)
{
    return in->session->source->meta ? &in->session->source->meta->notes : NULL;
}

/* NULL: no attribute of this name and type. */
static const exr_attribute_t *find(const lf_exr_input *in, const char *name,
                                   exr_attribute_type_t type)
{
    const exr_attribute_t *attribute = NULL;
    if (exr_get_attribute_by_name(in->exr, in->part, name, &attribute) != EXR_ERR_SUCCESS ||
        !attribute)
        return NULL;
    if (attribute->type == type)
        return attribute;
    lf_image_note(notes_of(in), "ignored %s, which has the unexpected type %s", name,
                  attribute->type_name);
    return NULL;
}

static const char *find_text(const lf_exr_input *in, const char *name)
{
    const exr_attribute_t *attribute = find(in, name, EXR_ATTR_STRING);
    return attribute ? attribute->string->str : NULL;
}

/* ----------------------------------------------------------------------------------- colours -- */

/* The colour space of a name attribute. Names of other than linear spaces are noted. NULL: no
 * usable information. */
static const lf_chromaticities *space_of(const lf_exr_input *in, const char *attribute)
{
    const char *name = find_text(in, attribute);
    for (size_t i = 0; name && i < sizeof spaces / sizeof *spaces; i++)
        if (strcmp(spaces[i].name, name) == 0)
            return spaces[i].space;
    if (name)
        lf_image_note(notes_of(in), "unknown %s \"%.60s\"; the values are read as linear light",
                      attribute, name);
    return NULL;
}

/* The space given by a name or flag, for files without chromaticities. */
static const lf_chromaticities *named_space(const lf_exr_input *in)
{
    const lf_chromaticities *id = space_of(in, "colorInteropID"),
                            *other = space_of(in, "oiio:ColorSpace");
    const exr_attribute_t *aces = find(in, "acesImageContainerFlag", EXR_ATTR_INT);
    if (id)
        return id;
    return aces && aces->i == 1 ? &ap0 : other;
}

static const lf_chromaticities *stated(const lf_exr_input *in, lf_chromaticities *room)
{
    const exr_attribute_t *attribute = find(in, "chromaticities", EXR_ATTR_CHROMATICITIES);
    if (!attribute)
        return NULL;
    exr_attr_chromaticities_t c;
    memcpy(&c, attribute->chromaticities, sizeof c);
    *room = (lf_chromaticities){{(double)c.red_x, (double)c.red_y},
                                {(double)c.green_x, (double)c.green_y},
                                {(double)c.blue_x, (double)c.blue_y},
                                {(double)c.white_x, (double)c.white_y}};
    return room;
}

static void read_colours(lf_exr_input *in)
{
    lf_chromaticities room;
    const lf_chromaticities *named = named_space(in), *given = stated(in, &room);
    const lf_chromaticities *c = given ? given : named ? named : &lf_rec709;
    const exr_attribute_t *attribute = find(in, "adoptedNeutral", EXR_ATTR_V2F);
    const double *neutral = c == &lf_xyz ? lf_rec709.white : NULL;
    double adopted[2];
    if (attribute) {
        exr_attr_v2f_t v;
        memcpy(&v, attribute->v2f, sizeof v);
        adopted[0] = (double)v.x;
        adopted[1] = (double)v.y;
        neutral = adopted;
    }
    if (lf_colours_from(c, neutral, &in->colours) == LF_OK) {
        /* grey is white already */
        if (in->grey && !in->chroma && !neutral)
            in->colours.converts = false;
        return;
    }
    if (attribute && lf_colours_from(c, NULL, &in->colours) == LF_OK)
        lf_image_note(notes_of(in), "ignored adoptedNeutral (%g, %g), which is not a valid colour",
                      adopted[0], adopted[1]);
    else
        lf_image_note(notes_of(in), "the chromaticities are degenerate; Rec. 709 is used");
}

/* ------------------------------------------------------------------------------------ layout -- */

/* In ImfEnvmap.h the data window covers the sphere. */
static void read_layout(lf_exr_input *in)
{
    const exr_attribute_t *envmap = find(in, "envmap", EXR_ATTR_ENVMAP);
    if (!envmap)
        return;
    int64_t width = (int64_t)in->data.max.x - in->data.min.x + 1,
            height = (int64_t)in->data.max.y - in->data.min.y + 1;
    in->display = in->data;
    if (envmap->uc > EXR_ENVMAP_CUBE)
        lf_image_note(notes_of(in),
                      "unknown envmap type %u; the image is read as latitude-longitude",
                      envmap->uc);
    else if (envmap->uc == EXR_ENVMAP_CUBE && 6 * width != height)
        lf_image_note(notes_of(in),
                      "envmap is a cube, but %lldx%lld pixels are not six squares; the image is "
                      "read as latitude-longitude",
                      (long long)width, (long long)height);
    else if (envmap->uc == EXR_ENVMAP_CUBE && in->session->source->meta)
        in->session->source->meta->layout = LF_IMAGE_CUBE;
}

static void note_windows(const lf_exr_input *in)
{
    if (in->data.min.x > in->display.max.x || in->data.max.x < in->display.min.x ||
        in->data.min.y > in->display.max.y || in->data.max.y < in->display.min.y)
        lf_image_note(notes_of(in),
                      "the data window is outside the display window; the image is black");
}

/* -------------------------------------------------------------------------- what is not used -- */

static void note_numbers(const lf_exr_input *in)
{
    const exr_attribute_t *luminance = find(in, "whiteLuminance", EXR_ATTR_FLOAT),
                          *turn = find(in, "Orientation", EXR_ATTR_INT);
    float aspect = 1;
    if (in->session->source->meta &&
        exr_get_pixel_aspect_ratio(in->exr, in->part, &aspect) == EXR_ERR_SUCCESS)
        lf_image_metadata_aspect(in->session->source->meta, "pixelAspectRatio", (double)aspect);
    if (luminance)
        lf_image_note(notes_of(in), "ignored whiteLuminance %g; the value 1 stays 1",
                      (double)luminance->f);
    if (turn && turn->i != 1)
        lf_image_note(notes_of(in), "ignored Orientation %d; the image is not rotated", turn->i);
}

static void note_texts(const lf_exr_input *in)
{
    static const char *const transforms[] = {"renderingTransform", "lookModTransform"};
    for (size_t i = 0; i < sizeof transforms / sizeof *transforms; i++) {
        const char *name = find_text(in, transforms[i]);
        if (name)
            lf_image_note(notes_of(in), "%s \"%.60s\" is not applied", transforms[i], name);
    }
    const exr_attribute_t *views = find(in, "multiView", EXR_ATTR_STRING_VECTOR);
    char list[200] = "";
    for (int i = 1; views && i < views->stringvector->n_strings; i++)
        lf_exr_list(list, sizeof list, views->stringvector->strings[i].str);
    if (list[0])
        lf_image_note(notes_of(in), "ignored views: %s", list);
}

void lf_exr_read_attributes(lf_exr_input *in)
{
    read_colours(in);
    read_layout(in);
    note_windows(in);
    note_numbers(in);
    note_texts(in);
    in->session->message[0] = 0;
}
