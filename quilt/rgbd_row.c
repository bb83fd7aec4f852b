#include "quilt/rgbd_row.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

#define S LF_RGBD_SAMPLES

/* -------------------------------------------------------------------------------------- light --
 */

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

/* ------------------------------------------------------------------------------------- memory --
 */

lf_status lf_rgbd_row_init(lf_rgbd_row *row, int n, int width, int n_samples)
{
    const size_t columns = (size_t)width, pixels = (size_t)n;
    *row = (lf_rgbd_row){.n = n,
                         .light = lf_calloc(columns, 3 * sizeof(float)),
                         .least = lf_calloc(columns, sizeof(float)),
                         .mean = lf_calloc(columns, sizeof(float)),
                         .most = lf_calloc(columns, sizeof(float)),
                         .chief = lf_calloc(columns, sizeof(float)),
                         .light16 = lf_calloc(pixels, 3 * sizeof(uint16_t)),
                         .colour = lf_calloc(pixels, 3),
                         .code = lf_calloc(pixels, sizeof(float)),
                         .spare = lf_calloc(pixels, sizeof(float)),
                         .left = lf_calloc(pixels, sizeof(float)),
                         .right = lf_calloc(pixels, sizeof(float)),
                         .from = lf_calloc(pixels, sizeof(int)),
                         .to = lf_calloc(pixels, sizeof(int)),
                         .shown = lf_calloc((size_t)n_samples, sizeof(int))};
    if (row->light && row->least && row->mean && row->most && row->chief && row->light16 &&
        row->colour && row->code && row->spare && row->left && row->right && row->from && row->to &&
        row->shown)
        return LF_OK;
    lf_rgbd_row_finish(row);
    return LF_E_NOMEM;
}

void lf_rgbd_row_finish(lf_rgbd_row *row)
{
    void *const all[] = {row->light,  row->least,   row->mean, row->most,  row->chief,
                         row->colour, row->light16, row->code, row->spare, row->left,
                         row->right,  row->from,    row->to,   row->shown};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        lf_free(all[i]);
    *row = (lf_rgbd_row){0};
}

/* -------------------------------------------------------------------------------- from pixels --
 */

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

static void add_colours(lf_rgbd_row *row, const lf_rgbd_light *light, const uint8_t *rgb,
                        float weight, int width)
{
    for (int i = 0; i < 3 * width; i++)
        row->light[i] += weight * light->of_code[rgb[i]];
}

/* Takes the codes of row i of the source. */
static void add_codes(lf_rgbd_row *row, const lf_rgbd *rgbd, const uint8_t *rgb, float weight,
                      bool is_first, bool is_chief, int width)
{
    for (int x = 0; x < width; x++) {
        const float code = code_of(rgbd, rgb + 3 * x);
        row->mean[x] += weight * code;
        if (is_first || code < row->least[x])
            row->least[x] = code;
        if (is_first || code > row->most[x])
            row->most[x] = code;
        if (is_chief)
            row->chief[x] = code;
    }
}

/* Reduces the rows of the source to one. */
static void reduce_rows(lf_rgbd_row *row, const lf_rgbd *rgbd, const lf_rgbd_light *light,
                        const lf_rgbd_source *s)
{
    int chief = 0;
    for (int i = 1; i < s->n; i++)
        if (s->weight[i] > s->weight[chief])
            chief = i;
    memset(row->light, 0, (size_t)s->width * 3 * sizeof *row->light);
    memset(row->mean, 0, (size_t)s->width * sizeof *row->mean);
    for (int i = 0; i < s->n; i++) {
        add_colours(row, light, s->colour + (size_t)i * s->stride, s->weight[i], s->width);
        add_codes(row, rgbd, s->depth + (size_t)i * s->stride, s->weight[i], i == 0, i == chief,
                  s->width);
    }
}

/* The code of a sample: the mean on a surface. At a step an area belongs to its nearest part, so
 * that mixed colours move with what is in front; an enlarged pixel keeps its side. */
