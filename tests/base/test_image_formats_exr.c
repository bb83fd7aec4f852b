/* Everything that an OpenEXR file can say of its picture: docs/reference/formats/images.md, row by
 * row. */
#include "tests/base/exr_bytes.h"
#include "tests/base/image_metadata.h"
#include "tests/formats.h"

static char *folder;

#define RGB_CHANNELS                                                                               \
    {                                                                                              \
        "B", "G", "R"                                                                              \
    }
/* of the pixels of most files here */
#define PLAIN                                                                                      \
    {                                                                                              \
        0.1f, 0.1f, 0.8f                                                                           \
    }
static const double plain[3] = {0.8, 0.1, 0.1};

static const char *file(void)
{
    return lf_test_path(folder, "a.exr");
}

static lf_image32 load(const exr_part_bytes *parts, int n, const char *told)
{
    lf_image_metadata meta;
    exr_write(file(), parts, n);
    lf_image32 image = lf_picture_metadata(file(), &meta);
    lf_metadata_notes(&meta, told);
    return image;
}

static void expect(const exr_part_bytes *parts, int n, const char *told, const double rgb[3],
                   double tolerance)
{
    lf_image32 image = load(parts, n, told);
    lf_pixel_is(&image, 1, 1, rgb, tolerance);
    lf_image32_finish(&image);
}

/* -------------------------------------------------------------------------------- attributes -- */

/* A file with this attribute, what its pixels become and the word that is told. */
typedef struct attribute_case {
    const char *type;
    const void *data;
    int size;
    double rgb[3]; /* all 0: they stay */
    const char *told;
} attribute_case;

#define TEXT(words) "string", words, sizeof words - 1
#define DATA(type, ...) type, __VA_ARGS__, sizeof __VA_ARGS__

static void attribute(const lf_format_row *row)
{
    const attribute_case *c = row->with;
    const exr_part_bytes part = {.channels = RGB_CHANNELS,
                                 .value = PLAIN,
                                 .type = EXR_FLOAT,
                                 .attributes = {{row->name, c->type, c->data, c->size}}};
    bool stays = c->rgb[0] == 0 && c->rgb[1] == 0 && c->rgb[2] == 0;
    assert_int_equal(strcmp(row->verdict, "warned") == 0, !!c->told);
    assert_int_equal(strcmp(row->verdict, "used") == 0, !stays);
    lf_image32 image = load(&part, 1, c->told);
    const float bits[3] = {0.8f, 0.1f, 0.1f};
    if (stays)
        assert_memory_equal(image.data, bits, sizeof bits);
    else
        lf_pixel_is(&image, 1, 1, c->rgb, 2e-4);
    lf_image32_finish(&image);
}

/* Rec. ITU-R BT.2020, whose matrix to BT.709 BT.2087 has: 1.6605 -0.5876 -0.0728, -0.1246 1.1329
 * -0.0083, -0.0182 -0.1006 1.1187. */
static const float rec2020[8] = {0.708f, 0.292f, 0.17f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.329f};
static const attribute_case chromaticities = {
    DATA("chromaticities", rec2020), {1.26234, 0.01282, 0.08729}, NULL};
/* what has the chromaticity of the adopted neutral becomes neutral: plain is 0.8 0.1 0.1 */
static const float neutral[2] = {0.508235f, 0.329597f};
static const attribute_case adopted_neutral = {
    DATA("v2f", neutral), {0.24885, 0.24885, 0.24885}, NULL};
/* AP0: 2.52169 -1.13413 -0.38756, -0.27648 1.37272 -0.09624, -0.01538 -0.15298 1.16835 */
static const int32_t one[1] = {1};
static const attribute_case aces = {DATA("int", one), {1.86518, -0.09354, 0.08923}, NULL};
/* AP1: 1.70505 -0.62179 -0.08326, -0.13026 1.14080 -0.01055, -0.02400 -0.12897 1.15297 */
static const attribute_case interop = {TEXT("lin_ap1_scene"), {1.29354, 0.00882, 0.0832}, NULL};
/* P3: 1.2249 -0.2247 0, -0.0420 1.0419 0, -0.0197 -0.0786 1.0979 */
static const attribute_case oiio = {TEXT("lin_p3d65"), {0.95746, 0.07056, 0.08625}, NULL};

