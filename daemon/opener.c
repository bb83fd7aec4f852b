#include "daemon/opener.h"

#include <string.h>

#include "base/alloc.h"
#include "device/find.h"

enum { MAX_FOUND = 16 };

lf_errand *lf_errand_create(lf_errand_kind kind)
{
    lf_errand *errand = lf_calloc(1, sizeof *errand);
    if (errand != NULL) {
        errand->kind = kind;
    }
    return errand;
}

void lf_errand_destroy(lf_errand *errand)
{
    lf_device_destroy(errand->device);
    lf_buttons_destroy(errand->buttons);
    lf_free(errand);
}

void lf_errand_forget(void *reader, lf_letter *letter)
{
    (void)reader;
    lf_errand_destroy((lf_errand *)(void *)letter);
}

static void close_all(lf_errand *errand)
{
    lf_device_destroy(errand->device);
    lf_buttons_destroy(errand->buttons);
    errand->device = NULL;
    errand->buttons = NULL;
}

/* The HID side of the panel whose EEPROM holds this serial number; else the only one there is, when it does not tell its own. */
static const lf_found *panel_of(const lf_found *found, int n, const char *serial)
{
    for (int i = 0; i < n; i++) {
        if (found[i].problem[0] == '\0' && strcmp(found[i].calibration.serial, serial) == 0) {
            return &found[i];
        }
    }
    return n == 1 && found->problem[0] != '\0' ? found : NULL;
}

static lf_status open_buttons(lf_errand *errand)
{
    lf_found *found = lf_calloc(MAX_FOUND, sizeof *found);
    int n = found != NULL ? lf_find_hid(found, MAX_FOUND) : 0;
    const lf_found *panel = panel_of(found, n, errand->spec);
    lf_status status = panel != NULL ? lf_buttons_open(panel->path, &errand->buttons, &errand->err) : LF_E_NODEV;
    lf_free(found);
    return status;
}

static lf_status find_panel(lf_errand *errand, const lf_calibration *calibration)
{
    errand->found = lf_device_find(errand->first, calibration, &errand->device, &errand->err);
    if (errand->found == LF_OK || errand->panel_only) {
        return errand->found;
    }
    const lf_error why = errand->err;
    return lf_none_create(why.what, &errand->device, &errand->err);
}

static lf_status open_device(lf_errand *errand)
{
    lf_calibration calibration;
    const lf_calibration *given = NULL;
    if (errand->calibration != NULL) {
        lf_status status = lf_calibration_load(errand->calibration, &calibration, &errand->err);
        if (status != LF_OK) {
            return status;
        }
        given = &calibration;
    }
    return strcmp(errand->spec, "auto") == 0 ? find_panel(errand, given)
                                             : lf_device_open(errand->spec, given, &errand->device, &errand->err);
}

static void run_letter(void *context, lf_letter *letter)
{
    lf_errand *errand = (lf_errand *)(void *)letter;
    (void)context;
    switch (errand->kind) {
    case LF_ERRAND_OPEN:
        errand->status = open_device(errand);
        break;
    case LF_ERRAND_CLOSE:
        close_all(errand);
        break;
    case LF_ERRAND_BUTTONS:
        errand->status = open_buttons(errand);
        break;
    case LF_ERRAND_CHECK:
        errand->denied = lf_find_denies(&errand->display, &errand->used);
        break;
    case LF_ERRAND_LIST:
        errand->n_devices = lf_device_list(errand->devices, LF_LISTED_DEVICES);
        break;
    }
}

static void drop_letter(void *context, lf_letter *letter)
{
    lf_errand *errand = (lf_errand *)(void *)letter;
    if (errand->kind == LF_ERRAND_CLOSE) {
        run_letter(context, letter);
    } else {
        errand->status = lf_error_set(&errand->err, LF_E_CANCELLED, "", "the daemon is shutting down");
    }
}

/* ----------------------------------------------------------------------------------------------------------- lanes -- */

struct lf_opener {
    lf_worker *lanes[LF_OPENER_LANES];
};

lf_lane lf_lane_of(const char *spec)
{
    size_t n = strcspn(spec, ":");
    bool files = (n == 3 && memcmp(spec, "sim", n) == 0) || (n == 4 && memcmp(spec, "none", n) == 0);
    return files ? LF_LANE_FILES : LF_LANE_PANELS;
}

static lf_lane lane_of_errand(const lf_errand *errand)
{
    switch (errand->kind) {
    case LF_ERRAND_OPEN:
        return lf_lane_of(errand->spec);
    case LF_ERRAND_CLOSE:
        return errand->device != NULL ? lf_lane_of(errand->device->ops->kind) : LF_LANE_BUTTONS;
    case LF_ERRAND_LIST:
        return LF_LANE_LIST;
    case LF_ERRAND_BUTTONS:
    case LF_ERRAND_CHECK:
        break;
    }
    return LF_LANE_BUTTONS;
}

lf_status lf_opener_create(lf_inbox *inbox, lf_opener **out_opener)
{
    static const char *const names[LF_OPENER_LANES] = {"lf-opener", "lf-opener-files", "lf-opener-keys", "lf-opener-list"};
    lf_opener *opener = lf_calloc(1, sizeof *opener);
    lf_status status = opener != NULL ? LF_OK : LF_E_NOMEM;
    for (int i = 0; i < LF_OPENER_LANES && status == LF_OK; i++) {
        status = lf_worker_create(names[i], run_letter, drop_letter, NULL, inbox, &opener->lanes[i]);
    }
    if (status != LF_OK) {
        lf_opener_destroy(opener);
        return status;
    }
    *out_opener = opener;
    return LF_OK;
}

void lf_opener_destroy(lf_opener *opener)
{
    for (int i = 0; opener != NULL && i < LF_OPENER_LANES; i++) {
        lf_worker_destroy(opener->lanes[i]);
    }
    lf_free(opener);
}

void lf_opener_queue(lf_opener *opener, lf_errand *errand)
{
    lf_worker_queue(opener->lanes[lane_of_errand(errand)], &errand->letter);
}

bool lf_opener_drain(lf_opener *opener, double end)
{
    bool done = true;
    for (int i = 0; i < LF_OPENER_LANES; i++) {
        done = lf_worker_drain(opener->lanes[i], end) && done;
    }
    return done;
}
