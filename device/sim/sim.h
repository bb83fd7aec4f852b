/* The parts of the simulated device. Private to device/. */
#ifndef LF_DEVICE_SIM_H
#define LF_DEVICE_SIM_H

#include <stdint.h>

#include "device/device.h"

#define LF_SIM_NEVER UINT64_MAX

/* ----------------------------------------------------------------------------- sim_options.c -- */

/* "DIR[,option=value…]"; pushes count from 1. 0 = the fault is off unless noted. */
typedef struct lf_sim_options {
    char dir[512]; /* unchanged; holds no comma */
    /* links=no: follow no symbolic link to the folder, or from it to calibration.json */
    bool no_links;
    /* eye=DEG: direction of the eye of view.png, positive = right; -90..90 */
    double eye_deg;
    uint64_t latency_ms;  /* latency=MS: every push takes this long */
    uint64_t bandwidth;   /* bandwidth=BYTES: bytes per second on the wire */
    uint64_t stall_push;  /* stall=N[:MS]: the Nth push takes MS longer … */
    uint64_t stall_ms;    /* … or never ends (LF_SIM_NEVER) */
    uint64_t error_push;  /* error=N: the Nth push fails */
    uint64_t error_every; /* error_every=N: every Nth push fails */
    /* unplug=N: after N rectangles the device is gone (once per process) … */
    uint64_t unplug_updates;
    /* replug=MS: … and can be opened again MS later (LF_SIM_NEVER = not given) */
    uint64_t replug_ms;
    /* rotate=BYTES: size at which updates.jsonl is rotated; 16 MiB when not given */
    uint64_t rotate_bytes;
} lf_sim_options;

/* LF_E_ARG, naming the option. */
LF_NODISCARD lf_status lf_sim_options_parse(const char *argument, lf_sim_options *out,
                                            lf_error *err);

/* ----------------------------------------------------------------------------- sim_updates.c -- */

/* A shown rectangle: one line of updates.jsonl. */
typedef struct lf_sim_update {
    uint64_t seq; /* number of the push, from 1; its rectangles share it */
    lf_rect rect;
    uint64_t bytes;   /* on the wire */
    uint64_t time_ns; /* CLOCK_MONOTONIC when it was shown */
} lf_sim_update;

/* updates.jsonl, appended to. At rotate_bytes it becomes updates.jsonl.1, replacing an older one,
 * and a new file begins. */
typedef struct lf_sim_log {
    int folder_fd; /* borrowed */
    uint64_t rotate_bytes;
    int fd; /* -1 = not open: the next append tries again */
} lf_sim_log;

void lf_sim_log_init(lf_sim_log *log, int folder_fd, uint64_t rotate_bytes);
void lf_sim_log_finish(lf_sim_log *log);
/* Appends whole lines. LF_E_IO: the failed line and later ones are lost; the file still ends with a
 * whole line. */
LF_NODISCARD lf_status lf_sim_log_append(lf_sim_log *log, const lf_sim_update *updates, int n,
                                         lf_error *err);

/* ------------------------------------------------------------------------------ sim_unplug.c -- */

/* The unplugged state outlives the device object, but not the process: it is stored in
 * DIR/.unplugged and valid only for this process. */
typedef enum lf_sim_plug {
    LF_SIM_PLUGGED,   /* never unplugged by this process */
    LF_SIM_UNPLUGGED, /* unplugged now */
    LF_SIM_REPLUGGED, /* connected again; not unplugged a second time */
} lf_sim_plug;
lf_sim_plug lf_sim_plug_state(int folder_fd, uint64_t now_ns);
/* Records that it is unplugged until back_ns (LF_SIM_NEVER). LF_E_IO. */
LF_NODISCARD lf_status lf_sim_plug_out(int folder_fd, uint64_t back_ns, lf_error *err);
/* Removes the record. */
void lf_sim_plug_clear(int folder_fd);
/* True if the folder was removed while it was open. */
bool lf_sim_removed(int folder_fd);

/* ------------------------------------------------------------------------------ sim_writer.c -- */

/* The thread that writes all files of DIR, and its data: the panel's pixels, the newest views,
 * pending lines. The functions below are called by the device's thread; they copy and return. */
typedef struct lf_sim_writer lf_sim_writer;

/* folder_fd is DIR. news_fd (lf_wakeup) is signalled after an attempt to write awaited pictures.
 * Both are borrowed until the writer is destroyed. */
LF_NODISCARD lf_status lf_sim_writer_create(const lf_sim_options *options, int folder_fd,
                                            int news_fd, const lf_calibration *calibration,
                                            lf_sim_writer **out, lf_error *err);
/* Writes everything pending and ends the thread; after 1 s it begins no picture other than
 * panel.png. Accepts NULL and half-built writers. */
void lf_sim_writer_destroy(lf_sim_writer *writer);
/* Copies the rectangles' pixels to the panel. They appear in files only after
 * lf_sim_writer_shown. */
void lf_sim_writer_pixels(lf_sim_writer *writer, const lf_image8 *frame, const lf_rect *rects,
                          int n);
/* Reports that updates[n] were shown, which makes pictures and lines pending. n may be 0. */
void lf_sim_writer_shown(lf_sim_writer *writer, const lf_sim_update *updates, int n,
                         uint64_t generation);
/* Copies the views as a quilt; the newest win. Ignores views that cannot be a quilt. */
void lf_sim_writer_views(lf_sim_writer *writer, const lf_views8 *views, int columns, int rows);
/* Writes at once and waits until nothing is pending. LF_E_TIMEOUT; LF_E_IO: something could not be
 * written. */
LF_NODISCARD lf_status lf_sim_writer_flush(lf_sim_writer *writer, int timeout_ms);
/* The number of calls of lf_sim_writer_shown that are completely on disk, with their views.
 * awaited: writes all of them at once. LF_E_IO: the last attempt failed. */
LF_NODISCARD lf_status lf_sim_writer_kept(lf_sim_writer *writer, bool awaited, uint64_t *out_shown);
/* Copies the current problem ("" = none) and returns the number of failed writes so far. */
uint64_t lf_sim_writer_problem(lf_sim_writer *writer, char *out, size_t size);

#endif
