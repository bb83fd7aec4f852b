/* quiltsim's work: a simulated Looking Glass (device/model/model.h) on a USB/IP server or plugged
 * into this machine, told what to do by lines on standard input and by signals. One thread, the
 * caller's; it takes SIGINT, SIGTERM and SIGUSR1 for itself. */
#ifndef LF_DAEMON_SIMULATOR_H
#define LF_DAEMON_SIMULATOR_H

#include "device/model/model.h"

typedef struct lf_simulator_config {
    const char *calibration; /* file whose bytes the EEPROM holds; NULL = a nominal Portrait */
    int width_px, height_px; /* of the display; 0 = the calibration's */
    bool no_hid, no_display; /* not both */
    uint8_t formats[8];      /* GUD numbers, best first */
    int n_formats;           /* 0 = RGB888 alone */
    uint32_t buffer_bytes;   /* the display's max_buffer_size; 0 = no limit */
    bool lz4, full_update;   /* what the display asks for */
    lf_model_hid_faults hid; /* faults of either side */
    lf_model_gud_faults gud; /* … */
    const char *panel_png; /* where the picture goes on SIGUSR1, on "picture" and at the end; NULL =
                              nowhere */
    bool attach;           /* to vhci_hcd of this machine; else listens … */
    int port;              /* … on 127.0.0.1, this port; 0 = any (it is printed) */
} lf_simulator_config;

/* Serves until "quit", SIGINT or SIGTERM. Prints what a user has to know on stdout; one line an
 * answer. LF_E_ARG and LF_E_FORMAT: the configuration contradicts itself or its file; LF_E_IO,
 * LF_E_NODEV, LF_E_BUSY, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_simulator_run(const lf_simulator_config *config, lf_error *err);

#endif
