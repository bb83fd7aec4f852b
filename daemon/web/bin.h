/* bin: the image that comes with a message of the older protocol, in one memory file.
 *
 * A bitmap becomes raw RGB on its way (bmp.h); any other file is kept as it is, for quiltd to
 * decode. Images of all clients have a common limit. Thread: event. */
#ifndef LF_DAEMON_WEB_BIN_H
#define LF_DAEMON_WEB_BIN_H

#include <stdint.h>

#include "base/status.h"

#define LF_BIN_LIMIT_MIB 193 /* a bitmap of 8192x8192 has 201 MB */

typedef struct lf_bin lf_bin;

/* What all images share. */
typedef struct lf_bins {
    uint64_t limit; /* bytes of one image; all together may have twice as many */
    uint64_t used;
    /* Forgets an image that nobody waits for; false: there is none. */
    bool (*make_room)(void *context);
    void *context;
} lf_bins;

/* An empty image. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_bin_create(lf_bins *bins, lf_bin **out);
/* Accepts NULL. */
void lf_bin_destroy(lf_bin *bin);

/* Takes the next data[n]. After a failure, which lf_bin_finish reports, it is forgotten. */
void lf_bin_take(lf_bin *bin, const uint8_t *data, size_t n);
/* The image is there: seals its file. LF_E_ARG: it has no bytes, or too many; LF_E_BUSY: too many
 * images are there; LF_E_FORMAT, LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_bin_finish(lf_bin *bin, lf_error *err);

/* After lf_bin_finish: the file, which stays the image's, and the size of its raw pixels; 0: it is
 * an image file. */
int lf_bin_fd(const lf_bin *bin);
int lf_bin_width(const lf_bin *bin);
int lf_bin_height(const lf_bin *bin);

#endif
