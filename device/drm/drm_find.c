#include <errno.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/number.h"
#include "device/device_table.h"
#include "device/drm/drm.h"
#include "device/find/find.h"

enum { MAX_CARD = 255 };

/* The first opener of a card is its master, wanted or not: while one thread only looks, another
 * must not be refused for it. */
static pthread_mutex_t mastership = PTHREAD_MUTEX_INITIALIZER;

/* ------------------------------------------------------------------------------------ naming -- */

/* TYPE-NUMBER, TYPE of letters, digits and hyphens: "DP-1", "HDMI-A-1", "Virtual-1". */
static bool is_connector_name(const char *s)
{
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
    static const char digits[] = "0123456789";
    const char *hyphen = strrchr(s, '-');
    if (!hyphen || hyphen == s || strlen(s) >= LF_KMS_NAME)
        return false;
    size_t number = strspn(hyphen + 1, digits);
    if (number == 0 || number > 9 || hyphen[1 + number] != 0)
        return false;
    for (const char *c = s; c < hyphen; c++)
        if (!strchr(letters, *c) && !strchr(digits, *c) && *c != '-')
            return false;
    return strchr(letters, s[0]);
}

lf_status lf_drm_name_parse(const char *argument, lf_drm_name *out, lf_error *err)
{
    lf_drm_name name = {.card = -1};
    const char *connector = argument, *slash = NULL;
    uint64_t card;
    if (argument[0] == 0) {
        *out = name;
        return LF_OK;
    }
    if (strncmp(argument, "card", 4) == 0)
        slash = lf_whole_read(argument + 4, &card);
    if (slash && *slash == '/') {
        name.card = card > MAX_CARD ? MAX_CARD + 1 : (int)card;
        connector = slash + 1;
    }
    if (name.card > MAX_CARD || !is_connector_name(connector))
        return lf_error_set(err, LF_E_ARG, "drm",
                            "\"%.60s\" is not the name of a display output; expected drm, drm:DP-1 "
                            "or drm:card1/HDMI-A-1",
                            argument);
    if (connector == argument)
        name.card = -1;
    snprintf(name.connector, sizeof name.connector, "%s", connector);
    *out = name;
    return LF_OK;
}

/* ------------------------------------------------------------------------ modes and monitors -- */

static bool mode_usable(const struct drm_mode_modeinfo *mode)
{
    const uint32_t odd = DRM_MODE_FLAG_INTERLACE | DRM_MODE_FLAG_DBLSCAN | DRM_MODE_FLAG_3D_MASK;
    return mode->hdisplay > 0 && mode->hdisplay <= LF_MAX_SIDE && mode->vdisplay > 0 &&
           mode->vdisplay <= LF_MAX_SIDE && (mode->flags & odd) == 0;
}

static bool mode_better(const struct drm_mode_modeinfo *a, const struct drm_mode_modeinfo *b)
{
    bool preferred_a = (a->type & DRM_MODE_TYPE_PREFERRED) != 0,
         preferred_b = (b->type & DRM_MODE_TYPE_PREFERRED) != 0;
    uint32_t area_a = (uint32_t)a->hdisplay * a->vdisplay,
             area_b = (uint32_t)b->hdisplay * b->vdisplay;
    if (preferred_a || preferred_b)
        return preferred_a && !preferred_b; /* of two preferred ones the first */
    return area_a != area_b ? area_a > area_b : a->vrefresh > b->vrefresh;
}

const struct drm_mode_modeinfo *lf_drm_native_mode(const lf_kms_connector *connector)
{
    const struct drm_mode_modeinfo *best = NULL;
    for (int i = 0; i < connector->n_modes && i < LF_KMS_MODES; i++)
        if (mode_usable(&connector->modes[i]) && (!best || mode_better(&connector->modes[i], best)))
            best = &connector->modes[i];
    return best;
}

/* A connector as the kernel knows it; monitors are asked only when nobody has before. */
static bool get_connector(const lf_kms_calls *kms, int fd, uint32_t id, bool look,
                          lf_kms_connector *out)
{
    if (kms->connector(fd, id, look, out) != 0)
        return false;
    bool unasked = !out->known || (out->connected && out->n_modes == 0);
    return look || !unasked || kms->connector(fd, id, true, out) == 0;
}

