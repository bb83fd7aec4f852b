/* The parts of quiltbench usb. */
#ifndef LF_BENCH_USB_H
#define LF_BENCH_USB_H

#include "base/image.h"
#include "daemon/output/options.h"

/* The data that a converging rendering sends to a USB display, as the daemon does it. The panel is
 * a nominal Portrait (1536x2048); the display is simulated in this process. */
typedef struct lf_bench_converge {
    double seconds; /* duration from the first frame on */
    bool lz4;       /* the display accepts LZ4 */
    /* the outcome */
    int updates;
    double wire_bytes, first_bytes; /* total; for the first update, which is a whole frame */
    double frame_bytes;             /* size of a full frame */
    double shown_seconds;           /* from the first update to the last */
    /* bytes of the display's last picture that differ from the exact frame */
    int64_t differences;
} lf_bench_converge;

/* Runs the measurement. file: a scene; options: quiltd's. Takes `seconds` and a few more. On LF_OK
 * the caller owns *out_last, the last frame (lf_image8_finish). */
LF_NODISCARD lf_status lf_bench_usb_converge(const char *file, const lf_options *options,
                                             lf_bench_converge *converge, lf_image8 *out_last,
                                             lf_error *err);

#endif
