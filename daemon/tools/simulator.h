/* The work of quiltsim: a simulated Looking Glass (device/model/model.h), on a USB/IP server or
 * attached to this machine. Lines on standard input and signals control it. One thread, the
 * caller's; it handles SIGINT, SIGTERM and SIGUSR1. */
#ifndef LF_DAEMON_SIMULATOR_H
#define LF_DAEMON_SIMULATOR_H

#include "device/model/model.h"

typedef struct lf_simulator_config {
    const char *calibration; /* file whose bytes the EEPROM holds; NULL = a nominal Portrait */
    int width_px, height_px; /* display size; 0 = the calibration's */
    bool no_hid, no_display; /* not both */
    uint8_t formats[8];      /* GUD format numbers, best first */
    int n_formats;           /* 0 = RGB888 alone */
    uint32_t buffer_bytes;   /* the display's max_buffer_size; 0 = no limit */
    bool lz4, full_update;   /* what the display requests */
    lf_model_hid_faults hid; /* faults of the HID side */
    lf_model_gud_faults gud; /* faults of the GUD side */
    const char *panel_png;   /* file for the picture on SIGUSR1, on "picture" and at the end; NULL =
                              * none */
    bool attach;             /* attach to vhci_hcd of this machine; otherwise listen … */
    int port;                /* … on 127.0.0.1, this port; 0 = any, printed */
} lf_simulator_config;

/* Serves until "quit", SIGINT or SIGTERM. Prints information for the user to stdout, one line per
 * answer. LF_E_ARG, LF_E_FORMAT: the configuration contradicts itself or its file; LF_E_IO,
 * LF_E_NODEV, LF_E_BUSY, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_simulator_run(const lf_simulator_config *config, lf_error *err);

#endif
