#include "tests/testing.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <jpeglib.h>

#include "tests/quilt/photographed.h"

/* ------------------------------------------------------------------------------------- paper -- */

void lf_paper_make(const lf_printed *printed, double right_mm, double down_mm, double spot_mm,
                   lf_paper *out)
{
    const int w = printed->width, h = printed->height;
    const double most = printed->bits == 16 ? 65535.0 : 255.0, half = 0.5 * spot_mm / right_mm;
    double *sum = calloc((size_t)w + 1, sizeof *sum), curve[256];
    *out = (lf_paper){w, h, right_mm, down_mm, calloc((size_t)w * (size_t)h, sizeof(float))};
    assert_non_null(sum);
    assert_non_null(out->light);
    for (int i = 0; i < 256; i++)
        curve[i] = lf_srgb_to_linear(i / 255.0);
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++) {
            const uint16_t v =
                printed->value[((size_t)y * (size_t)w + (size_t)x) * (size_t)printed->channels];
            sum[x + 1] =
                sum[x] + (printed->bits == 8 ? curve[v & 255] : lf_srgb_to_linear(v / most));
        }
        for (int x = 0; x < w; x++) {
            const double a = fmax(x + 0.5 - half, 0.0), b = fmin(x + 0.5 + half, w);
            const int i = (int)a, j = (int)b < w ? (int)b : w - 1;
            const double left = sum[i] + (a - i) * (sum[i + 1] - sum[i]),
                         right = sum[j] + (b - j) * (sum[j + 1] - sum[j]);
            out->light[(size_t)y * (size_t)w + (size_t)x] = (float)((right - left) / (b - a));
        }
    }
    free(sum);
}

void lf_paper_finish(lf_paper *paper)
{
    free(paper->light);
    *paper = (lf_paper){0};
}

/* Ink is not quite black, paper not quite white; a grey table around it. */
static double paper_at(const lf_paper *paper, double x, double y)
{
    const double i = x / paper->right_mm + 0.5 * paper->width,
                 j = y / paper->down_mm + 0.5 * paper->height;
    if (i < -200 || j < -200 || i > paper->width + 200 || j > paper->height + 200)
        return 0.25;
    if (i < 0 || j < 0 || i >= paper->width - 1 || j >= paper->height)
        return 0.9;
    const float *row = paper->light + (size_t)j * (size_t)paper->width;
    const double at = fmax(i - 0.5, 0.0);
    const int left = (int)at;
    return 0.03 + 0.87 * ((double)row[left] + (at - left) * (double)(row[left + 1] - row[left]));
}

/* ------------------------------------------------------------------------------------- sheet -- */

/* Unit vector across the lenses. */
static void lenses_of(const lf_shot *shot, double out[2])
{
    const double lean =
        shot->skew_deg * M_PI / 180.0 + (shot->sheets == LF_TURNED_SHEET ? 0.5 * M_PI : 0.0);
    out[0] = cos(lean), out[1] = sin(lean);
}

/* Light that leaves the sheet at (x, y) towards an eye above (ex, ey). */
static double sheet_light(const lf_paper *paper, const lf_shot *shot, const double lenses[2],
                          const double eye[3], double x, double y)
{
    if (shot->sheets == LF_NO_SHEET)
        return paper_at(paper, x, y);
    const bool other = shot->sheets == LF_TWO_SHEETS && x > 0.0;
    const double pitch = 25.4 / (shot->lpi * (other ? 1.004 : 1.0)),
                 first = shot->phase_mm + (other ? 0.37 * pitch : 0.0);
    const double across = x * lenses[0] + y * lenses[1];
    const double off = first + pitch * round((across - first) / pitch) - across;
    const double px = x + off * lenses[0], py = y + off * lenses[1];
    const double dx = px - eye[0], dy = py - eye[1], square = dx * dx + dy * dy;
    /* sine of the ray's angle in the sheet, over the distance aside */
    const double sine = 1.0 / (sqrt(square + eye[2] * eye[2]) * shot->index);
    const double move = shot->thickness_mm * sine / sqrt(1.0 - sine * sine * square);
    return paper_at(paper, px + move * dx, py + move * dy);
}