static const float luminance[1] = {621}, aspect[1] = {2}, number[1] = {3}, world[16] = {1},
                   point[2] = {3, 4};
static const int32_t turned[1] = {6}, box[4] = {0, 0, 99, 99}, fraction[2] = {24, 1},
                     keycode[7] = {1, 2, 3, 4, 5, 6, 7}, timecode[2] = {1, 2};
static const unsigned char preview[12] = {1, 0, 0, 0, 1, 0, 0, 0, 255, 0, 0, 255};
static const attribute_case white_luminance = {DATA("float", luminance), {0}, "whiteLuminance"};
static const attribute_case pixel_aspect = {DATA("float", aspect), {0}, NULL};
static const attribute_case orientation = {DATA("int", turned), {0}, "Orientation 6"};
static const attribute_case rendering = {TEXT("transform_RRT"), {0}, "transform_RRT"};
static const attribute_case look = {TEXT("look_warm"), {0}, "look_warm"};
static const attribute_case text = {TEXT("words"), {0}, NULL};
static const attribute_case wrap = {TEXT("clamp,periodic"), {0}, NULL};
static const attribute_case real = {DATA("float", number), {0}, NULL};
static const attribute_case matrix = {DATA("m44f", world), {0}, NULL};
static const attribute_case window = {DATA("box2i", box), {0}, NULL};
static const attribute_case rational = {DATA("rational", fraction), {0}, NULL};
static const attribute_case key = {DATA("keycode", keycode), {0}, NULL};
static const attribute_case moment = {DATA("timecode", timecode), {0}, NULL};
static const attribute_case thumbnail = {DATA("preview", preview), {0}, NULL};
static const attribute_case strange = {DATA("v2f", point), {0}, NULL};

static void no_pixels(const lf_format_row *row)
{
    static const float none[1] = {1000};
    const exr_part_bytes part = {.channels = RGB_CHANNELS,
                                 .value = PLAIN,
                                 .type = EXR_FLOAT,
                                 .attributes = {{"pixelAspectRatio", "float", none, sizeof none}}};
    (void)row;
    expect(&part, 1, "pixelAspectRatio is no shape of pixels", plain, 1e-7);
}

static void oblong_pixels(const lf_format_row *row)
{
    const attribute_case *c = row->with;
    const exr_part_bytes part = {.channels = RGB_CHANNELS,
                                 .value = PLAIN,
                                 .type = EXR_FLOAT,
                                 .attributes = {{row->name, c->type, c->data, c->size}}};
    lf_image_metadata meta;
    expect(&part, 1, c->told, plain, 1e-7);
    lf_image32 image = lf_picture_metadata(file(), &meta);
    lf_metadata_is(&meta, 2, 0);
    lf_image32_finish(&image);
}

static void bad_chromaticities(const lf_format_row *row)
{
    (void)row;
    static const float cases[][8] = {
        {0.1f, 0.1f, 0.2f, 0.2f, 0.3f, 0.3f, 0.3127f, 0.329f},       /* on a line */
        {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0},        /* white without y */
        {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.8f, 0.8f},        /* white outside */
        {NAN, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f},     /* no numbers */
        {INFINITY, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f} /* */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const exr_part_bytes part = {
            .channels = RGB_CHANNELS,
            .value = PLAIN,
            .type = EXR_FLOAT,
            .attributes = {{"chromaticities", "chromaticities", cases[i], sizeof cases[i]}}};
        expect(&part, 1, "chromaticities", plain, 1e-7);
    }
}

static void unknown_space(const lf_format_row *row)
{
    const exr_part_bytes part = {.channels = RGB_CHANNELS,
                                 .value = PLAIN,
                                 .type = EXR_FLOAT,
                                 .attributes = {{row->with, "string", "srgb_rec709_scene", 17}}};
    expect(&part, 1, "\"srgb_rec709_scene\"", plain, 1e-7);
}

