/* Private to the readers of OpenEXR: an open file and the part of it that is the picture.
 * image_exr.c reads pixels, image_exr_header.c finds part and channels, image_exr_says.c reads
 * attributes. */
#ifndef LF_BASE_IMAGE_EXR_H
#define LF_BASE_IMAGE_EXR_H

#include <openexr.h>

#include "base/image_colours.h"
#include "base/image_formats.h"

/* State for OpenEXRCore's callbacks. */
typedef struct lf_exr_session {
    const lf_image_source *source; /* reading */
    lf_outfile *file;              /* writing */
    lf_error *err;
    lf_status status;  /* of our own I/O */
    char message[200]; /* the library's first complaint */
} lf_exr_session;

typedef struct lf_exr_input {
    lf_exr_session *session;
    exr_context_t exr;
    int part;
    exr_attr_box2i_t data, display;
    int data_width, data_height;
    exr_compression_t compression;
    bool tiled, grey, chroma, half;
    bool named;             /* R, G, B or Y of the first part, which the C++ library also reads */
    const char *channel[3]; /* red, green and blue; grey: only the first. Owned by the library */
    lf_image_colours colours;
} lf_exr_input;

/* Sets the error for a result of the library; returns its status. */
lf_status lf_exr_fail(const lf_exr_session *s, exr_result_t code);

/* Fills all members except session and exr from an open file. LF_E_FORMAT: not a flat picture, no
 * usable channels, or too large. Parts that are not read are noted. */
LF_NODISCARD lf_status lf_exr_read_header(lf_exr_input *in);

/* Reads the part's attributes about its pixels, once part, channels and windows are known. */
void lf_exr_read_attributes(lf_exr_input *in);

/* Appends ", NAME" (the first without comma) if there is room, otherwise "..." once. */
void lf_exr_list(char *list, size_t size, const char *name);

#endif
