/* Everything that a Radiance picture can say: docs/reference/formats/images.md, row by row. */
#include "tests/base/image_metadata.h"
#include "tests/formats.h"

static char *folder;

/* A header, the first pixel (2 x 3 of them, each another), what becomes of it and the word that is
 * told. */
typedef struct hdr_case {
    const char *header;
    unsigned char pixel[4];
    double rgb[3], tolerance;
    const char *told;
} hdr_case;

static lf_image32 load(const char *header, const unsigned char pixel[4], const char *told)
{
    char data[512];
    lf_image_metadata meta;
    const char *path = lf_test_path(folder, "a.hdr");
    size_t n = (size_t)snprintf(data, sizeof data, "%s", header);
    for (int i = 0; i < 6; i++, n += 4) {
        memcpy(data + n, pixel, 4);
        data[n + 1] = (char)(pixel[1] + i);
    }
    lf_picture_write(path, data, n);
    lf_image32 image = lf_picture_metadata(path, &meta);
    lf_metadata_notes(&meta, told);
    return image;
}

static void header(const lf_format_row *row)
{
    const hdr_case *c = row->with;
    assert_int_equal(strcmp(row->verdict, "warned") == 0, !!c->told);
    lf_image32 image = load(c->header, c->pixel, c->told);
    lf_pixel_is(&image, 0, 0, c->rgb, c->tolerance);
    lf_image32_finish(&image);
}

#define END "\n\n-Y 3 +X 2\n"
#define RGBE "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n"
/* 200/256, 25/256, 25/256 */
#define PIXEL                                                                                      \
    {                                                                                              \
        200, 25, 25, 128                                                                           \
    }
#define PLAIN {0.78125, 0.09765625, 0.09765625}, 0, NULL

static const hdr_case radiance = {"#?RADIANCE\nFORMAT=32-bit_rle_rgbe" END, PIXEL, PLAIN};
static const hdr_case rgbe = {"#?RGBE\nFORMAT=32-bit_rle_rgbe" END, PIXEL, PLAIN};
static const hdr_case unstated = {"#?RADIANCE" END, PIXEL, PLAIN};
/* X, Y, Z of a white of D65 become those of E first: this grey is the white of the picture */
static const hdr_case xyze = {"#?RADIANCE\nFORMAT=32-bit_rle_xyze" END,
                              {100, 100, 100, 128},
                              {0.390625, 0.390625, 0.390625},
                              1e-6,
                              NULL};
static const hdr_case exposure = {
    RGBE "EXPOSURE=2\nEXPOSURE=2" END, PIXEL, {0.1953125, 0.0244140625, 0.0244140625}, 0, NULL};
static const hdr_case colour = {
    RGBE "COLORCORR=1 2 4" END, PIXEL, {0.78125, 0.048828125, 0.0244140625}, 0, NULL};
/* by the matrix of Rec. ITU-R BT.2087: 1.660491 -0.587641 -0.072850, -0.124550 1.132900 -0.008349,
 * -0.018151 -0.100579 1.118730 */
static const hdr_case primaries = {
    RGBE "PRIMARIES=0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.3290" END,
    PIXEL,
    {1.232758, 0.012514, 0.085249},
    2e-4,
    NULL};
static const hdr_case rec709 = {
    RGBE "PRIMARIES=0.640 0.330 0.300 0.600 0.150 0.060 0.3127 0.3290" END, PIXEL, PLAIN};
static const hdr_case on_a_line = {RGBE "PRIMARIES=0.1 0.1 0.2 0.2 0.3 0.3 0.33 0.33" END,
                                   PIXEL,
                                   {0.78125, 0.09765625, 0.09765625},
                                   0,
                                   "PRIMARIES span no"};
static const hdr_case few = {RGBE "PRIMARIES=0.64 0.33" END,
                             PIXEL,
                             {0.78125, 0.09765625, 0.09765625},
                             0,
                             "not eight numbers"};
static const hdr_case aspect = {RGBE "PIXASPECT=1\nPIXASPECT=0.5" END, PIXEL, PLAIN};
static const hdr_case no_aspect = {
    RGBE "PIXASPECT=x" END, PIXEL, {0.78125, 0.09765625, 0.09765625}, 0, "PIXASPECT is no shape"};
static const hdr_case gamma_said = {
    RGBE "GAMMA=2.2" END, PIXEL, {0.78125, 0.09765625, 0.09765625}, 0, "GAMMA=2.2"};
static const hdr_case words = {
    RGBE "VIEW=-vta -vh 360\nSOFTWARE= x\nCAPDATE=2026:11:28 10:00:00\nGMT=x\nOWNER=x\nLATLONG=1 "
         "2\nCAMERA=x\nPIXASPECT=1\nGAMMA=1\n# EXPOSURE=2\npfilt -1\n\tpcond" END,
    PIXEL, PLAIN};
