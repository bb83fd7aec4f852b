#include "quilt/rgbd_surface.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

/* ------------------------------------------------------------------------------------- light -- */

void lf_rgbd_light_init(lf_rgbd_light *light)
{
    int code = 0;
    lf_srgb_light(light->of_code);
    for (int c = 0; c < 256; c++)
        light->of_code[c] *= 65535.0f;
    for (int v = 0; v < 65536; v++) {
        /* the curve between two codes is close to linear, except in light that 16 bits resolve */
        while (code < 255 && (float)v > 0.5f * (light->of_code[code] + light->of_code[code + 1]))
            code++;
        light->code_of[v] = (uint8_t)code;
    }
}

/* ------------------------------------------------------------------------------------ memory -- */

lf_status lf_rgbd_surface_init(lf_rgbd_surface *surface, int n, int height)
{
    const size_t pixels = (size_t)n * (size_t)height;
    *surface = (lf_rgbd_surface){.n = n,
                                 .height = height,
                                 .light = lf_calloc(pixels, 3 * sizeof(uint16_t)),
                                 .colour = lf_calloc(pixels, 3),
                                 .code = lf_calloc(pixels, sizeof(float)),
                                 .spare = lf_calloc(pixels, sizeof(float))};
    if (surface->light && surface->colour && surface->code && surface->spare)
        return LF_OK;
    lf_rgbd_surface_finish(surface);
    return LF_E_NOMEM;
}

void lf_rgbd_surface_finish(lf_rgbd_surface *surface)
{
    lf_free(surface->light);
    lf_free(surface->colour);
    lf_free(surface->code);
    lf_free(surface->spare);
    *surface = (lf_rgbd_surface){0};
}

lf_status lf_rgbd_strip_init(lf_rgbd_strip *strip, int width)
{
    const size_t n = (size_t)width;
    *strip = (lf_rgbd_strip){.light = lf_calloc(n, 3 * sizeof(float)),
                             .least = lf_calloc(n, sizeof(float)),
                             .mean = lf_calloc(n, sizeof(float)),
                             .most = lf_calloc(n, sizeof(float)),
                             .chief = lf_calloc(n, sizeof(float))};
    if (strip->light && strip->least && strip->mean && strip->most && strip->chief)
        return LF_OK;
    lf_rgbd_strip_finish(strip);
    return LF_E_NOMEM;
}

void lf_rgbd_strip_finish(lf_rgbd_strip *strip)
{
    lf_free(strip->light);
    lf_free(strip->least);
    lf_free(strip->mean);
    lf_free(strip->most);
    lf_free(strip->chief);
    *strip = (lf_rgbd_strip){0};
}

/* ------------------------------------------------------------------------------- from pixels -- */

/* Red is near, and blue, a third of the circle beyond green, is far. Magentas beyond blue count as
 * the end that they are closer to. Grey, black and white have no hue: far. */
static float code_of_hue(const uint8_t *rgb)
{
    const int r = rgb[0], g = rgb[1], b = rgb[2];
    const int most = r > g ? (r > b ? r : b) : (g > b ? g : b),
              least = r < g ? (r < b ? r : b) : (g < b ? g : b);
    const float chroma = (float)(most - least);
    if (most == least)
        return 0;
    float sixth = most == r   ? (float)(g - b) / chroma
                  : most == g ? 2 + (float)(b - r) / chroma
                              : 4 + (float)(r - g) / chroma;
    if (sixth > 5)
        sixth -= 6;
    return sixth <= 0 ? 1 : sixth >= 4 ? 0 : 1 - sixth / 4;
}

static float code_of(const lf_rgbd *rgbd, const uint8_t *rgb)
{
    float code = rgbd->is_hue ? code_of_hue(rgb) : (float)(rgb[0] + rgb[1] + rgb[2]) / 765.0f;
    if (rgbd->near_is_black)
        code = 1 - code;
    return code > (float)rgbd->cutoff ? code : (float)rgbd->cutoff;
}

