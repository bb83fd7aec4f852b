#include "tests/device/fake_kms.h"

#include "tests/testing.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/eventfd.h>

enum {
    MAX_BUFFERS = 8,
    CONNECTOR = 50, /* and up */
    PRIMARY = 60,
    CURSOR = 61,
};
/* The hundreds of a property's number tell whose it is. */
enum { PLANE_BASE = 100, CURSOR_BASE = 200, CRTC_BASE = 300, CONNECTOR_BASE = 400 };

typedef struct fake_buffer {
    bool live, framed;
    uint8_t *memory;
    /* the copy of a driver that uploads buffers, and only what it is told */
    uint8_t uploaded[FAKE_HEIGHT][FAKE_WIDTH][4];
} fake_buffer;

lf_fake_kms lf_fake;

/* What no test looks at but through functions. */
static struct inside {
    fake_buffer buffers[MAX_BUFFERS];
    uint8_t clips[64 * sizeof(struct drm_mode_rect)];
    size_t n_clips;
    /* of a driver that copies to the display only what it is told */
    uint8_t glass[FAKE_HEIGHT][FAKE_WIDTH][4];
    int shows, fds, blobs, watch_fd;
    bool flip_pending;
} inside;

static bool fails(int *out)
{
    lf_fake.calls++;
    *out = -lf_fake.fail_with;
    return lf_fake.calls == lf_fake.fail_call;
}

#define MAY_FAIL                                                                                   \
    do {                                                                                           \
        int error_;                                                                                \
        if (fails(&error_))                                                                        \
            return error_;                                                                         \
    } while (0)

static int fake_cards(int out[LF_KMS_CARDS])
{
    for (int i = 0; i < lf_fake.n_cards; i++)
        out[i] = i;
    return lf_fake.n_cards;
}

static int fake_open(int card)
{
    (void)card;
    MAY_FAIL;
    if (lf_fake.open_error != 0)
        return -lf_fake.open_error;
    inside.fds++;
    return eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
}

static void fake_close(int fd)
{
    inside.fds--;
    close(fd);
}

static int fake_master_set(int fd)
{
    (void)fd;
    MAY_FAIL;
    return lf_fake.taken ? -EBUSY : 0;
}

static void fake_master_drop(int fd)
{
    (void)fd;
    lf_fake.dropped++;
}

static bool fake_master_is(int fd)
{
    (void)fd;
    return !lf_fake.taken;
}

static bool fake_master_name(int card, char *out, size_t size)
{
    (void)card;
    snprintf(out, size, "Xorg (process 12)");
    return true;
}

static bool fake_usable(int fd)
{
    (void)fd;
    return true;
}

static bool fake_atomic(int fd)
{
    (void)fd;
    return lf_fake.atomic;
}

static int fake_resources(int fd, lf_kms_resources *out)
{
    (void)fd;
    MAY_FAIL;
    *out = (lf_kms_resources){
        .n_crtcs = 1, .crtcs = {FAKE_CRTC}, .n_connectors = lf_fake.n_connectors};
    for (int i = 0; i < lf_fake.n_connectors; i++)
        out->connectors[i] = CONNECTOR + (uint32_t)i;
    return 0;
}

static int fake_connector(int fd, uint32_t id, bool look, lf_kms_connector *out)
{
    (void)fd;
    pthread_mutex_lock(&lf_fake.lock);
    lf_fake.looks += look;
    *out = lf_fake.connectors[(id - CONNECTOR) % 4];
    out->id = id;
    pthread_mutex_unlock(&lf_fake.lock);
    return out->n_modes < 0 ? -ENODEV : 0;
}

static int fake_edid(int fd, uint32_t connector, uint8_t out[LF_KMS_EDID])
{
    (void)fd;
    unsigned i = (connector - CONNECTOR) % 4;
    pthread_mutex_lock(&lf_fake.lock);
    memcpy(out, lf_fake.edid[i], sizeof lf_fake.edid[i]);
    int n = lf_fake.n_edid[i];
    pthread_mutex_unlock(&lf_fake.lock);
    return n;
}

static int fake_crtc(int fd, uint32_t id, lf_kms_crtc *out)
{
    (void)fd;
    MAY_FAIL;
    *out = lf_fake.shown;
    return id == FAKE_CRTC ? 0 : -ENOENT;
}

