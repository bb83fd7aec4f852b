/* Kernel mode setting as plain structs and a table of functions: the part of libdrm that the drm
 * device uses, which tests replace. Private to device/ and its tests.
 *
 * Source: "Userland interfaces" of the kernel's DRM driver API (drm-kms, drm-uapi) and drm_mode.h;
 * mode numbers and flags are the kernel's (drm_mode_modeinfo).
 *
 * Errors: functions that return int return 0 (or a count) or a negative errno. -ENODEV = the card
 * is gone, -EACCES = not master (any more), -EBUSY = another program is master, or the last flip is
 * still in progress.
 *
 * Threads: a descriptor is used by one thread at a time. Counts never exceed the arrays of the
 * structs, whatever a driver reports. */
#ifndef LF_DEVICE_KMS_H
#define LF_DEVICE_KMS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <drm.h>
#include <drm_mode.h>

enum {
    LF_KMS_CARDS = 16,
    LF_KMS_CONNECTORS = 64,
    LF_KMS_CRTCS = 32,
    LF_KMS_MODES = 128,
    LF_KMS_PLANES = 64,
    LF_KMS_PROPERTIES = 96,
    LF_KMS_ENUMS = 24,
    LF_KMS_NAME = 32,
    LF_KMS_EDID = 2048,
};

/* A display output. */
typedef struct lf_kms_connector {
    uint32_t id;
    char name[LF_KMS_NAME]; /* "DP-1", "HDMI-A-1": the kernel's, as in /sys/class/drm */
    bool connected, known;  /* known: false until it was probed */
    uint32_t crtc;          /* the CRTC that drives it now; 0 = none */
    uint32_t crtcs;         /* bit i: crtcs[i] of the resources can drive it */
    int n_modes;
    struct drm_mode_modeinfo modes[LF_KMS_MODES];
} lf_kms_connector;

typedef struct lf_kms_resources {
    int n_crtcs, n_connectors;
    uint32_t crtcs[LF_KMS_CRTCS], connectors[LF_KMS_CONNECTORS];
} lf_kms_resources;

/* The state of a CRTC. */
typedef struct lf_kms_crtc {
    uint32_t id, fb; /* fb 0 = nothing */
    uint32_t x, y;   /* offset of the picture in fb */
    bool lit;        /* mode is valid */
    struct drm_mode_modeinfo mode;
    int gamma_size;
} lf_kms_crtc;

typedef struct lf_kms_plane {
    uint32_t id, crtc; /* crtc: the CRTC that shows it now; 0 = none */
    uint32_t crtcs;    /* as in a connector */
    bool xrgb8888;     /* takes this format */
} lf_kms_plane;

typedef struct lf_kms_property {
    uint32_t id;
    char name[LF_KMS_NAME];
    uint64_t value;
    uint64_t low, high; /* of a range; otherwise 0 */
    int n_enums;
    struct {
        char name[LF_KMS_NAME];
        uint64_t value; /* of a bit mask: the bit's number */
    } enums[LF_KMS_ENUMS];
} lf_kms_property;

/* Sets a property of an object to a value. */
typedef struct lf_kms_assignment {
    uint32_t object, property;
    uint64_t value;
} lf_kms_assignment;

typedef enum lf_kms_commit {
    LF_KMS_TEST, /* test only; mode setting allowed */
    LF_KMS_SET,  /* mode setting allowed; returns when it is shown */
    LF_KMS_FLIP, /* returns at once; a flip event reports when it is shown */
} lf_kms_commit;

/* Without atomic mode setting. */
typedef struct lf_kms_legacy {
    /* crtc_set: shows fb on a connector now (fb 0: switches the CRTC off). page_flip: shows fb at
     * the next refresh, followed by an event. dirty: reports changed parts of the shown fb to the
     * driver. gamma_reset: resets the colour look-up table. */
    int (*crtc_set)(int fd, const lf_kms_crtc *crtc, uint32_t connector);
    int (*page_flip)(int fd, uint32_t crtc, uint32_t fb);
    int (*dirty)(int fd, uint32_t fb, const struct drm_mode_rect *rects, int n);
    int (*gamma_reset)(int fd, uint32_t crtc, int size);
} lf_kms_legacy;

typedef struct lf_kms_calls {
    /* The numbers N of existing /dev/dri/cardN; returns how many (at most LF_KMS_CARDS). */
    int (*cards)(int out[LF_KMS_CARDS]);
    /* A descriptor. The first opener of a card without a master becomes master. */
    int (*open)(int card);
    void (*close)(int fd);
    int (*master_set)(int fd);
    void (*master_drop)(int fd);
    bool (*master_is)(int fd);
    /* The name of the program that is master, if the kernel shows it; false: unknown. */
    bool (*master_name)(int card, char *out, size_t size);
    /* True if the card has outputs and supports dumb buffers. */
    bool (*usable)(int fd);
    /* Enables atomic mode setting for this descriptor; false: the driver has none. */
    bool (*atomic)(int fd);

    int (*resources)(int fd, lf_kms_resources *out);
    /* look: probes the monitor (tens of ms); otherwise returns the kernel's knowledge. */
    int (*connector)(int fd, uint32_t id, bool look, lf_kms_connector *out);
    /* Bytes of the EDID written to out (0 = none). */
    int (*edid)(int fd, uint32_t connector, uint8_t out[LF_KMS_EDID]);
    int (*crtc)(int fd, uint32_t id, lf_kms_crtc *out);
    /* Planes, cursors and overlays included; returns how many. Atomic only. */
    int (*planes)(int fd, lf_kms_plane out[LF_KMS_PLANES]);
    /* type is DRM_MODE_OBJECT_…; returns how many. */
    int (*properties)(int fd, uint32_t object, uint32_t type,
                      lf_kms_property out[LF_KMS_PROPERTIES]);
    int (*property_set)(int fd, uint32_t object, uint32_t type, uint32_t property, uint64_t value);

    /* Dumb buffers, 32 bits per pixel. */
    int (*buffer_create)(int fd, uint32_t width, uint32_t height, uint32_t *out_handle,
                         uint32_t *out_pitch, uint64_t *out_size);
    void (*buffer_destroy)(int fd, uint32_t handle);
    void *(*buffer_map)(int fd, uint32_t handle, size_t size); /* NULL with errno */
    void (*buffer_unmap)(void *map, size_t size);
    /* XRGB8888 */
    int (*fb_add)(int fd, uint32_t width, uint32_t height, uint32_t pitch, uint32_t handle,
                  uint32_t *out_fb);
    void (*fb_remove)(int fd, uint32_t fb);
    int (*blob_create)(int fd, const void *data, size_t size, uint32_t *out_blob);
    void (*blob_destroy)(int fd, uint32_t blob);

    lf_kms_legacy legacy;
    int (*commit)(int fd, lf_kms_commit how, const lf_kms_assignment *assignments, int n);

    /* Reads pending events from fd; returns the number of flips. */
    int (*events)(int fd);
    /* A descriptor that polls readable when a connector may have changed; -errno if the system does
     * not report it. */
    int (*watch)(void);
    /* Reads an event of it; true if it was about displays. */
    bool (*watch_read)(int watch_fd);
} lf_kms_calls;

/* The kernel's functions, through libdrm. */
extern const lf_kms_calls lf_kms_kernel;

#endif