/* ------------------------------------------------------------------------------------ camera -- */

typedef struct view {
    double eye[3], right[3], down[3], forward[3]; /* z away from the viewer */
} view;

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static view view_of(const lf_shot *shot)
{
    const double tilt = shot->tilt_deg * M_PI / 180.0, to = shot->direction_deg * M_PI / 180.0,
                 roll = shot->roll_deg * M_PI / 180.0;
    view v = {.forward = {-sin(tilt) * cos(to), -sin(tilt) * sin(to), cos(tilt)}};
    const double y[3] = {-sin(roll), cos(roll), 0.0};
    cross(y, v.forward, v.right);
    const double length =
        sqrt(v.right[0] * v.right[0] + v.right[1] * v.right[1] + v.right[2] * v.right[2]);
    for (int k = 0; k < 3; k++) {
        v.right[k] /= length;
        v.eye[k] = (k < 2 ? shot->aim_mm[k] : 0.0) - shot->distance_mm * v.forward[k];
    }
    cross(v.forward, v.right, v.down);
    return v;
}

void lf_shot_eye(const lf_shot *shot, double out[3])
{
    const view v = view_of(shot);
    out[0] = v.eye[0], out[1] = v.eye[1], out[2] = -v.eye[2];
}

double lf_shot_visual_lpi(const lf_shot *shot, double distance_mm)
{
    return shot->lpi / (1.0 + shot->thickness_mm / (shot->index * distance_mm));
}

double lf_shot_random(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return (double)(*state >> 11) * 0x1p-53;
}

static void expose(const lf_paper *paper, const lf_shot *shot, float *out)
{
    const view v = view_of(shot);
    const double eye[3] = {v.eye[0], v.eye[1], -v.eye[2]};
    const double focal = shot->focal_35mm / 43.2666 * hypot(shot->width, shot->height);
    double lenses[2];
    lenses_of(shot, lenses);
    for (int j = 0; j < shot->height; j++)
        for (int i = 0; i < shot->width; i++) {
            const double a = (i + 0.5 - 0.5 * shot->width) / focal,
                         b = (j + 0.5 - 0.5 * shot->height) / focal;
            double straight = 1.0;
            for (int k = 0; k < 4 && shot->k1 != 0.0; k++)
                straight = 1.0 / (1.0 + shot->k1 * (a * a + b * b) * straight * straight);
            double ray[3];
            for (int k = 0; k < 3; k++)
                ray[k] = straight * (a * v.right[k] + b * v.down[k]) + v.forward[k];
            const double far = eye[2] / ray[2];
            const double even =
                sheet_light(paper, shot, lenses, eye, eye[0] + far * ray[0], eye[1] + far * ray[1]);
            const double across = (double)i / shot->width - 0.5,
                         along = (double)j / shot->height - 0.5;
            out[(size_t)j * (size_t)shot->width + (size_t)i] =
                (float)(shot->gain * even *
                        (1.0 + shot->slope[0] * across + shot->slope[1] * along) *
                        (1.0 - shot->vignette * 2.0 * (across * across + along * along)));
        }
}

static void blur_line(const float *in, float *out, int n, size_t step, const double *weight, int m)
{
    for (int i = 0; i < n; i++) {
        double sum = 0.0;
        for (int k = -m; k <= m; k++) {
            const int at = i + k < 0 ? 0 : i + k >= n ? n - 1 : i + k;
            sum += weight[k < 0 ? -k : k] * (double)in[(size_t)at * step];
        }
        out[i] = (float)sum;
    }
}

static void blur(const lf_shot *shot, float *light)
{
    const int w = shot->width, h = shot->height, m = (int)fmin(ceil(2.5 * shot->blur_px), 31.0);
    double weight[32], sum = 0.0;
    float *line = calloc((size_t)(w > h ? w : h), sizeof *line);
    assert_non_null(line);
    for (int k = 0; k <= m; k++) {
        weight[k] = exp(-0.5 * k * k / (shot->blur_px * shot->blur_px));
        sum += k ? 2.0 * weight[k] : weight[k];
    }
    for (int k = 0; k <= m; k++)
        weight[k] /= sum;
    for (int j = 0; j < h; j++) {
        float *row = light + (size_t)j * (size_t)w;
        blur_line(row, line, w, 1, weight, m);
        memcpy(row, line, (size_t)w * sizeof *row);
    }
    for (int i = 0; i < w; i++) {
        blur_line(light + i, line, h, (size_t)w, weight, m);
        for (int j = 0; j < h; j++)
            light[(size_t)j * (size_t)w + (size_t)i] = line[j];
    }
    free(line);
}

