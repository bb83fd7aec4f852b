/* The inverse of a panel's response: the last step before a picture is sent. */
#include <assert.h>
#include <math.h>

#include "quilt/quilt.h"

#define MAX_THROW 1000.0 /* largest ratio between the channels of a white */

/* CIE daylight (15:2004) of a nominal temperature: 6500 is D65. */
static void white_of_day(double kelvin, double out_xy[2])
{
    double t = kelvin * 1.4388 / 1.438, x;
    if (t <= 7000.0)
        x = 0.244063 + 0.09911e3 / t + 2.9678e6 / (t * t) - 4.6070e9 / (t * t * t);
    else
        x = 0.237040 + 0.24748e3 / t + 1.9018e6 / (t * t) - 2.0064e9 / (t * t * t);
    out_xy[0] = x;
    out_xy[1] = -3.0 * x * x + 2.870 * x - 0.275;
}

/* The amount of each primary of Rec. 709 in the panel's white; 1 each for D65. */
static bool white_of(const lf_response *response, double out[3])
{
    static const double from_xyz[3][3] = {{3.2404542, -1.5371385, -0.4985314},
                                          {-0.9692660, 1.8760108, 0.0415560},
                                          {0.0556434, -0.2040259, 1.0572252}};
    double xy[2] = {response->white_x, response->white_y}, least = INFINITY, most = 0.0;
    if (response->white > 0.0)
        white_of_day(response->white, xy);
    for (int c = 0; c < 3; c++) {
        out[c] = 1.0;
        if (xy[0] > 0.0 && xy[1] > 0.0)
            out[c] = from_xyz[c][0] * xy[0] / xy[1] + from_xyz[c][1] +
                     from_xyz[c][2] * (1.0 - xy[0] - xy[1]) / xy[1];
        least = fmin(least, out[c]);
        most = fmax(most, out[c]);
    }
    return least > most / MAX_THROW;
}

static double decoded(int code)
{
    double s = code / 255.0;
    return s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4);
}

static double encoded(double light, double gamma)
{
    if (gamma > 0.0 && isfinite(gamma))
        return pow(light, 1.0 / gamma);
    return light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1.0 / 2.4) - 0.055;
}

lf_status lf_response_codes(const lf_response *response, lf_codes *out, lf_error *err)
{
    double white[3];
    if (response->white > 0.0 && (response->white_x > 0.0 || response->white_y > 0.0))
        return lf_error_set(err, LF_E_ARG, "white", "give a temperature or x and y, not both");
    if ((response->white_x > 0.0) != (response->white_y > 0.0))
        return lf_error_set(err, LF_E_ARG, "white", "x and y must be given together");
    if (!white_of(response, white))
        return lf_error_set(err, LF_E_ARG, "white",
                            "x %g, y %g is not a colour that red, green and blue can mix",
                            response->white_x, response->white_y);
    double least = fmin(white[0], fmin(white[1], white[2]));
    lf_codes codes = {.same = true};
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 256; i++) {
            double light = decoded(i) * least / white[c];
            codes.code[c][i] = (uint8_t)floor(255.0 * encoded(light, response->gamma) + 0.5);
            codes.same = codes.same && codes.code[c][i] == i;
        }
    *out = codes;
    return LF_OK;
}

typedef struct coding {
    const lf_codes *codes;
    lf_image8 *image;
} coding;

static void code_row(void *context, int row, int worker)
{
    const coding *c = context;
    size_t n = (size_t)c->image->width * 3;
    uint8_t *at = c->image->data + (size_t)row * n;
    (void)worker;
    for (size_t i = 0; i < n; i += 3)
        for (int k = 0; k < 3; k++)
            at[i + (size_t)k] = c->codes->code[k][at[i + (size_t)k]];
}

void lf_codes_apply(const lf_codes *codes, lf_image8 *image, lf_pool *pool)
{
    coding c = {codes, image};
    assert(image->channels == 3);
    if (codes->same)
        return;
    if (pool)
        (void)!lf_pool_run(pool, image->height, code_row, &c, NULL);
    for (int row = 0; row < image->height && !pool; row++)
        code_row(&c, row, 0);
}
