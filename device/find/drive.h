/* Calibrations on the drives that panels of the second generation and later are:
 * LKG_calibration/visual.json (looking-glass.md 1.2). Volumes that somebody has mounted are read
 * where they lie; drives that nobody has mounted are mounted by udisks2, read-only, for as long as
 * reading takes. Whatever lies on a drive is hostile. Private to device/ and its tests. Threads:
 * any. May take as long as udisks2 does (17 s at most a drive that is not mounted): not for the
 * event thread. */
#ifndef LF_DEVICE_DRIVE_H
#define LF_DEVICE_DRIVE_H

#include "device/find/find.h"

/* Where to look. */
typedef struct lf_drive_places {
    const char *mountinfo; /* the kernel's list of mounts: /proc/self/mountinfo */
    /* udev's folder of links from volume labels to block devices: /dev/disk/by-label */
    const char *by_label;
} lf_drive_places;
extern const lf_drive_places lf_drive_system;

/* Fills at most max entries with the calibrations found on drives, and drives labelled LKG-… that
 * cannot be read, with their problem; returns their number. path is the file, or the block device
 * when it was mounted for reading only. */
int lf_drive_list(const lf_drive_places *places, lf_found *out, int max);

/* Whether a drive labelled LKG-… is plugged in, and the label of one (sanitised). Reads no drive.
 */
bool lf_drive_is_there(const lf_drive_places *places, char out_label[64]);

/* The calibration on a volume mounted at `volume`. The file must be a regular one under that
 * folder: links are not followed.
 *   LF_E_NODEV   there is none
 *   LF_E_IO      it may not be read
 *   LF_E_FORMAT  too large, no file, or no calibration */
LF_NODISCARD lf_status lf_drive_read(const char *volume, lf_calibration *out, lf_error *err);

/* ---------------------------------------------------------------------------- drive_udisks.c -- */

/* A volume that udisks2 has mounted for us. */
typedef struct lf_udisks lf_udisks;

/* For everything up to the mount: a drive that spins up, a udisks2 that has to be started first, a
 * bus that hangs. 15 s. */
extern const int lf_udisks_patient_ms;

/* Asks udisks2 (on the system's bus) to mount a block device with ro,nosuid,nodev,noexec, without
 * asking anybody for a password, and takes no longer than total_ms, whoever does not answer (and 2
 * s to undo a mount that may come too late). On LF_OK *out is the caller's: lf_udisks_unmount it.
 * LF_E_BUSY: somebody else has mounted it meanwhile. LF_E_IO: err says what to do. */
LF_NODISCARD lf_status lf_udisks_mount(const char *device, int total_ms, lf_udisks **out,
                                       lf_error *err);
/* Where it is mounted; valid until unmounting. */
const char *lf_udisks_folder(const lf_udisks *mount);
/* Unmounts (at most 2 s) and frees; accepts NULL. */
void lf_udisks_unmount(lf_udisks *mount);

#endif