static float code_at(const lf_rgbd_row *row, const lf_rgbd_columns *columns, int sample)
{
    const lf_axis_filter *f = columns->filter;
    const float *weight = f->weight + (size_t)sample * (size_t)f->max_taps;
    const int first = f->first[sample];
    float least = row->least[first], most = row->most[first], mean = 0;
    int chief = 0;
    for (int t = 0; t < f->n_taps[sample]; t++) {
        const int x = first + t;
        mean += weight[t] * row->mean[x];
        if (row->least[x] < least)
            least = row->least[x];
        if (row->most[x] > most)
            most = row->most[x];
        if (weight[t] > weight[chief])
            chief = t;
    }
    if (most - least <= (float)LF_RGBD_STEP)
        return mean;
    return columns->enlarged ? row->chief[first + chief] : most;
}

static void colour_at(lf_rgbd_row *row, const lf_rgbd_light *light, const lf_rgbd_columns *columns,
                      int j)
{
    const lf_axis_filter *f = columns->filter;
    const int sample = columns->column[j];
    const float *weight = f->weight + (size_t)sample * (size_t)f->max_taps,
                *from = row->light + 3 * (size_t)f->first[sample];
    for (int c = 0; c < 3; c++) {
        float sum = 0.5f;
        for (int t = 0; t < f->n_taps[sample]; t++)
            sum += weight[t] * from[3 * t + c];
        const uint16_t value = sum < 65535.0f ? (uint16_t)sum : 65535;
        row->light16[3 * j + c] = value;
        row->colour[3 * j + c] = light->code_of[value];
    }
}

/* -------------------------------------------------------------------------------------- steps --
 */

enum { REACH = 2, SHARPEN = 3 };

/* Makes steps of slopes that are too steep to be a surface, as cameras, JPEG and depth networks
 * make them: codes near either end of their neighbourhood become this end. A plane's code is in the
 * middle, and stays. */
static void sharpen(const float *in, int n, float *out)
{
    for (int j = 0; j < n; j++) {
        const int low = j > REACH ? j - REACH : 0, high = j + REACH < n - 1 ? j + REACH : n - 1;
        float least = in[j], most = in[j];
        for (int i = low; i <= high; i++) {
            least = in[i] < least ? in[i] : least;
            most = in[i] > most ? in[i] : most;
        }
        const float range = most - least;
        out[j] = range <= 2 * (float)LF_RGBD_STEP ? in[j]
                 : in[j] - least < 0.45f * range  ? least
                 : most - in[j] < 0.45f * range   ? most
                                                  : in[j];
    }
}

static bool is_step(float a, float b)
{
    return fabsf(a - b) > (float)LF_RGBD_STEP;
}

/* A pixel alone between two steps, in depth between its neighbours, is a mixture of both: it joins
 * the nearer one. */
static void join_lone(float *code, int n)
{
    for (int j = 1; j + 1 < n; j++) {
        const float before = code[j - 1], after = code[j + 1];
        const float near = before > after ? before : after, far = before > after ? after : before;
        if (is_step(code[j], before) && is_step(code[j], after) && code[j] < near && code[j] > far)
            code[j] = near;
    }
}

static void find_edges(lf_rgbd_row *row)
{
    const float *code = row->code;
    row->left[0] = code[0];
    for (int j = 1; j < row->n; j++) {
        const bool cut = is_step(code[j - 1], code[j]);
        const float shared = 0.5f * (code[j - 1] + code[j]);
        row->right[j - 1] = cut ? code[j - 1] : shared;
        row->left[j] = cut ? code[j] : shared;
    }
    row->right[row->n - 1] = code[row->n - 1];
}

void lf_rgbd_row_take(lf_rgbd_row *row, const lf_rgbd *rgbd, const lf_rgbd_light *light,
                      const lf_rgbd_source *source, const lf_rgbd_columns *columns)
{
    reduce_rows(row, rgbd, light, source);
    for (int j = 0; j < row->n; j++) {
        row->code[j] = code_at(row, columns, columns->column[j]);
        colour_at(row, light, columns, j);
    }
    for (int i = 0; i < SHARPEN; i++) {
        float *sharp = row->spare;
        sharpen(row->code, row->n, sharp);
        row->spare = row->code;
        row->code = sharp;
    }
    join_lone(row->code, row->n);
    find_edges(row);
}

/* --------------------------------------------------------------------------------------- view --
 */

/* The samples of a view that an edge at a column leaves to its right: the first whose middle is not
 * left of it, 0..n. */
static int first_sample(float at, int n)
{
    const float sample = (float)S * at - 0.5f;
    if (!(sample > 0))
        return 0;
    if (sample >= (float)n)
        return n;
    const int whole = (int)sample;
    return whole + ((float)whole < sample);
}

