/* Metadata of a picture file: how to interpret its pixels, and notes about features that were not
 * used. Filled by a reader, for the code that shows the picture. One thread. */
#ifndef LF_BASE_IMAGE_METADATA_H
#define LF_BASE_IMAGE_METADATA_H

#include "base/status.h"

/* How a sky's pixels are arranged around the viewer. */
typedef enum lf_image_layout {
    LF_IMAGE_PLAIN, /* a picture, or the whole sphere in latitude and longitude */
    LF_IMAGE_CUBE,  /* six squares in a column: +X -X +Y -Y +Z -Z (OpenEXR's ImfEnvmap.h) */
    LF_N_IMAGE_LAYOUTS
} lf_image_layout;

enum { LF_IMAGE_NOTES = 2048, LF_IMAGE_MAX_FOCAL = 5000, LF_IMAGE_MAX_RATE = 1000 };

/* Lines for people, each ended by a newline, without the file's name. Zeroed: none. */
typedef struct lf_image_notes {
    size_t length;
    char text[LF_IMAGE_NOTES];
} lf_image_notes;

/* The geometry of a picture with depth that quiltd wrote, from its attributes (quiltd.near, …).
 * Zeroed: unknown; otherwise all members but width and height are positive. Lengths are in one
 * unit. */
typedef struct lf_image_depth {
    double near, far; /* along the view axis, of the nearest and farthest code; far: or INFINITY */
    double distance;  /* of the plane in which points stay in place from view to view */
    double fov_y, aspect, cone; /* degrees; aspect: width / height of a view */
    double views;               /* cameras of the whole line; a whole number */
    double centred;             /* 1: cameras in the middle of equal parts of the cone; 2: at its
                                 * ends */
    double width, height;       /* pixels of a view; 0: not given */
} lf_image_depth;
enum { LF_IMAGE_DEPTH_NUMBERS = 10 };
/* True if all numbers are as described. */
bool lf_image_depth_is_valid(const lf_image_depth *depth);

typedef struct lf_image_metadata {
    lf_image_layout layout;
    int orientation; /* EXIF orientation, 1..8; 0: none. Already applied by
                      * lf_image8_read_metadata */
    /* width / height of a pixel of the upright picture; 0: square */
    double pixel_aspect;
    /* frames per second of the animation that quiltd rendered it of; 0: unknown */
    double frame_rate;
    int focal_35mm; /* EXIF: focal length in mm, as if on film of 36 x 24 mm; 0: unknown */
    lf_image_depth depth;
    lf_image_notes notes;
} lf_image_metadata;

/* Sets the pixel aspect (width / height) that `what` (a chunk, an attribute) gives. Values near 1
 * count as square; values beyond 1:100 are noted and not used. */
void lf_image_metadata_aspect(lf_image_metadata *meta, const char *what, double aspect);

/* Adds a line without its control characters, unless it is there already; notes NULL: does nothing.
 * A line that is too long is cut; without room it is dropped. */
void lf_image_note(lf_image_notes *notes, const char *fmt, ...) LF_PRINTF(2, 3);
/* Adds the lines of text[length], which is not terminated (NULL with 0: none). */
void lf_image_note_lines(lf_image_notes *notes, const char *text, size_t length);
/* Copies the next line from *at into line and moves *at past it; false: none. Start with 0. */
bool lf_image_notes_next(const lf_image_notes *notes, size_t *at, char *line, size_t size);

#endif
