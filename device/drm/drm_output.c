#include <errno.h>
#include <string.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "device/drm/drm.h"

/* Where the choice is made; the struct itself would be too much for a stack. */
typedef struct drm_scratch {
    lf_kms_plane planes[LF_KMS_PLANES];
    lf_kms_property properties[LF_KMS_PROPERTIES];
    lf_kms_connector other;
} drm_scratch;

/* -------------------------------------------------------------------------------- properties -- */

static const lf_kms_property *find_property(const lf_kms_property *properties, int n,
                                            const char *name)
{
    for (int i = 0; i < n; i++)
        if (strcmp(properties[i].name, name) == 0)
            return &properties[i];
    return NULL;
}

static bool assign(lf_drm_output *output, uint32_t object, uint32_t property, uint64_t value)
{
    if (output->n_all >= LF_DRM_ASSIGNMENTS)
        return false;
    output->all[output->n_all++] = (lf_kms_assignment){object, property, value};
    return true;
}

/* Assigns a property by name; false when the object has none of that name. */
static bool assign_named(lf_drm_output *output, uint32_t object, const lf_kms_property *properties,
                         int n, const char *name, uint64_t value)
{
    const lf_kms_property *property = find_property(properties, n, name);
    return property && assign(output, object, property->id, value);
}

static bool enum_value(const lf_kms_property *property, const char *name, uint64_t *out_value)
{
    for (int i = 0; i < property->n_enums && i < LF_KMS_ENUMS; i++) {
        if (strcmp(property->enums[i].name, name) == 0) {
            *out_value = property->enums[i].value;
            return true;
        }
    }
    return false;
}

/* A wish of the connector, whose value is put back at the end. */
static void wish_connector(lf_drm_output *output, const lf_kms_property *property, uint64_t value)
{
    if (output->n_old < LF_DRM_SAVED && assign(output, output->connector, property->id, value))
        output->old_values[output->n_old++] =
            (lf_kms_assignment){output->connector, property->id, property->value};
}

/* Every pixel as it is: whatever of this a driver has. Names as in the kernel's "KMS Properties"
 * and of amdgpu, radeon and nouveau. */
static void wish_exact_pixels(lf_drm_output *output, const lf_kms_property *properties, int n)
{
    static const struct {
        const char *property, *value;
    } wanted[] = {
        {"Broadcast RGB", "Full"},    {"scaling mode", "None"}, {"dither", "off"},
        {"dithering mode", "off"},    {"underscan", "off"},     {"Colorspace", "Default"},
        {"content type", "Graphics"},
    };
    uint64_t value;
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        const lf_kms_property *property = find_property(properties, n, wanted[i].property);
        if (property && enum_value(property, wanted[i].value, &value))
            wish_connector(output, property, value);
    }
    const lf_kms_property *depth = find_property(properties, n, "max bpc");
    if (depth && depth->low <= 8 && depth->high >= 8)
        wish_connector(output, depth, 8);
}

/* ---------------------------------------------------------------------------------- choosing -- */

/* Which CRTCs drive other connectors, as bits. */
static uint32_t taken_crtcs(const lf_drm_output *output, const lf_kms_resources *resources,
                            lf_kms_connector *other)
{
    uint32_t taken = 0;
    for (int i = 0; i < resources->n_connectors; i++) {
        uint32_t id = resources->connectors[i];
        if (id == output->connector || output->kms->connector(output->fd, id, false, other) != 0 ||
            other->crtc == 0)
            continue;
        for (int k = 0; k < resources->n_crtcs && k < LF_KMS_CRTCS; k++)
            if (resources->crtcs[k] == other->crtc)
                taken |= UINT32_C(1) << k;
    }
    return taken;
}

/* The connector's own CRTC, unless it shows the same elsewhere; else a free one. Returns its
 * number, -1 = none. */
static int choose_crtc(const lf_drm_output *output, const lf_drm_found *found,
                       lf_kms_connector *other)
{
    const lf_kms_resources *resources = &found->resources;
    uint32_t idle = found->connector.crtcs & ~taken_crtcs(output, resources, other);
    int chosen = -1;
    for (int k = 0; k < resources->n_crtcs && k < LF_KMS_CRTCS; k++) {
        if ((idle & UINT32_C(1) << k) == 0)
            continue;
        if (chosen < 0 || resources->crtcs[k] == found->connector.crtc)
            chosen = k;
    }
    return chosen;
}

/* The primary plane of a CRTC; -1 = none that takes our pixels. Its properties are in scratch then;
 * *out_n of them. */