static void find_samples(lf_rgbd_row *row, const lf_rgbd_move *move, int n)
{
    const float gain = (float)move->gain, offset = (float)move->offset;
    for (int j = 0; j < row->n; j++) {
        const float x = (float)j + offset;
        row->from[j] = first_sample(x + gain * row->left[j], n);
        row->to[j] = first_sample(x + 1 + gain * row->right[j], n);
    }
}

static void paint(lf_rgbd_row *row, int j)
{
    for (int s = row->from[j]; s < row->to[j]; s++)
        row->shown[s] = j;
}

/* Of two points of a row at the same place of a view, the nearer one has moved further. So it comes
 * from the right if near points move to the left, and painting from the left to the right ends with
 * what is in front (McMillan, "An image-based approach to three-dimensional computer graphics",
 * 1997). */
static void paint_all(lf_rgbd_row *row, const lf_rgbd_move *move, int n)
{
    for (int s = 0; s < n; s++)
        row->shown[s] = -1;
    if (move->gain <= 0)
        for (int j = 0; j < row->n; j++)
            paint(row, j);
    else
        for (int j = row->n - 1; j >= 0; j--)
            paint(row, j);
}

/* -------------------------------------------------------------------------------------- holes --
 */

/* Pixels at the rim of a hole that are not repeated, because their colours may be mixed with those
 * in front. */
enum { RIM = 2 };

/* Pixels of the surface from `rim` on, in a direction, at most `most`: without steps, and not
 * nearer than its rim by a step. */
static int length_of(const lf_rgbd_row *row, int rim, int direction, int most)
{
    int n = 1;
    for (int j = rim + direction; n < most && j >= 0 && j < row->n; j += direction, n++)
        if (is_step(row->code[j], row->code[j - direction]) ||
            row->code[j] > row->code[rim] + (float)LF_RGBD_STEP)
            break;
    return n;
}

/* Fills samples [from, to) of a hole: the background goes on, mirrored at its rim. */
static void fill_hole(lf_rgbd_row *row, int from, int to, int n)
{
    const int before = from > 0 ? row->shown[from - 1] : -1, after = to < n ? row->shown[to] : -1;
    if (before < 0 && after < 0)
        return;
    const bool from_after = before < 0 || (after >= 0 && row->code[after] < row->code[before]);
    const int rim = from_after ? after : before, direction = from_after ? 1 : -1;
    const int wanted = (to - from) / S + 1 + RIM, there = length_of(row, rim, direction, wanted);
    const int skip = there > RIM ? RIM : there - 1, period = there - skip;
    for (int s = from; s < to; s++) {
        const int t = (from_after ? to - 1 - s : s - from) / S % (2 * period);
        row->shown[s] = rim + direction * (skip + (t < period ? t : 2 * period - 1 - t));
    }
}

static void fill_holes(lf_rgbd_row *row, int n)
{
    for (int s = 0; s < n; s++) {
        const int from = s;
        if (row->shown[s] >= 0)
            continue;
        while (s < n && row->shown[s] < 0)
            s++;
        fill_hole(row, from, s, n);
    }
}

/* The mean of the samples of a pixel, in linear light. */
static void average(const lf_rgbd_row *row, const lf_rgbd_light *light, const int *shown,
                    uint8_t *out)
{
    unsigned sum[3] = {S / 2, S / 2, S / 2};
    for (int s = 0; s < S; s++)
        for (int c = 0; c < 3; c++)
            sum[c] += shown[s] < 0 ? 0 : row->light16[3 * shown[s] + c];
    for (int c = 0; c < 3; c++)
        out[c] = light->code_of[sum[c] / S];
}

void lf_rgbd_row_draw(lf_rgbd_row *row, const lf_rgbd_light *light, const lf_rgbd_move *move,
                      int n_out, uint8_t *out)
{
    const int n = S * n_out;
    find_samples(row, move, n);
    paint_all(row, move, n);
    fill_holes(row, n);
    for (int x = 0; x < n_out; x++, out += 3) {
        const int *shown = row->shown + S * x;
        const int first = shown[0];
        if (first >= 0 && shown[1] == first && shown[2] == first && shown[3] == first)
            memcpy(out, row->colour + 3 * first, 3);
        else
            average(row, light, shown, out);
    }
}
