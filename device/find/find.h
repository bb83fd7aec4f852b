/* Finding calibrations: all places that may hold a panel's calibration, and the choice of the right
 * one for a display.
 *
 * Places, highest priority first: a file given by the user (handled by the caller); the EEPROM of a
 * first-generation panel over HID; LKG_calibration/visual.json on the drive of a later panel; the
 * cache.
 *
 * Reading never writes to a panel: EEPROM pages are only read. Drives are mounted by udisks2,
 * read-only, if they are not mounted already; quiltd itself mounts nothing.
 *
 * Threads: any, one call at a time per thread, but not the event thread. A call may take 9 s for
 * each panel that does not answer over HID: 4 s, and 5 s for which the kernel may hold the last
 * request (hid.h). It may take 17 s for each drive. */
#ifndef LF_DEVICE_FIND_H
#define LF_DEVICE_FIND_H

#include <sys/types.h>

#include "base/calibration.h"
#include "device/find/edid.h"

typedef enum lf_source { LF_SOURCE_HID, LF_SOURCE_DRIVE, LF_SOURCE_CACHE } lf_source;

/* A place that holds, or should hold, a calibration. Strings are sanitised (lf_device_text). */
typedef struct lf_found {
    lf_source source;
    char path[256];    /* /dev/hidraw0, /media/me/LKG-P00671/LKG_calibration/visual.json; for a
                        * drive mounted only for reading, its block device */
    char label[64];    /* product string or volume label, known before reading */
    char problem[256]; /* why it cannot be used and what to do; empty = calibration is valid */
    lf_calibration calibration;
    /* CACHE: the display that it was found for, and the calibration in the cache; name empty =
     * unknown */
    lf_edid display;
} lf_found;

/* The name of a panel: its drive's label, otherwise its serial (which on some Portraits is only
 * "LKG-PORT-"). */
const char *lf_found_name(const lf_found *found);

/* Searches all places; fills at most max entries and returns their number. A connected panel is not
 * listed again from the cache. Damaged and inaccessible places are listed with their problem. */
int lf_find_all(lf_found *out, int max);
/* HID only: the panels that have buttons. */
int lf_find_hid(lf_found *out, int max);

/* Chooses the calibration for a display among found[n]. The rules, in order:
 * - One whose serial or label begins with the display's name or serial number (of 5 characters or
 *   more), or that was found for this display before.
 * - The only one with the display's screen size, unless it was found for another display.
 * - If the display does not identify itself: the only one found.
 *
 * Connected panels come before the cache in each step. NULL = none; err says what was found instead
 * and what to do. LF_E_NODEV; LF_E_FORMAT: the display's own panel is connected but cannot be read
 * (the cache may still help). */
const lf_found *lf_find_match(const lf_found *found, int n, const lf_edid *display, lf_error *err);

/* True if a connected panel contradicts the cached calibration of a display: lf_find_match chooses
 * a connected one among found[n], and it differs. If the display reports no serial number, the
 * cached one is used. */
bool lf_found_deny(const lf_found *found, int n, const lf_edid *display,
                   const lf_calibration *cached);
/* lf_found_deny with the results of lf_find_all. */
bool lf_find_denies(const lf_edid *display, const lf_calibration *cached);

/* The source of a calibration. */
typedef struct lf_origin {
    char words[256]; /* for people: "EEPROM, /dev/hidraw0" */
    bool cached;     /* LF_SOURCE_CACHE */
} lf_origin;

/* lf_find_all and lf_find_match together, for devices that show on a display. Stores the
 * calibration in the cache, with the display. LF_E_NODEV: none; LF_E_FORMAT: the matching one is
 * damaged. */
LF_NODISCARD lf_status lf_find_for_display(const lf_edid *display, lf_calibration *out,
                                           lf_origin *out_origin, lf_error *err);

/* Where the calibration for a display will probably come from, without access to any panel or
 * drive: the words of lf_find_for_display, from the cache or from connected panels that were not
 * read yet. False (out_from empty): no known source. */
bool lf_find_promise(const lf_edid *display, char out_from[256]);

/* True if a search for calibrations has this block device mounted, or had until 5 s ago. Kernel
 * events about it are then caused by the search itself. */
bool lf_find_touches(dev_t device);

/* The cache: one file per panel, named by lf_found_name, which is the label in lists. Folder:
 * $CACHE_DIRECTORY/panels (systemd), otherwise $XDG_CACHE_HOME/quiltd/panels, otherwise
 * ~/.cache/quiltd/panels. Files are replaced as a whole. A cache that cannot be written is not an
 * error; damaged files in it are skipped. */
void lf_cache_store(const lf_found *found);
int lf_cache_list(lf_found *out, int max);

#endif
