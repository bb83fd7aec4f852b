#include "device/find/find.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "device/device_table.h"
#include "device/find/drive.h"
#include "device/hid/hid.h"

#define MAX_FOUND 32
/* A name that says less than this ("LKG-") is every panel's. */
#define MIN_NAME 5

const char *lf_found_name(const lf_found *found)
{
    return strncmp(found->label, "LKG-", 4) == 0 ? found->label : found->calibration.serial;
}

int lf_find_hid(lf_found *out, int max)
{
    lf_hid_place places[MAX_FOUND];
    int n = lf_hid_list(places, max < MAX_FOUND ? max : MAX_FOUND);
    for (int i = 0; i < n; i++) {
        lf_hid_link link = {0};
        lf_error err = {0};
        out[i] = (lf_found){.source = LF_SOURCE_HID};
        lf_device_text(out[i].path, sizeof out[i].path, places[i].path);
        lf_device_text(out[i].label, sizeof out[i].label, places[i].product);
        lf_status status = lf_hid_open(places[i].path, &link, &err);
        if (status == LF_OK)
            status = lf_hid_read_calibration(&link, &lf_hid_patient, places[i].path,
                                             &out[i].calibration, &err);
        if (status != LF_OK)
            lf_device_problem(out[i].problem, sizeof out[i].problem, &err);
        lf_hid_close(&link);
    }
    return n;
}

static bool is_same_panel(const lf_found *a, const lf_found *b)
{
    return a->source != b->source && a->problem[0] == 0 && b->problem[0] == 0 &&
           lf_found_name(b)[0] != 0 && strcmp(lf_found_name(a), lf_found_name(b)) == 0;
}

/* Leaves out what a more trusted place has told already, but for the display that only the cache
 * knows. */
static int drop_repeated(lf_found *found, int n)
{
    int kept = 0;
    for (int i = 0; i < n; i++) {
        int k = 0;
        while (k < kept && !is_same_panel(&found[k], &found[i]))
            k++;
        if (k == kept)
            found[kept++] = found[i];
        else if (found[k].display.name[0] == 0)
            found[k].display = found[i].display;
    }
    return kept;
}

static int find_plugged(lf_found *out, int max)
{
    int n = lf_find_hid(out, max);
    return n + lf_drive_list(&lf_drive_system, out + n, max - n);
}

int lf_find_all(lf_found *out, int max)
{
    int n = find_plugged(out, max);
    n += lf_cache_list(out + n, max - n);
    return drop_repeated(out, n);
}

/* ---------------------------------------------------------------------------------- matching -- */

typedef bool (*fits)(const lf_found *found, const lf_edid *display);

static bool begins(const char *text, const char *name)
{
    return strlen(name) >= MIN_NAME && strncmp(text, name, strlen(name)) == 0;
}

/* Whether this is the display that the calibration was found for. Desktops lengthen names. */
static bool was_found_for(const lf_found *found, const lf_edid *display)
{
    return begins(display->name, found->display.name) &&
           (display->serial[0] == 0 || strcmp(display->serial, found->display.serial) == 0);
}

/* Whether it was found for another. Only what names itself as a panel counts: desktops have names
 * of their own for displays. */
static bool is_anothers(const lf_found *found, const lf_edid *display)
{
    return lf_edid_is_panel(&found->display) && lf_edid_is_panel(display) &&
           !was_found_for(found, display);
}

static bool fits_by_name(const lf_found *found, const lf_edid *display)
{
    return was_found_for(found, display) || begins(found->calibration.serial, display->name) ||
           begins(found->label, display->name) ||
           begins(found->calibration.serial, display->serial) ||
           begins(found->label, display->serial);
}

static bool fits_by_size(const lf_found *found, const lf_edid *display)
{
    return found->calibration.screen_width_px == display->width_px &&
           found->calibration.screen_height_px == display->height_px &&
           !is_anothers(found, display);
}

/* A display that says nothing of itself is whatever panel there is. */
static bool fits_silence(const lf_found *found, const lf_edid *display)
{
    (void)found;
    return display->name[0] == 0 && display->serial[0] == 0 && display->width_px == 0;
}

/* The last of the valid ones that fit, in the cache or plugged in; *out_n says how many there are.
 */
static const lf_found *fitting(const lf_found *found, int n, const lf_edid *display, bool cached,
                               fits fit, int *out_n)
{
    const lf_found *one = NULL;
    *out_n = 0;
    for (int i = 0; i < n; i++) {
        if (found[i].problem[0] != 0 || (found[i].source == LF_SOURCE_CACHE) != cached ||
            !fit(&found[i], display))
            continue;
        /* a drive that is mounted twice, or a panel's other place, is no second answer */
        bool again =
            one && memcmp(&one->calibration, &found[i].calibration, sizeof one->calibration) == 0;
        one = &found[i];
        *out_n += !again;
    }
    return one;
}

/* The display's own panel, when it is plugged in and cannot be read. */
static const lf_found *damaged(const lf_found *found, int n, const lf_edid *display)
{
    for (int i = 0; i < n; i++)
        if (found[i].problem[0] != 0 && fits_by_name(&found[i], display))
            return &found[i];
    return NULL;
}

/* By the first rule that anything fits. When the display's own panel cannot be read, what is
 * plugged in besides is another's: only the cache may help then. */