static const hdr_case bright = {RGBE "EXPOSURE=1e-30" END,
                                {255, 25, 25, 255},
                                {65504, 65504, 65504},
                                0,
                                "6 pixels are not finite"};

/* It is height over width. */
static void oblong_pixels(const lf_format_row *row)
{
    const hdr_case *c = row->with;
    lf_image_metadata meta;
    header(row);
    lf_image32 image = load(c->header, c->pixel, NULL);
    lf_image32_finish(&image);
    image = lf_picture_metadata(lf_test_path(folder, "a.hdr"), &meta);
    lf_metadata_is(&meta, 2, 0);
    lf_image32_finish(&image);
}

static void other_format(const lf_format_row *row)
{
    (void)row;
    const char text[] = "#?RADIANCE\nFORMAT=Radiance_spectra" END "abcdabcdabcdabcd";
    const char *path = lf_test_path(folder, "b.hdr");
    lf_picture_write(path, text, sizeof text);
    lf_picture_refused(path, "FORMAT=Radiance_spectra");
}

/* The second pixel of the file, whose green is one more, lies where the axes say. */
static void axes(const lf_format_row *row)
{
    static const struct {
        const char *words;
        int x, y;
    } cases[] = {{"-Y 3 +X 2", 1, 0}, {"-Y 3 -X 2", 0, 0}, {"+Y 3 +X 2", 1, 2},
                 {"+Y 3 -X 2", 0, 2}, {"+X 2 -Y 3", 0, 1}, {"-X 2 -Y 3", 1, 1},
                 {"+X 2 +Y 3", 0, 1}, {"-X 2 +Y 3", 1, 1}};
    (void)row;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[128];
        const unsigned char pixel[4] = PIXEL;
        const double second[3] = {200.0 / 256, 26.0 / 256, 25.0 / 256};
        snprintf(text, sizeof text, RGBE "\n%s\n", cases[i].words);
        lf_image32 image = load(text, pixel, NULL);
        assert_true(image.width == 2 && image.height == 3);
        lf_pixel_is(&image, cases[i].x, cases[i].y, second, 0);
        lf_image32_finish(&image);
    }
}

static void runs(const lf_format_row *row)
{
    (void)row;
    /* new: 8 pixels of a run each; old: a pixel, and 7 like it */
    const unsigned char fresh[] = {2, 2, 0, 8, 136, 200, 136, 25, 136, 25, 136, 128},
                        old[] = {200, 25, 25, 128, 1, 1, 1, 7};
    char data[256];
    lf_image_metadata meta;
    const char *path = lf_test_path(folder, "c.hdr");
    const double rgb[3] = {0.78125, 0.09765625, 0.09765625};
    size_t n = (size_t)snprintf(data, sizeof data, RGBE "\n-Y 2 +X 8\n");
    memcpy(data + n, fresh, sizeof fresh);
    memcpy(data + n + sizeof fresh, old, sizeof old);
    lf_picture_write(path, data, n + sizeof fresh + sizeof old);
    lf_image32 image = lf_picture_metadata(path, &meta);
    for (int i = 0; i < 16; i++)
        lf_pixel_is(&image, i % 8, i / 8, rgb, 0);
    lf_image32_finish(&image);
}

static const lf_format_row rows[] = {
    {"#?RADIANCE", "used", header, &radiance},
    {"#?RGBE", "used", header, &rgbe},
    {"FORMAT=32-bit_rle_rgbe", "used", header, &radiance},
    {"FORMAT=32-bit_rle_xyze", "used", header, &xyze},
    {"no FORMAT", "used", header, &unstated},
    {"other FORMAT", "refused", other_format, NULL},
    {"EXPOSURE", "used", header, &exposure},
    {"COLORCORR", "used", header, &colour},
    {"PRIMARIES", "used", header, &primaries},
    {"PRIMARIES of Rec. 709", "used", header, &rec709},
    {"PRIMARIES without colours", "warned", header, &on_a_line},
    {"PRIMARIES without eight numbers", "warned", header, &few},
    {"PIXASPECT", "used", oblong_pixels, &aspect},
    {"PIXASPECT beyond 1:100", "warned", header, &no_aspect},
    {"GAMMA", "warned", header, &gamma_said},
    {"VIEW and other lines", "ignored", header, &words},
    {"-Y N +X M and the other seven", "used", axes, NULL},
    {"run lengths, new and old", "used", runs, NULL},
    {"numbers beyond floats", "warned", header, &bright},
};

static void what_a_radiance_picture_says(void **state)
{
    folder = *state;
    lf_formats_walk("images.md", "Radiance HDR", rows, sizeof rows / sizeof *rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_a_radiance_picture_says)};
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
