/* The drm device over a kernel of the test's own: finding, taking over, showing by three kinds of drivers, and every step failing. */
#include "tests/device/device_testing.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/eventfd.h>

#include "device/device_table.h"
#include "device/drm.h"
#include "device/find.h"

enum {
    WIDTH = 64,
    HEIGHT = 48,
    MAX_BUFFERS = 8,
    PITCH = WIDTH * 4 + 64,
    CRTC = 40,
    CONNECTOR = 50, /* and up */
    PRIMARY = 60,
    CURSOR = 61,
    OLD_FB = 77,
};

/* ---------------------------------------------------------------------------------------------------- the kernel -- */

enum { P_FB, P_CRTC, P_SRC_X, P_SRC_Y, P_SRC_W, P_SRC_H, P_X, P_Y, P_W, P_H, P_TYPE, P_ROTATION, P_CLIPS, PLANE_PROPERTIES };
enum { C_MODE, C_ACTIVE, C_GAMMA, CRTC_PROPERTIES };
enum { N_CRTC, N_RANGE, N_DEPTH, N_LINK, N_ORIENTATION, CONNECTOR_PROPERTIES };
/* The hundreds of a property's number tell whose it is. */
enum { PLANE_BASE = 100, CURSOR_BASE = 200, CRTC_BASE = 300, CONNECTOR_BASE = 400 };

typedef struct fake_buffer {
    bool live, framed;
    uint8_t *memory;
    uint8_t uploaded[HEIGHT][WIDTH][4]; /* the copy of a driver that uploads buffers, and only what it is told */
} fake_buffer;

static struct fake {
    pthread_mutex_t lock;
    /* what there is */
    int n_cards, open_error;
    bool atomic, taken, no_page_flip, silent, wishes_refused, no_watch, other_crtc;
    int n_connectors;
    lf_kms_connector connectors[4];
    uint8_t edid[4][128];
    int n_edid[4];
    uint32_t pitch;
    uint64_t size;
    /* errors: the n-th call that can fail does so (0 = never), or the n-th picture */
    int fail_call, calls, fail_with, fail_show, shows;
    /* what happened */
    uint64_t plane[PLANE_PROPERTIES], cursor[PLANE_PROPERTIES], crtc[CRTC_PROPERTIES], connector[CONNECTOR_PROPERTIES];
    fake_buffer buffers[MAX_BUFFERS];
    uint8_t clips[64 * sizeof(struct drm_mode_rect)];
    size_t n_clips;
    uint8_t glass[HEIGHT][WIDTH][4]; /* of a driver that copies to the display only what it is told */
    lf_kms_crtc shown;
    int flips, modes, dirts, looks, fds, blobs, dropped, watch_fd;
    bool flip_pending;
} fake;

static bool fails(int *out)
{
    fake.calls++;
    *out = -fake.fail_with;
    return fake.calls == fake.fail_call;
}

#define MAY_FAIL                                                                                                                   \
    do {                                                                                                                           \
        int error_;                                                                                                                \
        if (fails(&error_))                                                                                                        \
            return error_;                                                                                                         \
    } while (0)

static int fake_cards(int out[LF_KMS_CARDS])
{
    for (int i = 0; i < fake.n_cards; i++)
        out[i] = i;
    return fake.n_cards;
}

static int fake_open(int card)
{
    (void)card;
    MAY_FAIL;
    if (fake.open_error != 0)
        return -fake.open_error;
    fake.fds++;
    return eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
}

static void fake_close(int fd)
{
    fake.fds--;
    close(fd);
}

static int fake_master_set(int fd)
{
    (void)fd;
    MAY_FAIL;
    return fake.taken ? -EBUSY : 0;
}

static void fake_master_drop(int fd)
{
    (void)fd;
    fake.dropped++;
}

static bool fake_master_is(int fd)
{
    (void)fd;
    return !fake.taken;
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
    return fake.atomic;
}

static int fake_resources(int fd, lf_kms_resources *out)
{
    (void)fd;
    MAY_FAIL;
    *out = (lf_kms_resources){.n_crtcs = 1, .crtcs = {CRTC}, .n_connectors = fake.n_connectors};
    for (int i = 0; i < fake.n_connectors; i++)
        out->connectors[i] = CONNECTOR + (uint32_t)i;
    return 0;
}

static int fake_connector(int fd, uint32_t id, bool look, lf_kms_connector *out)
{
    (void)fd;
    pthread_mutex_lock(&fake.lock);
    fake.looks += look;
    *out = fake.connectors[(id - CONNECTOR) % 4];
    out->id = id;
    pthread_mutex_unlock(&fake.lock);
    return out->n_modes < 0 ? -ENODEV : 0;
}

static int fake_edid(int fd, uint32_t connector, uint8_t out[LF_KMS_EDID])
{
    (void)fd;
    unsigned i = (connector - CONNECTOR) % 4;
    pthread_mutex_lock(&fake.lock);
    memcpy(out, fake.edid[i], sizeof fake.edid[i]);
    int n = fake.n_edid[i];
    pthread_mutex_unlock(&fake.lock);
    return n;
}

static int fake_crtc(int fd, uint32_t id, lf_kms_crtc *out)
{
    (void)fd;
    MAY_FAIL;
    *out = fake.shown;
    return id == CRTC ? 0 : -ENOENT;
}

static int fake_planes(int fd, lf_kms_plane out[LF_KMS_PLANES])
{
    (void)fd;
    MAY_FAIL;
    out[0] = (lf_kms_plane){.id = CURSOR, .crtc = CRTC, .crtcs = 1, .xrgb8888 = true};
    out[1] = (lf_kms_plane){.id = PRIMARY, .crtc = CRTC, .crtcs = 1, .xrgb8888 = true};
    return 2;
}

static const char *const plane_names[] = {"FB_ID",  "CRTC_ID", "SRC_X",  "SRC_Y", "SRC_W",    "SRC_H",          "CRTC_X",
                                          "CRTC_Y", "CRTC_W",  "CRTC_H", "type",  "rotation", "FB_DAMAGE_CLIPS"};
