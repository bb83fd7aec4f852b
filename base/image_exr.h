/* Private to the readers of OpenEXR: a file that is open, and what of it is the picture.
 * image_exr.c reads its pixels, image_exr_header.c finds its part and channels, image_exr_says.c
 * what its attributes say. */
#ifndef LF_BASE_IMAGE_EXR_H
#define LF_BASE_IMAGE_EXR_H

#include <openexr.h>

#include "base/image_colours.h"
#include "base/image_formats.h"

/* What OpenEXRCore's callbacks reach. */
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
    bool named;             /* R, G, B or Y of the first part: the C++ library reads them, too */
    const char *channel[3]; /* red, green and blue; grey: the first alone. The library's */
    lf_image_colours colours;
} lf_exr_input;

/* The error that a result of the library is; returns its status. */
lf_status lf_exr_fail(const lf_exr_session *s, exr_result_t code);

/* Fills all but session and exr, of a file that is open. LF_E_FORMAT: it is no flat picture, has no
 * channels to take, or is too large. What is not read is noted. */
LF_NODISCARD lf_status lf_exr_read_header(lf_exr_input *in);

/* What the attributes of the part say of its pixels, once part, channels and windows are known. */
void lf_exr_read_attributes(lf_exr_input *in);

/* Appends ", NAME" (the first without its comma) where there is room, else "..." once. */
void lf_exr_list(char *list, size_t size, const char *name);

#endif
