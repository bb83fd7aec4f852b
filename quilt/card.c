#include <math.h>
#include <stdio.h>
#include <string.h>

#include "quilt/font.h"
#include "quilt/quilt.h"

/* In squares of the font: advance per character and per line. */
#define ADVANCE 6
#define LEADING 13
/* Radii of strokes and of single squares: dots look smaller than they are. */
#define STROKE_RADIUS 0.42
#define DOT_RADIUS 0.62
/* Size of a square as a fraction of the card's shorter side: largest and smallest. */
#define LARGEST (1.0 / 120)
#define SMALLEST (1.0 / 220)
/* Number of sizes tried, from largest to smallest. */
#define SIZES 6
/* Margin at the left and right, as a fraction of the width. */
#define MARGIN 0.07
#define NAME "quiltd"
#define NAME_SIZE 0.75

enum { LINES = 9, MOST_STROKES = LF_FONT_COLUMNS * LF_FONT_ROWS * 2 };

static const uint8_t ground[3] = {0x26, 0x28, 0x2b}, ink[3] = {0xdc, 0xde, 0xe0},
                     dim[3] = {0x78, 0x7b, 0x80};

/* ------------------------------------------------------------------------------------- lines -- */

typedef struct lines {
    int n;
    char text[LINES][LF_CARD_TEXT];
} lines;

/* Number of characters of text for a line of at most `most`: up to a blank, otherwise up to a
 * separator of paths or names, otherwise as many as fit. */
static int line_length(const char *text, int most)
{
    const int n = (int)strlen(text);
    if (n <= most)
        return n;
    for (int i = most; i > 0; i--)
        if (text[i] == ' ')
            return i;
    for (int i = most; i > most / 2; i--)
        if (strchr("/_-.:,", text[i - 1]))
            return i;
    return most;
}

/* Wraps text into lines; false: it did not fit, and the last line ends with dots. */
static bool wrap(const char *text, int most, lines *out)
{
    out->n = 0;
    while (*text == ' ')
        text++;
    while (*text != '\0' && out->n < LINES) {
        const int n = line_length(text, most);
        char *line = out->text[out->n++];
        memcpy(line, text, (size_t)n);
        line[n] = '\0';
        for (text += n; *text == ' ';)
            text++;
    }
    if (*text == '\0')
        return true;
    char *last = out->text[LINES - 1];
    const size_t n = strlen(last), room = (size_t)most;
    memcpy(last + (n + 3 <= room ? n : room - 3), "...", 4);
    return false;
}

/* ----------------------------------------------------------------------------------- strokes -- */

/* A stroke of a glyph: a line between the centres of two adjacent squares; a single square is a
 * dot. */
typedef struct stroke {
    double x, y, dx, dy, radius;
} stroke;

static bool is_lit(const uint8_t *rows, int x, int y)
{
    return x >= 0 && x < LF_FONT_COLUMNS && y >= 0 && y < LF_FONT_ROWS &&
           (rows[y] >> (LF_FONT_COLUMNS - 1 - x) & 1) != 0;
}

/* Squares that touch at a corner are joined, unless they are joined through a third one. */
static bool is_joined(const uint8_t *rows, int x, int y, int dx, int dy)
{
    if (!is_lit(rows, x + dx, y + dy))
        return false;
    return dx == 0 || dy == 0 || (!is_lit(rows, x + dx, y) && !is_lit(rows, x, y + dy));
}

static int strokes_of(char character, stroke *out)
{
    static const int steps[8][2] = {{1, 0},  {0, 1},  {1, 1},   {-1, 1},
                                    {-1, 0}, {0, -1}, {-1, -1}, {1, -1}};
    const uint8_t *rows = lf_font_rows(character);
    int n = 0;
    for (int y = 0; y < LF_FONT_ROWS; y++) {
        for (int x = 0; x < LF_FONT_COLUMNS; x++) {
            bool alone = true;
            for (int i = 0; i < 8 && is_lit(rows, x, y); i++) {
                if (!is_joined(rows, x, y, steps[i][0], steps[i][1]))
                    continue;
                alone = false;
                if (i < 4) /* the other four belong to a neighbour */
                    out[n++] = (stroke){x + 0.5, y + 0.5, steps[i][0], steps[i][1], STROKE_RADIUS};
            }
            if (alone && is_lit(rows, x, y))
                out[n++] = (stroke){x + 0.5, y + 0.5, 0, 0, DOT_RADIUS};
        }
    }
    return n;
}

