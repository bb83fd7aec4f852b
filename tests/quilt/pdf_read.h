/* What tests read of a PDF that pdf.c or a print wrote. It shares no code with the writer: objects
 * are found by the cross-reference table, the image is inflated and unfiltered by the rules of PNG.
 * Fails the running test when anything is wrong. */
#ifndef LF_TESTS_QUILT_PDF_READ_H
#define LF_TESTS_QUILT_PDF_READ_H

#include <stddef.h>
#include <stdint.h>

typedef struct lf_pdf_read {
    char *bytes; /* the file, with a 0 behind it */
    size_t size;
    int n_objects;
    int width, height, channels, bits; /* of the image; 0: none */
    uint16_t *value;                   /* [height][width][channels] */
    double matrix[6];                  /* that places it */
    double media[4], bleed[4], trim[4];
} lf_pdf_read;

void lf_pdf_read_file(const char *path, lf_pdf_read *out);
void lf_pdf_read_finish(lf_pdf_read *pdf);
/* True if a part of the file is this text. */
int lf_pdf_read_has(const lf_pdf_read *pdf, const char *text);
/* Where object's first byte is, behind "N 0 obj\n". */
const char *lf_pdf_read_object(const lf_pdf_read *pdf, int object);

#endif
