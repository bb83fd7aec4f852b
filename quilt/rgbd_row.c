#include "quilt/rgbd_row.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

#define S LF_RGBD_SAMPLES

lf_status lf_rgbd_row_init(lf_rgbd_row *row, const lf_rgbd_columns *columns, int n_samples)
{
    const size_t n = (size_t)columns->n;
    *row = (lf_rgbd_row){.columns = *columns,
                         .light = lf_calloc(n, 3 * sizeof(uint16_t)),
                         .colour = lf_calloc(n, 3),
                         .code = lf_calloc(n, sizeof(float)),
                         .left = lf_calloc(n, sizeof(float)),
                         .right = lf_calloc(n, sizeof(float)),
                         .from = lf_calloc(n, sizeof(int)),
                         .to = lf_calloc(n, sizeof(int)),
                         .shown = lf_calloc((size_t)n_samples, sizeof(int))};
    if (row->light && row->colour && row->code && row->left && row->right && row->from && row->to &&
        row->shown)
        return LF_OK;
    lf_rgbd_row_finish(row);
    return LF_E_NOMEM;
}

void lf_rgbd_row_finish(lf_rgbd_row *row)
{
    lf_free(row->light);
    lf_free(row->colour);
    lf_free(row->code);
    lf_free(row->left);
    lf_free(row->right);
    lf_free(row->from);
    lf_free(row->to);
    lf_free(row->shown);
    *row = (lf_rgbd_row){0};
}

static bool is_step(float a, float b)
{
    return fabsf(a - b) > (float)LF_RGBD_STEP;
}

/* The code of a pixel that is not there. */
#define ABSENT (-1.0f)

/* Removes what is nearer than the picture's edge from a mirrored side, which begins at pixel `from`
 * in a direction; edge: the first pixel of the picture. */
static void remove_near(lf_rgbd_row *row, int from, int direction, int edge)
{
    const float most = row->code[edge] + (float)LF_RGBD_STEP;
    for (int j = from; j >= 0 && j < row->columns.n; j += direction)
        if (row->code[j] > most)
            row->code[j] = ABSENT;
}

static void find_edges(lf_rgbd_row *row)
{
    const int n = row->columns.n;
    const float *code = row->code;
    row->left[0] = code[0];
    for (int j = 1; j < n; j++) {
        const bool cut = is_step(code[j - 1], code[j]);
        const float shared = 0.5f * (code[j - 1] + code[j]);
        row->right[j - 1] = cut ? code[j - 1] : shared;
        row->left[j] = cut ? code[j] : shared;
    }
    row->right[n - 1] = code[n - 1];
}

void lf_rgbd_row_take(lf_rgbd_row *row, const lf_rgbd_surface *surface, int y)
{
    const lf_rgbd_columns *c = &row->columns;
    const size_t start = (size_t)y * (size_t)surface->n;
    for (int j = 0; j < c->n; j++) {
        const size_t from = start + (size_t)c->column[j];
        memcpy(row->light + 3 * j, surface->light + 3 * from, 3 * sizeof *row->light);
        memcpy(row->colour + 3 * j, surface->colour + 3 * from, 3);
        row->code[j] = surface->code[from];
    }
    if (c->first > 0)
        remove_near(row, c->first - 1, -1, c->first);
    if (c->end < c->n)
        remove_near(row, c->end, 1, c->end - 1);
    find_edges(row);
}

/* -------------------------------------------------------------------------------------- view -- */

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
    for (int j = 0; j < row->columns.n; j++) {
        const float x = (float)j + offset;
        row->from[j] = first_sample(x + gain * row->left[j], n);
        row->to[j] = first_sample(x + 1 + gain * row->right[j], n);
    }
}

static void paint(lf_rgbd_row *row, int j)
{
    for (int s = row->code[j] < 0 ? row->to[j] : row->from[j]; s < row->to[j]; s++)
        row->shown[s] = j;
}

/* lf_rgbd_row.shown of the gap between pixels j and j + 1, and back. */
static int mark_of(int j)
{
    return -2 - j;
}

/* The pixel at the rim of a gap, on its farther side. */
static int rim_of(const lf_rgbd_row *row, int mark)
{
    const int j = -2 - mark;
    return row->code[j] <= row->code[j + 1] ? j : j + 1;
}

/* What is shown at a sample: a pixel, or for a gap the pixel at its rim; -1: nothing. */
static int pixel_at(const lf_rgbd_row *row, int s)
{
    return row->shown[s] < -1 ? rim_of(row, row->shown[s]) : row->shown[s];
}

/* Paints the gap that opens between the sides of a cut. Its background goes on as far as the
 * farther side, and hides what is farther by a step: not the pixels that it would repeat. */
static void paint_gap(lf_rgbd_row *row, int j)
{
    if (row->to[j] >= row->from[j + 1] || row->code[j] < 0 || row->code[j + 1] < 0)
        return;
    const float least = fminf(row->code[j], row->code[j + 1]) - (float)LF_RGBD_STEP;
    for (int s = row->to[j]; s < row->from[j + 1]; s++) {
        const int there = pixel_at(row, s);
        if (there < 0 || row->code[there] < least)
            row->shown[s] = mark_of(j);
    }
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
        for (int j = 0; j < row->columns.n; j++) {
            if (j > 0)
                paint_gap(row, j - 1);
            paint(row, j);
        }
    else
        for (int j = row->columns.n - 1; j >= 0; j--) {
            if (j + 1 < row->columns.n)
                paint_gap(row, j);
            paint(row, j);
        }
}

