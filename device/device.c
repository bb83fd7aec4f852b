#include "device/device.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "device/device_table.h"

enum { MAX_FOUND = 32 };

const lf_device_ops *const lf_device_table[] = {&lf_drm_ops, &lf_window_ops, &lf_usb_ops,
                                                &lf_sim_ops, &lf_none_ops,   NULL};

static const lf_device_ops *find_kind(const lf_device_ops *const table[], const char *kind,
                                      size_t length)
{
    for (int i = 0; table[i]; i++)
        if (strlen(table[i]->kind) == length && memcmp(table[i]->kind, kind, length) == 0)
            return table[i];
    return NULL;
}

/* The part of a spec behind the colon. */
static const char *argument_of(const char *spec)
{
    const char *colon = strchr(spec, ':');
    return colon ? colon + 1 : "";
}

static const lf_device_ops *kind_of(const char *spec)
{
    return find_kind(lf_device_table, spec, strcspn(spec, ":"));
}

const char *lf_device_kind_at(int index)
{
    if (index == 0)
        return "auto";
    return lf_device_table[index - 1] ? lf_device_table[index - 1]->kind : NULL;
}

bool lf_device_is_auto(const char *spec)
{
    return strcmp(spec, "auto") == 0;
}

bool lf_device_has_kind(const char *spec, const char *kind)
{
    size_t n = strcspn(spec, ":");
    return strncmp(spec, kind, n) == 0 && kind[n] == '\0';
}

bool lf_device_is_panel(const char *spec)
{
    const lf_device_ops *ops = kind_of(spec);
    return !ops || ops->is_panel;
}

bool lf_device_is_hardware(const char *spec)
{
    const lf_device_ops *ops = kind_of(spec);
    return !ops || ops->is_hardware;
}

bool lf_device_same(const char *open, const char *spec)
{
    const lf_device_ops *ops = kind_of(open);
    if (lf_device_is_auto(spec))
        return true;
    return ops && lf_device_has_kind(spec, ops->kind) &&
           (!ops->same || ops->same(argument_of(open), argument_of(spec)));
}

const char *lf_device_folder(const char *spec, size_t *out_length)
{
    const lf_device_ops *ops = kind_of(spec);
    if (!ops || !ops->folder || !strchr(spec, ':'))
        return NULL;
    *out_length = ops->folder(argument_of(spec));
    return argument_of(spec);
}

char *lf_device_allowed_spec(const char *spec, const char *folder)
{
    size_t n = 0;
    const char *named = lf_device_folder(spec, &n), *option = kind_of(spec)->no_links;
    assert(named && option);
    bool has = strstr(named + n, option);
    size_t size = strlen(spec) - n + strlen(folder) + strlen(option) + 1;
    char *allowed = lf_calloc(size, 1);
    if (allowed)
        snprintf(allowed, size, "%.*s%s%s%s", (int)(named - spec), spec, folder, named + n,
                 has ? "" : option);
    return allowed;
}

/* What has become of looking for a panel so far. */
typedef struct search {
    const char *first; /* its spec; empty = any */
    const lf_calibration *calibration;
    lf_device *device; /* the one that could be opened */
    bool tried;        /* there was one that could not */
    /* LF_E_NODEV, until there was one that may be opened later without anything being plugged in */
    lf_status status;
    char problem[256];
} search;

static bool try_panel(const lf_device_ops *ops, const lf_device_info *found, search *s)
{
    lf_error why = {0};
    lf_status status = ops->open(argument_of(found->spec), s->calibration, &s->device, &why);
    if (status == LF_OK)
        return true;
    s->tried = true;
    if (status != LF_E_NODEV)
        s->status = status == LF_E_BUSY ? LF_E_BUSY : LF_E_IO;
    snprintf(s->problem, sizeof s->problem, "%.100s cannot be used: %.130s", found->spec, why.what);
    return false;
}