static const char *const crtc_names[] = {"MODE_ID", "ACTIVE", "GAMMA_LUT"};
static const char *const connector_names[] = {"CRTC_ID", "Broadcast RGB", "max bpc", "link-status", "panel orientation"};

static int list(lf_kms_property *out, uint32_t base, const char *const names[], const uint64_t *values, int n)
{
    for (int i = 0; i < n; i++) {
        out[i] = (lf_kms_property){.id = base + (uint32_t)i, .value = values[i]};
        snprintf(out[i].name, sizeof out[i].name, "%s", names[i]);
    }
    return n;
}

static int fake_properties(int fd, uint32_t object, uint32_t type, lf_kms_property out[LF_KMS_PROPERTIES])
{
    (void)fd;
    pthread_mutex_lock(&fake.lock);
    int n = 0;
    if (type == DRM_MODE_OBJECT_PLANE && object == PRIMARY)
        n = list(out, PLANE_BASE, plane_names, fake.plane, PLANE_PROPERTIES);
    else if (type == DRM_MODE_OBJECT_PLANE)
        n = list(out, CURSOR_BASE, plane_names, fake.cursor, PLANE_PROPERTIES);
    else if (type == DRM_MODE_OBJECT_CRTC)
        n = list(out, CRTC_BASE, crtc_names, fake.crtc, CRTC_PROPERTIES);
    else
        n = list(out, CONNECTOR_BASE, connector_names, fake.connector, CONNECTOR_PROPERTIES);
    if (type == DRM_MODE_OBJECT_CONNECTOR) {
        out[N_RANGE].n_enums = 2;
        strcpy(out[N_RANGE].enums[0].name, "Automatic");
        strcpy(out[N_RANGE].enums[1].name, "Full");
        out[N_RANGE].enums[1].value = 1;
        out[N_ORIENTATION].n_enums = 2;
        strcpy(out[N_ORIENTATION].enums[0].name, "Normal");
        strcpy(out[N_ORIENTATION].enums[1].name, "Left Side Up");
        out[N_ORIENTATION].enums[1].value = 2;
        out[N_DEPTH].low = 8;
        out[N_DEPTH].high = 16;
    }
    pthread_mutex_unlock(&fake.lock);
    return n;
}

static uint64_t *value_of(uint32_t property)
{
    uint64_t *const tables[] = {NULL, fake.plane, fake.cursor, fake.crtc, fake.connector};
    return tables[property / 100] + property % 100;
}

static int fake_property_set(int fd, uint32_t object, uint32_t type, uint32_t property, uint64_t value)
{
    (void)fd;
    (void)object;
    (void)type;
    if (fake.wishes_refused)
        return -EINVAL;
    *value_of(property) = value;
    return 0;
}

static int fake_buffer_create(int fd, uint32_t width, uint32_t height, uint32_t *out_handle, uint32_t *out_pitch,
                              uint64_t *out_size)
{
    (void)fd;
    MAY_FAIL;
    assert_int_equal(width, WIDTH);
    assert_int_equal(height, HEIGHT);
    for (uint32_t i = 1; i < MAX_BUFFERS; i++) {
        if (fake.buffers[i].live)
            continue;
        fake.buffers[i].live = true;
        fake.buffers[i].memory = calloc(HEIGHT, PITCH);
        *out_handle = i;
        *out_pitch = fake.pitch;
        *out_size = fake.size;
        return 0;
    }
    return -ENOSPC;
}

static void fake_buffer_destroy(int fd, uint32_t handle)
{
    (void)fd;
    assert_true(fake.buffers[handle].live && !fake.buffers[handle].framed);
    free(fake.buffers[handle].memory);
    fake.buffers[handle] = (fake_buffer){0};
}

static void *fake_buffer_map(int fd, uint32_t handle, size_t size)
{
    (void)fd;
    int e;
    if (fails(&e) || size != PITCH * HEIGHT) {
        errno = -e;
        return NULL;
    }
    return fake.buffers[handle].memory;
}

static void fake_buffer_unmap(void *map, size_t size)
{
    assert_non_null(map);
    assert_int_equal(size, PITCH * HEIGHT);
}

static int fake_fb_add(int fd, uint32_t width, uint32_t height, uint32_t pitch, uint32_t handle, uint32_t *out_fb)
{
    (void)fd;
    (void)width;
    (void)height;
    (void)pitch;
    MAY_FAIL;
    fake.buffers[handle].framed = true;
    *out_fb = 1000 + handle;
    return 0;
}

static void fake_fb_remove(int fd, uint32_t fb)
{
    (void)fd;
    fake.buffers[fb - 1000].framed = false;
}

static int fake_blob_create(int fd, const void *data, size_t size, uint32_t *out_blob)
{
    (void)fd;
    MAY_FAIL;
    fake.blobs++;
    *out_blob = size == sizeof(struct drm_mode_modeinfo) ? 1 : 2;
    if (*out_blob == 2) {
        assert_true(size <= sizeof fake.clips);
        memcpy(fake.clips, data, size);
        fake.n_clips = size / sizeof(struct drm_mode_rect);
    }
    return 0;
}

static void fake_blob_destroy(int fd, uint32_t blob)
{
    (void)fd;
    assert_int_not_equal(blob, 0);
    fake.blobs--;
}

/* What both kinds of drivers do with a picture of which these parts have changed. */
static void upload(uint32_t fb, const struct drm_mode_rect *rects, size_t n)
{
    fake_buffer *buffer = &fake.buffers[fb - 1000];
    const struct drm_mode_rect whole = {0, 0, WIDTH, HEIGHT};
    for (size_t i = 0; i < (n > 0 ? n : 1); i++) {
        const struct drm_mode_rect *r = n > 0 ? &rects[i] : &whole;
        for (int y = r->y1; y < r->y2; y++) {
            const uint8_t *from = buffer->memory + (size_t)y * PITCH + (size_t)r->x1 * 4;
            memcpy(buffer->uploaded[y][r->x1], from, (size_t)(r->x2 - r->x1) * 4);
            memcpy(fake.glass[y][r->x1], from, (size_t)(r->x2 - r->x1) * 4);
        }
    }
    fake.shown.fb = fb;
}

