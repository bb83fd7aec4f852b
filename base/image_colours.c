#include "base/image_colours.h"

#include <float.h>
#include <math.h>

const lf_chromaticities lf_rec709 = {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}};
const lf_chromaticities lf_xyz = {{1, 0}, {0, 1}, {0, 0}, {1.0 / 3, 1.0 / 3}};

static const lf_matrix3 bradford = {
    {{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};

static bool is_same(const double a[2], const double b[2])
{
    return fabs(a[0] - b[0]) < 5e-4 && fabs(a[1] - b[1]) < 5e-4;
}

bool lf_is_rec709(const lf_chromaticities *c)
{
    return is_same(c->red, lf_rec709.red) && is_same(c->green, lf_rec709.green) &&
           is_same(c->blue, lf_rec709.blue) && is_same(c->white, lf_rec709.white);
}

static lf_matrix3 multiply(const lf_matrix3 *a, const lf_matrix3 *b)
{
    lf_matrix3 out;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            out.m[i][k] =
                a->m[i][0] * b->m[0][k] + a->m[i][1] * b->m[1][k] + a->m[i][2] * b->m[2][k];
    return out;
}

static void apply(const lf_matrix3 *a, const double v[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a->m[i][0] * v[0] + a->m[i][1] * v[1] + a->m[i][2] * v[2];
}

static double minor_of(const lf_matrix3 *a, int row, int column)
{
    int r0 = (row + 1) % 3, r1 = (row + 2) % 3, c0 = (column + 1) % 3, c1 = (column + 2) % 3;
    return a->m[r0][c0] * a->m[r1][c1] - a->m[r0][c1] * a->m[r1][c0];
}

static double determinant(const lf_matrix3 *a)
{
    return a->m[0][0] * minor_of(a, 0, 0) + a->m[0][1] * minor_of(a, 0, 1) +
           a->m[0][2] * minor_of(a, 0, 2);
}

static lf_matrix3 invert(const lf_matrix3 *a)
{
    lf_matrix3 out;
    double d = determinant(a);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            out.m[k][i] = minor_of(a, i, k) / d;
    return out;
}

/* X, Y, Z of a chromaticity with Y = 1; false: none exists. */
static bool white_of(const double xy[2], double out[3])
{
    out[0] = xy[0] / xy[1];
    out[1] = 1;
    out[2] = (1 - xy[0] - xy[1]) / xy[1];
    return xy[1] > 1e-3 && isfinite(out[0]) && isfinite(out[2]);
}

/* Solves for the weights of the primaries that add up to white. Primaries with y = 0, as in XYZ,
 * are valid: only white's y is a divisor. */
static bool to_xyz(const lf_chromaticities *c, lf_matrix3 *out)
{
    const double *const xy[3] = {c->red, c->green, c->blue};
    lf_matrix3 m;
    double white[3], share[3];
    for (int i = 0; i < 3; i++) {
        m.m[0][i] = xy[i][0];
        m.m[1][i] = xy[i][1];
        m.m[2][i] = 1 - xy[i][0] - xy[i][1];
    }
    if (!(fabs(determinant(&m)) > 1e-5) || !white_of(c->white, white))
        return false;
    lf_matrix3 back = invert(&m);
    apply(&back, white, share);
    for (int i = 0; i < 3; i++) {
        if (!(share[i] > 0))
            return false;
        for (int k = 0; k < 3; k++)
            out->m[k][i] = m.m[k][i] * share[i];
    }
    return true;
}

/* Adaptation from a white to D65. */
static bool adapt(const double white[2], lf_matrix3 *out)
{
    double from[3], to[3], cones_from[3], cones_to[3];
    if (!white_of(white, from) || !white_of(lf_rec709.white, to))
        return false;
    apply(&bradford, from, cones_from);
    apply(&bradford, to, cones_to);
    lf_matrix3 scale = {{{0}}}, back = invert(&bradford);
    for (int i = 0; i < 3; i++) {
        if (!(cones_from[i] > 0))
            return false;
        scale.m[i][i] = cones_to[i] / cones_from[i];
    }
    scale = multiply(&scale, &bradford);
    *out = multiply(&back, &scale);
    return true;
}

lf_status lf_colours_from(const lf_chromaticities *c, const double neutral[2],
                          lf_image_colours *out)
{
    lf_matrix3 from, to_d65, rec709;
    const double *white = neutral ? neutral : c->white;
    if (!to_xyz(c, &from) || !to_xyz(&lf_rec709, &rec709) || !adapt(white, &to_d65))
        return LF_E_FORMAT;
    lf_matrix3 back = invert(&rec709), all = multiply(&to_d65, &from);
    all = multiply(&back, &all);
    for (int i = 0; i < 9; i++)
        if (!(fabs(all.m[i / 3][i % 3]) < 1e4))
            return LF_E_FORMAT;
    *out = (lf_image_colours){!lf_is_rec709(c) || !is_same(white, lf_rec709.white), all};
    return LF_OK;
}

static float largest_of(const lf_image32 *image, size_t n)
{
    float largest = 65504;
    for (size_t i = 0; i < n; i++)
        if (isfinite(image->data[i]) && image->data[i] > largest)
            largest = image->data[i];
    return largest;
}

static void clamp(const lf_image_source *source, lf_image32 *image)
{
    size_t n = (size_t)image->width * (size_t)image->height, pixels = 0;
    float largest = 0;
    for (size_t i = 0; i < n; i++) {
        float *rgb = image->data + 3 * i;
        bool finite = true;
        for (int c = 0; c < 3; c++) {
            if (isfinite(rgb[c]))
                continue;
            finite = false;
            if (largest == 0)
                largest = largest_of(image, 3 * n);
            rgb[c] = rgb[c] > 0 ? largest : 0;
        }
        pixels += !finite;
    }
    if (pixels > 0 && source->meta)
        lf_image_note(&source->meta->notes,
                      "%zu %s not finite; +Inf is read as %g, NaN and -Inf as 0", pixels,
                      pixels == 1 ? "pixel is" : "pixels are", (double)largest);
}

static void convert(const lf_image_colours *colours, lf_image32 *image)
{
    size_t n = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < n; i++) {
        float *rgb = image->data + 3 * i;
        const double from[3] = {(double)rgb[0], (double)rgb[1], (double)rgb[2]};
        double to[3];
        apply(&colours->to_rec709, from, to);
        for (int c = 0; c < 3; c++)
            rgb[c] = (float)fmin(fmax(to[c], -(double)FLT_MAX), (double)FLT_MAX);
    }
}

void lf_image_settle(const lf_image_source *source, const lf_image_colours *colours,
                     lf_image32 *image)
{
    clamp(source, image);
    if (colours->converts)
        convert(colours, image);
}
