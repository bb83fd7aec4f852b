/* Single pictures for the vendor's hololuminescent displays (--preset hld): one view of 2160x3840.
 * The display shows white as transparent. The object is on a shadow of its own, inside the vendor's
 * margins: 355 pixels at the top, 100 at the bottom, 108 at the sides. Source:
 * hlddocs.lookingglassfactory.com, "Media specs and encoding". Thread: any. */
#ifndef LF_DAEMON_HLD_H
#define LF_DAEMON_HLD_H

#include "render/render.h"

/* Frames of a video's turntable by default: 20 s at 30 frames per second. */
#define LF_HLD_FRAMES 600

/* Makes the merge patch (RFC 7396) that adapts a scene to such a display. It sets:
 * - A backdrop that is white after `exposure` stops and the tone curve "srgb".
 * - A ground that catches shadows, unless a mesh already does.
 * - If `frames`: a camera that keeps its direction, moved so that the scene stays inside the
 *   margins during a turntable.
 *
 * On LF_OK *out_patch is a new reference, NULL = out of memory. LF_E_STATE: the scene has no object
 * to frame. */
LF_NODISCARD lf_status lf_hld_patch(const lf_scene *scene, double exposure, bool frames,
                                    json_t **out_patch, lf_error *err);

#endif