static int choose_plane(const lf_drm_output *output, int crtc, drm_scratch *scratch, int n_planes,
                        int *out_n)
{
    for (int pass = 0; pass < 2; pass++) { /* first the one that shows there now */
        for (int i = 0; i < n_planes; i++) {
            const lf_kms_plane *plane = &scratch->planes[i];
            bool ours = plane->crtc == output->crtc, idle = plane->crtc == 0;
            if ((plane->crtcs & UINT32_C(1) << crtc) == 0 || !plane->xrgb8888 ||
                (pass == 0 ? !ours : !idle))
                continue;
            int n = output->kms->properties(output->fd, plane->id, DRM_MODE_OBJECT_PLANE,
                                            scratch->properties);
            const lf_kms_property *type =
                n > 0 ? find_property(scratch->properties, n, "type") : NULL;
            if (!type || type->value != 1 /* DRM_PLANE_TYPE_PRIMARY */)
                continue;
            *out_n = n;
            return i;
        }
    }
    return -1;
}

static bool plan_plane(lf_drm_output *output, const lf_kms_property *properties, int n)
{
    const struct {
        const char *name;
        uint64_t value;
    } needed[] = {
        {"FB_ID", 0},
        {"CRTC_ID", output->crtc},
        {"SRC_X", 0},
        {"SRC_Y", 0},
        {"SRC_W", (uint64_t)output->mode.hdisplay << 16},
        {"SRC_H", (uint64_t)output->mode.vdisplay << 16},
        {"CRTC_X", 0},
        {"CRTC_Y", 0},
        {"CRTC_W", output->mode.hdisplay},
        {"CRTC_H", output->mode.vdisplay},
    };
    for (size_t i = 0; i < sizeof needed / sizeof *needed; i++)
        if (!assign_named(output, output->plane, properties, n, needed[i].name, needed[i].value))
            return false;
    const lf_kms_property *clips = find_property(properties, n, "FB_DAMAGE_CLIPS");
    output->clips_property = clips ? clips->id : 0;
    return true;
}

/* What a desktop has left on other planes of the CRTC, its cursor above all, would cover the
 * picture. */
static void plan_other_planes(lf_drm_output *output, drm_scratch *scratch, int n_planes)
{
    for (int i = 0; i < n_planes; i++) {
        uint32_t id = scratch->planes[i].id;
        if (id == output->plane || scratch->planes[i].crtc != output->crtc)
            continue;
        int n = output->kms->properties(output->fd, id, DRM_MODE_OBJECT_PLANE, scratch->properties);
        assign_named(output, id, scratch->properties, n, "FB_ID", 0);
        assign_named(output, id, scratch->properties, n, "CRTC_ID", 0);
    }
}

static bool plan_crtc_and_connector(lf_drm_output *output, drm_scratch *scratch)
{
    const lf_kms_calls *kms = output->kms;
    lf_kms_property *properties = scratch->properties;
    int n = kms->properties(output->fd, output->crtc, DRM_MODE_OBJECT_CRTC, properties);
    if (!assign_named(output, output->crtc, properties, n, "MODE_ID", output->mode_blob) ||
        !assign_named(output, output->crtc, properties, n, "ACTIVE", 1))
        return false;
    n = kms->properties(output->fd, output->connector, DRM_MODE_OBJECT_CONNECTOR, properties);
    if (!assign_named(output, output->connector, properties, n, "CRTC_ID", output->crtc))
        return false;
    /* Without it a link that has failed is not set up again, and stays dark. */
    assign_named(output, output->connector, properties, n, "link-status",
                 DRM_MODE_LINK_STATUS_GOOD);
    return true;
}

static void plan_wishes(lf_drm_output *output, drm_scratch *scratch)
{
    static const char *const tables[] = {"GAMMA_LUT", "DEGAMMA_LUT", "CTM", "VRR_ENABLED"};
    const lf_kms_calls *kms = output->kms;
    lf_kms_property *properties = scratch->properties;
    output->n_base = output->n_all;
    int n = 0;
    if (output->atomic) {
        n = kms->properties(output->fd, output->plane, DRM_MODE_OBJECT_PLANE, properties);
        assign_named(output, output->plane, properties, n, "rotation", DRM_MODE_ROTATE_0);
        n = kms->properties(output->fd, output->crtc, DRM_MODE_OBJECT_CRTC, properties);
        for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
            assign_named(output, output->crtc, properties, n, tables[i], 0);
    }
    n = kms->properties(output->fd, output->connector, DRM_MODE_OBJECT_CONNECTOR, properties);
    wish_exact_pixels(output, properties, n);
}