static int show_error(void)
{
    fake.shows++;
    return fake.shows == fake.fail_show ? -fake.fail_with : 0;
}

static int fake_crtc_set(int fd, const lf_kms_crtc *crtc, uint32_t connector)
{
    (void)fd;
    (void)connector;
    pthread_mutex_lock(&fake.lock);
    int e = show_error();
    if (e == 0) {
        fake.modes++;
        fake.shown = *crtc;
        if (crtc->fb >= 1000 && !fake.no_page_flip)
            upload(crtc->fb, NULL, 0);
    }
    pthread_mutex_unlock(&fake.lock);
    return e;
}

static void flip(int fd, uint32_t fb)
{
    assert_false(fake.flip_pending);
    fake.shown.fb = fb;
    fake.flips++;
    fake.flip_pending = !fake.silent;
    if (!fake.silent)
        assert_int_equal(write(fd, &(uint64_t){1}, 8), 8);
}

static int fake_page_flip(int fd, uint32_t crtc, uint32_t fb)
{
    assert_int_equal(crtc, CRTC);
    if (fake.no_page_flip)
        return -EINVAL;
    pthread_mutex_lock(&fake.lock);
    int e = show_error();
    if (e == 0) {
        upload(fb, NULL, 0);
        flip(fd, fb);
    }
    pthread_mutex_unlock(&fake.lock);
    return e;
}

static int fake_dirty(int fd, uint32_t fb, const struct drm_mode_rect *rects, int n)
{
    (void)fd;
    pthread_mutex_lock(&fake.lock);
    fake.dirts++;
    upload(fb, rects, (size_t)n);
    pthread_mutex_unlock(&fake.lock);
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
        clipped = clipped || a[i].property == PLANE_BASE + P_CLIPS;
    }
    uint32_t fb = (uint32_t)fake.plane[P_FB];
    upload(fb, (const struct drm_mode_rect *)(const void *)fake.clips, clipped ? fake.n_clips : 0);
    if (how == LF_KMS_FLIP)
        flip(fd, fb);
    else
        fake.modes++;
}

static int fake_commit(int fd, lf_kms_commit how, const lf_kms_assignment *assignments, int n)
{
    pthread_mutex_lock(&fake.lock);
    int e = 0;
    if (how == LF_KMS_TEST)
        e = fails(&e) ? e : 0;
    else
        e = show_error();
    for (int i = 0; i < n && fake.wishes_refused; i++)
        if (assignments[i].property == CONNECTOR_BASE + N_RANGE)
            e = -EINVAL;
    if (e == 0 && how != LF_KMS_TEST)
        apply(fd, how, assignments, n);
    pthread_mutex_unlock(&fake.lock);
    return e;
}

static int fake_events(int fd)
{
    uint64_t n = 0;
    pthread_mutex_lock(&fake.lock);
    if (read(fd, &n, sizeof n) == sizeof n)
        fake.flip_pending = false;
    pthread_mutex_unlock(&fake.lock);
    return (int)n;
}

static int fake_watch(void)
{
    if (fake.no_watch)
        return -EPERM;
    fake.fds++;
    return fake.watch_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
}

static bool fake_watch_read(int watch_fd)
{
    uint64_t n;
    return read(watch_fd, &n, sizeof n) == sizeof n;
}

static const lf_kms_calls fake_kms = {
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
    .crtc_set = fake_crtc_set,
    .page_flip = fake_page_flip,
    .dirty = fake_dirty,
    .gamma_reset = fake_gamma_reset,
    .commit = fake_commit,
    .events = fake_events,
    .watch = fake_watch,
    .watch_read = fake_watch_read,
};

/* --------------------------------------------------------------------------------------------------- its monitors -- */

static void set_edid(int i, const char *name)
{
    static const uint8_t header[8] = {0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0};
    uint8_t *e = fake.edid[i], sum = 0;
    memset(e, 0, 128);
    memcpy(e, header, sizeof header);
    e[75] = 0xfc;
    memset(e + 77, ' ', 13);
    memcpy(e + 77, name, strlen(name));
    for (int k = 0; k < 127; k++)
        sum = (uint8_t)(sum + e[k]);
    e[127] = (uint8_t)-sum;
    fake.n_edid[i] = 128;
}

static struct drm_mode_modeinfo make_mode(int width, int height, uint32_t type, uint32_t flags)
{
    return (struct drm_mode_modeinfo){
        .hdisplay = (uint16_t)width, .vdisplay = (uint16_t)height, .vrefresh = 60, .type = type, .flags = flags};
}

static void set_connector(int i, const char *name, bool connected, int width, int height)
{
    lf_kms_connector *c = &fake.connectors[i];
    *c = (lf_kms_connector){.id = CONNECTOR + (uint32_t)i, .connected = connected, .known = true, .crtcs = 1, .n_modes = connected};
    snprintf(c->name, sizeof c->name, "%s", name);
    c->modes[0] = make_mode(width, height, DRM_MODE_TYPE_PREFERRED, 0);
}

/* An ordinary monitor on HDMI-A-1 with the console, a Looking Glass on DP-1, nothing on DP-2. */
static void plug_in(bool atomic)
{
    fake = (struct fake){.lock = PTHREAD_MUTEX_INITIALIZER, .n_cards = 1, .atomic = atomic, .n_connectors = 3, .pitch = PITCH};
    fake.size = PITCH * HEIGHT;
    fake.fail_with = EIO;
    set_connector(0, "HDMI-A-1", true, 1920, 1080);
    set_edid(0, "DELL U2720Q");
    set_connector(1, "DP-1", true, WIDTH, HEIGHT);
    set_edid(1, "LKG-TEST");
    set_connector(2, "DP-2", false, 0, 0);
    fake.shown = (lf_kms_crtc){.id = CRTC, .fb = OLD_FB, .lit = true, .mode = make_mode(1024, 768, 0, 0)};
    fake.plane[P_TYPE] = 1;
    fake.plane[P_ROTATION] = DRM_MODE_ROTATE_180;
    fake.cursor[P_TYPE] = 2;
    fake.cursor[P_FB] = 9;
    fake.crtc[C_GAMMA] = 5;
    fake.connector[N_DEPTH] = 12;
}

