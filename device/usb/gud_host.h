/* The host of a GUD display over any link: its description, mode and updates.
 *
 *     lf_gud_host_open -> lf_gud_host_choose
 *     -> (lf_gud_host_start -> lf_gud_host_update …)* -> lf_gud_host_stop -> destroy
 *
 * Open and choose only query the display and change nothing on it. gud.h checks all data of the
 * display before use. No query is repeated, no wait is unlimited, and no allocation is larger than
 * a frame of LF_MAX_SIDE squared.
 *
 * Threads: an object and its link belong to one thread at a time. Private to device/, its tests and
 * bench. */
#ifndef LF_DEVICE_GUD_HOST_H
#define LF_DEVICE_GUD_HOST_H

#include "device/usb/gud.h"
#include "device/usb/usb_link.h"

typedef struct lf_gud_host lf_gud_host;

typedef struct lf_gud_host_counters {
    uint64_t bands;      /* accepted by the display */
    uint64_t compressed; /* compressed ones among them */
    uint64_t bytes;      /* bytes for them on the bulk endpoint */
    uint64_t failures;   /* failed updates */
} lf_gud_host_counters;

/* Queries descriptor, formats, properties, the first connector that is not disconnected, its EDID
 * and modes. A refused query of an optional item counts as its absence. link is borrowed until
 * destroy. Takes at most 5 s: a query may begin in the third second and take one, and asking for
 * the reason of a refusal another. LF_E_FORMAT: invalid data; LF_E_NODEV: unplugged, or all
 * connectors disconnected; LF_E_TIMEOUT, LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gud_host_open(lf_usb_link *link, lf_gud_host **out, lf_error *err);
/* Accepts NULL. Sends nothing to the display. */
void lf_gud_host_destroy(lf_gud_host *host);

/* The raw EDID, a multiple of 128 bytes; *out_n = 0 if there is none. Valid until destroy. */
const uint8_t *lf_gud_host_edid(const lf_gud_host *host, size_t *out_n);

/* The default mode (lf_gud_mode_choose without a size); false: no usable mode. */
bool lf_gud_host_preferred(const lf_gud_host *host, lf_gud_mode *out);

/* Chooses the mode (lf_gud_mode_choose) and allocates its buffers. To be called once. LF_E_ARG: no
 * mode of this size; LF_E_FORMAT: no usable mode, or the display's buffer is smaller than a row
 * (than a frame, for FULL_UPDATE); LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gud_host_choose(lf_gud_host *host, int width, int height, lf_error *err);
/* The chosen mode and the format of pixels. */
const lf_gud_mode *lf_gud_host_mode(const lf_gud_host *host);
lf_gud_format lf_gud_host_format(const lf_gud_host *host);

/* Sets the mode and switches the display on; its contents then count as unknown. May be called
 * again, also after failures. Errors of lf_gud_host_update. */
LF_NODISCARD lf_status lf_gud_host_start(lf_gud_host *host, lf_error *err);
/* Switches the display off; ignores failures. */
void lf_gud_host_stop(lf_gud_host *host);

/* Shows rects[n] of frame (the mode's size, 3 channels); pixels that are already shown are not
 * sent. Outside rects, frame must equal the frame of the last update, even of a failed one. After a
 * failure, the bands before it are shown and all others count as unknown: they are sent again whole
 * once a rectangle touches them. LF_E_NODEV unplugged; LF_E_TIMEOUT; LF_E_CANCELLED; LF_E_IO
 * refused, with the display's reason; LF_E_FORMAT an undefined status; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gud_host_update(lf_gud_host *host, const lf_image8 *frame,
                                          const lf_rect *rects, int n, lf_error *err);

/* LF_E_NODEV: the display is unplugged. LF_OK: it answers, or cannot be queried now. */
LF_NODISCARD lf_status lf_gud_host_alive(lf_gud_host *host);

void lf_gud_host_counters_get(const lf_gud_host *host, lf_gud_host_counters *out);

#endif