static int fake_planes(int fd, lf_kms_plane out[LF_KMS_PLANES])
{
    (void)fd;
    MAY_FAIL;
    out[0] = (lf_kms_plane){.id = CURSOR, .crtc = FAKE_CRTC, .crtcs = 1, .xrgb8888 = true};
    out[1] = (lf_kms_plane){.id = PRIMARY, .crtc = FAKE_CRTC, .crtcs = 1, .xrgb8888 = true};
    return 2;
}

static const char *const plane_names[] = {"FB_ID", "CRTC_ID",  "SRC_X",          "SRC_Y",  "SRC_W",
                                          "SRC_H", "CRTC_X",   "CRTC_Y",         "CRTC_W", "CRTC_H",
                                          "type",  "rotation", "FB_DAMAGE_CLIPS"};
static const char *const crtc_names[] = {"MODE_ID", "ACTIVE", "GAMMA_LUT"};
static const char *const connector_names[] = {"CRTC_ID", "Broadcast RGB", "max bpc", "link-status",
                                              "panel orientation"};

static int list(lf_kms_property *out, uint32_t base, const char *const names[],
                const uint64_t *values, int n)
{
    for (int i = 0; i < n; i++) {
        out[i] = (lf_kms_property){.id = base + (uint32_t)i, .value = values[i]};
        snprintf(out[i].name, sizeof out[i].name, "%s", names[i]);
    }
    return n;
}

static int fake_properties(int fd, uint32_t object, uint32_t type,
                           lf_kms_property out[LF_KMS_PROPERTIES])
{
    (void)fd;
    pthread_mutex_lock(&lf_fake.lock);
    int n = 0;
    if (type == DRM_MODE_OBJECT_PLANE && object == PRIMARY)
        n = list(out, PLANE_BASE, plane_names, lf_fake.plane, FAKE_PLANE_PROPERTIES);
    else if (type == DRM_MODE_OBJECT_PLANE)
        n = list(out, CURSOR_BASE, plane_names, lf_fake.cursor, FAKE_PLANE_PROPERTIES);
    else if (type == DRM_MODE_OBJECT_CRTC)
        n = list(out, CRTC_BASE, crtc_names, lf_fake.crtc, FAKE_CRTC_PROPERTIES);
    else
        n = list(out, CONNECTOR_BASE, connector_names, lf_fake.connector,
                 FAKE_CONNECTOR_PROPERTIES);
    if (type == DRM_MODE_OBJECT_CONNECTOR) {
        out[FAKE_CONNECTOR_RANGE].n_enums = 2;
        strcpy(out[FAKE_CONNECTOR_RANGE].enums[0].name, "Automatic");
        strcpy(out[FAKE_CONNECTOR_RANGE].enums[1].name, "Full");
        out[FAKE_CONNECTOR_RANGE].enums[1].value = 1;
        out[FAKE_CONNECTOR_ORIENTATION].n_enums = 2;
        strcpy(out[FAKE_CONNECTOR_ORIENTATION].enums[0].name, "Normal");
        strcpy(out[FAKE_CONNECTOR_ORIENTATION].enums[1].name, "Left Side Up");
        out[FAKE_CONNECTOR_ORIENTATION].enums[1].value = 2;
        out[FAKE_CONNECTOR_DEPTH].low = 8;
        out[FAKE_CONNECTOR_DEPTH].high = 16;
    }
    pthread_mutex_unlock(&lf_fake.lock);
    return n;
}

static uint64_t *value_of(uint32_t property)
{
    uint64_t *const tables[] = {NULL, lf_fake.plane, lf_fake.cursor, lf_fake.crtc,
                                lf_fake.connector};
    return tables[property / 100] + property % 100;
}

static int fake_property_set(int fd, uint32_t object, uint32_t type, uint32_t property,
                             uint64_t value)
{
    (void)fd;
    (void)object;
    (void)type;
    if (lf_fake.wishes_refused)
        return -EINVAL;
    *value_of(property) = value;
    return 0;
}

