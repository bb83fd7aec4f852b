/* Calibrations on USB drives: panels of the second generation and later are a drive with
 * LKG_calibration/visual.json. Mounted volumes are read in place. Other drives are mounted
 * read-only by udisks2 while they are read. Files on a drive are untrusted. Private to device/ and
 * its tests.
 *
 * Threads: any, except the event thread: may take as long as udisks2 (at most 17 s per drive that
 * is not mounted). */
#ifndef LF_DEVICE_DRIVE_H
#define LF_DEVICE_DRIVE_H

#include "device/find/find.h"

/* System paths to search. */
typedef struct lf_drive_places {
    const char *mountinfo; /* the kernel's list of mounts: /proc/self/mountinfo */
    /* udev's folder of links from volume labels to block devices: /dev/disk/by-label */
    const char *by_label;
} lf_drive_places;
extern const lf_drive_places lf_drive_system;

/* Fills at most max entries with the calibrations found on drives, and with drives labelled LKG-…
 * that cannot be read, with their problem; returns their number. path is the file, or the block
 * device if it was mounted only for reading. */
int lf_drive_list(const lf_drive_places *places, lf_found *out, int max);

/* True if a drive labelled LKG-… is connected; out_label is the label of one (sanitised). Reads no
 * drive. */
bool lf_drive_is_there(const lf_drive_places *places, char out_label[64]);

/* Reads the calibration on a volume mounted at `volume`. The file must be a regular one under that
 * folder: links are not followed.
 *   LF_E_NODEV   not found
 *   LF_E_IO      it cannot be read
 *   LF_E_FORMAT  too large, not a regular file, or not a calibration */
LF_NODISCARD lf_status lf_drive_read(const char *volume, lf_calibration *out, lf_error *err);

/* ---------------------------------------------------------------------------- drive_udisks.c -- */

/* A volume mounted through udisks2. */
typedef struct lf_udisks lf_udisks;

/* Time limit for everything up to the mount: a drive that spins up, a udisks2 that starts first, a
 * bus that hangs. 15 s. */
extern const int lf_udisks_patient_ms;

/* Asks udisks2 (on the system bus) to mount a block device with ro,nosuid,nodev,noexec, without a
 * password prompt. Returns within total_ms, and 2 s more to undo a mount that may come too late. On
 * LF_OK the caller releases *out with lf_udisks_unmount. LF_E_BUSY: it was mounted by another
 * program meanwhile. LF_E_IO: err says what to do. */
LF_NODISCARD lf_status lf_udisks_mount(const char *device, int total_ms, lf_udisks **out,
                                       lf_error *err);
/* Its mount point; valid until unmounting. */
const char *lf_udisks_folder(const lf_udisks *mount);
/* Unmounts (at most 2 s) and frees; accepts NULL. */
void lf_udisks_unmount(lf_udisks *mount);

#endif
