/* A kernel of the test's own in place of /dev/dri: one card, an ordinary monitor on HDMI-A-1 with
 * the console, a Looking Glass on DP-1, nothing on DP-2. It does what three kinds of drivers do,
 * counts what is asked of it, and fails where it is told to. Threads: any; what a device's thread
 * may write is read and written under the lock. */
#ifndef LF_TESTS_DEVICE_FAKE_KMS_H
#define LF_TESTS_DEVICE_FAKE_KMS_H

#include <pthread.h>

#include "base/image.h"
#include "device/drm/drm.h"

enum {
    FAKE_WIDTH = 64,
    FAKE_HEIGHT = 48,
    FAKE_PITCH = FAKE_WIDTH * 4 + 64,
    FAKE_CRTC = 40,
    FAKE_OLD_FB = 77, /* the console's */
};

/* The properties of each kind of object. */
enum {
    FAKE_PLANE_FB,
    FAKE_PLANE_CRTC,
    FAKE_PLANE_SRC_X,
    FAKE_PLANE_SRC_Y,
    FAKE_PLANE_SRC_W,
    FAKE_PLANE_SRC_H,
    FAKE_PLANE_X,
    FAKE_PLANE_Y,
    FAKE_PLANE_W,
    FAKE_PLANE_H,
    FAKE_PLANE_TYPE,
    FAKE_PLANE_ROTATION,
    FAKE_PLANE_CLIPS,
    FAKE_PLANE_PROPERTIES
};
enum { FAKE_CRTC_MODE, FAKE_CRTC_ACTIVE, FAKE_CRTC_GAMMA, FAKE_CRTC_PROPERTIES };
enum {
    FAKE_CONNECTOR_CRTC,
    FAKE_CONNECTOR_RANGE,
    FAKE_CONNECTOR_DEPTH,
    FAKE_CONNECTOR_LINK,
    FAKE_CONNECTOR_ORIENTATION,
    FAKE_CONNECTOR_PROPERTIES
};

typedef struct lf_fake_kms {
    pthread_mutex_t lock;
    /* what there is */
    int n_cards, open_error;
    bool atomic, taken, no_page_flip, silent, wishes_refused, no_watch;
    int n_connectors;
    lf_kms_connector connectors[4];
    uint8_t edid[4][128];
    int n_edid[4];
    uint32_t pitch;
    uint64_t size;
    /* errors: the n-th call that can fail does so (0 = never), or the n-th picture */
    int fail_call, calls, fail_with, fail_show;
    /* what happened */
    uint64_t plane[FAKE_PLANE_PROPERTIES], cursor[FAKE_PLANE_PROPERTIES],
        crtc[FAKE_CRTC_PROPERTIES], connector[FAKE_CONNECTOR_PROPERTIES];
    lf_kms_crtc shown;
    int flips, modes, dirts, looks, dropped;
} lf_fake_kms;

extern lf_fake_kms lf_fake;
extern const lf_kms_calls lf_fake_calls;

/* A new machine, as above. */
void lf_fake_plug_in(bool atomic);
/* Fails the test when a descriptor, a blob or a buffer is still held. */
void lf_fake_nothing_is_left(void);

/* Connector i has a monitor of this name. */
void lf_fake_set_edid(int i, const char *name);
/* Of 60 Hz; type and flags: DRM_MODE_... */
struct drm_mode_modeinfo lf_fake_mode(int width, int height, uint32_t type, uint32_t flags);
/* Tells that a connector has changed, whose watch must be open. */
void lf_fake_announce(void);

/* Whether the display shows this frame, by a driver that copies all and by one that copies what it
 * is told. */
bool lf_fake_shows(const lf_image8 *frame);

#endif