/* Tries the panels of a kind: the first one's, or all others. */
static bool try_kind(const lf_device_ops *ops, bool first, search *s)
{
    lf_device_info found[MAX_FOUND];
    int n = ops->probe ? ops->probe(found, MAX_FOUND) : 0;
    for (int i = 0; i < n; i++) {
        if ((strcmp(found[i].spec, s->first) == 0) != first)
            continue;
        if (found[i].model[0] == 0) { /* nobody knows whether it is a panel */
            if (!s->tried)
                snprintf(s->problem, sizeof s->problem, "%.255s", found[i].problem);
            continue;
        }
        if (try_panel(ops, &found[i], s))
            return true;
    }
    return false;
}

lf_status lf_device_find_in(const lf_device_ops *const table[], const char *first,
                            const lf_calibration *calibration, lf_device **out_device,
                            lf_error *err)
{
    search s = {.first = first,
                .calibration = calibration,
                .status = LF_E_NODEV,
                .problem = "no panel was found; check its cables, or run quiltctl doctor"};
    const lf_device_ops *kind = find_kind(table, first, strcspn(first, ":"));
    bool found = kind && try_kind(kind, true, &s);
    for (int i = 0; table[i] && !found; i++)
        found = try_kind(table[i], false, &s);
    if (!found)
        return lf_error_set(err, s.status, "auto", "%s", s.problem);
    *out_device = s.device;
    return LF_OK;
}

lf_status lf_device_find(const char *first, const lf_calibration *calibration,
                         lf_device **out_device, lf_error *err)
{
    assert(first && out_device);
    return lf_device_find_in(lf_device_table, first, calibration, out_device, err);
}

static lf_status open_auto(const lf_calibration *calibration, lf_device **out_device, lf_error *err)
{
    lf_error why = {0};
    lf_status status = lf_device_find("", calibration, out_device, &why);
    return status == LF_OK ? LF_OK : lf_none_create(why.what, out_device, err);
}

lf_status lf_device_open(const char *spec, const lf_calibration *calibration,
                         lf_device **out_device, lf_error *err)
{
    assert(spec && out_device);
    if (strlen(spec) >= sizeof((lf_device_info *)0)->spec)
        return lf_error_set(err, LF_E_ARG, "device", "the spec is longer than %zu bytes",
                            sizeof((lf_device_info *)0)->spec - 1);
    if (lf_device_is_auto(spec))
        return open_auto(calibration, out_device, err);
    const lf_device_ops *ops = kind_of(spec);
    if (!ops)
        return lf_error_set(err, LF_E_ARG, spec,
                            "unknown kind of device; expected auto, drm[:OUTPUT], "
                            "window[:MONITOR], usb[:BUS-PORT], none or sim:DIR[,option=value]");
    return ops->open(argument_of(spec), calibration, out_device, err);
}

static bool rect_fits(const lf_rect *r, int width, int height)
{
    return r->x >= 0 && r->y >= 0 && r->width > 0 && r->height > 0 && r->width <= width &&
           r->height <= height && r->x <= width - r->width && r->y <= height - r->height;
}

bool lf_device_push_fits(int width, int height, const lf_image8 *frame, const lf_rect *rects, int n)
{
    if (n < 0 || n > LF_DEVICE_MAX_RECTS || !frame || frame->channels != 3 ||
        frame->width != width || frame->height != height)
        return false;
    for (int i = 0; i < n; i++)
        if (!rect_fits(&rects[i], width, height))
            return false;
    return true;
}

void lf_device_destroy(lf_device *device)
{
    if (device)
        device->ops->destroy(device);
}

int lf_device_list(lf_device_info *out, int max)
{
    int n = 0;
    for (int i = 0; lf_device_table[i] && n < max; i++)
        if (lf_device_table[i]->probe)
            n += lf_device_table[i]->probe(out + n, max - n);
    if (n < max) {
        out[n] = (lf_device_info){.spec = "none", .kind = "none", .model = "no panel"};
        n++;
    }
    return n;
}