/* ------------------------------------------------------------------------------------- photo -- */

static uint8_t *develop(const lf_shot *shot, const float *light)
{
    enum { STEPS = 4096 };
    uint8_t *out = malloc((size_t)shot->width * (size_t)shot->height * 3), curve[STEPS];
    uint64_t state = shot->seed * 0x9e3779b97f4a7c15u + 77;
    assert_non_null(out);
    for (int i = 0; i < STEPS; i++) {
        const double v = (i + 0.5) / STEPS;
        const double encoded = shot->gamma > 0.0 ? pow(v, 1.0 / shot->gamma)
                               : v <= 0.0031308  ? 12.92 * v
                                                 : 1.055 * pow(v, 1.0 / 2.4) - 0.055;
        curve[i] = (uint8_t)(255.0 * encoded + 0.5);
    }
    for (int j = 0; j < shot->height; j++)
        for (int i = 0; i < shot->width; i++) {
            const size_t at = (size_t)j * (size_t)shot->width + (size_t)i;
            const size_t to = shot->mirrored ? at - (size_t)i + (size_t)(shot->width - 1 - i) : at;
            double grain = -2.0;
            for (int k = 0; k < 4; k++)
                grain += lf_shot_random(&state);
            const double v = (double)light[at] + 1.73 * grain * shot->noise;
            const int step = (int)(v * STEPS);
            memset(out + 3 * to, curve[step < 0 ? 0 : step >= STEPS ? STEPS - 1 : step], 3);
        }
    return out;
}

/* Through JPEG and back, as phones write it: 4:2:0. */
static void compress(const lf_shot *shot, uint8_t *photo)
{
    struct jpeg_compress_struct to = {0};
    struct jpeg_decompress_struct from = {0};
    struct jpeg_error_mgr errors;
    unsigned char *bytes = NULL;
    unsigned long size = 0;
    const size_t row_bytes = 3 * (size_t)shot->width;
    to.err = from.err = jpeg_std_error(&errors);
    jpeg_create_compress(&to);
    jpeg_mem_dest(&to, &bytes, &size);
    to.image_width = (JDIMENSION)shot->width;
    to.image_height = (JDIMENSION)shot->height;
    to.input_components = 3;
    to.in_color_space = JCS_RGB;
    jpeg_set_defaults(&to);
    jpeg_set_quality(&to, shot->quality, TRUE);
    jpeg_start_compress(&to, TRUE);
    while (to.next_scanline < to.image_height) {
        JSAMPROW row = photo + row_bytes * to.next_scanline;
        jpeg_write_scanlines(&to, &row, 1);
    }
    jpeg_finish_compress(&to);
    jpeg_create_decompress(&from);
    jpeg_mem_src(&from, bytes, size);
    jpeg_read_header(&from, TRUE);
    jpeg_start_decompress(&from);
    while (from.output_scanline < from.output_height) {
        JSAMPROW row = photo + row_bytes * from.output_scanline;
        jpeg_read_scanlines(&from, &row, 1);
    }
    jpeg_finish_decompress(&from);
    jpeg_destroy_decompress(&from);
    jpeg_destroy_compress(&to);
    free(bytes);
}

