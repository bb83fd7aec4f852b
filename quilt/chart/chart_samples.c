#include <math.h>

#include "base/alloc.h"
#include "quilt/chart/fringes.h"

#define COLUMN_MM 1.0
#define ROW_MM 1.2
#define MOST_COLUMNS 600
#define MOST_ROWS 8
#define END_MM 1.5 /* of a band, not read */
#define BAND_FROM 0.08
#define BAND_TO 0.82
#define MOST_POINTS 12 /* per area and direction */
#define CLIPPED 253

double lf_chart_reach(const lf_chart_optics *optics)
{
    return optics->thickness / optics->index;
}

void lf_chart_through(const lf_chart_optics *optics, double x, double y, double out[2])
{
    double ratio = lf_chart_reach(optics) / optics->distance; /* displacement / r */
    const double dx = x - optics->eye[0], dy = y - optics->eye[1];
    for (int i = 0; i < 4; i++) {
        const double r = hypot(dx, dy) / (1.0 + ratio);
        const double sine = r / hypot(r, optics->distance) / optics->index;
        if (r > 1e-9)
            ratio = optics->thickness * sine / sqrt(1.0 - sine * sine) / r;
    }
    out[0] = optics->eye[0] + dx / (1.0 + ratio);
    out[1] = optics->eye[1] + dy / (1.0 + ratio);
}

/* ------------------------------------------------------------------------------------- light -- */

static double pixel_at(lf_chart_light *light, double px, double py)
{
    const double x = px - 0.5, y = py - 0.5;
    const int left = (int)floor(x), top = (int)floor(y);
    double sum = 0.0;
    if (left < 0 || top < 0 || left + 1 >= light->width || top + 1 >= light->height)
        return -1.0;
    for (int k = 0; k < 4; k++) {
        const int i = left + (k & 1), j = top + (k >> 1);
        const uint8_t *p = light->data + 3 * ((size_t)j * (size_t)light->width + (size_t)i);
        const double weight = (1.0 - fabs(x - i)) * (1.0 - fabs(y - j));
        sum +=
            weight * 0.25 * (light->linear[p[0]] + 2.0 * light->linear[p[1]] + light->linear[p[2]]);
        light->n_clipped += k == 0 && p[1] >= CLIPPED;
    }
    light->n_points++;
    return sum;
}

double lf_chart_light_at(lf_chart_light *light, double x, double y, double width, double height)
{
    double corner[4][2], sum = 0.0;
    const int nx = (int)fmin(ceil(width * light->px_per_mm), MOST_POINTS) + 1,
              ny = (int)fmin(ceil(height * light->px_per_mm), MOST_POINTS) + 1;
    for (int k = 0; k < 4; k++)
        if (!lf_chart_project(light->camera, x + ((k & 1) - 0.5) * width,
                              y + ((k >> 1) - 0.5) * height, &corner[k][0], &corner[k][1]))
            return -1.0;
    for (int j = 0; j < ny; j++)
        for (int i = 0; i < nx; i++) {
            const double u = (i + 0.5) / nx, v = (j + 0.5) / ny;
            double p[2];
            for (int c = 0; c < 2; c++)
                p[c] = (1 - v) * ((1 - u) * corner[0][c] + u * corner[1][c]) +
                       v * ((1 - u) * corner[2][c] + u * corner[3][c]);
            const double one = pixel_at(light, p[0], p[1]);
            if (one < 0.0)
                return -1.0;
            sum += one;
        }
    return sum / (nx * ny);
}

/* -------------------------------------------------------------------------------------- grid -- */

static void place_grid(const lf_chart *chart, lf_chart_samples *s)
{
    const double height = (BAND_TO - BAND_FROM) * chart->band_height;
    for (int i = 0; i < s->n_columns; i++)
        s->x[i] = s->half_width * ((2 * i + 1.0) / s->n_columns - 1.0);
    for (int band = 0; band < s->n_bands; band++)
        for (int r = 0; r < s->rows_of_band; r++)
            s->y[band * s->rows_of_band + r] =
                chart->top + (band + BAND_FROM) * chart->band_height +
                (r + 0.5) / s->rows_of_band * height - 0.5 * chart->height;
}

static bool allocate(const lf_chart *chart, lf_chart_samples *s)
{
    const double height = (BAND_TO - BAND_FROM) * chart->band_height;
    s->half_width = chart->half_width - END_MM;
    s->n_bands = chart->n_bands;
    s->n_columns = (int)fmin(fmax(2.0 * s->half_width / COLUMN_MM, 12.0), MOST_COLUMNS);
    s->rows_of_band = (int)fmin(fmax(height / ROW_MM, 1.0), MOST_ROWS);
    const size_t rows = (size_t)(s->n_bands * s->rows_of_band), columns = (size_t)s->n_columns;
    s->x = lf_calloc(columns, sizeof *s->x);
    s->y = lf_calloc(rows, sizeof *s->y);
    s->lens = lf_calloc(rows * columns, 2 * sizeof *s->lens);
    s->light = lf_calloc(rows * columns, sizeof *s->light);
    return s->x && s->y && s->lens && s->light;
}

lf_status lf_chart_samples_take(const lf_chart *chart, const lf_chart_optics *optics,
                                lf_chart_light *light, const char *where, lf_chart_samples *out,
                                lf_error *err)
{
    *out = (lf_chart_samples){0};
    if (!allocate(chart, out))
        return lf_error_set(err, LF_E_NOMEM, where, "not enough memory to read the bands");
    place_grid(chart, out);
    const double width = 2.0 * out->half_width / out->n_columns;
    const double height = (BAND_TO - BAND_FROM) * chart->band_height / out->rows_of_band;
    for (int r = 0; r < out->n_bands * out->rows_of_band; r++)
        for (int c = 0; c < out->n_columns; c++) {
            const size_t at = (size_t)r * (size_t)out->n_columns + (size_t)c;
            const double mean = lf_chart_light_at(light, out->x[c], out->y[r], width, height);
            if (mean < 0.0)
                return lf_error_set(err, LF_E_FORMAT, where,
                                    "a part of the chart is outside the photo; show all of it");
            out->light[at] = mean;
            lf_chart_through(optics, out->x[c], out->y[r], out->lens + 2 * at);
        }
    return LF_OK;
}

void lf_chart_samples_finish(lf_chart_samples *samples)
{
    lf_free(samples->x);
    lf_free(samples->y);
    lf_free(samples->lens);
    lf_free(samples->light);
    *samples = (lf_chart_samples){0};
}