/* ------------------------------------------------------------------------------------- holes -- */

/* Pixels at the rim of a hole that are not repeated, because their colours may be mixed with those
 * in front. */
enum { RIM = 2 };

/* Pixels of the surface from `rim` on, in a direction, at most `most`: without steps, and not
 * nearer than its rim by a step. */
static int length_of(const lf_rgbd_row *row, int rim, int direction, int most)
{
    int n = 1;
    for (int j = rim + direction; n < most && j >= 0 && j < row->columns.n; j += direction, n++)
        if (is_step(row->code[j], row->code[j - direction]) ||
            row->code[j] > row->code[rim] + (float)LF_RGBD_STEP)
            break;
    return n;
}

/* The surface of a background from *rim on in a direction: if this is only a splinter, the next one
 * that is not nearer. Moves *rim there; returns its length. */
static int surface_of(const lf_rgbd_row *row, int direction, int wanted, int *rim)
{
    const int first = length_of(row, *rim, direction, wanted);
    int at = *rim, there = first;
    for (int tries = 0; tries < 4 && (there <= RIM || row->code[at] < 0); tries++) {
        const int next = at + direction * there;
        if (next < 0 || next >= row->columns.n ||
            row->code[next] > row->code[*rim] + (float)LF_RGBD_STEP)
            return first;
        at = next;
        there = length_of(row, at, direction, wanted);
    }
    if (there <= RIM || row->code[at] < 0)
        return first;
    *rim = at;
    return there;
}

/* Where a hole's background is. */
typedef struct background {
    int rim, direction; /* its first pixel, and where it goes on */
} background;

/* Takes a pixel as the background if it is there, and farther than the background so far. */
static void prefer(const lf_rgbd_row *row, int rim, int direction, background *b)
{
    if (rim < 0 || rim >= row->columns.n || row->code[rim] < 0)
        return;
    if (b->rim < 0 || row->code[rim] < row->code[b->rim])
        *b = (background){rim, direction};
}

/* The background of a hole: the pixel at one of its ends, or the neighbour in the picture of one of
 * them, which may be hidden. */
static background background_of(const lf_rgbd_row *row, int before, int after)
{
    background b = {.rim = -1};
    prefer(row, after, 1, &b);
    prefer(row, before, -1, &b);
    if (before >= 0)
        prefer(row, before + 1, 1, &b);
    if (after >= 0)
        prefer(row, after - 1, -1, &b);
    return b;
}

/* Shows a background at samples [from, to) of a hole or gap over [low, high): the surface at its
 * rim goes on, mirrored. */
static void show_background(lf_rgbd_row *row, background b, int low, int high, int from, int to)
{
    const int there = surface_of(row, b.direction, (high - low) / S + 1 + RIM, &b.rim),
              skip = there > RIM ? RIM : there - 1, period = there - skip;
    for (int s = from; s < to; s++) {
        const int t = (b.direction > 0 ? high - 1 - s : s - low) / S % (2 * period);
        row->shown[s] = b.rim + b.direction * (skip + (t < period ? t : 2 * period - 1 - t));
    }
}

/* The end of the samples from `from` on that show the same. */
static int end_of(const lf_rgbd_row *row, int from, int n)
{
    int s = from + 1;
    while (s < n && row->shown[s] == row->shown[from])
        s++;
    return s;
}

/* A hole is beyond the sides of the picture, or where a mirrored front was left out. */
static void fill_hole(lf_rgbd_row *row, int from, int to, int n)
{
    const background b = background_of(row, from > 0 ? pixel_at(row, from - 1) : -1,
                                       to < n ? pixel_at(row, to) : -1);
    if (b.rim >= 0)
        show_background(row, b, from, to, from, to);
}

static void fill_gap(lf_rgbd_row *row, int from, int to)
{
    const int mark = row->shown[from], j = -2 - mark, rim = rim_of(row, mark);
    show_background(row, (background){rim, rim == j ? -1 : 1}, row->to[j], row->from[j + 1], from,
                    to);
}

static void fill_background(lf_rgbd_row *row, int n)
{
    for (int s = 0; s < n; s++) {
        if (row->shown[s] >= 0)
            continue;
        const int to = end_of(row, s, n);
        if (row->shown[s] == -1)
            fill_hole(row, s, to, n);
        else
            fill_gap(row, s, to);
        s = to - 1;
    }
}

/* The mean of the samples of a pixel, in linear light. */
static void average(const lf_rgbd_row *row, const lf_rgbd_light *light, const int *shown,
                    uint8_t *out)
{
    unsigned sum[3] = {S / 2, S / 2, S / 2};
    for (int s = 0; s < S; s++)
        for (int c = 0; c < 3; c++)
            sum[c] += shown[s] < 0 ? 0 : row->light[3 * shown[s] + c];
    for (int c = 0; c < 3; c++)
        out[c] = light->code_of[sum[c] / S];
}

void lf_rgbd_row_draw(lf_rgbd_row *row, const lf_rgbd_light *light, const lf_rgbd_move *move,
                      int n_out, uint8_t *out)
{
    const int n = S * n_out;
    find_samples(row, move, n);
    paint_all(row, move, n);
    fill_background(row, n);
    for (int x = 0; x < n_out; x++, out += 3) {
        const int *shown = row->shown + S * x;
        const int first = shown[0];
        if (first >= 0 && shown[1] == first && shown[2] == first && shown[3] == first)
            memcpy(out, row->colour + 3 * first, 3);
        else
            average(row, light, shown, out);
    }
}