static void other_type(const lf_format_row *row)
{
    (void)row;
    const exr_part_bytes part = {.channels = RGB_CHANNELS,
                                 .value = PLAIN,
                                 .type = EXR_FLOAT,
                                 .attributes = {{"chromaticities", "string", "ACEScg", 6}}};
    expect(&part, 1, "chromaticities is of the type string", plain, 1e-7);
}

/* The first is the one without a prefix. */
static void views(const lf_format_row *row)
{
    (void)row;
    static const unsigned char names[] = {4, 0, 0, 0,   'l', 'e', 'f', 't', 5,
                                          0, 0, 0, 'r', 'i', 'g', 'h', 't'};
    const exr_part_bytes part = {
        .channels = RGB_CHANNELS,
        .value = PLAIN,
        .type = EXR_FLOAT,
        .attributes = {{"multiView", "stringvector", names, sizeof names}}};
    expect(&part, 1, "views that are not read: right", plain, 1e-7);
}

/* Though its channels have one. */
static void first_view(const lf_format_row *row)
{
    (void)row;
    static const unsigned char names[] = {1, 0, 0, 0, 'r', 1, 0, 0, 0, 'l'};
    const exr_part_bytes part = {
        .channels = {"l.B", "l.G", "l.R", "r.B", "r.G", "r.R"},
        .value = {5, 5, 5, 0.1f, 0.1f, 0.8f},
        .type = EXR_FLOAT,
        .attributes = {{"multiView", "stringvector", names, sizeof names}}};
    lf_image_metadata meta;
    exr_write(file(), &part, 1);
    lf_image32 image = lf_picture_metadata(file(), &meta);
    lf_pixel_is(&image, 0, 0, plain, 1e-7);
    assert_non_null(strstr(meta.notes.text, "channels that are not read: l.B, l.G, l.R\n"));
    lf_image32_finish(&image);
}

/* ---------------------------------------------------------------------------------- channels -- */

/* The picture of a part, and what is told. */
typedef struct part_case {
    exr_part_bytes part;
    double rgb[3];
    double tolerance;
    const char *told;
} part_case;

static void one_part(const lf_format_row *row)
{
    const part_case *c = row->with;
    assert_int_equal(strcmp(row->verdict, "warned") == 0, !!c->told);
    expect(&c->part, 1, c->told, c->rgb, c->tolerance);
}

static const part_case rgb = {
    {.channels = RGB_CHANNELS, .value = PLAIN, .type = EXR_FLOAT}, {0.8, 0.1, 0.1}, 1e-7, NULL};
static const part_case halfs = {
    {.channels = RGB_CHANNELS, .value = PLAIN, .type = EXR_HALF}, {0.8, 0.1, 0.1}, 2e-4, NULL};
static const part_case whole = {
    {.channels = RGB_CHANNELS, .value = {7, 1000, 70000}, .type = EXR_UINT},
    {70000, 1000, 7},
    0,
    NULL};
static const part_case grey = {
    {.channels = {"Y"}, .value = {0.25f}, .type = EXR_FLOAT}, {0.25, 0.25, 0.25}, 0, NULL};
/* colours are those before black already */
static const part_case alpha = {
    {.channels = {"A", "B", "G", "R"}, .value = {0.5f, 0.1f, 0.1f, 0.8f}, .type = EXR_FLOAT},
    {0.8, 0.1, 0.1},
    1e-7,
    NULL};
static const part_case layer = {
    {.channels = {"sky.B", "sky.G", "sky.R"}, .value = PLAIN, .type = EXR_FLOAT},
    {0.8, 0.1, 0.1},
    1e-7,
    NULL};
static const part_case lone = {
    {.channels = {"density"}, .value = {0.25f}, .type = EXR_FLOAT}, {0.25, 0.25, 0.25}, 0, NULL};
static const part_case more = {
    {.channels = {"B", "G", "R", "Z", "n.X"}, .value = {0.1f, 0.1f, 0.8f, 9, 9}, .type = EXR_FLOAT},
    {0.8, 0.1, 0.1},
    1e-7,
    "channels that are not read: Z, n.X"};
static const part_case backwards = {
    {.channels = RGB_CHANNELS, .value = PLAIN, .type = EXR_FLOAT, .order = 1},
    {0.8, 0.1, 0.1},
    1e-7,
    NULL};
