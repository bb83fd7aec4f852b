/* The picture that an eye sees, from the light of the lenses. */
#include <math.h>
#include <string.h>

#include "quilt/proof/simulate.h"

#define MAX_PIXELS 16000000.0

lf_status lf_proof_size(const lf_proof_sheet *sheet, int width, int *out_width, int *out_height,
                        lf_error *err)
{
    const double lenses =
        (sheet->horizontal ? sheet->height_mm : sheet->width_mm) / sheet->pitch_mm;
    const double aspect = sheet->width_mm / sheet->height_mm;
    const double wide = width > 0 ? width : round(sheet->horizontal ? lenses * aspect : lenses);
    const double high = round(wide / aspect);
    if (wide > LF_PROOF_MAX_SIDE || high > LF_PROOF_MAX_SIDE || wide * high > MAX_PIXELS)
        return lf_error_set(err, LF_E_ARG, "--width",
                            "gives a picture of %.0fx%.0f pixels; give a smaller width", wide,
                            high);
    *out_width = wide < 1 ? 1 : (int)wide;
    *out_height = high < 1 ? 1 : (int)high;
    return LF_OK;
}

static const float *light_at(const lf_proof_light *light, int along, int lens)
{
    along = along < 0 ? 0 : along >= light->n_along ? light->n_along - 1 : along;
    lens = lens < 0 ? 0 : lens >= light->n ? light->n - 1 : lens;
    return light->light + 3 * ((size_t)along * (size_t)light->n + (size_t)lens);
}

/* ---------------------------------------------------------------------------- upright lenses -- */

/* Pixels of the picture across the lenses are the mean of the lenses that they cover. */
static void compose_straight(const lf_proof_sheet *sheet, const lf_proof_light *light,
                             lf_image32 *image)
{
    const int n = sheet->horizontal ? image->height : image->width;
    const double size = sheet->horizontal ? sheet->height_mm : sheet->width_mm;
    const int n_along = sheet->horizontal ? image->width : image->height;
    for (int i = 0; i < n; i++) {
        const double low = ((double)i / n - 0.5) * size / sheet->pitch_mm - sheet->offset + 0.5,
                     high = ((i + 1.0) / n - 0.5) * size / sheet->pitch_mm - sheet->offset + 0.5;
        for (int along = 0; along < n_along; along++) {
            double sum[3] = {0};
            for (int lens = (int)floor(low); lens < high; lens++) {
                const double covered = fmin(high, lens + 1.0) - fmax(low, (double)lens);
                const float *from = light_at(light, along, lens - light->first);
                for (int c = 0; c < 3; c++)
                    sum[c] += covered * (double)from[c];
            }
            const size_t at = sheet->horizontal ? (size_t)i * (size_t)image->width + (size_t)along
                                                : (size_t)along * (size_t)image->width + (size_t)i;
            for (int c = 0; c < 3; c++)
                image->data[3 * at + (size_t)c] = (float)(sum[c] / (high - low));
        }
    }
}

/* ---------------------------------------------------------------------------- the other ones -- */

/* The light of the lens over a point of the sheet. */
static const float *light_over(const lf_proof_sheet *sheet, const lf_proof_light *light, double x,
                               double y)
{
    const double u = (x * sheet->right + y * sheet->down) / sheet->pitch_mm - sheet->offset;
    const double v =
        sheet->horizontal ? x * sheet->down - y * sheet->right : y * sheet->right - x * sheet->down;
    if (sheet->grid == LF_LENS_LINEAR)
        return light_at(light, (int)floor((v - light->along0_mm) / light->along_mm),
                        (int)lround(u) - light->first);
    const double row_mm =
        sheet->grid == LF_LENS_HEXAGONAL ? sheet->pitch_mm * sqrt(0.75) : sheet->pitch_mm;
    const double rows = v / row_mm - sheet->offset_down;
    int lens = 0, row = 0;
    double nearest = INFINITY;
    for (int j = (int)floor(rows); j <= (int)floor(rows) + 1; j++) {
        const double shift = sheet->grid == LF_LENS_HEXAGONAL ? 0.5 * (j & 1) : 0.0;
        const double i = round(u - shift), right = (u - shift - i) * sheet->pitch_mm,
                     down = (rows - j) * row_mm;
        if (right * right + down * down < nearest) {
            nearest = right * right + down * down;
            lens = (int)i;
            row = j;
        }
    }
    return light_at(light, row - light->first_row, lens - light->first);
}

static void compose_points(const lf_proof_sheet *sheet, const lf_proof_light *light,
                           lf_image32 *image)
{
    const double pixel = sheet->width_mm / image->width, down = sheet->height_mm / image->height;
    const double wanted = ceil(3.0 * pixel / sheet->pitch_mm);
    const int parts = wanted < 2 ? 2 : wanted > 8 ? 8 : (int)wanted;
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            float sum[3] = {0},
                  *out = image->data + 3 * ((size_t)y * (size_t)image->width + (size_t)x);
            for (int k = 0; k < parts * parts; k++) {
                const int column = k % parts, line = k / parts;
                const double right_mm = (x + (column + 0.5) / parts - 0.5 * image->width) * pixel;
                const double down_mm = (y + (line + 0.5) / parts - 0.5 * image->height) * down;
                const float *from = light_over(sheet, light, right_mm, down_mm);
                for (int c = 0; c < 3; c++)
                    sum[c] += from[c];
            }
            for (int c = 0; c < 3; c++)
                out[c] = sum[c] / (float)(parts * parts);
        }
}

lf_status lf_proof_picture(lf_print_file *file, const lf_proof_sheet *sheet, const lf_eye *eye,
                           int width, int height, const lf_cancel *cancel, lf_image32 *out,
                           lf_error *err)
{
    const bool is_straight =
        sheet->grid == LF_LENS_LINEAR && (sheet->horizontal ? sheet->right : sheet->down) == 0.0;
    lf_proof_light light;
    lf_image32 image = {0};
    lf_status status =
        lf_proof_see(file, sheet, eye, sheet->horizontal ? width : height, cancel, &light, err);
    if (status != LF_OK)
        return status;
    if (lf_image32_init(&image, width, height, 3) != LF_OK)
        status = lf_error_set(err, LF_E_NOMEM, "proof", "out of memory");
    else if (is_straight)
        compose_straight(sheet, &light, &image);
    else
        compose_points(sheet, &light, &image);
    lf_proof_light_finish(&light);
    if (status == LF_OK)
        *out = image;
    return status;
}