/* True when the driver has everything that atomic mode setting takes. */
static bool plan_atomic(lf_drm_output *output, int crtc, drm_scratch *scratch)
{
    const lf_kms_calls *kms = output->kms;
    int n = 0, n_planes = kms->atomic(output->fd) ? kms->planes(output->fd, scratch->planes) : 0;
    int i = choose_plane(output, crtc, scratch, n_planes, &n);
    if (i < 0)
        return false;
    output->plane = scratch->planes[i].id;
    if (!plan_plane(output, scratch->properties, n) ||
        kms->blob_create(output->fd, &output->mode, sizeof output->mode, &output->mode_blob) != 0 ||
        !plan_crtc_and_connector(output, scratch))
        return false;
    plan_other_planes(output, scratch, n_planes);
    return true;
}

lf_status lf_drm_output_init(const lf_kms_calls *kms, const lf_drm_found *found, lf_drm_output *out,
                             lf_error *err)
{
    lf_status status = LF_OK;
    const char *name = found->connector.name;
    *out = (lf_drm_output){
        .kms = kms, .fd = found->fd, .connector = found->connector.id, .mode = found->mode};
    drm_scratch *scratch = lf_calloc(1, sizeof *scratch);
    if (!scratch)
        return lf_error_set(err, LF_E_NOMEM, "drm", "out of memory");
    int crtc = choose_crtc(out, found, &scratch->other);
    if (crtc < 0) {
        status = lf_error_set(err, LF_E_BUSY, "drm",
                              "the card cannot drive another display; switch one off for %s", name);
        goto fail;
    }
    out->crtc = found->resources.crtcs[crtc];
    int e = kms->crtc(found->fd, out->crtc, &out->old);
    if (e != 0) {
        status = lf_error_set(err, LF_E_IO, "drm", "cannot read what %s shows now: %s", name,
                              lf_errno_text(-e));
        goto fail;
    }
    out->atomic = plan_atomic(out, crtc, scratch);
    if (!out->atomic)
        out->n_all = 0;
    plan_wishes(out, scratch);
fail:
    lf_free(scratch);
    return status;
}

/* ----------------------------------------------------------------------------------- showing -- */

static bool refused(int e)
{
    return e == -EINVAL || e == -ERANGE || e == -EOPNOTSUPP || e == -ENOSYS;
}

/* Whether the driver does not want the first n assignments. */
static bool would_refuse(const lf_drm_output *output, int n)
{
    return refused(output->kms->commit(output->fd, LF_KMS_TEST, output->all, n));
}

/* Asks for the wishes one by one: those that are refused must not cost the others. */
static void drop_refused_wishes(lf_drm_output *output)
{
    int n = output->n_base;
    for (int i = output->n_base; i < output->n_all; i++) {
        output->all[n] = output->all[i];
        if (!would_refuse(output, n + 1))
            n++;
    }
    output->plain = output->plain || n < output->n_all;
    output->n_all = n;
}

/* With all wishes, or without those that the driver refuses. */
static int commit_mode(lf_drm_output *output, lf_kms_commit how, uint32_t fb)
{
    output->all[0].value = fb;
    int e = output->kms->commit(output->fd, how, output->all, output->n_all);
    if (!refused(e) || output->n_all == output->n_base || would_refuse(output, output->n_base))
        return e; /* not for a wish */
    drop_refused_wishes(output);
    return output->kms->commit(output->fd, how, output->all, output->n_all);
}

lf_status lf_drm_output_test(lf_drm_output *output, uint32_t fb, lf_error *err)
{
    int e = output->atomic ? commit_mode(output, LF_KMS_TEST, fb) : 0;
    if (e == 0)
        return LF_OK;
    return lf_error_set(err, LF_E_IO, "drm", "the driver cannot show %dx%d at %u Hz here: %s",
                        output->mode.hdisplay, output->mode.vdisplay, output->mode.vrefresh,
                        lf_errno_text(-e));
}

static int point_crtc(const lf_drm_output *output, uint32_t fb, const struct drm_mode_rect *clips,
                      int n)
{
    const lf_kms_crtc crtc = {.id = output->crtc, .fb = fb, .lit = true, .mode = output->mode};
    int e = output->kms->legacy.crtc_set(output->fd, &crtc, output->connector);
    if (e == 0) /* drivers that need no telling do not have it */
        output->kms->legacy.dirty(output->fd, fb, clips, n);
    return e;
}