static int fake_buffer_create(int fd, uint32_t width, uint32_t height, uint32_t *out_handle,
                              uint32_t *out_pitch, uint64_t *out_size)
{
    (void)fd;
    MAY_FAIL;
    assert_int_equal(width, FAKE_WIDTH);
    assert_int_equal(height, FAKE_HEIGHT);
    for (uint32_t i = 1; i < MAX_BUFFERS; i++) {
        if (inside.buffers[i].live)
            continue;
        inside.buffers[i].live = true;
        inside.buffers[i].memory = calloc(FAKE_HEIGHT, FAKE_PITCH);
        *out_handle = i;
        *out_pitch = lf_fake.pitch;
        *out_size = lf_fake.size;
        return 0;
    }
    return -ENOSPC;
}

static void fake_buffer_destroy(int fd, uint32_t handle)
{
    (void)fd;
    assert_true(inside.buffers[handle].live && !inside.buffers[handle].framed);
    free(inside.buffers[handle].memory);
    inside.buffers[handle] = (fake_buffer){0};
}

static void *fake_buffer_map(int fd, uint32_t handle, size_t size)
{
    (void)fd;
    int e;
    if (fails(&e) || size != FAKE_PITCH * FAKE_HEIGHT) {
        errno = -e;
        return NULL;
    }
    return inside.buffers[handle].memory;
}

static void fake_buffer_unmap(void *map, size_t size)
{
    assert_non_null(map);
    assert_int_equal(size, FAKE_PITCH * FAKE_HEIGHT);
}

static int fake_fb_add(int fd, uint32_t width, uint32_t height, uint32_t pitch, uint32_t handle,
                       uint32_t *out_fb)
{
    (void)fd;
    (void)width;
    (void)height;
    (void)pitch;
    MAY_FAIL;
    inside.buffers[handle].framed = true;
    *out_fb = 1000 + handle;
    return 0;
}

static void fake_fb_remove(int fd, uint32_t fb)
{
    (void)fd;
    inside.buffers[fb - 1000].framed = false;
}

static int fake_blob_create(int fd, const void *data, size_t size, uint32_t *out_blob)
{
    (void)fd;
    MAY_FAIL;
    inside.blobs++;
    *out_blob = size == sizeof(struct drm_mode_modeinfo) ? 1 : 2;
    if (*out_blob == 2) {
        assert_true(size <= sizeof inside.clips);
        memcpy(inside.clips, data, size);
        inside.n_clips = size / sizeof(struct drm_mode_rect);
    }
    return 0;
}

static void fake_blob_destroy(int fd, uint32_t blob)
{
    (void)fd;
    assert_int_not_equal(blob, 0);
    inside.blobs--;
}

/* What both kinds of drivers do with a picture of which these parts have changed. */
static void upload(uint32_t fb, const struct drm_mode_rect *rects, size_t n)
{
    fake_buffer *buffer = &inside.buffers[fb - 1000];
    const struct drm_mode_rect drm_whole = {0, 0, FAKE_WIDTH, FAKE_HEIGHT};
    for (size_t i = 0; i < (n > 0 ? n : 1); i++) {
        const struct drm_mode_rect *r = n > 0 ? &rects[i] : &drm_whole;
        for (int y = r->y1; y < r->y2; y++) {
            const uint8_t *from = buffer->memory + (size_t)y * FAKE_PITCH + (size_t)r->x1 * 4;
            memcpy(buffer->uploaded[y][r->x1], from, (size_t)(r->x2 - r->x1) * 4);
            memcpy(inside.glass[y][r->x1], from, (size_t)(r->x2 - r->x1) * 4);
        }
    }
    lf_fake.shown.fb = fb;
}

static int show_error(void)
{
    inside.shows++;
    return inside.shows == lf_fake.fail_show ? -lf_fake.fail_with : 0;
}

static int fake_crtc_set(int fd, const lf_kms_crtc *crtc, uint32_t connector)
{
    (void)fd;
    (void)connector;
    pthread_mutex_lock(&lf_fake.lock);
    int e = show_error();
    if (e == 0) {
        lf_fake.modes++;
        lf_fake.shown = *crtc;
        if (crtc->fb >= 1000 && !lf_fake.no_page_flip)
            upload(crtc->fb, NULL, 0);
    }
    pthread_mutex_unlock(&lf_fake.lock);
    return e;
}

static void flip(int fd, uint32_t fb)
{
    assert_false(inside.flip_pending);
    lf_fake.shown.fb = fb;
    lf_fake.flips++;
    inside.flip_pending = !lf_fake.silent;
    if (!lf_fake.silent)
        assert_int_equal(write(fd, &(uint64_t){1}, 8), 8);
}

