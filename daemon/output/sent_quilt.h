/* sent_quilt: a quilt that a client sends instead of naming a file: raw pixels or a picture file,
 * by a descriptor that is kept among passed files. Thread: any. */
#ifndef LF_DAEMON_SENT_QUILT_H
#define LF_DAEMON_SENT_QUILT_H

#include "base/passed.h"
#include "quilt/quilt.h"
#include "quilt/rgbd.h"

#define LF_SENT_QUILT_SIDE 16384                /* pixels */
#define LF_SENT_QUILT_BYTES ((uint64_t)1 << 30) /* of the file, and of its pixels */

typedef struct lf_sent_quilt {
    bool given;           /* false: the other members are not valid */
    lf_quilt_tiles tiles; /* zeroed for a picture with depth */
    int width, height;    /* of raw RGB, 8 bits per channel; 0: a picture file */
} lf_sent_quilt;

/* Checks the descriptor as far as possible without reading, and adds it to passed. On LF_OK takes
 * fd. LF_E_ARG, LF_E_BUSY, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_sent_quilt_add(const lf_sent_quilt *quilt, lf_passed *passed, int fd,
                                         lf_error *err);
/* Reads the quilt of a list that lf_sent_quilt_add has filled. Errors name `name`. A picture is
 * decoded by a reader process. LF_E_FORMAT, LF_E_IO, LF_E_NOMEM, errors of lf_import_run. */
LF_NODISCARD lf_status lf_sent_quilt_read(const lf_sent_quilt *quilt, lf_passed *passed,
                                          const char *name, const lf_photo *photo,
                                          lf_quilt_file *out, lf_error *err);

/* A picture with depth that a client sends. */
typedef struct lf_sent_rgbd {
    const lf_standing *standing; /* set by the caller, with side */
    lf_rgbd_in side;
    lf_raster raster; /* the rest is set by lf_sent_rgbd_open */
    void *pixels;     /* mapped; NULL: the raster has its own */
    size_t bytes;
    lf_rgbd_file file;
} lf_sent_rgbd;
/* Like lf_sent_quilt_read, for a picture with depth; errors of lf_rgbd_file_take, too. Release it
 * with lf_sent_rgbd_close, also after a failure. */
LF_NODISCARD lf_status lf_sent_rgbd_open(const lf_sent_quilt *quilt, lf_passed *passed,
                                         const char *name, const lf_photo *photo,
                                         lf_sent_rgbd *rgbd, lf_error *err);
void lf_sent_rgbd_close(lf_sent_rgbd *rgbd);

#endif
