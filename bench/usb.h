/* The parts of quiltbench usb. */
#ifndef LF_BENCH_USB_H
#define LF_BENCH_USB_H

#include "base/image.h"
#include "daemon/output/options.h"

/* What a render that converges sends to a USB display, as the daemon does it: the scene on a panel
 * (a nominal Portrait, 1536x2048), the display simulated in this process. */
typedef struct lf_bench_converge {
    double seconds; /* from the first frame on */
    bool lz4;       /* the display takes it */
    /* the outcome */
    int updates;
    double wire_bytes, first_bytes; /* sent in all; for the first update, which is whole */
    double frame_bytes;             /* a full frame */
    double shown_seconds;           /* from the first update to the last */
    /* bytes of the display's last picture that are not the exact frame's */
    int64_t differences;
} lf_bench_converge;

/* Runs it: file is a scene, options are quiltd's. Takes seconds and a few more. On LF_OK *out_last
 * is the last frame, the caller's (lf_image8_finish). */
LF_NODISCARD lf_status lf_bench_usb_converge(const char *file, const lf_options *options,
                                             lf_bench_converge *converge, lf_image8 *out_last,
                                             lf_error *err);

#endif