/* Distance of a point from a stroke's edge, in squares; negative: inside. */
static double outside(const stroke *s, double x, double y)
{
    const double px = x - s->x, py = y - s->y, length = s->dx * s->dx + s->dy * s->dy,
                 along = length > 0 ? (px * s->dx + py * s->dy) / length : 0,
                 t = fmin(fmax(along, 0), 1);
    return hypot(px - t * s->dx, py - t * s->dy) - s->radius;
}

/* Draws a glyph with its top left corner at (left, top), in pixels; edges are one pixel soft. */
static void draw_glyph(lf_image8 *image, char character, double left, double top, double square,
                       const uint8_t *colour)
{
    stroke strokes[MOST_STROKES];
    const int n = strokes_of(character, strokes);
    const int x0 = (int)fmax(left - 1, 0), y0 = (int)fmax(top - 1, 0),
              x1 = (int)fmin(left + LF_FONT_COLUMNS * square + 2, image->width),
              y1 = (int)fmin(top + LF_FONT_ROWS * square + 2, image->height);
    for (int y = y0; y < y1; y++) {
        uint8_t *row = image->data + (size_t)y * image->stride;
        for (int x = x0; x < x1; x++) {
            double least = INFINITY;
            for (int i = 0; i < n; i++)
                least = fmin(least, outside(&strokes[i], (x + 0.5 - left) / square,
                                            (y + 0.5 - top) / square));
            const double covered = fmin(fmax(0.5 - least * square, 0), 1);
            for (int c = 0; c < 3 && covered > 0; c++)
                row[x * 3 + c] =
                    (uint8_t)lrint(row[x * 3 + c] * (1 - covered) + colour[c] * covered);
        }
    }
}

/* Draws a line, horizontally centred. */
static void draw_line(lf_image8 *image, const char *text, double top, double square,
                      const uint8_t *colour)
{
    const double width = ((double)strlen(text) * ADVANCE - 1) * square;
    double left = (image->width - width) / 2;
    for (; *text != '\0'; text++, left += ADVANCE * square)
        draw_glyph(image, *text, left, top, square, colour);
}

/* -------------------------------------------------------------------------------------- card -- */

void lf_card_size(int panel_width, int panel_height, int *out_width, int *out_height)
{
    const int longer = panel_width > panel_height ? panel_width : panel_height;
    const double scale = fmax(640.0, longer / 3.2) / longer;
    *out_width = (int)fmax(round(panel_width * scale), 1);
    *out_height = (int)fmax(round(panel_height * scale), 1);
}

lf_status lf_card_draw(const char *text, int width, int height, lf_image8 *out)
{
    if (lf_image8_init(out, width, height, 3) != LF_OK)
        return LF_E_NOMEM;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            memcpy(out->data + (size_t)y * out->stride + (size_t)x * 3, ground, 3);
    char ascii[LF_CARD_TEXT];
    lf_font_ascii(text, ascii, sizeof ascii);
    const double side = fmin(width, height), room = width * (1 - 2 * MARGIN);
    double square = side * LARGEST;
    lines l = {0};
    for (int i = 0; i < SIZES; i++) {
        square = side * (LARGEST + (SMALLEST - LARGEST) * i / (SIZES - 1));
        const int most = (int)((room / square + 1) / ADVANCE);
        if (wrap(ascii, most > 4 ? most : 4, &l))
            break;
    }
    const double tall = ((l.n - 1) * LEADING + LF_FONT_ASCENT) * square;
    for (int i = 0; i < l.n; i++)
        draw_line(out, l.text[i], (height - tall) / 2 + i * LEADING * square, square, ink);
    const double small = side * SMALLEST * NAME_SIZE;
    draw_line(out, NAME, height - (LF_FONT_ROWS + LEADING) * small, small, dim);
    return LF_OK;
}