static void nothing_is_left(void)
{
    assert_int_equal(fake.fds, 0);
    assert_int_equal(fake.blobs, 0);
    for (int i = 0; i < MAX_BUFFERS; i++)
        assert_false(fake.buffers[i].live);
}

static lf_calibration lens(int width, int height)
{
    lf_calibration c;
    lf_calibration_portrait(&c);
    c.screen_width_px = width;
    c.screen_height_px = height;
    return c;
}

static lf_status try_open(const char *argument, lf_device **out, lf_error *err)
{
    lf_calibration c = lens(WIDTH, HEIGHT);
    return lf_drm_open(&fake_kms, argument, &c, out, err);
}

static lf_device *open_drm(void)
{
    lf_device *device = NULL;
    lf_error err = {0};
    lf_assert_ok(try_open("", &device, &err), &err);
    return device;
}

static void refuses(const char *argument, lf_status expected, const char *words)
{
    lf_device *device = NULL;
    lf_error err = {0};
    lf_assert_status(try_open(argument, &device, &err), expected, &err);
    assert_null(device);
    if (strstr(err.what, words) == NULL)
        fail_msg("\"%s\" does not say \"%s\"", err.what, words);
    nothing_is_left();
}

/* ------------------------------------------------------------------------------------------------------ pictures -- */

static const lf_rect whole = {0, 0, WIDTH, HEIGHT};

static lf_image8 make_frame(void)
{
    lf_image8 frame = {0};
    lf_assert_ok(lf_image8_init(&frame, WIDTH, HEIGHT, 3), NULL);
    return frame;
}

static void scribble(lf_image8 *frame, const lf_rect *r, int seed)
{
    for (int y = r->y; y < r->y + r->height; y++)
        for (int i = r->x * 3; i < (r->x + r->width) * 3; i++)
            frame->data[(size_t)y * frame->stride + (size_t)i] = (uint8_t)(seed * 37 + y * 5 + i * 3);
}

static bool is_picture(uint8_t picture[HEIGHT][WIDTH][4], const lf_image8 *frame)
{
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const uint8_t *rgb = frame->data + (size_t)y * frame->stride + (size_t)x * 3, *got = picture[y][x];
            if (got[0] != rgb[2] || got[1] != rgb[1] || got[2] != rgb[0] || got[3] != 0)
                return false;
        }
    return true;
}

/* On both kinds of displays. */
static bool shows(const lf_image8 *frame)
{
    pthread_mutex_lock(&fake.lock);
    bool good =
        fake.shown.fb >= 1000 && is_picture(fake.glass, frame) && is_picture(fake.buffers[fake.shown.fb - 1000].uploaded, frame);
    pthread_mutex_unlock(&fake.lock);
    return good;
}

/* ------------------------------------------------------------------------------------------------------- finding -- */

static void names_of_outputs_are_understood(void **state)
{
    (void)state;
    lf_drm_name name;
    static const char *const good[] = {"DP-1", "HDMI-A-1", "Virtual-1", "eDP-1", "card0/DP-1", "card11/HDMI-A-12"};
    static const char *const bad[] = {"DP",
                                      "-1",
                                      "DP-",
                                      "DP-1x",
                                      "card0",
                                      "card0/",
                                      "card0/DP",
                                      "/dev/dri",
                                      "card/DP-1",
                                      "card999/DP-1",
                                      "card-1/DP-1",
                                      "card 1/DP-1",
                                      "D\nP-1",
                                      "card1/card2/DP-1",
                                      "1-1",
                                      "DP-12345678901",
                                      "a-very-long-name-of-a-connector-that-no-kernel-has-1"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        lf_assert_ok(lf_drm_name_parse(good[i], &name, NULL), NULL);
    assert_int_equal(name.card, 11);
    assert_string_equal(name.connector, "HDMI-A-12");
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lf_status status = lf_drm_name_parse(bad[i], &name, NULL);
        if (status != LF_E_ARG)
            fail_msg("\"%s\" is taken", bad[i]);
    }
    lf_assert_ok(lf_drm_name_parse("", &name, NULL), NULL);
    assert_int_equal(name.card, -1);
    assert_string_equal(name.connector, "");
}

static void native_mode_is_the_preferred_one_that_can_be(void **state)
{
    (void)state;
    lf_kms_connector c = {.n_modes = 0};
    assert_null(lf_drm_native_mode(&c));
    c.modes[c.n_modes++] = make_mode(0, 0, DRM_MODE_TYPE_PREFERRED, 0);
    c.modes[c.n_modes++] = make_mode(65535, 65535, DRM_MODE_TYPE_PREFERRED, 0);
    c.modes[c.n_modes++] = make_mode(16385, 1, DRM_MODE_TYPE_PREFERRED, 0);
    c.modes[c.n_modes++] = make_mode(1920, 1080, DRM_MODE_TYPE_PREFERRED, DRM_MODE_FLAG_INTERLACE);
    c.modes[c.n_modes++] = make_mode(640, 480, DRM_MODE_TYPE_PREFERRED, DRM_MODE_FLAG_DBLSCAN);
    assert_null(lf_drm_native_mode(&c));
    c.modes[c.n_modes++] = make_mode(800, 600, 0, 0);
    c.modes[c.n_modes++] = make_mode(1024, 768, 0, 0);
    c.modes[c.n_modes++] = make_mode(640, 480, 0, 0);
    assert_int_equal(lf_drm_native_mode(&c)->hdisplay, 1024);
    c.modes[c.n_modes++] = make_mode(320, 200, DRM_MODE_TYPE_PREFERRED, 0);
    c.modes[c.n_modes++] = make_mode(1600, 1200, DRM_MODE_TYPE_PREFERRED, 0);
    assert_int_equal(lf_drm_native_mode(&c)->hdisplay, 320);
    c.n_modes = INT_MAX;
    assert_int_equal(lf_drm_native_mode(&c)->hdisplay, 320);
}

