/* Prints in a folder of their own, written as quiltrender does, spoilt, and checked. Fails the
 * running test when anything goes wrong. */
#ifndef LF_TESTS_QUILT_CHECKED_H
#define LF_TESTS_QUILT_CHECKED_H

#include <jansson.h>

#include "quilt/proof/check.h"

/* A print as it lies in a folder. */
typedef struct lf_checked {
    char *folder;
    const char *tiff, *manifest; /* paths */
    lf_print print;
    lf_print_witness witness;
    lf_print_report report; /* of the last check */
} lf_checked;

typedef float lf_card_value(const void *context, int view, int row, int column, int c);

/* Waves at several depths, as a picture with parallax has them. */
float lf_card_waves(const void *context, int view, int row, int column, int c);
/* The same in all views. */
float lf_card_still(const void *context, int view, int row, int column, int c);
float lf_card_grey(const void *context, int view, int row, int column, int c);

/* Writes sheet.tif and sheet.json. chart: a pitch chart; value is not read. */
void lf_checked_make(const lf_print *print, lf_card_value *value, bool chart, lf_checked *out);
/* The same as sheet.pdf, whose path is out->tiff. */
void lf_checked_make_pdf(const lf_print *print, lf_card_value *value, bool chart, lf_checked *out);
/* Checks the file as it is now; with the witness of its writing, or without. */
void lf_checked_run(lf_checked *checked, bool with_witness);
/* Sets the manifest's SHA-256 and number of bytes to those of the file as it is now. */
void lf_checked_hash(const lf_checked *checked);
void lf_checked_finish(lf_checked *checked);

/* A point's result; it counts from 1, as in the list. */
lf_check_result lf_checked_point(const lf_checked *checked, int number);

/* The file's rows, decoded by libtiff; and writing them with other tags. */
typedef struct lf_saved {
    int width, height, samples, bits;
    uint8_t *data; /* [height][width][samples] of 8 or 16 bits */
    void *icc;
    uint32_t icc_size;
    double dpi[2];
    int compression, orientation, photometric, unit;
    int extra; /* extra samples */
} lf_saved;
void lf_saved_read(const char *path, lf_saved *out);
void lf_saved_write(const lf_saved *raster, const char *path);
void lf_saved_finish(lf_saved *raster);
/* A value as stored. */
uint16_t lf_saved_at(const lf_saved *raster, int x, int y, int c);
void lf_saved_set(lf_saved *raster, int x, int y, int c, double value);

/* The options of a small chart. */
lf_print lf_checked_chart(void);

#endif