static void add_colours(lf_rgbd_strip *c, const lf_rgbd_light *light, const uint8_t *rgb,
                        float weight, int width)
{
    for (int i = 0; i < 3 * width; i++)
        c->light[i] += weight * light->of_code[rgb[i]];
}

/* Takes the codes of row i of the source. */
static void add_codes(lf_rgbd_strip *c, const lf_rgbd *rgbd, const uint8_t *rgb, float weight,
                      bool is_first, bool is_chief, int width)
{
    for (int x = 0; x < width; x++) {
        const float code = code_of(rgbd, rgb + 3 * x);
        c->mean[x] += weight * code;
        if (is_first || code < c->least[x])
            c->least[x] = code;
        if (is_first || code > c->most[x])
            c->most[x] = code;
        if (is_chief)
            c->chief[x] = code;
    }
}

/* Reduces the rows of the source to one. */
static void reduce_rows(lf_rgbd_strip *c, const lf_rgbd *rgbd, const lf_rgbd_light *light,
                        const lf_rgbd_source *s)
{
    int chief = 0;
    for (int i = 1; i < s->n; i++)
        if (s->weight[i] > s->weight[chief])
            chief = i;
    memset(c->light, 0, (size_t)s->width * 3 * sizeof *c->light);
    memset(c->mean, 0, (size_t)s->width * sizeof *c->mean);
    for (int i = 0; i < s->n; i++) {
        add_colours(c, light, s->colour + (size_t)i * s->stride, s->weight[i], s->width);
        add_codes(c, rgbd, s->depth + (size_t)i * s->stride, s->weight[i], i == 0, i == chief,
                  s->width);
    }
}

/* The code of sample j: the mean on a surface. At a step an area belongs to its nearest part, so
 * that mixed colours move with what is in front; an enlarged pixel keeps its side. */
static float code_at(const lf_rgbd_strip *c, const lf_axis_filter *f, bool enlarged, int j)
{
    const float *weight = f->weight + (size_t)j * (size_t)f->max_taps;
    const int first = f->first[j];
    float least = c->least[first], most = c->most[first], mean = 0;
    int chief = 0;
    for (int t = 0; t < f->n_taps[j]; t++) {
        const int x = first + t;
        mean += weight[t] * c->mean[x];
        if (c->least[x] < least)
            least = c->least[x];
        if (c->most[x] > most)
            most = c->most[x];
        if (weight[t] > weight[chief])
            chief = t;
    }
    if (most - least <= (float)LF_RGBD_STEP)
        return mean;
    return enlarged ? c->chief[first + chief] : most;
}

void lf_rgbd_surface_take(lf_rgbd_surface *surface, int y, const lf_rgbd *rgbd,
                          const lf_rgbd_light *light, const lf_rgbd_source *source,
                          const lf_axis_filter *filter, lf_rgbd_strip *strip)
{
    const size_t start = (size_t)y * (size_t)surface->n;
    reduce_rows(strip, rgbd, light, source);
    for (int j = 0; j < surface->n; j++) {
        const float *weight = filter->weight + (size_t)j * (size_t)filter->max_taps,
                    *from = strip->light + 3 * (size_t)filter->first[j];
        const size_t to = 3 * (start + (size_t)j);
        surface->code[start + (size_t)j] = code_at(strip, filter, source->enlarged, j);
        for (size_t c = 0; c < 3; c++) {
            float sum = 0.5f;
            for (int t = 0; t < filter->n_taps[j]; t++)
                sum += weight[t] * from[3 * (size_t)t + c];
            surface->light[to + c] = sum < 65535.0f ? (uint16_t)sum : 65535;
            surface->colour[to + c] = light->code_of[surface->light[to + c]];
        }
    }
}

/* ------------------------------------------------------------------------------------- steps -- */

static bool is_step(float a, float b)
{
    return fabsf(a - b) > (float)LF_RGBD_STEP;
}