bool lf_drm_read_edid(const lf_kms_calls *kms, int fd, uint32_t connector, lf_edid *out,
                      uint8_t out_block[LF_DRM_EDID_BLOCK])
{
    uint8_t bytes[LF_KMS_EDID];
    int n = kms->edid(fd, connector, bytes);
    *out = (lf_edid){0};
    memset(out_block, 0, LF_DRM_EDID_BLOCK);
    if (n < LF_DRM_EDID_BLOCK || lf_edid_parse(bytes, LF_DRM_EDID_BLOCK, out, NULL) != LF_OK)
        return false;
    memcpy(out_block, bytes, LF_DRM_EDID_BLOCK);
    return true;
}

/* ----------------------------------------------------------------------------------- finding -- */

/* What was met on the way, for the error. */
typedef struct drm_search {
    int denied;     /* a card that may not be opened, -1 = none */
    int denied_why; /* errno */
    char seen[256]; /* monitors, with commas */
} drm_search;

static void remember(drm_search *search, const lf_kms_connector *connector, const lf_edid *edid)
{
    size_t used = strlen(search->seen);
    snprintf(search->seen + used, sizeof search->seen - used, "%s%s%s%s%s", used > 0 ? ", " : "",
             connector->name, edid->name[0] != 0 ? " (" : "", edid->name,
             edid->name[0] != 0 ? ")" : "");
}

/* Looks at one connector; true when it is the one. */
static bool is_wanted(const lf_kms_calls *kms, const lf_drm_name *name, uint32_t id,
                      drm_search *search, lf_drm_found *out)
{
    lf_kms_connector *connector = &out->connector;
    bool named = name->connector[0] != 0;
    if (!get_connector(kms, out->fd, id, false, connector))
        return false;
    if (named && strcmp(connector->name, name->connector) == 0 && !connector->connected &&
        !get_connector(kms, out->fd, id, true, connector))
        return false;
    if (!connector->connected)
        return false;
    out->has_edid = lf_drm_read_edid(kms, out->fd, id, &out->edid, out->edid_block);
    remember(search, connector, &out->edid);
    return named ? strcmp(connector->name, name->connector) == 0
                 : out->has_edid && lf_edid_is_panel(&out->edid);
}

static int open_card(const lf_kms_calls *kms, int card, lf_kms_resources *resources)
{
    int fd = kms->open(card);
    if (fd < 0)
        return fd;
    if (kms->usable(fd) && kms->resources(fd, resources) == 0)
        return fd;
    kms->close(fd);
    return -EOPNOTSUPP;
}

static bool find_on_card(const lf_kms_calls *kms, const lf_drm_name *name, int card,
                         drm_search *search, lf_drm_found *out)
{
    out->card = card;
    out->fd = open_card(kms, card, &out->resources);
    if (out->fd == -EACCES || out->fd == -EPERM) {
        search->denied = card;
        search->denied_why = -out->fd;
    }
    if (out->fd < 0)
        return false;
    for (int i = 0; i < out->resources.n_connectors; i++)
        if (is_wanted(kms, name, out->resources.connectors[i], search, out))
            return true;
    kms->close(out->fd);
    return false;
}

static lf_status not_found(const lf_drm_name *name, const drm_search *search, lf_error *err)
{
    char what[LF_KMS_NAME + 40] = "no Looking Glass is connected to a display output";
    if (search->denied >= 0)
        return lf_error_set(err, LF_E_IO, "drm",
                            "cannot open /dev/dri/card%d (%s); add the user to the group video "
                            "(usermod -aG video) or log in at this machine's screen",
                            search->denied, lf_errno_text(search->denied_why));
    if (name->connector[0] != 0)
        snprintf(what, sizeof what, "no monitor is connected to %s", name->connector);
    return lf_error_set(err, LF_E_NODEV, "drm", "%s; found: %s", what,
                        search->seen[0] != 0 ? search->seen : "nothing");
}

static lf_status find(const lf_kms_calls *kms, const lf_drm_name *name, lf_drm_found *out,
                      lf_error *err)
{
    int cards[LF_KMS_CARDS];
    drm_search search = {.denied = -1};
    int n = kms->cards(cards);
    for (int i = 0; i < n; i++) {
        if (name->card >= 0 && cards[i] != name->card)
            continue;
        if (!find_on_card(kms, name, cards[i], &search, out))
            continue;
        const struct drm_mode_modeinfo *mode = lf_drm_native_mode(&out->connector);
        if (mode) {
            out->mode = *mode;
            return LF_OK;
        }
        kms->close(out->fd);
        return lf_error_set(err, LF_E_FORMAT, "drm",
                            "the monitor on %s has no usable mode; unplug it and plug it in again",
                            out->connector.name);
    }
    return not_found(name, &search, err);
}

