/* The parts of the simulated device. Private to device/. */
#ifndef LF_DEVICE_SIM_H
#define LF_DEVICE_SIM_H

#include <stdint.h>

#include "device/device.h"

#define LF_SIM_NEVER UINT64_MAX

/* ----------------------------------------------------------------------------- sim_options.c -- */

/* "DIR[,option=value…]"; pushes count from 1. 0 = the fault is off unless said otherwise. */
typedef struct lf_sim_options {
    char dir[512]; /* as given; holds no comma */
    /* links=no: no symbolic link is followed on the way to it, or from it to calibration.json */
    bool no_links;
    /* eye=DEG: from where view.png is seen, positive = from the right; -90..90 */
    double eye_deg;
    uint64_t latency_ms;  /* latency=MS: every push takes this long */
    uint64_t bandwidth;   /* bandwidth=BYTES: bytes per second on the wire */
    uint64_t stall_push;  /* stall=N[:MS]: the Nth push takes MS longer … */
    uint64_t stall_ms;    /* … or never ends (LF_SIM_NEVER) */
    uint64_t error_push;  /* error=N: the Nth push fails */
    uint64_t error_every; /* error_every=N: every Nth push fails */
    /* unplug=N: once N rectangles were shown the device is gone (once in a process) … */
    uint64_t unplug_updates;
    /* replug=MS: … and can be opened again so much later (LF_SIM_NEVER = not given) */
    uint64_t replug_ms;
    /* rotate=BYTES: size at which updates.jsonl is rotated; 16 MiB when not given */
    uint64_t rotate_bytes;
} lf_sim_options;

/* LF_E_ARG, naming the option. */
LF_NODISCARD lf_status lf_sim_options_parse(const char *argument, lf_sim_options *out,
                                            lf_error *err);

/* ----------------------------------------------------------------------------- sim_updates.c -- */

/* A rectangle that was shown: one line of updates.jsonl. */
typedef struct lf_sim_update {
    uint64_t seq; /* of the push, from 1; its rectangles share it */
    lf_rect rect;
    uint64_t bytes;   /* on the wire */
    uint64_t time_ns; /* CLOCK_MONOTONIC when it was shown */
} lf_sim_update;

/* updates.jsonl, appended to; at rotate_bytes it becomes updates.jsonl.1 (the older .1 is lost) and
 * a new one begins. */
typedef struct lf_sim_log {
    int folder_fd; /* borrowed */
    uint64_t rotate_bytes;
    int fd; /* -1 = not open: the next append tries again */
} lf_sim_log;

void lf_sim_log_init(lf_sim_log *log, int folder_fd, uint64_t rotate_bytes);
void lf_sim_log_finish(lf_sim_log *log);
/* Appends whole lines. LF_E_IO: the lines from the one that failed on are lost, the file still ends
 * with a whole line. */
LF_NODISCARD lf_status lf_sim_log_append(lf_sim_log *log, const lf_sim_update *updates, int n,
                                         lf_error *err);

/* ------------------------------------------------------------------------------ sim_unplug.c -- */

/* The unplugged state outlives the device object, but not the process: it is kept in
 * DIR/.unplugged, for this process alone. */
typedef enum lf_sim_plug {
    LF_SIM_PLUGGED,   /* was never unplugged by this process */
    LF_SIM_UNPLUGGED, /* is away */
    LF_SIM_REPLUGGED, /* was away and is back: is not unplugged a second time */
} lf_sim_plug;
lf_sim_plug lf_sim_plug_state(int folder_fd, uint64_t now_ns);
/* Writes down that it is away until back_ns (LF_SIM_NEVER). LF_E_IO. */
LF_NODISCARD lf_status lf_sim_plug_out(int folder_fd, uint64_t back_ns, lf_error *err);
/* Forgets. */
void lf_sim_plug_clear(int folder_fd);
/* Whether the folder was removed while it was held open. */
bool lf_sim_removed(int folder_fd);

/* ------------------------------------------------------------------------------ sim_writer.c -- */

/* The thread that owns all writing into DIR, and what it writes: the panel's pixels, the newest
 * views, the lines owed. The calls below come from the device's thread; they copy and return. */
typedef struct lf_sim_writer lf_sim_writer;

/* folder_fd is DIR; news_fd (lf_wakeup) is signalled after an attempt to write pictures that were
 * awaited; both are borrowed until the writer is destroyed. */
LF_NODISCARD lf_status lf_sim_writer_create(const lf_sim_options *options, int folder_fd,
                                            int news_fd, const lf_calibration *calibration,
                                            lf_sim_writer **out, lf_error *err);
/* Writes what is owed (no further picture but panel.png is begun when 1 s has passed), ends the
 * thread. Accepts NULL and half-built. */
void lf_sim_writer_destroy(lf_sim_writer *writer);
/* Copies the rectangles' pixels onto the panel; they are not seen in files before
 * lf_sim_writer_shown. */
void lf_sim_writer_pixels(lf_sim_writer *writer, const lf_image8 *frame, const lf_rect *rects,
                          int n);
/* Says that updates[n] were shown; pictures and lines are owed now. n may be 0. */
void lf_sim_writer_shown(lf_sim_writer *writer, const lf_sim_update *updates, int n,
                         uint64_t generation);
/* Copies the views as a quilt, the newest win; declines what cannot be a quilt. */
void lf_sim_writer_views(lf_sim_writer *writer, const lf_views8 *views, int columns, int rows);
/* Waits until nothing is owed, writing at once. LF_E_TIMEOUT; LF_E_IO when something could not be
 * written. */
LF_NODISCARD lf_status lf_sim_writer_flush(lf_sim_writer *writer, int timeout_ms);
/* How many calls of lf_sim_writer_shown are on disk whole, with the views before them. awaited: all
 * of them are written at once. LF_E_IO: the last attempt failed. */
LF_NODISCARD lf_status lf_sim_writer_kept(lf_sim_writer *writer, bool awaited, uint64_t *out_shown);
/* Copies what is wrong at present ("" = nothing) and returns how many writes failed so far. */
uint64_t lf_sim_writer_problem(lf_sim_writer *writer, char *out, size_t size);

#endif