static void looking_glass_is_found_by_its_edid(void **state)
{
    (void)state;
    plug_in(true);
    lf_device *device = open_drm();
    lf_device_info info = device_info_of(device);
    assert_string_equal(info.spec, "drm:card0/DP-1");
    assert_string_equal(info.model, "LKG-TEST");
    assert_string_equal(info.output, "card0/DP-1 64x48 at 60 Hz");
    assert_string_equal(info.problem, "");
    assert_int_equal(fake.modes, 0); /* opening leaves the display as it is */
    lf_device_destroy(device);
    assert_int_equal(fake.shown.fb, OLD_FB);
    nothing_is_left();
}

static void what_is_not_there_is_told_with_what_is(void **state)
{
    (void)state;
    plug_in(true);
    refuses("DP-2", LF_E_NODEV, "no monitor is on DP-2; there is: HDMI-A-1 (DELL U2720Q), DP-1 (LKG-TEST)");
    refuses("card1/DP-1", LF_E_NODEV, "DP-1");
    refuses("DP-x", LF_E_ARG, "expected drm, drm:DP-1 or drm:card1/HDMI-A-1");
    refuses("HDMI-A-1", LF_E_ARG, "its native mode is 1920x1080 pixels, the calibration (given by the caller) is for 64x48");
    fake.n_connectors = 1;
    refuses("", LF_E_NODEV, "no Looking Glass");
    fake.n_cards = 0;
    refuses("", LF_E_NODEV, "there is: nothing");
    plug_in(true);
    fake.open_error = EACCES;
    refuses("", LF_E_IO, "group video");
    plug_in(true);
    fake.taken = true;
    refuses("", LF_E_BUSY, "Xorg (process 12) shows on /dev/dri/card0; within a desktop take --device window");
    plug_in(true);
    fake.connectors[1].n_modes = 0;
    refuses("", LF_E_FORMAT, "no mode");
    plug_in(true);
    fake.connectors[0].crtc = CRTC; /* the only one there is drives the other monitor */
    refuses("", LF_E_BUSY, "no more displays");
    plug_in(true);
}

static void calibration_is_found_by_what_the_monitor_is_called(void **state)
{
    (void)state;
    char *dir = lf_test_folder();
    lf_device *device = NULL;
    lf_error err = {0};
    lf_found found = {.source = LF_SOURCE_DRIVE, .label = "LKG-TEST", .calibration = lens(WIDTH, HEIGHT)};
    setenv("CACHE_DIRECTORY", dir, 1);
    plug_in(true);
    lf_assert_status(lf_drm_open(&fake_kms, "", NULL, &device, &err), LF_E_NODEV, &err);
    nothing_is_left();
    strcpy(found.calibration.serial, "LKG-TEST");
    lf_cache_store(&found);
    lf_assert_ok(lf_drm_open(&fake_kms, "", NULL, &device, &err), &err);
    assert_int_equal(device->ops->calibration(device)->screen_width_px, WIDTH);
    assert_string_equal(device_info_of(device).serial, "LKG-TEST");
    assert_non_null(strstr(device_info_of(device).calibration_from, dir));
    lf_device_destroy(device);
    nothing_is_left();
    unsetenv("CACHE_DIRECTORY");
    lf_test_folder_remove(dir);
}

static void damaged_edids_make_no_panel(void **state)
{
    (void)state;
    static const int sizes[] = {0, 1, 100, 127, -5};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        plug_in(true);
        fake.n_edid[1] = sizes[i];
        refuses("", LF_E_NODEV, "no Looking Glass");
    }
    plug_in(true);
    fake.edid[1][127] ^= 1;
    refuses("", LF_E_NODEV, "DP-1");
    lf_device *device = NULL; /* named, it is shown on */
    lf_assert_ok(try_open("DP-1", &device, NULL), NULL);
    lf_device_destroy(device);
    plug_in(true);
    fake.n_connectors = LF_KMS_CONNECTORS;
    fake.connectors[1].connected = false;
    refuses("", LF_E_NODEV, "no Looking Glass");
}

static void impossible_memory_is_refused(void **state)
{
    (void)state;
    static const struct {
        uint32_t pitch;
        uint64_t size;
    } bad[] = {{WIDTH * 4 - 4, PITCH * HEIGHT},
               {0, PITCH * HEIGHT},
               {UINT32_MAX, UINT64_MAX},
               {PITCH + 1, PITCH * HEIGHT * 2},
               {PITCH, PITCH * HEIGHT - 1},
               {PITCH, UINT64_MAX - 64},
               {PITCH, 0}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        plug_in(true);
        fake.pitch = bad[i].pitch;
        fake.size = bad[i].size;
        refuses("", LF_E_FORMAT, "which cannot be");
    }
}

static void every_step_of_opening_may_fail(void **state)
{
    (void)state;
    for (int legacy = 0; legacy < 2; legacy++) {
        int n = 1;
        for (;; n++) {
            plug_in(legacy == 0);
            fake.fail_call = n;
            lf_device *device = NULL;
            lf_error err = {0};
            lf_status status = try_open("", &device, &err);
            if (status == LF_OK) {
                lf_device_destroy(device);
            } else {
                assert_null(device);
                assert_true(err.what[0] != 0);
            }
            nothing_is_left();
            if (fake.calls < n)
                break;
        }
        assert_in_range(n, 10, 40);
    }
}

/* ------------------------------------------------------------------------------------------------------- showing -- */

