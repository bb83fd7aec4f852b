#include "quilt/lens.h"

#include <math.h>
#include <string.h>

/* The solution is exact to a millionth of this, in units of place. */
#define CLOSE 1e-7
#define MAX_STEPS 20

/* ------------------------------------------------------------------------------------- phase -- */

/* An eye at the distance D sees a point r of the lens plane at r + t g(r) of the print, with
 * g = sin / sqrt(n^2 - sin^2) and sin = r / sqrt(r^2 + D^2). Newton's steps from the paraxial
 * solution. */
double lf_lens_factor(const lf_lens *lens, double radius)
{
    const double t = lens->thickness, n2 = lens->index * lens->index,
                 d2 = lens->distance * lens->distance;
    if (!(t > 0.0) || !(radius > 0.0))
        return t > 0.0 ? 1.0 / (1.0 + t / (lens->index * lens->distance)) : 1.0;
    double r = radius / (1.0 + t / (lens->index * lens->distance));
    for (int i = 0; i < MAX_STEPS; i++) {
        const double root = 1.0 / sqrt((n2 - 1.0) * r * r + n2 * d2);
        const double slope = 1.0 + t * n2 * d2 * root * root * root;
        const double step = (r + t * r * root - radius) / slope;
        r -= step;
        if (fabs(step) < CLOSE)
            break;
    }
    return r / radius;
}

/* With a = n^2 - 1, b = n^2 D^2, u = 1 / sqrt(a r^2 + b) and w = a r^2 u^2 (0 to 1), a point R = r
 * (1 + t u) of the print has the factor f = 1 / (1 + t u). By s = R^2, f' = (a/2) t u^3 f^3 / (1 +
 * t b u^3), and |f''| <= (3a/2) u^2 f f'. Along a line f_xx = 2 f' + 4 x^2 f'', with x <= R = r /
 * f: |f_xx| <= a t u^3 f^2 (f + 3 w). A line between points is off by step^2 / 8 of it, times R. In
 * terms of w, R |f_xx| is at most t sqrt(a) / b times sqrt(w) (1 - w) (1 + 3 w) <= 0.89; f_xx
 * itself is at most a t / sqrt(b)^3 times (1 - w)^1.5 (1 + 3 w) <= 1.15, and R grows by a step. */
double lf_lens_factor_error(const lf_lens *lens, double step)
{
    const double a = lens->index * lens->index - 1.0, eye = lens->index * lens->distance;
    return lens->thickness * step * step / 8.0 / (eye * eye) *
           (0.89 * sqrt(a) + 1.15 * a * step / eye);
}

double lf_lens_phase(const lf_lens *lens, double x, double y, int channel)
{
    if (!(lens->thickness > 0.0))
        return lf_lens_flat(lens, x, y, channel);
    const double factor = lf_lens_factor(lens, sqrt(x * x + y * y));
    return lf_lens_flat(lens, factor * x, factor * y, channel);
}

/* ------------------------------------------------------------------------------------- panel -- */

static bool is_first_version(const lf_calibration *c)
{
    return strcmp(c->config_version, "1.0") == 0;
}

/* The vendor's software reads invView only for the first generation. */
static bool counts_from_right(const lf_calibration *c, lf_invert invert)
{
    if (invert != LF_INVERT_AUTO)
        return invert == LF_INVERT_YES;
    return !is_first_version(c) || c->inv_view;
}

lf_lens lf_lens_of_panel(const lf_calibration *c, lf_invert invert)
{
    const double width = c->screen_width_px, height = c->screen_height_px;
    const double mirrored = c->flip_image_x ? -1 : 1, subpixel = mirrored / (3 * width);
    const int red = c->flip_subp ? 2 : 0; /* blue has the other end */
    lf_lens lens = {.right = 1,
                    .down = mirrored * height / (width * c->slope),
                    .scale = c->pitch * width / c->dpi * cos(atan(1 / c->slope)),
                    .offset = c->center,
                    .from_right = counts_from_right(c, invert)};
    if (c->n_cells == 0) {
        lens.channel[0] = red * subpixel;
        lens.channel[1] = 1 * subpixel;
        lens.channel[2] = (2 - red) * subpixel;
    }
    return lens;
}

/* ------------------------------------------------------------------------------------- print -- */

double lf_print_cos(const lf_print *print)
{
    return cos(print->optics.slant * LF_DEGREE);
}

double lf_print_sin(const lf_print *print)
{
    return sin(print->optics.slant * LF_DEGREE);
}

static lf_lens lens_of(const lf_print *print, double right, double down, double phase_mm,
                       double pitch_mm)
{
    const lf_optics *o = &print->optics;
    lf_lens lens = {.right = right,
                    .down = down,
                    .scale = 1.0 / pitch_mm,
                    .offset = phase_mm / pitch_mm,
                    .from_right = !print->reverse};
    if (!lf_print_is_exact(print))
        return lens;
    lens.thickness = o->thickness_mm;
    lens.index = lf_optics_index(o);
    lens.distance = o->distance_mm;
    lens.scale *= lf_lens_enlargement_of(print);
    return lens;
}

lf_lens lf_lens_of_print(const lf_print *print)
{
    const double pitch_mm = 25.4 / print->lpi, cosine = lf_print_cos(print),
                 sine = lf_print_sin(print);
    const double turned = print->horizontal ? -sine : cosine,
                 other = print->horizontal ? cosine : sine;
    return lens_of(print, turned, other, print->phase_mm, pitch_mm);
}

lf_lens lf_lens_of_print_rows(const lf_print *print)
{
    const double pitch_mm = 25.4 / print->lpi;
    const double row_mm =
        print->optics.grid == LF_LENS_HEXAGONAL ? pitch_mm * sqrt(0.75) : pitch_mm;
    return lens_of(print, -lf_print_sin(print), lf_print_cos(print), print->optics.phase_down_mm,
                   row_mm);
}
