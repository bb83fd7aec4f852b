#include "render/import/scene/environment_cube.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/alloc.h"

enum { LEAST_HEIGHT = 512, MOST_HEIGHT = 8192, MOST_SAMPLES = 1 << 26 };

void lf_cube_unfolded(int side, int *out_width, int *out_height)
{
    int height = side < MOST_HEIGHT / 2 ? 2 * side : MOST_HEIGHT;
    *out_height = height < LEAST_HEIGHT ? LEAST_HEIGHT : height;
    *out_width = 2 * *out_height;
}

/* The cube face in a direction, and the position on it from -1 to 1, rightwards and downwards in
 * the order of pixels. */
static int place_on_cube(const double d[3], double *right, double *down)
{
    int axis = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(d[i]) > fabs(d[axis]))
            axis = i;
    double x = d[0] / fabs(d[axis]), y = d[1] / fabs(d[axis]), z = d[2] / fabs(d[axis]);
    const bool positive = d[axis] > 0;
    *right = x;
    *down = -y;
    if (axis == 0)
        *right = positive ? z : -z;
    else if (axis == 1)
        *down = positive ? -z : z;
    else if (positive)
        *right = -x;
    return 2 * axis + !positive;
}

static double clamp(double x, double low, double high)
{
    return fmin(fmax(x, low), high);
}

static void look_up(const float *faces, int side, const double d[3], double sum[3])
{
    double right, down;
    int face = place_on_cube(d, &right, &down), last = side - 1;
    double x = clamp((right + 1) / 2 * last, 0, last), y = clamp((down + 1) / 2 * last, 0, last);
    int x0 = (int)x, y0 = (int)y, x1 = x0 < last ? x0 + 1 : last, y1 = y0 < last ? y0 + 1 : last;
    const float *upper = faces + 3 * ((size_t)face * (size_t)side + (size_t)y0) * (size_t)side,
                *lower = faces + 3 * ((size_t)face * (size_t)side + (size_t)y1) * (size_t)side;
    for (int c = 0; c < 3; c++) {
        double a = (double)upper[3 * x0 + c], b = (double)lower[3 * x0 + c];
        a += (x - x0) * ((double)upper[3 * x1 + c] - a);
        b += (x - x0) * ((double)lower[3 * x1 + c] - b);
        sum[c] += a + (y - y0) * (b - a);
    }
}

/* Sines and cosines of n directions in each column. */
static double *turns_of(int width, int n)
{
    double *turn = lf_calloc((size_t)width * (size_t)n, 2 * sizeof *turn);
    for (int i = 0; turn && i < width * n; i++) {
        double phi = 2 * M_PI * (i + 0.5) / ((double)width * n);
        turn[2 * i] = -sin(phi);
        turn[2 * i + 1] = cos(phi);
    }
    return turn;
}

/* Adds the directions at one polar angle. */
static void add_line(const float *faces, int side, double theta, const double *turn, int n,
                     double sum[3])
{
    const double sine = sin(theta), cosine = cos(theta);
    for (int k = 0; k < n; k++) {
        const double d[3] = {turn[2 * k] * sine, cosine, turn[2 * k + 1] * sine};
        look_up(faces, side, d, sum);
    }
}

bool lf_cube_unfold(const float *faces, int side, int width, int height, float *rgb)
{
    const int n = (int64_t)width * height * 16 <= MOST_SAMPLES ? 4 : 2;
    double *turn = turns_of(width, n);
    for (int y = 0; turn && y < height; y++)
        for (int x = 0; x < width; x++) {
            double sum[3] = {0};
            for (int k = 0; k < n; k++)
                add_line(faces, side, M_PI * (y + (k + 0.5) / n) / height,
                         turn + 2 * (size_t)x * (size_t)n, n, sum);
            float *to = rgb + 3 * ((size_t)y * (size_t)width + (size_t)x);
            for (int c = 0; c < 3; c++)
                to[c] = (float)(sum[c] / (n * n));
        }
    lf_free(turn);
    return turn;
}