static int set_mode(lf_drm_output *output, uint32_t fb)
{
    const lf_kms_calls *kms = output->kms;
    output->touched = true;
    if (output->atomic)
        return commit_mode(output, LF_KMS_SET, fb);
    for (int i = output->n_base; i < output->n_all; i++) {
        const lf_kms_assignment *wish = &output->all[i];
        if (kms->property_set(output->fd, wish->object, DRM_MODE_OBJECT_CONNECTOR, wish->property,
                              wish->value) != 0)
            output->plain = true;
    }
    /* A driver without a table has nothing to reset. */
    kms->legacy.gamma_reset(output->fd, output->crtc, output->old.gamma_size);
    const struct drm_mode_rect whole = {0, 0, output->mode.hdisplay, output->mode.vdisplay};
    return point_crtc(output, fb, &whole, 1);
}

/* clips[n], or the box around them when they are many: drivers walk them one by one. */
static int make_clips(const lf_rect *clips, int n, struct drm_mode_rect out[LF_DRM_CLIPS])
{
    struct drm_mode_rect box = {INT32_MAX, INT32_MAX, 0, 0};
    for (int i = 0; i < n; i++) {
        const lf_rect *c = &clips[i];
        struct drm_mode_rect r = {c->x, c->y, c->x + c->width, c->y + c->height};
        box.x1 = r.x1 < box.x1 ? r.x1 : box.x1;
        box.y1 = r.y1 < box.y1 ? r.y1 : box.y1;
        box.x2 = r.x2 > box.x2 ? r.x2 : box.x2;
        box.y2 = r.y2 > box.y2 ? r.y2 : box.y2;
        if (i < LF_DRM_CLIPS)
            out[i] = r;
    }
    if (n <= LF_DRM_CLIPS)
        return n;
    out[0] = box;
    return 1;
}

static int flip_atomic(const lf_drm_output *output, uint32_t fb, const struct drm_mode_rect *clips,
                       int n)
{
    lf_kms_assignment list[2] = {output->all[0]};
    uint32_t blob = 0;
    int used = 1;
    list[0].value = fb;
    /* Without clips the driver takes everything for changed. */
    if (output->clips_property != 0 && n > 0 &&
        output->kms->blob_create(output->fd, clips, (size_t)n * sizeof *clips, &blob) == 0)
        list[used++] = (lf_kms_assignment){output->plane, output->clips_property, blob};
    int e = output->kms->commit(output->fd, LF_KMS_FLIP, list, used);
    if (blob != 0)
        output->kms->blob_destroy(output->fd, blob);
    return e == 0 ? LF_DRM_LATER : e;
}

static int flip_legacy(lf_drm_output *output, uint32_t fb, const struct drm_mode_rect *clips, int n)
{
    if (!output->no_flip) {
        int e = output->kms->legacy.page_flip(output->fd, output->crtc, fb);
        if (!refused(e))
            return e == 0 ? LF_DRM_LATER : e;
        output->no_flip = true;
    }
    int e = point_crtc(output, fb, clips, n);
    return e == 0 ? LF_DRM_NOW : e;
}

int lf_drm_output_show(lf_drm_output *output, uint32_t fb, const lf_rect *clips, int n)
{
    struct drm_mode_rect list[LF_DRM_CLIPS];
    int e;
    if (!output->lit) {
        e = set_mode(output, fb);
        output->lit = e == 0;
        return e == 0 ? LF_DRM_NOW : e;
    }
    n = make_clips(clips, n, list);
    e = output->atomic ? flip_atomic(output, fb, list, n) : flip_legacy(output, fb, list, n);
    output->lit = e >= 0;
    return e;
}

void lf_drm_output_finish(lf_drm_output *output)
{
    const lf_kms_calls *kms = output->kms;
    if (output->touched) {
        for (int i = 0; i < output->n_old; i++) {
            const lf_kms_assignment *old = &output->old_values[i];
            kms->property_set(output->fd, old->object, DRM_MODE_OBJECT_CONNECTOR, old->property,
                              old->value);
        }
        /* When the picture is gone with who made it there is nothing to do: closing the card brings
         * the console. */
        kms->legacy.crtc_set(output->fd, &output->old, output->connector);
    }
    if (output->mode_blob != 0)
        kms->blob_destroy(output->fd, output->mode_blob);
    *output = (lf_drm_output){0};
}

const char *lf_drm_output_problem(const lf_drm_output *output)
{
    return output->plain ? "the driver refuses full colour range, 8 bits per channel or unscaled, "
                           "unrotated, unprocessed output, so views may mix"
                         : "";
}