static void rectangles_make_the_frame(bool atomic, bool no_page_flip)
{
    plug_in(atomic);
    fake.no_page_flip = no_page_flip;
    lf_device *device = open_drm();
    lf_image8 frame = make_frame();
    scribble(&frame, &whole, 1);
    assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
    uint64_t pushes = 1, rects_pushed = 1;
    for (int i = 2; i < 200; i++) {
        lf_rect rects[80];
        int n = i % 50 == 0 ? 80 : i % 5; /* none at all, and more than a driver is told one by one */
        for (int k = 0; k < n; k++) {
            rects[k] = (lf_rect){(i * 7 + k * 3) % WIDTH, (i * 5 + k * 11) % HEIGHT, 0, 0};
            rects[k].width = 1 + (i + k) % (WIDTH - rects[k].x);
            rects[k].height = 1 + (i * 3 + k) % (HEIGHT - rects[k].y);
            scribble(&frame, &rects[k], i);
        }
        assert_int_equal(device_push(device, &frame, rects, n), LF_DEVICE_READY);
        assert_true(shows(&frame));
        pushes += n > 0;
        rects_pushed += (uint64_t)n;
    }
    frame.data[0] ^= 1;
    assert_false(shows(&frame));
    assert_int_equal(device_counters_of(device).updates, rects_pushed);
    assert_int_equal(device_counters_of(device).errors, 0);
    assert_int_equal(fake.modes, no_page_flip ? pushes : 1);
    assert_int_equal(fake.flips, no_page_flip ? 0 : pushes - 1);
    lf_image8_finish(&frame);
    lf_device_destroy(device);
    assert_int_equal(fake.shown.fb, OLD_FB);
    assert_int_equal(fake.shown.mode.hdisplay, 1024);
    nothing_is_left();
}

static void rectangles_make_the_frame_on_atomic_drivers(void **state)
{
    (void)state;
    rectangles_make_the_frame(true, false);
}

static void rectangles_make_the_frame_on_legacy_drivers(void **state)
{
    (void)state;
    rectangles_make_the_frame(false, false);
}

static void rectangles_make_the_frame_without_page_flips(void **state)
{
    (void)state;
    rectangles_make_the_frame(false, true);
    assert_true(fake.dirts > 100);
}

static void pixels_are_shown_unchanged_and_the_rest_is_put_back(void **state)
{
    (void)state;
    for (int legacy = 0; legacy < 2; legacy++) {
        plug_in(legacy == 0);
        lf_device *device = open_drm();
        lf_image8 frame = make_frame();
        assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
        assert_int_equal(fake.connector[N_RANGE], 1);
        assert_int_equal(fake.connector[N_DEPTH], 8);
        if (legacy == 0) {
            assert_int_equal(fake.plane[P_ROTATION], DRM_MODE_ROTATE_0);
            assert_int_equal(fake.plane[P_SRC_W], WIDTH << 16);
            assert_int_equal(fake.crtc[C_GAMMA], 0);
            assert_int_equal(fake.crtc[C_ACTIVE], 1);
            assert_int_equal(fake.cursor[P_FB], 0);
        }
        assert_string_equal(device_info_of(device).problem, "");
        lf_image8_finish(&frame);
        lf_device_destroy(device);
        assert_int_equal(fake.connector[N_RANGE], 0);
        assert_int_equal(fake.connector[N_DEPTH], 12);
        assert_int_equal(fake.shown.fb, OLD_FB);
        nothing_is_left();
    }
}

static void refused_wishes_are_told_and_the_rest_is_shown(void **state)
{
    (void)state;
    for (int legacy = 0; legacy < 2; legacy++) {
        plug_in(legacy == 0);
        fake.wishes_refused = true;
        lf_device *device = open_drm();
        lf_image8 frame = make_frame();
        assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
        assert_true(shows(&frame));
        assert_non_null(strstr(device_info_of(device).problem, "full colour range"));
        assert_int_equal(fake.connector[N_RANGE], 0);
        if (legacy == 0) { /* which refuses that one alone */
            assert_int_equal(fake.connector[N_DEPTH], 8);
            assert_int_equal(fake.plane[P_ROTATION], DRM_MODE_ROTATE_0);
            assert_int_equal(fake.crtc[C_GAMMA], 0);
        }
        lf_image8_finish(&frame);
        lf_device_destroy(device);
        nothing_is_left();
    }
}

static void pushes_of_the_wrong_shape_are_refused(void **state)
{
    (void)state;
    plug_in(true);
    lf_device *device = open_drm();
    lf_image8 frame = make_frame(), small = {0};
    lf_assert_ok(lf_image8_init(&small, WIDTH - 1, HEIGHT, 3), NULL);
    const lf_rect bad[] = {{-1, 0, 2, 2},     {0, 0, 0, 2},       {WIDTH - 1, 0, 2, 1},
                           {0, HEIGHT, 1, 1}, {INT_MAX, 0, 1, 1}, {1, 1, INT_MAX, 1}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        lf_assert_status(device->ops->push(device, &frame, &bad[i], 1, 1), LF_E_ARG, NULL);
    lf_assert_status(device->ops->push(device, &small, &whole, 1, 1), LF_E_ARG, NULL);
    lf_assert_status(device->ops->push(device, NULL, &whole, 1, 1), LF_E_ARG, NULL);
    lf_assert_status(device->ops->push(device, &frame, &whole, -1, 1), LF_E_ARG, NULL);
    lf_assert_status(device->ops->push(device, &frame, &whole, LF_DEVICE_MAX_RECTS + 1, 1), LF_E_ARG, NULL);
    assert_int_equal(device->ops->dispatch(device), LF_DEVICE_READY);
    lf_assert_ok(device->ops->push(device, &frame, &whole, 1, 1), NULL);
    assert_int_equal(device_outcome(device), LF_DEVICE_READY);
    lf_image8_finish(&frame);
    lf_image8_finish(&small);
    lf_device_destroy(device);
}

/* -------------------------------------------------------------------------------------------------------- faults -- */

static void failed_picture_is_told_once_and_the_next_sets_the_mode(void **state)
{
    (void)state;
    for (int at = 1; at < 4; at++) {
        plug_in(true);
        fake.fail_show = at;
        fake.fail_with = EACCES;
        lf_device *device = open_drm();
        lf_image8 frame = make_frame();
        for (int i = 1; i < at; i++)
            assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
        assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_RETRY);
        assert_int_equal(device->ops->dispatch(device), LF_DEVICE_READY);
        assert_non_null(strstr(device_info_of(device).problem, "DP-1 does not take pictures: Permission denied"));
        int modes = fake.modes;
        scribble(&frame, &whole, 9);
        assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
        assert_int_equal(fake.modes, modes + 1);
        assert_true(shows(&frame));
        assert_string_equal(device_info_of(device).problem, "");
        assert_int_equal(device_counters_of(device).errors, 1);
        lf_image8_finish(&frame);
        lf_device_destroy(device);
        nothing_is_left();
    }
}