static const part_case beside = {{.channels = RGB_CHANNELS,
                                  .value = PLAIN,
                                  .type = EXR_FLOAT,
                                  .data = {10, 10, 13, 12},
                                  .display = {0, 0, 5, 5}},
                                 {0, 0, 0},
                                 0,
                                 "beside the display window: the picture is black"};

static void several_layers(const lf_format_row *row)
{
    (void)row;
    const exr_part_bytes part = {.channels = {"a.B", "a.G", "a.R", "b.B", "b.G", "b.R"},
                                 .type = EXR_FLOAT};
    exr_write(file(), &part, 1);
    lf_picture_refused(file(), "it has a.B, a.G, a.R, b.B, b.G, b.R.");
}

static void chroma(const lf_format_row *row)
{
    (void)row;
    const int w[4] = {0, 0, 31, 31};
    lf_picture_half_exr(file(), w, w, IMF_ZIP_COMPRESSION, IMF_WRITE_YC, false);
    lf_image_metadata meta;
    lf_image32 image = lf_picture_metadata(file(), &meta);
    lf_metadata_notes(&meta, NULL);
    const double at[3] = {(double)lf_picture_smooth(16, 16, 0),
                          (double)lf_picture_smooth(16, 16, 1),
                          (double)lf_picture_smooth(16, 16, 2)};
    lf_pixel_is(&image, 16, 16, at, 0.02);
    lf_image32_finish(&image);
}

/* The first pixel of a file whose numbers are not finite, and all others as they are. */
static void not_finite(const lf_format_row *row)
{
    const part_case *c = row->with;
    lf_image32 image = load(&c->part, 1, c->told);
    lf_pixel_is(&image, 0, 0, c->rgb, 0);
    lf_pixel_is(&image, 1, 0, plain, 2e-4);
    lf_image32_finish(&image);
}

#define ODD(a, b, c)                                                                               \
    {                                                                                              \
        .channels = RGB_CHANNELS, .value = PLAIN, .type = EXR_HALF, .odd = true, .first = {        \
            c,                                                                                     \
            b,                                                                                     \
            a                                                                                      \
        }                                                                                          \
    }
static const part_case infinite = {
    ODD(INFINITY, 1, 2), {65504, 1, 2}, 0, "1 pixel is not finite: +Inf is taken as 65504"};
static const part_case nans = {ODD(NAN, -INFINITY, 2), {0, 0, 2}, 0, "1 pixel is not finite"};

/* ------------------------------------------------------------------------------------- parts -- */

static const exr_part_bytes colours_part = {
    .channels = RGB_CHANNELS, .value = PLAIN, .type = EXR_FLOAT, .name = "beauty"};
static const exr_part_bytes depth_part = {
    .channels = {"Z"}, .value = {9}, .type = EXR_FLOAT, .name = "depth"};

/* Whichever comes first. */
static void parts(const lf_format_row *row)
{
    (void)row;
    const exr_part_bytes a[] = {colours_part, depth_part}, b[] = {depth_part, colours_part};
    expect(a, 2, "channels that are not read: depth: Z", plain, 1e-7);
    expect(b, 2, "channels that are not read: depth: Z", plain, 1e-7);
}

static void view_of_part(const lf_format_row *row)
{
    (void)row;
    exr_part_bytes two[] = {colours_part, colours_part};
    two[0].attributes[0] = (exr_attribute_bytes){"view", "string", "left", 4};
    two[1].attributes[0] = (exr_attribute_bytes){"view", "string", "right", 5};
    two[1].name = "other";
    two[1].value[0] = two[1].value[1] = two[1].value[2] = 5;
    expect(two, 2, "not read: other: B, other: G, other: R", plain, 1e-7);
}

static void deep(const lf_format_row *row)
{
    (void)row;
    const exr_part_bytes part = {.channels = RGB_CHANNELS, .type = EXR_HALF, .deep = true};
    exr_write(file(), &part, 1);
    lf_picture_refused(file(), "a deep EXR");
}

static void one_name(const lf_format_row *row)
{
    (void)row;
    expect(&colours_part, 1, NULL, plain, 1e-7);
}

/* --------------------------------------------------------------------------- windows, layout -- */