lf_status lf_drm_find(const lf_kms_calls *kms, const lf_drm_name *name, lf_drm_found *out,
                      lf_error *err)
{
    pthread_mutex_lock(&mastership);
    lf_status status = find(kms, name, out, err);
    if (status == LF_OK)
        kms->master_drop(out->fd);
    pthread_mutex_unlock(&mastership);
    return status;
}

int lf_drm_become_master(const lf_kms_calls *kms, int fd)
{
    pthread_mutex_lock(&mastership);
    int e = kms->master_set(fd);
    pthread_mutex_unlock(&mastership);
    return e;
}

/* ----------------------------------------------------------------------------------- probing -- */

/* Whether what the CRTC shows is turned or mirrored on its way. */
static bool is_rotated(const lf_kms_calls *kms, int fd, uint32_t crtc)
{
    bool rotated = false;
    lf_kms_plane *planes = lf_calloc(LF_KMS_PLANES, sizeof *planes);
    lf_kms_property *properties = lf_calloc(LF_KMS_PROPERTIES, sizeof *properties);
    int n = planes && properties && kms->atomic(fd) ? kms->planes(fd, planes) : 0;
    for (int i = 0; i < n && !rotated; i++) {
        if (planes[i].crtc != crtc)
            continue;
        int n_properties = kms->properties(fd, planes[i].id, DRM_MODE_OBJECT_PLANE, properties);
        for (int k = 0; k < n_properties; k++)
            rotated = rotated || (strcmp(properties[k].name, "rotation") == 0 &&
                                  properties[k].value != DRM_MODE_ROTATE_0);
    }
    lf_free(planes);
    lf_free(properties);
    return rotated;
}

/* How the kernel says that the panel is built in, where that is not upright; "" = nothing is said.
 */
static void find_orientation(const lf_kms_calls *kms, int fd, uint32_t connector,
                             char out[LF_KMS_NAME])
{
    out[0] = 0;
    lf_kms_property *properties = lf_calloc(LF_KMS_PROPERTIES, sizeof *properties);
    int n = properties ? kms->properties(fd, connector, DRM_MODE_OBJECT_CONNECTOR, properties) : 0;
    for (int i = 0; i < n; i++) {
        const lf_kms_property *p = &properties[i];
        for (int k = 0; k < p->n_enums && strcmp(p->name, "panel orientation") == 0; k++)
            if (p->enums[k].value == p->value && strcmp(p->enums[k].name, "Normal") != 0)
                memcpy(out, p->enums[k].name, LF_KMS_NAME);
    }
    lf_free(properties);
}

/* What would be wrong with a panel that nobody uses, and what to do. */
static void describe_trouble(const lf_kms_calls *kms, int fd, const lf_kms_connector *connector,
                             bool known, lf_device_info *out)
{
    char orientation[LF_KMS_NAME], text[256] = "";
    find_orientation(kms, fd, connector->id, orientation);
    if (!lf_drm_native_mode(connector))
        snprintf(text, sizeof text,
                 "the monitor has no usable mode; unplug it and plug it in again");
    else if (orientation[0] != 0)
        snprintf(text, sizeof text,
                 "the kernel reports a rotated panel (%s), so desktops rotate the image; set "
                 "normal orientation there, or boot with video=%s:panel_orientation=normal",
                 orientation, connector->name);
    else if (out->problem[0] == 0 && !known)
        snprintf(text, sizeof text,
                 "no calibration was found; connect the panel's USB cable (not only video), or "
                 "pass its visual.json with --calibration");
    if (text[0] != 0)
        lf_device_text(out->problem, sizeof out->problem, text);
}

