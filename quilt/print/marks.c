#include "quilt/print/marks.h"

#include <math.h>

#include "quilt/print/print.h"

#define LINE_MM 0.2
#define STRIP_FROM 1.0
#define STRIP_TO 5.0
#define TICK_FROM 5.5
#define TICK_TO 7.5
#define CROP_FROM 1.0
#define CROP_TO 6.0
#define REGISTER_AT 4.0
#define REGISTER_ARM 2.5
#define REGISTER_RADIUS 1.5

lf_marks lf_marks_of(const lf_print *print, const lf_print_shape *shape)
{
    const double across = print->horizontal ? print->height_mm : print->width_mm;
    const double along = print->horizontal ? print->width_mm : print->height_mm;
    return (lf_marks){
        .width = shape->raster_width + 2 * shape->margin_px,
        .height = shape->raster_height + 2 * shape->margin_down_px,
        .margin_px = shape->margin_px,
        .margin_down_px = shape->margin_down_px,
        .horizontal = print->horizontal,
        .right = 25.4 / print->dpi,
        .down = 25.4 / lf_print_dpi_down(print),
        .pitch = 25.4 / print->lpi / lf_print_cos(print),
        .phase = print->phase_mm,
        .is_straight = lf_print_is_separable(print),
        .lens = lf_lens_of_print(print),
        .trim_across = 0.5 * across,
        .trim_along = 0.5 * along,
        .bleed_across = 0.5 * across + print->bleed_mm,
        .bleed_along = 0.5 * along + print->bleed_mm,
    };
}

/* The fraction of a pixel around x on a line of this width around `at`. */
static double on_line(double pixel, double x, double at, double width)
{
    const double half = 0.5 * pixel;
    const double covered = fmin(x + half, at + 0.5 * width) - fmax(x - half, at - 0.5 * width);
    return fmax(covered, 0.0) / pixel;
}

/* Size of a pixel in mm, across the lenses and along them. */
static double pixel_across(const lf_marks *marks)
{
    return marks->horizontal ? marks->down : marks->right;
}

static double pixel_along(const lf_marks *marks)
{
    return marks->horizontal ? marks->right : marks->down;
}

static bool within(double x, double from, double to)
{
    return x >= from && x < to;
}

/* The axis of lens 0 on a line along the edge, if the pitch were everywhere what it is here. */
static double axis_at(const lf_marks *marks, double across, double along)
{
    if (marks->is_straight)
        return marks->phase;
    const double phase = marks->horizontal ? lf_lens_phase(&marks->lens, along, across, 0)
                                           : lf_lens_phase(&marks->lens, across, along, 0);
    return across - phase * marks->pitch;
}

/* Ink beyond the ends of the lenses; out: distance from the bleed. */
static double end_ink(const lf_marks *marks, double across, double along, double out)
{
    const double axis = axis_at(marks, across, along);
    if (within(out, STRIP_FROM, STRIP_TO) && fabs(across) < marks->trim_across - 1.0) {
        const double lens = axis + marks->pitch * round((across - axis) / marks->pitch);
        return on_line(pixel_across(marks), across, lens, 0.25 * marks->pitch);
    }
    return within(out, TICK_FROM, TICK_TO) ? on_line(pixel_across(marks), across, axis, LINE_MM)
                                           : 0.0;
}

/* Ink beyond the first or last lens. */
static double side_ink(const lf_marks *marks, double out, double along)
{
    const double x = out - REGISTER_AT, radius = hypot(x, along);
    /* for the ring, which has all directions, a pixel is the finer of both sizes */
    const double finer = fmin(marks->right, marks->down);
    double ink = on_line(finer, radius, REGISTER_RADIUS, LINE_MM);
    if (fabs(along) < REGISTER_ARM)
        ink = fmax(ink, on_line(pixel_across(marks), x, 0.0, LINE_MM));
    if (fabs(x) < REGISTER_ARM)
        ink = fmax(ink, on_line(pixel_along(marks), along, 0.0, LINE_MM));
    return ink;
}

/* Ink of the lines on the trim edges, outside the bleed. */
static double crop_ink(const lf_marks *marks, double across, double along)
{
    double ink = 0.0;
    if (within(fabs(along) - marks->bleed_along, CROP_FROM, CROP_TO))
        ink = on_line(pixel_across(marks), fabs(across), marks->trim_across, LINE_MM);
    if (within(fabs(across) - marks->bleed_across, CROP_FROM, CROP_TO))
        ink = fmax(ink, on_line(pixel_along(marks), fabs(along), marks->trim_along, LINE_MM));
    return ink;
}

static double ink_at(const lf_marks *marks, double across, double along)
{
    const double beside = fabs(across) - marks->bleed_across;
    const double beyond = fabs(along) - marks->bleed_along;
    const double ink = crop_ink(marks, across, along);
    if (beyond > 0.0 && beside <= 0.0)
        return fmax(ink, end_ink(marks, across, along, beyond));
    if (beside > 0.0 && beyond <= 0.0)
        return fmax(ink, side_ink(marks, beside, along));
    return ink;
}

void lf_marks_row(const lf_marks *marks, int y, float *row)
{
    const double down = (y + 0.5 - 0.5 * marks->height) * marks->down;
    const bool beside_picture =
        y >= marks->margin_down_px && y < marks->height - marks->margin_down_px;
    for (int x = 0; x < marks->width; x++) {
        if (beside_picture && x == marks->margin_px)
            x = marks->width - marks->margin_px;
        const double right = (x + 0.5 - 0.5 * marks->width) * marks->right;
        const float light = (float)(1.0 - (marks->horizontal ? ink_at(marks, down, right)
                                                             : ink_at(marks, right, down)));
        for (int c = 0; c < 3; c++)
            row[3 * x + c] = light;
    }
}
