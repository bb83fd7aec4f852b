/* The parts of the drm device: finding the output (drm_find.c), driving it (drm_output.c), its
 * memory (drm_buffer.c), and the device itself (drm.c). Private to device/ and its tests. */
#ifndef LF_DEVICE_DRM_H
#define LF_DEVICE_DRM_H

#include "device/device.h"
#include "device/drm/kms.h"
#include "device/find/edid.h"

/* -------------------------------------------------------------------------------- drm_find.c -- */

/* The argument of --device: "" = the first Looking Glass, "DP-1", "card1/HDMI-A-1". */
typedef struct lf_drm_name {
    int card;                    /* -1 = any */
    char connector[LF_KMS_NAME]; /* empty = by EDID */
} lf_drm_name;

/* LF_E_ARG: not a possible name of an output. */
LF_NODISCARD lf_status lf_drm_name_parse(const char *argument, lf_drm_name *out, lf_error *err);

/* The first block of an EDID holds the monitor's maker, product, serial number and name (VESA
 * E-EDID A2 3). */
enum { LF_DRM_EDID_BLOCK = 128 };

/* An output with a monitor. */
typedef struct lf_drm_found {
    int card, fd; /* fd: the caller's */
    lf_kms_resources resources;
    lf_kms_connector connector;
    struct drm_mode_modeinfo mode; /* the native mode: preferred, progressive, of a usable size */
    bool has_edid;
    lf_edid edid;                          /* zeroed without has_edid */
    uint8_t edid_block[LF_DRM_EDID_BLOCK]; /* likewise */
} lf_drm_found;

/* Opens the card that has the output and describes it. The caller owns out->fd, which is not master
 * of the card. LF_E_NODEV: the output is missing; err lists the monitors found; LF_E_IO: a card
 * that could have it cannot be opened; LF_E_FORMAT: it has no usable mode. */
LF_NODISCARD lf_status lf_drm_find(const lf_kms_calls *kms, const lf_drm_name *name,
                                   lf_drm_found *out, lf_error *err);

/* Reads the EDID of the monitor on a connector. False: none, or incomplete; both outputs are then
 * zeroed. */
bool lf_drm_read_edid(const lf_kms_calls *kms, int fd, uint32_t connector, lf_edid *out,
                      uint8_t out_block[LF_DRM_EDID_BLOCK]);

/* Makes fd master of its card: 0 or a negative errno. A concurrent lf_drm_find or lf_drm_probe of
 * another thread does not make it fail. */
int lf_drm_become_master(const lf_kms_calls *kms, int fd);

/* The native mode of a connector; NULL = no usable mode. */
const struct drm_mode_modeinfo *lf_drm_native_mode(const lf_kms_connector *connector);

/* lf_device_ops.probe over this kernel. Finds Looking Glass panels and unidentified monitors.
 * Without an EDID, model is empty so that "auto" ignores the monitor. If opening makes it
 * master, it drops that at once. Sets nothing, and does not probe monitors that the kernel
 * already knows. */
int lf_drm_probe(const lf_kms_calls *kms, lf_device_info *out, int max);

/* ------------------------------------------------------------------------------ drm_buffer.c -- */

/* A picture in memory that a CRTC can show, and the parts of it that are older than the panel
 * picture. */
typedef struct lf_drm_buffer {
    uint32_t handle, fb, pitch;
    size_t size;
    uint8_t *map;
    bool all_stale;
    int n_stale;
    lf_rect *stale; /* [LF_DEVICE_MAX_RECTS] */
} lf_drm_buffer;

/* Allocates zeroed memory; everything is stale. width and height 1..LF_MAX_SIDE. After a failure
 * call finish. LF_E_NOMEM: too little video memory; LF_E_FORMAT: pitch or size cannot hold the
 * picture, or are implausibly large; LF_E_IO. */
LF_NODISCARD lf_status lf_drm_buffer_init(const lf_kms_calls *kms, int fd, int width, int height,
                                          lf_drm_buffer *out, lf_error *err);
/* Accepts zeroed and half-built buffers. */
void lf_drm_buffer_finish(const lf_kms_calls *kms, int fd, lf_drm_buffer *buffer);
/* Marks rects[n] as stale. */
void lf_drm_buffer_age(lf_drm_buffer *buffer, const lf_rect *rects, int n);
/* Copies all stale parts from picture (3 channels, the buffer's size), so that the buffer is up to
 * date. Returns the bytes written. */
uint64_t lf_drm_buffer_paint(lf_drm_buffer *buffer, const lf_image8 *picture);

/* ------------------------------------------------------------------------------ drm_output.c -- */

enum { LF_DRM_ASSIGNMENTS = 160, LF_DRM_SAVED = 16, LF_DRM_CLIPS = 64 };

/* One connector, the CRTC and plane that drive it, and their state before. */
typedef struct lf_drm_output {
    const lf_kms_calls *kms;
    int fd;
    uint32_t connector, crtc, plane; /* plane: atomic only */
    struct drm_mode_modeinfo mode;
    bool atomic;
    bool plain; /* optional properties were refused: shown without them */
    /* legacy API without page flips: the CRTC uses fb directly and is told what changed */
    bool no_flip;
    bool lit;        /* the mode is set and has not been lost since */
    bool touched;    /* something was set and must be restored */
    lf_kms_crtc old; /* state before */
    int n_old;
    lf_kms_assignment old_values[LF_DRM_SAVED]; /* of the connector's properties */
    uint32_t mode_blob;
    uint32_t clips_property; /* FB_DAMAGE_CLIPS; 0 = the driver takes none */
    int n_base;              /* required assignments; the first is the fb … */
    /* … and with the optional ones after them: full range, 8 bits, no gamma…, if the driver has
     * (and accepts) them */
    int n_all;
    lf_kms_assignment all[LF_DRM_ASSIGNMENTS];
} lf_drm_output;

typedef enum lf_drm_shown {
    LF_DRM_NOW,   /* shown */
    LF_DRM_LATER, /* an event on the descriptor will report it */
} lf_drm_shown;

/* Chooses CRTC and plane for found and saves their state. Sets nothing. The fd stays the caller's
 * and must outlive the output. LF_E_BUSY: no CRTC is free; LF_E_IO. */
LF_NODISCARD lf_status lf_drm_output_init(const lf_kms_calls *kms, const lf_drm_found *found,
                                          lf_drm_output *out, lf_error *err);
/* Tests whether the display would take this fb. Atomic only; otherwise always LF_OK. LF_E_IO. */
LF_NODISCARD lf_status lf_drm_output_test(lf_drm_output *output, uint32_t fb, lf_error *err);
/* Shows fb: sets the mode if it is not set, otherwise flips. clips[n] must cover everything that
 * differs both from the shown picture and from this fb's content when it was last shown. Returns
 * lf_drm_shown or a negative errno. After an error the state is unknown and the next call sets the
 * mode again. */
int lf_drm_output_show(lf_drm_output *output, uint32_t fb, const lf_rect *clips, int n);
/* Restores the state before init as far as possible, and frees. Accepts zeroed outputs. */
void lf_drm_output_finish(lf_drm_output *output);
/* The important optional properties that were refused, as text; "" = none. */
const char *lf_drm_output_problem(const lf_drm_output *output);

/* ------------------------------------------------------------------------------------- drm.c -- */

/* lf_device_ops.open over this kernel. */
LF_NODISCARD lf_status lf_drm_open(const lf_kms_calls *kms, const char *argument,
                                   const lf_calibration *calibration, lf_device **out_device,
                                   lf_error *err);

#endif