static void flip_without_an_end_is_given_up(void **state)
{
    (void)state;
    plug_in(true);
    lf_device *device = open_drm();
    lf_image8 frame = make_frame();
    assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
    fake.silent = true;
    lf_assert_ok(device->ops->push(device, &frame, &whole, 1, 2), NULL);
    lf_assert_status(device->ops->push(device, &frame, &whole, 1, 3), LF_E_STATE, NULL);
    lf_assert_status(device->ops->flush(device, 10), LF_E_TIMEOUT, NULL);
    assert_int_equal(device_outcome(device), LF_DEVICE_RETRY);
    pthread_mutex_lock(&fake.lock);
    fake.silent = false;
    pthread_mutex_unlock(&fake.lock);
    assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
    assert_int_equal(fake.modes, 2);
    lf_assert_ok(device->ops->push(device, &frame, &whole, 1, 5), NULL);
    lf_device_destroy(device); /* in the middle of a push */
    lf_image8_finish(&frame);
    assert_int_equal(fake.shown.fb, OLD_FB);
    nothing_is_left();
}

static void stays_gone(lf_device *device, const lf_image8 *frame)
{
    assert_int_equal(device_outcome(device), LF_DEVICE_GONE);
    assert_int_equal(device->ops->dispatch(device), LF_DEVICE_GONE);
    lf_assert_status(device->ops->push(device, frame, &whole, 1, 9), LF_E_NODEV, NULL);
    lf_assert_status(device->ops->flush(device, 10), LF_E_NODEV, NULL);
    lf_device_destroy(device);
    nothing_is_left();
}

static void set_connected(bool connected)
{
    pthread_mutex_lock(&fake.lock);
    fake.connectors[1].connected = connected;
    pthread_mutex_unlock(&fake.lock);
}

static void announce(void)
{
    assert_int_equal(write(fake.watch_fd, &(uint64_t){1}, 8), 8);
}

static void unplugged_monitor_is_told(void **state)
{
    (void)state;
    lf_image8 frame = make_frame();
    plug_in(true);
    lf_device *device = open_drm();
    assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
    announce(); /* of another display */
    assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
    set_connected(false);
    announce();
    stays_gone(device, &frame);
    refuses("", LF_E_NODEV, "no Looking Glass");
    plug_in(true);
    fake.no_watch = true; /* nothing is announced: asked for now and then */
    device = open_drm();
    set_connected(false);
    stays_gone(device, &frame);
    lf_image8_finish(&frame);
}

static void unplugged_card_is_told(void **state)
{
    (void)state;
    lf_image8 frame = make_frame();
    plug_in(false);
    fake.fail_show = 2;
    fake.fail_with = ENODEV;
    lf_device *device = open_drm();
    assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
    lf_assert_ok(device->ops->push(device, &frame, &whole, 1, 2), NULL);
    stays_gone(device, &frame);
    plug_in(true);
    device = open_drm();
    pthread_mutex_lock(&fake.lock);
    fake.connectors[1].n_modes = -1;
    pthread_mutex_unlock(&fake.lock);
    announce();
    stays_gone(device, &frame);
    lf_image8_finish(&frame);
}

/* Another monitor, or one that does not say what it is (NULL). */
static void swap_monitor(const char *name)
{
    pthread_mutex_lock(&fake.lock);
    fake.n_edid[1] = 0;
    if (name != NULL)
        set_edid(1, name);
    pthread_mutex_unlock(&fake.lock);
}

static void swapped_monitor_is_told(void **state)
{
    (void)state;
    lf_image8 frame = make_frame();
    plug_in(true);
    lf_device *device = open_drm();
    for (int whole_edid = 0; whole_edid < 2; whole_edid++) {
        swap_monitor(whole_edid != 0 ? "LKG-TEST" : NULL);
        announce();
        assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
        assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
    }
    swap_monitor("LKG-OTHER");
    announce();
    stays_gone(device, &frame);
    plug_in(true);
    fake.no_watch = true;
    device = open_drm();
    swap_monitor("LKG-OTHER");
    stays_gone(device, &frame);
    plug_in(true);
    fake.n_edid[1] = 0; /* opened by its output's name, and then it says that it is another */
    lf_assert_ok(try_open("DP-1", &device, NULL), NULL);
    swap_monitor("DELL U2720Q");
    announce();
    stays_gone(device, &frame);
    lf_image8_finish(&frame);
}

static void break_link(void)
{
    pthread_mutex_lock(&fake.lock);
    fake.connector[N_LINK] = DRM_MODE_LINK_STATUS_BAD;
    pthread_mutex_unlock(&fake.lock);
    announce();
}

static bool link_comes_back(void)
{
    bool good = false;
    for (int i = 0; i < DEVICE_WAIT_MS / 10 && !good; i++) {
        usleep(10000);
        pthread_mutex_lock(&fake.lock);
        good = fake.modes == 2 && fake.connector[N_LINK] == DRM_MODE_LINK_STATUS_GOOD;
        pthread_mutex_unlock(&fake.lock);
    }
    return good;
}

static void link_that_fails_is_set_up_again(void **state)
{
    (void)state;
    for (int refusing = 0; refusing < 2; refusing++) {
        plug_in(true);
        fake.wishes_refused = refusing != 0;
        lf_device *device = open_drm();
        lf_image8 frame = make_frame();
        scribble(&frame, &whole, 3);
        assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
        break_link();
        assert_true(link_comes_back());
        assert_true(shows(&frame));
        lf_image8_finish(&frame);
        lf_device_destroy(device);
        nothing_is_left();
    }
}

/* ------------------------------------------------------------------------------------------------------- probing -- */

