/* What the tests of picture files share: files made by other libraries than ours or byte by byte,
 * and ours written and read back. All fail the running test when anything goes wrong. */
#ifndef LF_TESTS_BASE_PICTURES_H
#define LF_TESTS_BASE_PICTURES_H

#include "tests/testing.h"

#include <ImfCRgbaFile.h>
#include <jpeglib.h>
#include <png.h>

#include "base/image_io.h"

/* Numbers that differ from test to test but not from run to run. */
uint32_t lf_picture_random(uint64_t *seed);
/* A smooth picture, 0.1 to 0.7, and 8 bits of noise. */
float lf_picture_smooth(int x, int y, int c);
lf_image8 lf_picture_noise(int width, int height);

void lf_picture_write(const char *path, const void *data, size_t n);
/* Release by lf_free. */
char *lf_picture_bytes(const char *path, size_t *n);

void lf_picture_save_png(const char *path, const lf_image8 *image, int level,
                         const lf_attribute *attributes, int n);
void lf_picture_save_exr(const char *path, const lf_image32 *image, const lf_attribute *attributes,
                         int n);
lf_image8 lf_picture_load8(const char *path);
lf_image32 lf_picture_load32(const char *path);
/* It is LF_E_FORMAT, with this word, and nothing is read. */
void lf_picture_refused(const char *path, const char *word);

/* The smooth picture, by libjpeg. */
void lf_picture_jpeg(const char *path, int width, int height, int components, J_COLOR_SPACE space);
/* Rows of any kind of PNG, by libpng; palettes have four colours, of which the second is clear and
 * the third nearly. clear: what is clear in pictures without alpha; NULL: nothing. */
void lf_picture_png(const char *path, int width, int height, int depth, int color, bool interlaced,
                    const png_color_16 *clear, uint8_t *rows, size_t stride);
/* The smooth picture in half floats, by OpenEXR's C++ library. Windows are {x0, y0, x1, y1}, ends
 * included. */
void lf_picture_half_exr(const char *path, const int display[4], const int data[4], int compression,
                         int channels, bool tiled);
/* The header of an HDR file with more lines; returns its length. */
size_t lf_picture_hdr_header(char *to, const char *resolution, const char *more);

#endif