void lf_photo_write(const char *path, const uint8_t *photo, const lf_shot *shot, int focal_35mm)
{
    /* a TIFF with a pointer to the EXIF directory, and this with one entry, 0xa405 */
    uint8_t exif[] = {'E',  'x',  'i', 'f', 0, 0, 'I', 'I', '*', 0, 8, 0, 0, 0, 1, 0, 0x69,
                      0x87, 4,    0,   1,   0, 0, 0,   26,  0,   0, 0, 0, 0, 0, 0, 1, 0,
                      0x05, 0xa4, 3,   0,   1, 0, 0,   0,   0,   0, 0, 0, 0, 0, 0, 0};
    struct jpeg_compress_struct to = {0};
    struct jpeg_error_mgr errors;
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    to.err = jpeg_std_error(&errors);
    jpeg_create_compress(&to);
    jpeg_stdio_dest(&to, file);
    to.image_width = (JDIMENSION)shot->width;
    to.image_height = (JDIMENSION)shot->height;
    to.input_components = 3;
    to.in_color_space = JCS_RGB;
    jpeg_set_defaults(&to);
    jpeg_set_quality(&to, 90, TRUE);
    jpeg_start_compress(&to, TRUE);
    exif[42] = (uint8_t)focal_35mm;
    if (focal_35mm > 0)
        jpeg_write_marker(&to, JPEG_APP0 + 1, exif, sizeof exif);
    while (to.next_scanline < to.image_height) {
        JSAMPROW row = (JSAMPROW)(uintptr_t)photo + 3 * (size_t)shot->width * to.next_scanline;
        jpeg_write_scanlines(&to, &row, 1);
    }
    jpeg_finish_compress(&to);
    jpeg_destroy_compress(&to);
    assert_int_equal(fclose(file), 0);
}

uint8_t *lf_photograph(const lf_paper *paper, const lf_shot *shot)
{
    float *light = calloc((size_t)shot->width * (size_t)shot->height, sizeof *light);
    assert_non_null(light);
    expose(paper, shot, light);
    if (shot->blur_px > 0.0)
        blur(shot, light);
    uint8_t *photo = develop(shot, light);
    free(light);
    if (shot->quality > 0)
        compress(shot, photo);
    return photo;
}

lf_shot lf_shot_usual(uint64_t seed)
{
    uint64_t s = (seed + 1) * 0x2545f4914f6cdd1du;
#define BETWEEN(a, b) ((a) + ((b) - (a)) * lf_shot_random(&s))
    for (int i = 0; i < 8; i++)
        (void)lf_shot_random(&s);
    lf_shot shot = {.thickness_mm = BETWEEN(0.4, 0.9),
                    .index = BETWEEN(1.49, 1.59),
                    .skew_deg = BETWEEN(-0.5, 0.5),
                    .tilt_deg = BETWEEN(0.0, 30.0),
                    .direction_deg = BETWEEN(0.0, 360.0),
                    .roll_deg = BETWEEN(-6.0, 6.0),
                    .aim_mm = {BETWEEN(-10.0, 10.0), BETWEEN(-10.0, 10.0)},
                    .focal_35mm = BETWEEN(24.0, 40.0),
                    .k1 = BETWEEN(-0.02, 0.02),
                    .width = 3024,
                    .height = 4032,
                    .slope = {BETWEEN(-0.5, 0.5), BETWEEN(-0.5, 0.5)},
                    .vignette = BETWEEN(0.0, 0.4),
                    .gain = BETWEEN(0.4, 0.75),
                    .gamma = lf_shot_random(&s) < 0.5 ? 0.0 : BETWEEN(2.0, 2.4),
                    .blur_px = BETWEEN(0.4, 2.0),
                    .noise = BETWEEN(0.002, 0.02),
                    .quality = (int)BETWEEN(60.0, 95.99),
                    .seed = seed};
    /* the chart's 277 mm fill 70 % of the height */
    shot.distance_mm = shot.focal_35mm / 43.2666 * 5040.0 * 277.0 / (0.70 * shot.height);
    /* two lens pitches off over 165 mm */
    const double seen = 60.0 + BETWEEN(-1.0, 1.0) * 2.0 * 25.4 / 165.0;
    double eye[3];
    lf_shot_eye(&shot, eye);
    shot.lpi = seen * (1.0 + shot.thickness_mm / (shot.index * eye[2]));
    shot.phase_mm = BETWEEN(-0.5, 0.5) * 25.4 / shot.lpi;
#undef BETWEEN
    return shot;
}