static void probe_tells_panels_and_what_may_be_one(void **state)
{
    (void)state;
    lf_device_info out[4];
    plug_in(true);
    assert_int_equal(lf_drm_probe(&fake_kms, out, 4), 1);
    assert_string_equal(out[0].spec, "drm:card0/DP-1");
    assert_string_equal(out[0].model, "LKG-TEST");
    assert_string_equal(out[0].output, "card0/DP-1 64x48");
    assert_int_equal(fake.dropped, 1); /* opening had made it master */
    assert_int_equal(fake.modes + fake.flips + fake.looks, 0);
    fake.n_edid[0] = 0;
    assert_int_equal(lf_drm_probe(&fake_kms, out, 4), 2);
    assert_string_equal(out[0].model, ""); /* "auto" leaves it alone */
    assert_non_null(strstr(out[0].problem, "no EDID"));
    assert_int_equal(lf_drm_probe(&fake_kms, out, 1), 1);
    assert_int_equal(lf_drm_probe(&fake_kms, out, 0), 0);
    fake.connectors[0].known = fake.connectors[0].connected = false;
    assert_int_equal(lf_drm_probe(&fake_kms, out, 4), 1);
    assert_int_equal(fake.looks, 1); /* nobody had looked at that one before */
    nothing_is_left();
}

static void probe_tells_where_the_calibration_will_come_from(void **state)
{
    (void)state;
    lf_device_info out[4];
    char *dir = lf_test_folder();
    lf_found found = {.source = LF_SOURCE_HID, .calibration = lens(WIDTH, HEIGHT)};
    snprintf(found.calibration.serial, sizeof found.calibration.serial, "LKG-TEST-1");
    setenv("CACHE_DIRECTORY", dir, 1);
    plug_in(true);
    assert_int_equal(lf_drm_probe(&fake_kms, out, 4), 1);
    if (out[0].calibration_from[0] == 0) /* this machine has no panel of its own */
        assert_non_null(strstr(out[0].problem, "no calibration for it is known: plug the panel's USB in"));
    lf_cache_store(&found);
    assert_int_equal(lf_drm_probe(&fake_kms, out, 4), 1);
    assert_non_null(strstr(out[0].calibration_from, "cache, "));
    assert_string_equal(out[0].problem, "");
    fake.connector[N_ORIENTATION] = 2;
    assert_int_equal(lf_drm_probe(&fake_kms, out, 4), 1);
    assert_non_null(strstr(out[0].problem, "Left Side Up"));
    assert_non_null(strstr(out[0].problem, "video=DP-1:panel_orientation=normal"));
    assert_int_equal(fake.modes + fake.flips, 0);
    unsetenv("CACHE_DIRECTORY");
    lf_test_folder_remove(dir);
    nothing_is_left();
}

static void probe_tells_who_uses_a_panel_and_what_is_wrong(void **state)
{
    (void)state;
    lf_device_info out[4];
    plug_in(true);
    fake.taken = true;
    fake.connectors[1].crtc = CRTC;
    assert_int_equal(lf_drm_probe(&fake_kms, out, 4), 1);
    assert_non_null(
        strstr(out[0].problem, "used by Xorg (process 12), which scales it: it is set to 1024x768, not to its native 64x48"));
    assert_non_null(strstr(out[0].problem, "--device window"));
    assert_int_equal(fake.dropped, 0);
    fake.shown.mode = make_mode(WIDTH, HEIGHT, 0, 0);
    lf_drm_probe(&fake_kms, out, 4);
    assert_non_null(strstr(out[0].problem, "turns it"));
    fake.plane[P_ROTATION] = fake.cursor[P_ROTATION] = DRM_MODE_ROTATE_0;
    lf_drm_probe(&fake_kms, out, 4);
    assert_string_equal(out[0].problem, "used by Xorg (process 12); within a desktop take --device window");
    fake.open_error = EACCES;
    assert_int_equal(lf_drm_probe(&fake_kms, out, 4), 1);
    assert_string_equal(out[0].model, "");
    assert_non_null(strstr(out[0].problem, "group video"));
    nothing_is_left();
}

static void machines_without_displays_are_probed(void **state)
{
    (void)state;
    lf_device_info out[32];
    assert_in_range(lf_drm_ops.probe(out, 32), 0, 32);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_of_outputs_are_understood),
        cmocka_unit_test(native_mode_is_the_preferred_one_that_can_be),
        cmocka_unit_test(looking_glass_is_found_by_its_edid),
        cmocka_unit_test(what_is_not_there_is_told_with_what_is),
        cmocka_unit_test(calibration_is_found_by_what_the_monitor_is_called),
        cmocka_unit_test(damaged_edids_make_no_panel),
        cmocka_unit_test(impossible_memory_is_refused),
        cmocka_unit_test(every_step_of_opening_may_fail),
        cmocka_unit_test(rectangles_make_the_frame_on_atomic_drivers),
        cmocka_unit_test(rectangles_make_the_frame_on_legacy_drivers),
        cmocka_unit_test(rectangles_make_the_frame_without_page_flips),
        cmocka_unit_test(pixels_are_shown_unchanged_and_the_rest_is_put_back),
        cmocka_unit_test(refused_wishes_are_told_and_the_rest_is_shown),
        cmocka_unit_test(pushes_of_the_wrong_shape_are_refused),
        cmocka_unit_test(failed_picture_is_told_once_and_the_next_sets_the_mode),
        cmocka_unit_test(flip_without_an_end_is_given_up),
        cmocka_unit_test(unplugged_monitor_is_told),
        cmocka_unit_test(unplugged_card_is_told),
        cmocka_unit_test(swapped_monitor_is_told),
        cmocka_unit_test(link_that_fails_is_set_up_again),
        cmocka_unit_test(probe_tells_panels_and_what_may_be_one),
        cmocka_unit_test(probe_tells_where_the_calibration_will_come_from),
        cmocka_unit_test(probe_tells_who_uses_a_panel_and_what_is_wrong),
        cmocka_unit_test(machines_without_displays_are_probed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
