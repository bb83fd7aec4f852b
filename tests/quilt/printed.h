/* A print made by lf_print_write or lf_chart_write, read back from its file by libtiff. Fails the
 * running test when anything goes wrong. */
#ifndef LF_TESTS_QUILT_PRINTED_H
#define LF_TESTS_QUILT_PRINTED_H

#include <jansson.h>

#include "quilt/prints.h"

typedef struct lf_printed {
    int width, height, channels, bits;
    uint16_t *value; /* [height][width][channels] as stored: 0..255 or 0..65535 */
    uint8_t *file;   /* the TIFF's bytes */
    size_t file_size;
    json_t *manifest;
} lf_printed;

/* rows_per_strip 0 = as lf_print_write chooses. */
void lf_printed_make(const lf_print *print, const lf_views32 *views, int rows_per_strip,
                     lf_printed *out);
/* The same with lf_chart_write. */
void lf_printed_chart(const lf_print *print, lf_printed *out);
/* The raster of any TIFF; the other members stay as they are. */
void lf_printed_read(const char *path, lf_printed *out);
void lf_printed_finish(lf_printed *printed);

/* A value as it is stored. */
uint16_t lf_printed_at(const lf_printed *printed, int x, int y, int c);
/* Both hold the same picture. */
void lf_printed_assert_same(const lf_printed *a, const lf_printed *b);
/* Linear light 0..1 of an sRGB print's value. */
double lf_printed_linear(const lf_printed *printed, int x, int y, int c);
/* The sRGB curve's inverse. */
double lf_srgb_to_linear(double encoded);

/* Views of the print's shape, [view][row][column]; value(context, view, row, column, c) is linear.
 * Release out->data by lf_free. */
void lf_card_make(const lf_print *print,
                  float (*value)(const void *context, int view, int row, int column, int c),
                  const void *context, lf_views32 *out);
void lf_card_finish(lf_views32 *views);

/* A value for lf_card_make that tells view, row, column and channel, within 0..1. */
float lf_card_speckle(const void *context, int view, int row, int column, int c);

/* A sound print to start from: 8 views, 60 lpi on 600 dpi, 50.8 x 2.54 mm, 8 bits, no compression.
 */
lf_print lf_print_sound(void);
/* One whose numbers divide nothing evenly, with a bleed and a phase; 7 views, 16 bits. */
lf_print lf_print_odd(void);

#endif