static const lf_found *choose(const lf_found *found, int n, const lf_edid *display, int *out_n)
{
    static const struct {
        fits fit;
        bool cached, of_others;
    } rules[] = {{fits_by_name, false, false}, {fits_by_name, true, false},
                 {fits_by_size, false, true},  {fits_by_size, true, false},
                 {fits_silence, false, true},  {fits_silence, true, false}};
    bool unreadable = damaged(found, n, display);
    *out_n = 0;
    for (size_t i = 0; i < sizeof rules / sizeof rules[0]; i++) {
        if (unreadable && rules[i].of_others)
            continue;
        const lf_found *one = fitting(found, n, display, rules[i].cached, rules[i].fit, out_n);
        if (*out_n > 0)
            return *out_n == 1 ? one : NULL;
    }
    return NULL;
}

/* One place in words: what is wrong with it, else whose lens it tells. */
static void describe(const lf_found *found, char *out, size_t size)
{
    if (found->problem[0] != 0)
        snprintf(out, size, "%.60s: %.150s", found->path, found->problem);
    else
        snprintf(out, size, "%.60s: serial %.40s, %dx%d", found->path, found->calibration.serial,
                 found->calibration.screen_width_px, found->calibration.screen_height_px);
}

static void nothing_fits(const lf_found *found, int n, const lf_edid *display, int n_fit,
                         lf_error *err)
{
    char where[64], first[256] = "";
    snprintf(where, sizeof where, "%s (%dx%d)", display->name[0] != 0 ? display->name : "display",
             display->width_px, display->height_px);
    if (n == 0) {
        lf_error_set(err, LF_E_NODEV, where,
                     "no calibration was found; connect the panel's USB cable (not only video), or "
                     "pass its visual.json with --calibration");
        return;
    }
    describe(&found[0], first, sizeof first);
    for (int i = n - 1; i >= 0; i--)
        if (found[i].problem[0] != 0)
            describe(&found[i], first, sizeof first);
    if (n_fit > 1)
        lf_error_set(err, LF_E_NODEV, where,
                     "%d calibrations fit this display, and none names it; pass the right one with "
                     "--calibration (the first is %s)",
                     n_fit, first);
    else
        lf_error_set(err, LF_E_NODEV, where,
                     "none of the %d calibrations found is for this display; pass its visual.json "
                     "with --calibration (%s)",
                     n, first);
}

const lf_found *lf_find_match(const lf_found *found, int n, const lf_edid *display, lf_error *err)
{
    int n_fit = 0;
    const lf_found *match = choose(found, n, display, &n_fit);
    const lf_found *own = !match ? damaged(found, n, display) : NULL;
    if (own)
        lf_error_set(err, LF_E_FORMAT, own->path, "%s", own->problem);
    else if (!match)
        nothing_fits(found, n, display, n_fit, err);
    return match;
}

bool lf_found_deny(const lf_found *found, int n, const lf_edid *display,
                   const lf_calibration *cached)
{
    lf_edid known = *display;
    for (int i = 0; i < n && known.serial[0] == 0; i++)
        if (memcmp(&found[i].calibration, cached, sizeof *cached) == 0 &&
            was_found_for(&found[i], display))
            memcpy(known.serial, found[i].display.serial, sizeof known.serial);
    const lf_found *match = lf_find_match(found, n, &known, NULL);
    return match && match->source != LF_SOURCE_CACHE &&
           memcmp(&match->calibration, cached, sizeof *cached) != 0;
}

bool lf_find_denies(const lf_edid *display, const lf_calibration *cached)
{
    lf_found *found = lf_calloc(MAX_FOUND, sizeof *found);
    bool denies = found && lf_found_deny(found, lf_find_all(found, MAX_FOUND), display, cached);
    lf_free(found);
    return denies;
}

static void tell_source(const lf_found *found, char out[256])
{
    static const char *const names[] = {
        [LF_SOURCE_HID] = "EEPROM", [LF_SOURCE_DRIVE] = "drive", [LF_SOURCE_CACHE] = "cache"};
    snprintf(out, 256, "%s, %.240s", names[found->source], found->path);
}

/* What is plugged in that may hold a calibration. */
static bool find_unread(char out_from[256])
{
    lf_hid_place place;
    char label[64];
    if (lf_hid_list(&place, 1) > 0)
        snprintf(out_from, 256, "EEPROM, %.200s (not read yet)", place.path);
    else if (lf_drive_is_there(&lf_drive_system, label))
        snprintf(out_from, 256, "drive, %.60s (not read yet)", label);
    else
        out_from[0] = 0;
    return out_from[0] != 0;
}

bool lf_find_promise(const lf_edid *display, char out_from[256])
{
    lf_found *found = lf_calloc(MAX_FOUND, sizeof *found);
    int n = found ? lf_cache_list(found, MAX_FOUND) : 0;
    const lf_found *match = lf_find_match(found, n, display, NULL);
    if (match)
        tell_source(match, out_from);
    lf_free(found);
    return match || find_unread(out_from);
}

static void remember(const lf_found *match, const lf_edid *display)
{
    lf_found known = *match;
    if (lf_edid_is_panel(display))
        known.display = *display;
    lf_cache_store(&known);
}

lf_status lf_find_for_display(const lf_edid *display, lf_calibration *out, lf_origin *out_origin,
                              lf_error *err)
{
    lf_found *found = lf_calloc(MAX_FOUND, sizeof *found);
    lf_error why = {0};
    if (!found)
        return lf_error_set(err, LF_E_NOMEM, "calibration", "out of memory");
    int n = lf_find_all(found, MAX_FOUND);
    const lf_found *match = lf_find_match(found, n, display, &why);
    if (match) {
        *out = match->calibration;
        tell_source(match, out_origin->words);
        out_origin->cached = match->source == LF_SOURCE_CACHE;
        if (match->source != LF_SOURCE_CACHE)
            remember(match, display);
    } else if (err) {
        *err = why;
    }
    lf_free(found);
    return match ? LF_OK : why.status;
}
