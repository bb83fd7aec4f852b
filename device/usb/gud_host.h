/* The host of a GUD display over any link: what it says of itself, its mode, and updates.
 *
 *     lf_gud_host_open -> lf_gud_host_choose
 *     -> (lf_gud_host_start -> lf_gud_host_update …)* -> lf_gud_host_stop -> destroy
 *
 * Up to choose the display is only asked, nothing on it changes. Nothing that it says is believed
 * before gud.h has checked it, nothing is asked twice or waited for without an end, and no
 * allocation is larger than a frame of LF_MAX_SIDE squared. Threads: an object, and its link,
 * belong to one thread at a time. Private to device/, its tests and bench. */
#ifndef LF_DEVICE_GUD_HOST_H
#define LF_DEVICE_GUD_HOST_H

#include "device/usb/gud.h"
#include "device/usb/usb_link.h"

typedef struct lf_gud_host lf_gud_host;

typedef struct lf_gud_host_counters {
    uint64_t bands;      /* that the display took */
    uint64_t compressed; /* of them */
    uint64_t bytes;      /* on the bulk endpoint for them */
    uint64_t failures;   /* updates that broke off */
} lf_gud_host_counters;

/* Asks for descriptor, formats, properties, the first connector that is not disconnected, its EDID
 * and modes. Refusing is an answer where a display need not have any. link is borrowed until
 * destroy. Takes at most 5 s (a question may begin in the third, takes one, and a refusal's reason
 * another). LF_E_FORMAT: it says what it must not; LF_E_NODEV: unplugged, or all connectors
 * disconnected; LF_E_TIMEOUT, LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gud_host_open(lf_usb_link *link, lf_gud_host **out, lf_error *err);
/* Accepts NULL. Says nothing to the display. */
void lf_gud_host_destroy(lf_gud_host *host);

/* The raw EDID, a multiple of 128 bytes; *out_n = 0 when it has none. Valid until destroy. */
const uint8_t *lf_gud_host_edid(const lf_gud_host *host, size_t *out_n);

/* The mode that it would show in by itself (lf_gud_mode_choose without a size); false when none can
 * be used. */
bool lf_gud_host_preferred(const lf_gud_host *host, lf_gud_mode *out);

/* Chooses the mode (lf_gud_mode_choose) and makes the buffers for it. LF_E_ARG: it has no mode of
 * this size; LF_E_FORMAT: its modes cannot be used, or its buffer is smaller than a row (than a
 * frame, when it wants whole ones); LF_E_NOMEM. Once. */
LF_NODISCARD lf_status lf_gud_host_choose(lf_gud_host *host, int width, int height, lf_error *err);
/* The chosen mode and the format of pixels. */
const lf_gud_mode *lf_gud_host_mode(const lf_gud_host *host);
lf_gud_format lf_gud_host_format(const lf_gud_host *host);

/* Sets the mode and switches the display on; what it shows counts as unknown. May be called again,
 * after failures too. Errors as lf_gud_host_update. */
LF_NODISCARD lf_status lf_gud_host_start(lf_gud_host *host, lf_error *err);
/* Switches the display off; failures do not matter any more. */
void lf_gud_host_stop(lf_gud_host *host);

/* Makes the display show rects[n] of frame (the mode's size, 3 channels); what it shows already is
 * not sent. All else of frame must be as in the last update, failed ones too. When it fails, bands
 * before the failure are shown, and all others count as unknown: they are sent again whole as soon
 * as a rectangle touches them. LF_E_NODEV unplugged; LF_E_TIMEOUT; LF_E_CANCELLED; LF_E_IO refused,
 * with the display's reason; LF_E_FORMAT a status that does not exist; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gud_host_update(lf_gud_host *host, const lf_image8 *frame,
                                          const lf_rect *rects, int n, lf_error *err);

/* LF_E_NODEV when the display is unplugged, LF_OK when it answers or cannot be asked now. */
LF_NODISCARD lf_status lf_gud_host_alive(lf_gud_host *host);

void lf_gud_host_counters_get(const lf_gud_host *host, lf_gud_host_counters *out);

#endif
