#include "daemon/opener.h"

#include <string.h>

#include "base/alloc.h"

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
    lf_free(errand);
}

static lf_status open_device(lf_errand *errand)
{
    lf_calibration calibration;
    bool given = errand->calibration != NULL;
    lf_status status = given ? lf_calibration_load(errand->calibration, &calibration, &errand->err) : LF_OK;
    if (status == LF_OK) {
        status = lf_device_open(errand->spec, given ? &calibration : NULL, &errand->device, &errand->err);
    }
    if (status != LF_OK || !errand->panel_only || strcmp(errand->device->ops->kind, "none") != 0) {
        return status;
    }
    lf_device_info info;
    errand->device->ops->info(errand->device, &info);
    lf_device_destroy(errand->device);
    errand->device = NULL;
    return lf_error_set(&errand->err, LF_E_NODEV, errand->spec, "%s", info.problem);
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
        lf_device_destroy(errand->device);
        errand->device = NULL;
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

lf_status lf_opener_start(lf_inbox *inbox, lf_worker **out_worker)
{
    return lf_worker_create("lf-opener", run_letter, drop_letter, NULL, inbox, out_worker);
}