static void windows(const lf_format_row *row)
{
    (void)row;
    const exr_part_bytes part = {.channels = RGB_CHANNELS,
                                 .value = PLAIN,
                                 .type = EXR_FLOAT,
                                 .data = {2, 1, 5, 3},
                                 .display = {0, 0, 3, 3}};
    const double black[3] = {0, 0, 0};
    lf_image32 image = load(&part, 1, NULL);
    assert_true(image.width == 4 && image.height == 4);
    lf_pixel_is(&image, 1, 1, black, 0);
    lf_pixel_is(&image, 2, 0, black, 0);
    lf_pixel_is(&image, 2, 1, plain, 1e-7);
    lf_pixel_is(&image, 3, 3, plain, 1e-7);
    lf_image32_finish(&image);
}

/* The layout of a file whose envmap this is; the data window is the whole sphere. */
static lf_image_layout layout_of(unsigned char envmap, int height, const char *told)
{
    lf_image_metadata meta;
    const exr_part_bytes part = {.channels = RGB_CHANNELS,
                                 .value = PLAIN,
                                 .type = EXR_FLOAT,
                                 .data = {2, 1, 3, height},
                                 .display = {0, 0, 9, 9},
                                 .attributes = {{"envmap", "envmap", &envmap, 1}}};
    exr_write(file(), &part, 1);
    lf_image32 image = lf_picture_metadata(file(), &meta);
    assert_true(image.width == 2 && image.height == height);
    lf_pixel_is(&image, 0, 0, plain, 1e-7);
    lf_metadata_notes(&meta, told);
    lf_image32_finish(&image);
    return meta.layout;
}

static void latlong(const lf_format_row *row)
{
    (void)row;
    assert_int_equal(layout_of(0, 1, NULL), LF_IMAGE_PLAIN);
}

static void cube(const lf_format_row *row)
{
    (void)row;
    assert_int_equal(layout_of(1, 12, NULL), LF_IMAGE_CUBE);
}

static void no_cube(const lf_format_row *row)
{
    (void)row;
    assert_int_equal(layout_of(1, 11, "2x11 pixels are not six squares"), LF_IMAGE_PLAIN);
}

/* ----------------------------------------------------------------------------------- storage -- */

/* by OpenEXR's C++ library; the number of with is its word for a compression */
static void compression(const lf_format_row *row)
{
    const int *which = row->with;
    const int w[4] = {0, 0, 40, 30};
    lf_picture_half_exr(file(), w, w, *which, IMF_WRITE_RGBA, false);
    lf_image_metadata meta;
    lf_image32 image = lf_picture_metadata(file(), &meta);
    lf_metadata_notes(&meta, NULL);
    const double at[3] = {(double)lf_picture_smooth(16, 9, 0), (double)lf_picture_smooth(16, 9, 1),
                          (double)lf_picture_smooth(16, 9, 2)};
    lf_pixel_is(&image, 16, 9, at, *which < IMF_B44_COMPRESSION ? 3e-4 : 0.02);
    lf_image32_finish(&image);
}

static void tiles(const lf_format_row *row)
{
    (void)row;
    const int w[4] = {0, 0, 40, 30};
    lf_picture_half_exr(file(), w, w, IMF_ZIP_COMPRESSION, IMF_WRITE_RGB, true);
    lf_image_metadata meta;
    lf_image32 image = lf_picture_metadata(file(), &meta);
    lf_metadata_notes(&meta, NULL);
    assert_true(image.width == 41 && image.height == 31);
    lf_image32_finish(&image);
}

static const int kinds[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};

