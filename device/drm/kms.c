#include "device/drm/kms.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <linux/netlink.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <drm_fourcc.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include "base/number.h"

/* ------------------------------------------------------------------------------------- cards -- */

static int order(const void *a, const void *b)
{
    const int *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

static int kernel_cards(int out[LF_KMS_CARDS])
{
    DIR *dir = opendir("/dev/dri");
    const struct dirent *entry;
    int n = 0;
    while (dir && n < LF_KMS_CARDS && (entry = readdir(dir))) {
        uint64_t card;
        if (strncmp(entry->d_name, "card", 4) == 0 && lf_whole_is(entry->d_name + 4, &card) &&
            card < 1000)
            out[n++] = (int)card;
    }
    if (dir)
        closedir(dir);
    qsort(out, (size_t)n, sizeof *out, order);
    return n;
}

static int kernel_open(int card)
{
    char path[32];
    snprintf(path, sizeof path, "/dev/dri/card%d", card);
    int fd = open(path, O_RDWR | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return -errno;
    return fd;
}

static void kernel_close(int fd)
{
    close(fd);
}

static int kernel_master_set(int fd)
{
    return drmSetMaster(fd) == 0 ? 0 : -errno;
}

static void kernel_master_drop(int fd)
{
    drmDropMaster(fd);
}

static bool kernel_master_is(int fd)
{
    return drmIsMaster(fd) != 0;
}

/* The kernel's debugfs has one line per client: command in 20 columns, process, minor, y or n for
 * master, … */
static bool kernel_master_name(int card, char *out, size_t size)
{
    enum { COMMAND = 20 };
    char line[256];
    bool found = false;
    snprintf(line, sizeof line, "/sys/kernel/debug/dri/%d/clients", card);
    FILE *file = fopen(line, "re");
    while (file && !found && fgets(line, sizeof line, file)) {
        int process, minor;
        char master;
        if (strlen(line) < COMMAND ||
            sscanf(line + COMMAND, " %d %d %c", &process, &minor, &master) != 3 || master != 'y')
            continue;
        line[COMMAND] = 0;
        snprintf(out, size, "%s (process %d)", line + strspn(line, " "), process);
        found = true;
    }
    if (file)
        fclose(file);
    return found;
}

static bool kernel_usable(int fd)
{
    uint64_t dumb = 0;
    return drmIsKMS(fd) && drmGetCap(fd, DRM_CAP_DUMB_BUFFER, &dumb) == 0 && dumb != 0;
}

static bool kernel_atomic(int fd)
{
    return drmSetClientCap(fd, DRM_CLIENT_CAP_UNIVERSAL_PLANES, 1) == 0 &&
           drmSetClientCap(fd, DRM_CLIENT_CAP_ATOMIC, 1) == 0;
}

/* ----------------------------------------------------------------------------- what there is -- */

static int copy_ids(uint32_t *out, int max, const uint32_t *ids, int n)
{
    n = n < 0 ? 0 : n < max ? n : max;
    for (int i = 0; i < n; i++)
        out[i] = ids[i];
    return n;
}

static int kernel_resources(int fd, lf_kms_resources *out)
{
    drmModeRes *resources = drmModeGetResources(fd);
    if (!resources)
        return errno != 0 ? -errno : -EIO;
    *out = (lf_kms_resources){0};
    out->n_crtcs = copy_ids(out->crtcs, LF_KMS_CRTCS, resources->crtcs, resources->count_crtcs);
    out->n_connectors = copy_ids(out->connectors, LF_KMS_CONNECTORS, resources->connectors,
                                 resources->count_connectors);
    drmModeFreeResources(resources);
    return 0;
}

static void read_encoders(int fd, const drmModeConnector *connector, lf_kms_connector *out)
{
    for (int i = 0; i < connector->count_encoders; i++) {
        drmModeEncoder *encoder = drmModeGetEncoder(fd, connector->encoders[i]);
        if (!encoder)
            continue;
        out->crtcs |= encoder->possible_crtcs;
        if (encoder->encoder_id == connector->encoder_id)
            out->crtc = encoder->crtc_id;
        drmModeFreeEncoder(encoder);
    }
}

static int kernel_connector(int fd, uint32_t id, bool look, lf_kms_connector *out)
{
    drmModeConnector *connector =
        look ? drmModeGetConnector(fd, id) : drmModeGetConnectorCurrent(fd, id);
    if (!connector)
        return errno != 0 ? -errno : -EIO;
    const char *type = drmModeGetConnectorTypeName(connector->connector_type);
    *out = (lf_kms_connector){.id = id,
                              .connected = connector->connection == DRM_MODE_CONNECTED,
                              .known = connector->connection != DRM_MODE_UNKNOWNCONNECTION};
    snprintf(out->name, sizeof out->name, "%s-%" PRIu32, type ? type : "Unknown",
             connector->connector_type_id);
    for (int i = 0; i < connector->count_modes && i < LF_KMS_MODES; i++) {
        _Static_assert(sizeof out->modes[0] == sizeof connector->modes[0],
                       "libdrm's mode is the kernel's");
        memcpy(&out->modes[i], &connector->modes[i], sizeof out->modes[i]);
        out->n_modes++;
    }
    read_encoders(fd, connector, out);
    drmModeFreeConnector(connector);
    return 0;
}

static int kernel_crtc(int fd, uint32_t id, lf_kms_crtc *out)
{
    drmModeCrtc *crtc = drmModeGetCrtc(fd, id);
    if (!crtc)
        return errno != 0 ? -errno : -EIO;
    *out = (lf_kms_crtc){.id = id,
                         .fb = crtc->buffer_id,
                         .x = crtc->x,
                         .y = crtc->y,
                         .lit = crtc->mode_valid != 0,
                         .gamma_size = crtc->gamma_size};
    memcpy(&out->mode, &crtc->mode, sizeof out->mode);
    drmModeFreeCrtc(crtc);
    return 0;
}

static int kernel_planes(int fd, lf_kms_plane out[LF_KMS_PLANES])
{
    drmModePlaneRes *planes = drmModeGetPlaneResources(fd);
    int n = 0;
    if (!planes)
        return errno != 0 ? -errno : -EIO;
    for (uint32_t i = 0; i < planes->count_planes && n < LF_KMS_PLANES; i++) {
        drmModePlane *plane = drmModeGetPlane(fd, planes->planes[i]);
        if (!plane)
            continue;
        out[n] = (lf_kms_plane){
            .id = plane->plane_id, .crtc = plane->crtc_id, .crtcs = plane->possible_crtcs};
        for (uint32_t k = 0; k < plane->count_formats; k++)
            out[n].xrgb8888 = out[n].xrgb8888 || plane->formats[k] == DRM_FORMAT_XRGB8888;
        drmModeFreePlane(plane);
        n++;
    }
    drmModeFreePlaneResources(planes);
    return n;
}

/* -------------------------------------------------------------------------------- properties -- */

static void read_property(drmModePropertyRes *property, uint64_t value, lf_kms_property *out)
{
    *out = (lf_kms_property){.id = property->prop_id, .value = value};
    snprintf(out->name, sizeof out->name, "%.*s", LF_KMS_NAME - 1, property->name);
    if (drm_property_type_is(property, DRM_MODE_PROP_RANGE) && property->count_values == 2) {
        out->low = property->values[0];
        out->high = property->values[1];
    }
    for (int i = 0; i < property->count_enums && i < LF_KMS_ENUMS; i++) {
        snprintf(out->enums[i].name, sizeof out->enums[i].name, "%.*s", LF_KMS_NAME - 1,
                 property->enums[i].name);
        out->enums[i].value = property->enums[i].value;
        out->n_enums++;
    }
}

static int kernel_properties(int fd, uint32_t object, uint32_t type,
                             lf_kms_property out[LF_KMS_PROPERTIES])
{
    drmModeObjectProperties *all = drmModeObjectGetProperties(fd, object, type);
    int n = 0;
    if (!all)
        return errno != 0 ? -errno : -EIO;
    for (uint32_t i = 0; i < all->count_props && n < LF_KMS_PROPERTIES; i++) {
        drmModePropertyRes *property = drmModeGetProperty(fd, all->props[i]);
        if (!property)
            continue;
        read_property(property, all->prop_values[i], &out[n++]);
        drmModeFreeProperty(property);
    }
    drmModeFreeObjectProperties(all);
    return n;
}

static int kernel_property_set(int fd, uint32_t object, uint32_t type, uint32_t property,
                               uint64_t value)
{
    return drmModeObjectSetProperty(fd, object, type, property, value) == 0 ? 0 : -errno;
}

/* Reads the EDID blob of a property; returns its bytes. */
static int read_blob(int fd, uint64_t blob_id, uint8_t out[LF_KMS_EDID])
{
    drmModePropertyBlobRes *blob = drmModeGetPropertyBlob(fd, (uint32_t)blob_id);
    if (!blob)
        return 0;
    size_t n = blob->length < LF_KMS_EDID ? blob->length : LF_KMS_EDID;
    memcpy(out, blob->data, n);
    drmModeFreePropertyBlob(blob);
    return (int)n;
}

static int kernel_edid(int fd, uint32_t connector, uint8_t out[LF_KMS_EDID])
{
    drmModeObjectProperties *all =
        drmModeObjectGetProperties(fd, connector, DRM_MODE_OBJECT_CONNECTOR);
    int n = 0;
    if (!all)
        return errno != 0 ? -errno : -EIO;
    for (uint32_t i = 0; i < all->count_props && n == 0; i++) {
        drmModePropertyRes *property = drmModeGetProperty(fd, all->props[i]);
        if (property && strncmp(property->name, "EDID", DRM_PROP_NAME_LEN) == 0 &&
            all->prop_values[i] != 0)
            n = read_blob(fd, all->prop_values[i], out);
        drmModeFreeProperty(property);
    }
    drmModeFreeObjectProperties(all);
    return n;
}

/* ----------------------------------------------------------------------------------- buffers -- */

static int kernel_buffer_create(int fd, uint32_t width, uint32_t height, uint32_t *out_handle,
                                uint32_t *out_pitch, uint64_t *out_size)
{
    return drmModeCreateDumbBuffer(fd, width, height, 32, 0, out_handle, out_pitch, out_size);
}

static void kernel_buffer_destroy(int fd, uint32_t handle)
{
    drmModeDestroyDumbBuffer(fd, handle);
}

static void *kernel_buffer_map(int fd, uint32_t handle, size_t size)
{
    uint64_t offset = 0;
    int e = drmModeMapDumbBuffer(fd, handle, &offset);
    if (e != 0) {
        errno = -e;
        return NULL;
    }
    void *map = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, fd, (off_t)offset);
    if (map == MAP_FAILED)
        return NULL;
    return map;
}

static void kernel_buffer_unmap(void *map, size_t size)
{
    munmap(map, size);
}

static int kernel_fb_add(int fd, uint32_t width, uint32_t height, uint32_t pitch, uint32_t handle,
                         uint32_t *out_fb)
{
    const uint32_t handles[4] = {handle}, pitches[4] = {pitch}, offsets[4] = {0};
    int e =
        drmModeAddFB2(fd, width, height, DRM_FORMAT_XRGB8888, handles, pitches, offsets, out_fb, 0);
    /* for drivers older than pixel formats */
    return e == 0 ? 0 : drmModeAddFB(fd, width, height, 24, 32, pitch, handle, out_fb);
}

static void kernel_fb_remove(int fd, uint32_t fb)
{
    drmModeRmFB(fd, fb);
}

static int kernel_blob_create(int fd, const void *data, size_t size, uint32_t *out_blob)
{
    return drmModeCreatePropertyBlob(fd, data, size, out_blob);
}

static void kernel_blob_destroy(int fd, uint32_t blob)
{
    drmModeDestroyPropertyBlob(fd, blob);
}

/* ----------------------------------------------------------------------------------- showing -- */

static int kernel_crtc_set(int fd, const lf_kms_crtc *crtc, uint32_t connector)
{
    drmModeModeInfo mode;
    memcpy(&mode, &crtc->mode, sizeof mode);
    if (crtc->fb == 0 || !crtc->lit)
        return drmModeSetCrtc(fd, crtc->id, 0, 0, 0, NULL, 0, NULL);
    return drmModeSetCrtc(fd, crtc->id, crtc->fb, crtc->x, crtc->y, &connector, 1, &mode);
}

static int kernel_page_flip(int fd, uint32_t crtc, uint32_t fb)
{
    return drmModePageFlip(fd, crtc, fb, DRM_MODE_PAGE_FLIP_EVENT, NULL);
}

static int kernel_dirty(int fd, uint32_t fb, const struct drm_mode_rect *rects, int n)
{
    enum { MAX_CLIPS = DRM_MODE_FB_DIRTY_MAX_CLIPS };
    drmModeClip clips[MAX_CLIPS];
    n = n < MAX_CLIPS ? n : MAX_CLIPS;
    for (int i = 0; i < n; i++)
        clips[i] = (drmModeClip){(uint16_t)rects[i].x1, (uint16_t)rects[i].y1,
                                 (uint16_t)rects[i].x2, (uint16_t)rects[i].y2};
    return drmModeDirtyFB(fd, fb, clips, (uint32_t)n);
}

static int kernel_gamma_reset(int fd, uint32_t crtc, int size)
{
    if (size < 2 || size > 65536)
        return 0;
    uint16_t *ramp = calloc((size_t)size, sizeof *ramp);
    if (!ramp)
        return -ENOMEM;
    for (int i = 0; i < size; i++)
        ramp[i] = (uint16_t)((int64_t)i * 65535 / (size - 1));
    int e = drmModeCrtcSetGamma(fd, crtc, (uint32_t)size, ramp, ramp, ramp);
    free(ramp);
    return e;
}

static int kernel_commit(int fd, lf_kms_commit how, const lf_kms_assignment *assignments, int n)
{
    static const uint32_t flags[] = {
        [LF_KMS_TEST] = DRM_MODE_ATOMIC_TEST_ONLY | DRM_MODE_ATOMIC_ALLOW_MODESET,
        [LF_KMS_SET] = DRM_MODE_ATOMIC_ALLOW_MODESET,
        [LF_KMS_FLIP] = DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_PAGE_FLIP_EVENT,
    };
    drmModeAtomicReq *request = drmModeAtomicAlloc();
    int e = request ? 0 : -ENOMEM;
    for (int i = 0; i < n && e >= 0; i++)
        e = drmModeAtomicAddProperty(request, assignments[i].object, assignments[i].property,
                                     assignments[i].value);
    if (e >= 0)
        e = drmModeAtomicCommit(fd, request, flags[how], NULL);
    drmModeAtomicFree(request);
    return e;
}

static int kernel_events(int fd)
{
    _Alignas(struct drm_event) char buffer[1024];
    ssize_t n = read(fd, buffer, sizeof buffer);
    if (n < 0)
        return errno == EAGAIN || errno == EINTR ? 0 : -errno;
    int flips = 0;
    for (size_t at = 0; at + sizeof(struct drm_event) <= (size_t)n;) {
        struct drm_event event;
        memcpy(&event, buffer + at, sizeof event);
        if (event.length < sizeof event)
            break;
        flips += event.type == DRM_EVENT_FLIP_COMPLETE;
        at += event.length;
    }
    return flips;
}

/* ---------------------------------------------------------------------------------- hot plug -- */

/* Events of the kernel itself: udevd is not needed, and its messages are ignored. */
static int kernel_watch(void)
{
    const struct sockaddr_nl address = {.nl_family = AF_NETLINK, .nl_groups = 1};
    int fd = socket(AF_NETLINK, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_KOBJECT_UEVENT);
    if (fd < 0)
        return -errno;
    if (bind(fd, (const struct sockaddr *)(const void *)&address, sizeof address) == 0)
        return fd;
    int e = errno;
    close(fd);
    return -e;
}

/* True if a message, a list of terminated strings, contains this line. */
static bool has_line(const char *message, size_t n, const char *line)
{
    for (size_t at = 0; at < n; at += strlen(message + at) + 1)
        if (strcmp(message + at, line) == 0)
            return true;
    return false;
}

static bool kernel_watch_read(int watch_fd)
{
    enum { MOST = 256 };
    bool displays = false;
    for (int i = 0; i < MOST; i++) {
        char message[8192];
        struct sockaddr_nl from = {0};
        socklen_t from_size = sizeof from;
        ssize_t n = recvfrom(watch_fd, message, sizeof message - 1, 0,
                             (struct sockaddr *)(void *)&from, &from_size);
        if (n < 0)
            /* some events were lost, possibly about displays */
            return displays || errno == ENOBUFS;
        message[n] = 0;
        displays = displays || (from.nl_pid == 0 && has_line(message, (size_t)n, "SUBSYSTEM=drm"));
    }
    return displays;
}

const lf_kms_calls lf_kms_kernel = {
    .cards = kernel_cards,
    .open = kernel_open,
    .close = kernel_close,
    .master_set = kernel_master_set,
    .master_drop = kernel_master_drop,
    .master_is = kernel_master_is,
    .master_name = kernel_master_name,
    .usable = kernel_usable,
    .atomic = kernel_atomic,
    .resources = kernel_resources,
    .connector = kernel_connector,
    .edid = kernel_edid,
    .crtc = kernel_crtc,
    .planes = kernel_planes,
    .properties = kernel_properties,
    .property_set = kernel_property_set,
    .buffer_create = kernel_buffer_create,
    .buffer_destroy = kernel_buffer_destroy,
    .buffer_map = kernel_buffer_map,
    .buffer_unmap = kernel_buffer_unmap,
    .fb_add = kernel_fb_add,
    .fb_remove = kernel_fb_remove,
    .blob_create = kernel_blob_create,
    .blob_destroy = kernel_blob_destroy,
    .legacy.crtc_set = kernel_crtc_set,
    .legacy.page_flip = kernel_page_flip,
    .legacy.dirty = kernel_dirty,
    .legacy.gamma_reset = kernel_gamma_reset,
    .commit = kernel_commit,
    .events = kernel_events,
    .watch = kernel_watch,
    .watch_read = kernel_watch_read,
};