static int fake_page_flip(int fd, uint32_t crtc, uint32_t fb)
{
    assert_int_equal(crtc, FAKE_CRTC);
    if (lf_fake.no_page_flip)
        return -EINVAL;
    pthread_mutex_lock(&lf_fake.lock);
    int e = show_error();
    if (e == 0) {
        upload(fb, NULL, 0);
        flip(fd, fb);
    }
    pthread_mutex_unlock(&lf_fake.lock);
    return e;
}

static int fake_dirty(int fd, uint32_t fb, const struct drm_mode_rect *rects, int n)
{
    (void)fd;
    pthread_mutex_lock(&lf_fake.lock);
    lf_fake.dirts++;
    upload(fb, rects, (size_t)n);
    pthread_mutex_unlock(&lf_fake.lock);
    return 0;
}

static int fake_gamma_reset(int fd, uint32_t crtc, int size)
{
    (void)fd;
    (void)crtc;
    (void)size;
    return -ENOSYS;
}

static void apply(int fd, lf_kms_commit how, const lf_kms_assignment *a, int n)
{
    bool clipped = false;
    for (int i = 0; i < n; i++) {
        *value_of(a[i].property) = a[i].value;
        clipped = clipped || a[i].property == PLANE_BASE + FAKE_PLANE_CLIPS;
    }
    uint32_t fb = (uint32_t)lf_fake.plane[FAKE_PLANE_FB];
    upload(fb, (const struct drm_mode_rect *)(const void *)inside.clips,
           clipped ? inside.n_clips : 0);
    if (how == LF_KMS_FLIP)
        flip(fd, fb);
    else
        lf_fake.modes++;
}

static int fake_commit(int fd, lf_kms_commit how, const lf_kms_assignment *assignments, int n)
{
    pthread_mutex_lock(&lf_fake.lock);
    int e = 0;
    if (how == LF_KMS_TEST)
        e = fails(&e) ? e : 0;
    else
        e = show_error();
    for (int i = 0; i < n && lf_fake.wishes_refused; i++)
        if (assignments[i].property == CONNECTOR_BASE + FAKE_CONNECTOR_RANGE)
            e = -EINVAL;
    if (e == 0 && how != LF_KMS_TEST)
        apply(fd, how, assignments, n);
    pthread_mutex_unlock(&lf_fake.lock);
    return e;
}

static int fake_events(int fd)
{
    uint64_t n = 0;
    pthread_mutex_lock(&lf_fake.lock);
    if (read(fd, &n, sizeof n) == sizeof n)
        inside.flip_pending = false;
    pthread_mutex_unlock(&lf_fake.lock);
    return (int)n;
}

static int fake_watch(void)
{
    if (lf_fake.no_watch)
        return -EPERM;
    inside.fds++;
    return inside.watch_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
}

static bool fake_watch_read(int watch_fd)
{
    uint64_t n;
    return read(watch_fd, &n, sizeof n) == sizeof n;
}

const lf_kms_calls lf_fake_calls = {
    .cards = fake_cards,
    .open = fake_open,
    .close = fake_close,
    .master_set = fake_master_set,
    .master_drop = fake_master_drop,
    .master_is = fake_master_is,
    .master_name = fake_master_name,
    .usable = fake_usable,
    .atomic = fake_atomic,
    .resources = fake_resources,
    .connector = fake_connector,
    .edid = fake_edid,
    .crtc = fake_crtc,
    .planes = fake_planes,
    .properties = fake_properties,
    .property_set = fake_property_set,
    .buffer_create = fake_buffer_create,
    .buffer_destroy = fake_buffer_destroy,
    .buffer_map = fake_buffer_map,
    .buffer_unmap = fake_buffer_unmap,
    .fb_add = fake_fb_add,
    .fb_remove = fake_fb_remove,
    .blob_create = fake_blob_create,
    .blob_destroy = fake_blob_destroy,
    .legacy.crtc_set = fake_crtc_set,
    .legacy.page_flip = fake_page_flip,
    .legacy.dirty = fake_dirty,
    .legacy.gamma_reset = fake_gamma_reset,
    .commit = fake_commit,
    .events = fake_events,
    .watch = fake_watch,
    .watch_read = fake_watch_read,
};

/* ------------------------------------------------------------------------------ its monitors -- */

