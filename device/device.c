#include "device/device.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "device/device_table.h"

enum { MAX_FOUND = 32 };

const lf_device_ops *const lf_device_table[] = {&lf_drm_ops, &lf_window_ops, &lf_usb_ops, &lf_sim_ops, &lf_none_ops, NULL};

static const lf_device_ops *find_kind(const char *kind, size_t length)
{
    for (int i = 0; lf_device_table[i] != NULL; i++)
        if (strlen(lf_device_table[i]->kind) == length && memcmp(lf_device_table[i]->kind, kind, length) == 0)
            return lf_device_table[i];
    return NULL;
}

/* The part of a spec behind the colon. */
static const char *argument_of(const char *spec)
{
    const char *colon = strchr(spec, ':');
    return colon != NULL ? colon + 1 : "";
}

lf_status lf_device_open_auto(const lf_device_ops *const table[], const lf_calibration *calibration, lf_device **out_device,
                              lf_error *err)
{
    char problem[256] = "no panel was found";
    bool tried = false;
    for (int i = 0; table[i] != NULL; i++) {
        if (table[i]->probe == NULL)
            continue;
        lf_device_info found[MAX_FOUND];
        int n = table[i]->probe(found, MAX_FOUND);
        for (int k = 0; k < n; k++) {
            if (found[k].model[0] == 0) { /* nobody knows whether it is a panel */
                if (!tried)
                    snprintf(problem, sizeof problem, "%.255s", found[k].problem);
                continue;
            }
            tried = true;
            lf_error why = {0};
            lf_status status = table[i]->open(argument_of(found[k].spec), calibration, out_device, &why);
            if (status == LF_OK)
                return LF_OK;
            snprintf(problem, sizeof problem, "%.100s cannot be used: %.130s", found[k].spec, why.what);
        }
    }
    return lf_none_create(problem, out_device, err);
}

lf_status lf_device_open(const char *spec, const lf_calibration *calibration, lf_device **out_device, lf_error *err)
{
    assert(spec != NULL && out_device != NULL);
    if (strlen(spec) >= sizeof((lf_device_info *)0)->spec)
        return lf_error_set(err, LF_E_ARG, "device", "the spec is longer than %zu bytes", sizeof((lf_device_info *)0)->spec - 1);
    if (strcmp(spec, "auto") == 0)
        return lf_device_open_auto(lf_device_table, calibration, out_device, err);
    const lf_device_ops *ops = find_kind(spec, strcspn(spec, ":"));
    if (ops == NULL)
        return lf_error_set(err, LF_E_ARG, spec,
                            "no such kind of device; expected auto, drm[:OUTPUT], window[:MONITOR], usb[:BUS-PORT], none or "
                            "sim:DIR[,option=value]");
    return ops->open(argument_of(spec), calibration, out_device, err);
}

static bool rect_fits(const lf_rect *r, int width, int height)
{
    return r->x >= 0 && r->y >= 0 && r->width > 0 && r->height > 0 && r->width <= width && r->height <= height &&
           r->x <= width - r->width && r->y <= height - r->height;
}

bool lf_device_push_fits(int width, int height, const lf_image8 *frame, const lf_rect *rects, int n)
{
    if (n < 0 || n > LF_DEVICE_MAX_RECTS || frame == NULL || frame->channels != 3 || frame->width != width ||
        frame->height != height)
        return false;
    for (int i = 0; i < n; i++)
        if (!rect_fits(&rects[i], width, height))
            return false;
    return true;
}

void lf_device_destroy(lf_device *device)
{
    if (device != NULL)
        device->ops->destroy(device);
}

int lf_device_list(lf_device_info *out, int max)
{
    int n = 0;
    for (int i = 0; lf_device_table[i] != NULL && n < max; i++)
        if (lf_device_table[i]->probe != NULL)
            n += lf_device_table[i]->probe(out + n, max - n);
    if (n < max) {
        out[n] = (lf_device_info){.spec = "none", .kind = "none", .model = "no panel"};
        n++;
    }
    return n;
}
