/* The parts of the drm device: which output (drm_find.c), how it is driven (drm_output.c), the
 * memory it shows (drm_buffer.c); drm.c is the device itself. Private to device/ and its tests. */
#ifndef LF_DEVICE_DRM_H
#define LF_DEVICE_DRM_H

#include "device/device.h"
#include "device/drm/kms.h"
#include "device/find/edid.h"

/* -------------------------------------------------------------------------------- drm_find.c -- */

/* What --device names: "" = the first Looking Glass, "DP-1", "card1/HDMI-A-1". */
typedef struct lf_drm_name {
    int card;                    /* -1 = any */
    char connector[LF_KMS_NAME]; /* empty = by EDID */
} lf_drm_name;

/* LF_E_ARG when no kernel would name an output so. */
LF_NODISCARD lf_status lf_drm_name_parse(const char *argument, lf_drm_name *out, lf_error *err);

/* The first block of an EDID has maker, product and serial number of a monitor, and its name (VESA
 * E-EDID A2 3). */
enum { LF_DRM_EDID_BLOCK = 128 };

/* An output with a monitor on it. */
typedef struct lf_drm_found {
    int card, fd; /* fd: the caller's */
    lf_kms_resources resources;
    lf_kms_connector connector;
    struct drm_mode_modeinfo mode; /* the native one: preferred, progressive, of a usable size */
    bool has_edid;
    lf_edid edid;                          /* zeroed without */
    uint8_t edid_block[LF_DRM_EDID_BLOCK]; /* likewise */
} lf_drm_found;

/* Opens the card that has the output and tells about it; out->fd is owned by the caller, and not
 * master of the card. LF_E_NODEV: it is not there, with the monitors that are; LF_E_IO: a card that
 * could have it may not be opened; LF_E_FORMAT: it has no mode that can be used. */
LF_NODISCARD lf_status lf_drm_find(const lf_kms_calls *kms, const lf_drm_name *name,
                                   lf_drm_found *out, lf_error *err);

/* Reads what the monitor on a connector says of itself. False: nothing that is whole; both are
 * zeroed then. */
bool lf_drm_read_edid(const lf_kms_calls *kms, int fd, uint32_t connector, lf_edid *out,
                      uint8_t out_block[LF_DRM_EDID_BLOCK]);

/* Makes fd master of its card: 0 or a negative errno. Not refused because another thread is just
 * looking (lf_drm_find, lf_drm_probe). */
int lf_drm_become_master(const lf_kms_calls *kms, int fd);

/* The native mode of a connector; NULL = none that can be used. */
const struct drm_mode_modeinfo *lf_drm_native_mode(const lf_kms_connector *connector);

/* lf_device_ops.probe over this kernel: Looking Glass panels, and monitors that do not say what
 * they are (no EDID: model empty, so that "auto" leaves them alone). Never master for longer than
 * it takes to give that back, sets nothing, asks no monitor that the kernel knows already. */
int lf_drm_probe(const lf_kms_calls *kms, lf_device_info *out, int max);

/* ------------------------------------------------------------------------------ drm_buffer.c -- */

/* A picture in memory that a CRTC can show, and which parts of it are older than the panel picture.
 */
typedef struct lf_drm_buffer {
    uint32_t handle, fb, pitch;
    size_t size;
    uint8_t *map;
    bool all_stale;
    int n_stale;
    lf_rect *stale; /* [LF_DEVICE_MAX_RECTS] */
} lf_drm_buffer;

/* Zeroed memory, everything stale. width and height 1..LF_MAX_SIDE. On failure finish takes what is
 * there. LF_E_NOMEM: too little video memory; LF_E_FORMAT: a pitch or size that cannot hold the
 * picture, or beyond any reason; LF_E_IO. */
LF_NODISCARD lf_status lf_drm_buffer_init(const lf_kms_calls *kms, int fd, int width, int height,
                                          lf_drm_buffer *out, lf_error *err);
/* Accepts zeroed and half-built ones. */
void lf_drm_buffer_finish(const lf_kms_calls *kms, int fd, lf_drm_buffer *buffer);
/* Notes that rects[n] of the picture are newer than the buffer. */
void lf_drm_buffer_age(lf_drm_buffer *buffer, const lf_rect *rects, int n);
/* Copies everything stale from picture (3 channels, the buffer's size): it is up to date then.
 * Returns the bytes written. */
uint64_t lf_drm_buffer_paint(lf_drm_buffer *buffer, const lf_image8 *picture);

/* ------------------------------------------------------------------------------ drm_output.c -- */

enum { LF_DRM_ASSIGNMENTS = 160, LF_DRM_SAVED = 16, LF_DRM_CLIPS = 64 };

/* One connector, the CRTC and plane that drive it, and what they showed before. */
typedef struct lf_drm_output {
    const lf_kms_calls *kms;
    int fd;
    uint32_t connector, crtc, plane; /* plane: atomic only */
    struct drm_mode_modeinfo mode;
    bool atomic;
    bool plain; /* wishes were refused: shown without them */
    /* legacy without page flips: the CRTC is pointed at the fb, and told what changed */
    bool no_flip;
    bool lit;        /* the mode is set and was not lost since */
    bool touched;    /* something was set: there is something to restore */
    lf_kms_crtc old; /* what was shown before */
    int n_old;
    lf_kms_assignment old_values[LF_DRM_SAVED]; /* of the connector's properties */
    uint32_t mode_blob;
    uint32_t clips_property; /* FB_DAMAGE_CLIPS; 0 = the driver takes none */
    int n_base;              /* what showing takes; the first is the fb … */
    /* … and behind it the wishes: full range, 8 bits, no gamma…, where the driver has (and grants)
     * them */
    int n_all;
    lf_kms_assignment all[LF_DRM_ASSIGNMENTS];
} lf_drm_output;

typedef enum lf_drm_shown {
    LF_DRM_NOW,   /* on the glass */
    LF_DRM_LATER, /* an event on the descriptor tells when it is */
} lf_drm_shown;

/* Chooses CRTC and plane for found and remembers what they show. Sets nothing. The fd stays the
 * caller's and must outlive the output. LF_E_BUSY: no CRTC is free; LF_E_IO. */
LF_NODISCARD lf_status lf_drm_output_init(const lf_kms_calls *kms, const lf_drm_found *found,
                                          lf_drm_output *out, lf_error *err);
/* Whether the display would take this fb (atomic only: else always LF_OK). LF_E_IO. */
LF_NODISCARD lf_status lf_drm_output_test(lf_drm_output *output, uint32_t fb, lf_error *err);
/* Shows fb: sets the mode when it is not set, else flips. clips[n] holds at least everything that
 * differs both from what is shown and from what this fb held when it was shown last. Returns
 * lf_drm_shown or a negative errno; after an error nothing is known and the next call sets the mode
 * anew. */
int lf_drm_output_show(lf_drm_output *output, uint32_t fb, const lf_rect *clips, int n);
/* Shows again what was there before init, as far as it still exists, and frees. Accepts zeroed
 * ones. */
void lf_drm_output_finish(lf_drm_output *output);
/* Which of the wishes matter and were not granted, in words; "" = all is well. */
const char *lf_drm_output_problem(const lf_drm_output *output);

/* ------------------------------------------------------------------------------------- drm.c -- */

/* lf_device_ops.open over this kernel. */
LF_NODISCARD lf_status lf_drm_open(const lf_kms_calls *kms, const char *argument,
                                   const lf_calibration *calibration, lf_device **out_device,
                                   lf_error *err);

#endif