/* The least and the greatest code at most `reach` pixels from pixel j of row y along both axes. */
static void range_at(const lf_rgbd_surface *s, int y, int j, int reach, float *out_least,
                     float *out_most)
{
    const int top = y > reach ? y - reach : 0, left = j > reach ? j - reach : 0,
              bottom = y + reach < s->height - 1 ? y + reach : s->height - 1,
              right = j + reach < s->n - 1 ? j + reach : s->n - 1;
    float least = s->code[(size_t)y * (size_t)s->n + (size_t)j], most = least;
    for (int i = top; i <= bottom; i++) {
        const float *code = s->code + (size_t)i * (size_t)s->n;
        for (int k = left; k <= right; k++) {
            least = code[k] < least ? code[k] : least;
            most = code[k] > most ? code[k] : most;
        }
    }
    *out_least = least;
    *out_most = most;
}

/* A pixel among enough pixels of its code is on a plateau, which is no part of a slope. */
static bool is_plateau(const lf_rgbd_surface *s, int y, int j)
{
    const int top = y > 2 ? y - 2 : 0, left = j > 2 ? j - 2 : 0,
              bottom = y + 2 < s->height - 1 ? y + 2 : s->height - 1,
              right = j + 2 < s->n - 1 ? j + 2 : s->n - 1;
    const float own = s->code[(size_t)y * (size_t)s->n + (size_t)j];
    int alike = 0;
    for (int i = top; i <= bottom; i++) {
        const float *code = s->code + (size_t)i * (size_t)s->n;
        for (int k = left; k <= right; k++)
            alike += fabsf(code[k] - own) < 0.5f * (float)LF_RGBD_STEP;
    }
    return alike >= s->plateau;
}

/* The code that pixel j gets at a step whose ends in 5 x 5 pixels are these: its own, or that of
 * the nearest pixels of an end's surface. */
static float sharp_at(const lf_rgbd_surface *s, int y, int j, float least, float most)
{
    const float own = s->code[(size_t)y * (size_t)s->n + (size_t)j], range = most - least;
    const bool falls = own - least < 0.45f * range, rises = !falls && most - own < 0.45f * range;
    if ((!falls && !rises) || is_plateau(s, y, j))
        return own;
    float low, high;
    range_at(s, y, j, 1, &low, &high);
    const float end = rises ? most : least, close = rises ? high : low;
    return is_step(close, end) ? end : close;
}

/* Codes near either end of their neighbourhood become this end, as a camera's sharpness, JPEG and
 * depth networks make slopes of steps. A plane's code is in the middle, and stays; so does a
 * surface between two others. */
void lf_rgbd_surface_sharpen(const lf_rgbd_surface *surface, int y)
{
    const size_t start = (size_t)y * (size_t)surface->n;
    const float *code = surface->code + start;
    float *out = surface->spare + start;
    for (int j = 0; j < surface->n; j++) {
        float least, most;
        range_at(surface, y, j, 2, &least, &most);
        out[j] = most - least <= 2 * (float)LF_RGBD_STEP ? code[j]
                                                         : sharp_at(surface, y, j, least, most);
    }
}

void lf_rgbd_surface_join(const lf_rgbd_surface *surface, int y)
{
    const size_t start = (size_t)y * (size_t)surface->n;
    const float *code = surface->code + start;
    float *out = surface->spare + start;
    for (int j = 0; j < surface->n; j++) {
        float least, most;
        range_at(surface, y, j, 1, &least, &most);
        const bool is_between =
            most - code[j] > (float)LF_RGBD_STEP && code[j] - least > (float)LF_RGBD_STEP;
        out[j] = is_between && !is_plateau(surface, y, j) ? most : code[j];
    }
}

void lf_rgbd_surface_widen(const lf_rgbd_surface *surface, int y)
{
    const size_t start = (size_t)y * (size_t)surface->n;
    const float *code = surface->code + start;
    float *out = surface->spare + start;
    for (int j = 0; j < surface->n; j++) {
        float least, most;
        range_at(surface, y, j, 1, &least, &most);
        out[j] = most - code[j] > (float)LF_RGBD_STEP ? most : code[j];
    }
}