void lf_fake_set_edid(int i, const char *name)
{
    static const uint8_t header[8] = {0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0};
    uint8_t *e = lf_fake.edid[i], sum = 0;
    memset(e, 0, 128);
    memcpy(e, header, sizeof header);
    e[75] = 0xfc;
    memset(e + 77, ' ', 13);
    memcpy(e + 77, name, strlen(name));
    for (int k = 0; k < 127; k++)
        sum = (uint8_t)(sum + e[k]);
    e[127] = (uint8_t)-sum;
    lf_fake.n_edid[i] = 128;
}

struct drm_mode_modeinfo lf_fake_mode(int width, int height, uint32_t type, uint32_t flags)
{
    return (struct drm_mode_modeinfo){.hdisplay = (uint16_t)width,
                                      .vdisplay = (uint16_t)height,
                                      .vrefresh = 60,
                                      .type = type,
                                      .flags = flags};
}

static void set_connector(int i, const char *name, bool connected, int width, int height)
{
    lf_kms_connector *c = &lf_fake.connectors[i];
    *c = (lf_kms_connector){.id = CONNECTOR + (uint32_t)i,
                            .connected = connected,
                            .known = true,
                            .crtcs = 1,
                            .n_modes = connected};
    snprintf(c->name, sizeof c->name, "%s", name);
    c->modes[0] = lf_fake_mode(width, height, DRM_MODE_TYPE_PREFERRED, 0);
}

void lf_fake_plug_in(bool atomic)
{
    inside = (struct inside){0};
    lf_fake = (lf_fake_kms){.lock = PTHREAD_MUTEX_INITIALIZER,
                            .n_cards = 1,
                            .atomic = atomic,
                            .n_connectors = 3,
                            .pitch = FAKE_PITCH};
    lf_fake.size = FAKE_PITCH * FAKE_HEIGHT;
    lf_fake.fail_with = EIO;
    set_connector(0, "HDMI-A-1", true, 1920, 1080);
    lf_fake_set_edid(0, "DELL U2720Q");
    set_connector(1, "DP-1", true, FAKE_WIDTH, FAKE_HEIGHT);
    lf_fake_set_edid(1, "LKG-TEST");
    set_connector(2, "DP-2", false, 0, 0);
    lf_fake.shown = (lf_kms_crtc){
        .id = FAKE_CRTC, .fb = FAKE_OLD_FB, .lit = true, .mode = lf_fake_mode(1024, 768, 0, 0)};
    lf_fake.plane[FAKE_PLANE_TYPE] = 1;
    lf_fake.plane[FAKE_PLANE_ROTATION] = DRM_MODE_ROTATE_180;
    lf_fake.cursor[FAKE_PLANE_TYPE] = 2;
    lf_fake.cursor[FAKE_PLANE_FB] = 9;
    lf_fake.crtc[FAKE_CRTC_GAMMA] = 5;
    lf_fake.connector[FAKE_CONNECTOR_DEPTH] = 12;
}

void lf_fake_nothing_is_left(void)
{
    assert_int_equal(inside.fds, 0);
    assert_int_equal(inside.blobs, 0);
    for (int i = 0; i < MAX_BUFFERS; i++)
        assert_false(inside.buffers[i].live);
}

void lf_fake_announce(void)
{
    assert_int_equal(write(inside.watch_fd, &(uint64_t){1}, 8), 8);
}

static bool is_picture(uint8_t picture[FAKE_HEIGHT][FAKE_WIDTH][4], const lf_image8 *frame)
{
    for (int y = 0; y < FAKE_HEIGHT; y++)
        for (int x = 0; x < FAKE_WIDTH; x++) {
            const uint8_t *rgb = frame->data + (size_t)y * frame->stride + (size_t)x * 3,
                          *got = picture[y][x];
            if (got[0] != rgb[2] || got[1] != rgb[1] || got[2] != rgb[0] || got[3] != 0)
                return false;
        }
    return true;
}

bool lf_fake_shows(const lf_image8 *frame)
{
    pthread_mutex_lock(&lf_fake.lock);
    bool good = lf_fake.shown.fb >= 1000 && is_picture(inside.glass, frame) &&
                is_picture(inside.buffers[lf_fake.shown.fb - 1000].uploaded, frame);
    pthread_mutex_unlock(&lf_fake.lock);
    return good;
}
