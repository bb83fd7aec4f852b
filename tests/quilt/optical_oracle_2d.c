#include "tests/quilt/optical_oracle_2d.h"

#include <math.h>

#define TURN (3.14159265358979323846 / 180.0)
#define SPOT_POINTS 10

/* Across the lenses, to the right of an upright axis. */
static void directions(const lf_sheet_2d *sheet, double across[2], double axis[2])
{
    /* y points down: an upright axis that turns clockwise goes to the upper right */
    axis[0] = sin(sheet->axis_deg * TURN);
    axis[1] = -cos(sheet->axis_deg * TURN);
    across[0] = cos(sheet->axis_deg * TURN);
    across[1] = sin(sheet->axis_deg * TURN);
}

void lf_lens_top(const lf_sheet_2d *sheet, int i, int j, double along_mm, double out[2])
{
    double across[2], axis[2], right = sheet->x0_mm + i * sheet->pitch_mm, up = along_mm;
    directions(sheet, across, axis);
    if (sheet->kind == LF_SQUARE_LENSLETS)
        up = -sheet->y0_mm - j * sheet->pitch_mm;
    if (sheet->kind == LF_HEXAGON_LENSLETS) {
        right += j % 2 != 0 ? sheet->pitch_mm / 2.0 : 0.0;
        up = -sheet->y0_mm - j * sheet->pitch_mm * cos(30.0 * TURN);
    }
    for (int k = 0; k < 2; k++)
        out[k] = right * across[k] + up * axis[k];
}

void lf_print_point(const lf_sheet_2d *sheet, const lf_eye *eye, const double top[2], double out[2])
{
    const double dx = top[0] - eye->x, dy = top[1] - eye->y, dz = -eye->distance;
    const double length = sqrt(dx * dx + dy * dy + dz * dz);
    /* the components along the surface shrink by the index */
    const double rx = dx / length / sheet->index, ry = dy / length / sheet->index;
    const double rz = -sqrt(1.0 - rx * rx - ry * ry);
    out[0] = top[0] - rx / rz * sheet->thickness_mm;
    out[1] = top[1] - ry / rz * sheet->thickness_mm;
}

static double pixel_light(const lf_raster_light *raster, double x, double y)
{
    int column = (int)floor(x / raster->right_mm + raster->width / 2.0);
    int row = (int)floor(y / raster->down_mm + raster->height / 2.0);
    column = column < 0 ? 0 : column >= raster->width ? raster->width - 1 : column;
    row = row < 0 ? 0 : row >= raster->height ? raster->height - 1 : row;
    return raster->light[(long)row * raster->width + column];
}

double lf_spot_light(const lf_sheet_2d *sheet, const lf_raster_light *raster, const double at[2],
                     double spot_mm)
{
    const int rows = sheet->kind == LF_CYLINDERS ? 1 : SPOT_POINTS;
    double across[2], axis[2], sum = 0.0;
    directions(sheet, across, axis);
    for (int j = 0; j < rows; j++)
        for (int i = 0; i < SPOT_POINTS; i++) {
            const double u = ((i + 0.5) / SPOT_POINTS - 0.5) * spot_mm,
                         v = ((j + 0.5) / rows - 0.5) * (rows > 1 ? spot_mm : 0.0);
            sum += pixel_light(raster, at[0] + u * across[0] + v * axis[0],
                               at[1] + u * across[1] + v * axis[1]);
        }
    return sum / (SPOT_POINTS * rows);
}
