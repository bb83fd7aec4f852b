/* What a picture file says of its pixels besides their numbers, and what of that the picture lacks:
 * filled by a reader, for whoever shows the picture. One thread. */
#ifndef LF_BASE_IMAGE_METADATA_H
#define LF_BASE_IMAGE_METADATA_H

#include "base/status.h"

/* How the pixels lie around the viewer, where the picture is a sky. */
typedef enum lf_image_layout {
    LF_IMAGE_PLAIN, /* a picture, or the whole sphere by latitude and longitude */
    LF_IMAGE_CUBE,  /* six squares one below the other: +X -X +Y -Y +Z -Z (OpenEXR's ImfEnvmap.h) */
    LF_N_IMAGE_LAYOUTS
} lf_image_layout;

enum { LF_IMAGE_NOTES = 2048 };

/* Lines for people, each ended by a newline; without the file's name. Zeroed: none. */
typedef struct lf_image_notes {
    size_t length;
    char text[LF_IMAGE_NOTES];
} lf_image_notes;

typedef struct lf_image_metadata {
    lf_image_layout layout;
    int orientation; /* of EXIF, 1..8; 0: none is said. lf_image8_read_metadata has obeyed it */
    /* width / height of a pixel of the picture, the right way up; 0: square */
    double pixel_aspect;
    lf_image_notes notes;
} lf_image_metadata;

/* Takes what `what` (a chunk, an attribute) says of the shape of pixels, width / height: near to 1
 * is square; beyond 1:100 it is noted and not used. */
void lf_image_metadata_aspect(lf_image_metadata *meta, const char *what, double aspect);

/* Adds a line, once however often it comes, without its control characters; notes NULL: nobody
 * listens. What is too long is cut, a line without room is dropped. */
void lf_image_note(lf_image_notes *notes, const char *fmt, ...) LF_PRINTF(2, 3);
/* Adds the lines of text, which has no end of its own (NULL with 0: none). */
void lf_image_note_lines(lf_image_notes *notes, const char *text, size_t length);
/* Copies the next line from *at on into line and moves *at behind it; false: there is none. Begin
 * with 0. */
bool lf_image_notes_next(const lf_image_notes *notes, size_t *at, char *line, size_t size);

#endif
