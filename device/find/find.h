/* Finding calibrations: every place where the lens of a panel may be written down, and which one
 * belongs to a display.
 *
 * Places, in the order in which they are believed: a file that the user gave (the caller's
 * business), the EEPROM of a first-generation panel over HID, LKG_calibration/visual.json on the
 * drive that a later panel is, the cache of what was read before. Reading never writes to a panel:
 * EEPROM pages are only read, drives are mounted by udisks2 read-only when nothing else has mounted
 * them, and nothing is ever mounted by quiltd itself. Threads: any, one at a time a call. May take
 * 9 s for each panel that does not answer over HID (4 s, and 5 s that the kernel may hold the last
 * request: hid.h) and 17 s for each drive: not for the event thread. */
#ifndef LF_DEVICE_FIND_H
#define LF_DEVICE_FIND_H

#include <sys/types.h>

#include "base/calibration.h"
#include "device/find/edid.h"

typedef enum lf_source { LF_SOURCE_HID, LF_SOURCE_DRIVE, LF_SOURCE_CACHE } lf_source;

/* A place where a calibration is, or should be. Strings are sanitised (lf_device_text). */
typedef struct lf_found {
    lf_source source;
    char path[256];    /* /dev/hidraw0, /media/me/LKG-P00671/LKG_calibration/visual.json; a drive
                          mounted for reading only: its block device */
    char label[64];    /* product string, volume label: what the place says before it is read */
    char problem[256]; /* why it cannot be used and what to do; empty = calibration is valid */
    lf_calibration calibration;
    /* CACHE: the display that it was found for, and what the cache knows already; name empty =
     * unknown */
    lf_edid display;
} lf_found;

/* What tells a panel from others: its drive's label, else its serial (which on some Portraits is a
 * bare "LKG-PORT-"). */
const char *lf_found_name(const lf_found *found);

/* Looks everywhere; fills at most max entries (a panel that is plugged in is not told from the
 * cache again) and returns their number. Damaged and forbidden places are told with their problem.
 */
int lf_find_all(lf_found *out, int max);
/* Those over HID alone: the panels that have buttons. */
int lf_find_hid(lf_found *out, int max);

/* The calibration for a display among found[n]: the one whose serial or label begins with the
 * display's name or serial number (of 5 characters or more), or that was found for this display
 * before; else the only one whose screen size is the display's, unless it was found for another;
 * else, when the display says nothing of itself, the only one there is. Each time what is plugged
 * in goes before the cache. NULL = none, with err telling what was found instead and what to do:
 * LF_E_NODEV, or LF_E_FORMAT when the display's own panel is there and cannot be read (the cache
 * may still help then). */
const lf_found *lf_find_match(const lf_found *found, int n, const lf_edid *display, lf_error *err);

/* Whether what is plugged in says otherwise of a display than the calibration that the cache had
 * for it: what lf_find_match chooses of found[n] is plugged in, and is not that. A serial number
 * that the display does not tell is taken from the cache. */
bool lf_found_deny(const lf_found *found, int n, const lf_edid *display,
                   const lf_calibration *cached);
/* The same of what lf_find_all finds now. */
bool lf_find_denies(const lf_edid *display, const lf_calibration *cached);

/* Where a calibration came from. */
typedef struct lf_origin {
    char words[256]; /* for people: "EEPROM, /dev/hidraw0" */
    bool cached;     /* LF_SOURCE_CACHE */
} lf_origin;

/* lf_find_all and lf_find_match in one: what the devices that show on a display call. Remembers the
 * calibration in the cache, with the display. LF_E_NODEV: none; LF_E_FORMAT: the one that matches
 * is damaged. */
LF_NODISCARD lf_status lf_find_for_display(const lf_edid *display, lf_calibration *out,
                                           lf_origin *out_origin, lf_error *err);

/* Where the calibration for a display will probably come from, without asking any panel or drive:
 * in words of lf_find_for_display, from the cache, or from what is plugged in and was not read yet.
 * False (out_from empty): from nowhere that is known. */
bool lf_find_promise(const lf_edid *display, char out_from[256]);

/* Whether looking for calibrations has, or until 5 s ago had, this block device mounted: the kernel
 * tells of it again then, which is no news. */
bool lf_find_touches(dev_t device);

/* The cache: a file a panel, called by lf_found_name (which is the label of what is listed), under
 * $CACHE_DIRECTORY/panels (systemd's), else $XDG_CACHE_HOME/quiltd/panels, else
 * ~/.cache/quiltd/panels. Writing replaces whole files. A cache that cannot be written is no error;
 * damaged files in it are passed over. */
void lf_cache_store(const lf_found *found);
int lf_cache_list(lf_found *out, int max);

#endif