static const lf_format_row rows[] = {
    {"R, G, B", "used", one_part, &rgb},
    {"Y", "used", one_part, &grey},
    {"Y, RY, BY", "used", chroma, NULL},
    {"A, AR, AG, AB", "ignored", one_part, &alpha},
    {"layer.R, layer.G, layer.B", "used", one_part, &layer},
    {"several layers", "refused", several_layers, NULL},
    {"one channel of another name", "used", one_part, &lone},
    {"further channels", "warned", one_part, &more},
    {"HALF", "used", one_part, &halfs},
    {"FLOAT", "used", one_part, &rgb},
    {"UINT", "used", one_part, &whole},
    {"+Inf", "warned", not_finite, &infinite},
    {"NaN, -Inf", "warned", not_finite, &nans},
    {"scanlineimage", "used", one_part, &rgb},
    {"tiledimage, mipmap and ripmap levels", "used", tiles, NULL},
    {"deepscanline, deeptile", "refused", deep, NULL},
    {"several parts", "warned", parts, NULL},
    {"name", "ignored", one_name, NULL},
    {"view", "warned", view_of_part, NULL},
    {"multiView", "warned", views, NULL},
    {"multiView of layers alone", "used", first_view, NULL},
    {"NO_COMPRESSION", "used", compression, &kinds[0]},
    {"RLE_COMPRESSION", "used", compression, &kinds[1]},
    {"ZIPS_COMPRESSION", "used", compression, &kinds[2]},
    {"ZIP_COMPRESSION", "used", compression, &kinds[3]},
    {"PIZ_COMPRESSION", "used", compression, &kinds[4]},
    {"PXR24_COMPRESSION", "used", compression, &kinds[5]},
    {"B44_COMPRESSION", "used", compression, &kinds[6]},
    {"B44A_COMPRESSION", "used", compression, &kinds[7]},
    {"DWAA_COMPRESSION", "used", compression, &kinds[8]},
    {"DWAB_COMPRESSION", "used", compression, &kinds[9]},
    {"lineOrder", "used", one_part, &backwards},
    {"dataWindow, displayWindow", "used", windows, NULL},
    {"windows that do not meet", "warned", one_part, &beside},
    {"pixelAspectRatio", "used", oblong_pixels, &pixel_aspect},
    {"pixelAspectRatio beyond 1:100", "warned", no_pixels, NULL},
    {"envmap 0", "used", latlong, NULL},
    {"envmap 1", "used", cube, NULL},
    {"envmap 1 without six squares", "warned", no_cube, NULL},
    {"chromaticities", "used", attribute, &chromaticities},
    {"chromaticities without colours", "warned", bad_chromaticities, NULL},
    {"adoptedNeutral", "used", attribute, &adopted_neutral},
    {"acesImageContainerFlag", "used", attribute, &aces},
    {"colorInteropID", "used", attribute, &interop},
    {"colorInteropID of other colours", "warned", unknown_space, "colorInteropID"},
    {"oiio:ColorSpace", "used", attribute, &oiio},
    {"oiio:ColorSpace of other colours", "warned", unknown_space, "oiio:ColorSpace"},
    {"one of these of another type", "warned", other_type, NULL},
    {"whiteLuminance", "warned", attribute, &white_luminance},
    {"renderingTransform", "warned", attribute, &rendering},
    {"lookModTransform", "warned", attribute, &look},
    {"Orientation", "warned", attribute, &orientation},
    {"wrapmodes", "ignored", attribute, &wrap},
    {"worldToCamera", "ignored", attribute, &matrix},
    {"worldToNDC", "ignored", attribute, &matrix},
    {"originalDataWindow", "ignored", attribute, &window},
    {"xDensity", "ignored", attribute, &real},
    {"longitude", "ignored", attribute, &real},
    {"latitude", "ignored", attribute, &real},
    {"altitude", "ignored", attribute, &real},
    {"focus", "ignored", attribute, &real},
    {"expTime", "ignored", attribute, &real},
    {"aperture", "ignored", attribute, &real},
    {"isoSpeed", "ignored", attribute, &real},
    {"utcOffset", "ignored", attribute, &real},
    {"dwaCompressionLevel", "ignored", attribute, &real},
    {"owner", "ignored", attribute, &text},
    {"comments", "ignored", attribute, &text},
    {"capDate", "ignored", attribute, &text},
    {"keyCode", "ignored", attribute, &key},
    {"timeCode", "ignored", attribute, &moment},
    {"framesPerSecond", "ignored", attribute, &rational},
    {"preview", "ignored", attribute, &thumbnail},
    {"other attributes", "ignored", attribute, &strange},
};

static void what_an_exr_says(void **state)
{
    folder = *state;
    lf_formats_walk("images.md", "OpenEXR", rows, sizeof rows / sizeof *rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_an_exr_says)};
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