/* What the program that has the card does wrong with this panel, for "…; it shows SOMETHING". */
static void describe_use(const lf_kms_calls *kms, int card, int fd,
                         const lf_kms_connector *connector, lf_device_info *out)
{
    char who[64], by[80] = "another program", text[256], how[96] = "";
    lf_kms_crtc crtc = {0};
    const struct drm_mode_modeinfo *native = lf_drm_native_mode(connector);
    if (kms->master_name(card, who, sizeof who))
        snprintf(by, sizeof by, "%s", who);
    if (connector->crtc != 0 && kms->crtc(fd, connector->crtc, &crtc) == 0 && crtc.lit && native) {
        if (crtc.mode.hdisplay != native->hdisplay || crtc.mode.vdisplay != native->vdisplay)
            snprintf(how, sizeof how,
                     ", which scales the image; set the mode from %dx%d to the native %dx%d",
                     crtc.mode.hdisplay, crtc.mode.vdisplay, native->hdisplay, native->vdisplay);
        else if (is_rotated(kms, fd, connector->crtc))
            snprintf(how, sizeof how, ", which rotates the image; set its orientation to normal");
    }
    snprintf(text, sizeof text, "used by %s%s; on a desktop use --device window", by, how);
    lf_device_text(out->problem, sizeof out->problem, text);
}

static bool describe(const lf_kms_calls *kms, int card, int fd, uint32_t id, bool used,
                     lf_device_info *out)
{
    lf_kms_connector connector;
    lf_edid edid;
    if (!get_connector(kms, fd, id, false, &connector) || !connector.connected)
        return false;
    uint8_t block[LF_DRM_EDID_BLOCK];
    bool has_edid = lf_drm_read_edid(kms, fd, id, &edid, block);
    if (has_edid && !lf_edid_is_panel(&edid))
        return false;
    const struct drm_mode_modeinfo *mode = lf_drm_native_mode(&connector);
    *out = (lf_device_info){.kind = "drm"};
    snprintf(out->spec, sizeof out->spec, "drm:card%d/%s", card, connector.name);
    snprintf(out->output, sizeof out->output, "card%d/%s", card, connector.name);
    if (mode)
        snprintf(out->output, sizeof out->output, "card%d/%s %dx%d", card, connector.name,
                 mode->hdisplay, mode->vdisplay);
    if (has_edid) {
        lf_device_text(out->model, sizeof out->model, edid.name);
        lf_device_text(out->serial, sizeof out->serial, edid.serial);
    } else {
        snprintf(out->problem, sizeof out->problem,
                 "the monitor has no EDID; if it is a Looking Glass, use --device drm:card%d/%s",
                 card, connector.name);
    }
    bool known = has_edid && lf_find_promise(&edid, out->calibration_from);
    if (used)
        describe_use(kms, card, fd, &connector, out);
    else
        describe_trouble(kms, fd, &connector, known, out);
    return true;
}

/* As open_card, and is not its master afterwards. */
static int look_at_card(const lf_kms_calls *kms, int card, lf_kms_resources *resources,
                        bool *out_unused)
{
    pthread_mutex_lock(&mastership);
    int fd = open_card(kms, card, resources);
    *out_unused = fd >= 0 && kms->master_is(fd);
    if (*out_unused)
        kms->master_drop(fd);
    pthread_mutex_unlock(&mastership);
    return fd;
}

static int probe_card(const lf_kms_calls *kms, int card, lf_device_info *out, int max)
{
    lf_kms_resources resources;
    bool unused = false;
    int n = 0, fd = look_at_card(kms, card, &resources, &unused);
    if (fd == -EACCES || fd == -EPERM) {
        *out = (lf_device_info){.spec = "drm", .kind = "drm"};
        snprintf(out->output, sizeof out->output, "card%d", card);
        snprintf(
            out->problem, sizeof out->problem,
            "cannot open /dev/dri/card%d (%s); add the user to the group video (usermod -aG video)",
            card, lf_errno_text(-fd));
        return 1;
    }
    if (fd < 0)
        return 0;
    for (int i = 0; i < resources.n_connectors && n < max; i++)
        n += describe(kms, card, fd, resources.connectors[i], !unused, &out[n]);
    kms->close(fd);
    return n;
}

int lf_drm_probe(const lf_kms_calls *kms, lf_device_info *out, int max)
{
    int cards[LF_KMS_CARDS];
    int n = 0, n_cards = kms->cards(cards);
    for (int i = 0; i < n_cards && n < max; i++)
        n += probe_card(kms, cards[i], out + n, max - n);
    return n;
}
