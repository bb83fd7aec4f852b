/* Pictures whose numbers are those of other primaries and whites. */
#include "tests/base/exr_bytes.h"
#include "tests/base/image_metadata.h"

/* As the attribute has them: red, green, blue, white. */
#define D65 0.3127f, 0.329f
#define REC709 0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f
#define REC2020 0.708f, 0.292f, 0.17f, 0.797f, 0.131f, 0.046f
#define XYZ 1, 0, 0, 1, 0, 0
#define E 1 / 3.0f, 1 / 3.0f

static lf_image32 load(const char *folder, const float chromaticities[8], const float rgb[3],
                       lf_image_metadata *meta)
{
    const char *path = lf_test_path(folder, "c.exr");
    const exr_part_bytes part = {
        .channels = {"B", "G", "R"},
        .value = {rgb[2], rgb[1], rgb[0]},
        .type = EXR_FLOAT,
        .attributes = {{"chromaticities", "chromaticities", chromaticities, 32}}};
    exr_write(path, &part, 1);
    return lf_picture_metadata(path, meta);
}

typedef struct colour_case {
    float chromaticities[8], from[3];
    double to[3];
} colour_case;

/* The matrices are those that others publish: Rec. ITU-R BT.2087 (2020 to 709), the ACES project's
 * (AP1 to 709), and of X, Y, Z with E the one of IEC 61966-2-1 after Bradford's adaptation. */
static void numbers_become_those_of_rec709(void **state)
{
    static const colour_case cases[] = {
        {{REC2020, D65}, {0.78f, 0.1f, 0.1f}, {1.22914, 0.01531, 0.08766}},
        {{REC2020, D65}, {1, 0, 0}, {1.6605, -0.1246, -0.0182}},
        {{REC2020, D65}, {0, 1, 0}, {-0.5876, 1.1329, -0.1006}},
        {{REC2020, D65}, {0, 0, 1}, {-0.0728, -0.0083, 1.1187}},
        {{0.713f, 0.293f, 0.165f, 0.83f, 0.128f, 0.044f, 0.32168f, 0.33767f},
         {0.529f, 0.149f, 0.114f},
         {0.79983, 0.09987, 0.09953}},
        {{XYZ, E}, {0.404f, 0.249f, 0.112f}, {0.80252, 0.08925, 0.10117}},
        /* another white alone: all of it is adaptation */
        {{REC709, E}, {0.5f, 0.5f, 0.5f}, {0.5, 0.5, 0.5}},
        {{XYZ, E}, {1, 1, 1}, {1, 1, 1}},
        {{REC2020, D65}, {1, 1, 1}, {1, 1, 1}},
        {{0.7347f, 0.2653f, 0, 1, 0.0001f, -0.077f, 0.32168f, 0.33767f}, {2, 2, 2}, {2, 2, 2}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_image_metadata meta;
        lf_image32 image = load(*state, cases[i].chromaticities, cases[i].from, &meta);
        lf_metadata_notes(&meta, NULL);
        lf_pixel_is(&image, 0, 0, cases[i].to, 3e-4);
        lf_image32_finish(&image);
    }
}

/* The attribute as different programs round it; numbers whose bits any product would change. */
static void numbers_of_rec709_keep_their_bits(void **state)
{
    static const float cases[][8] = {{REC709, D65},
                                     {REC709, 0.31271f, 0.32902f},
                                     {0.6401f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f}};
    const float odd[3] = {0.1f, 1e-38f, 3e38f};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_image_metadata meta;
        lf_image32 image = load(*state, cases[i], odd, &meta);
        lf_metadata_notes(&meta, NULL);
        assert_memory_equal(image.data, odd, sizeof odd);
        lf_image32_finish(&image);
    }
}

/* Nothing becomes infinite on the way. */
static void the_largest_numbers_stay_finite(void **state)
{
    const float largest[3] = {3.4e38f, -3.4e38f, -3.4e38f}, chromaticities[8] = {REC2020, D65};
    lf_image_metadata meta;
    lf_image32 image = load(*state, chromaticities, largest, &meta);
    for (int i = 0; i < image.width * image.height * 3; i++)
        assert_true(isfinite(image.data[i]));
    lf_image32_finish(&image);
}

/* Grey is white whatever the primaries are, but for an adopted neutral. */
static void grey_stays_grey(void **state)
{
    const float rec2020[8] = {REC2020, D65}, e[2] = {E};
    const char *path = lf_test_path(*state, "y.exr");
    exr_part_bytes part = {.channels = {"Y"},
                           .value = {0.3f},
                           .type = EXR_FLOAT,
                           .attributes = {{"chromaticities", "chromaticities", rec2020, 32}}};
    const float bits[3] = {0.3f, 0.3f, 0.3f};
    lf_image_metadata meta;
    exr_write(path, &part, 1);
    lf_image32 image = lf_picture_metadata(path, &meta);
    assert_memory_equal(image.data, bits, sizeof bits);
    lf_image32_finish(&image);
    part.attributes[1] = (exr_attribute_bytes){"adoptedNeutral", "v2f", e, 8};
    exr_write(path, &part, 1);
    image = lf_picture_metadata(path, &meta);
    assert_true(image.data[0] < 0.29f && image.data[2] > 0.31f);
    lf_image32_finish(&image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_become_those_of_rec709),
        cmocka_unit_test(numbers_of_rec709_keep_their_bits),
        cmocka_unit_test(the_largest_numbers_stay_finite),
        cmocka_unit_test(grey_stays_grey),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
