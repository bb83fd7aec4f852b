/* Plain pictures for the vendor's hololuminescent displays (--preset hld): one view of 2160x3840,
 * seen as if its white were not there. What is shown stands on a shadow of its own, inside the
 * margins that the vendor asks for (hlddocs.lookingglassfactory.com, "Media specs and encoding":
 * 355 pixels at the top, 100 at the bottom, 108 at the sides). Thread: any. */
#ifndef LF_DAEMON_HLD_H
#define LF_DAEMON_HLD_H

#include "render/render.h"

/* Frames of the slow turn that a video makes where nothing else is said: 20 s at 30 in a second. */
#define LF_HLD_FRAMES 600

/* The patch (RFC 7396) that makes a scene one for such a display: a backdrop that is white after so
 * many stops of exposure and the tone curve "srgb"; a ground that catches shadows, unless a mesh
 * does already; and where `frames` the camera, from its side, where what is there stays inside the
 * margins while it turns. On LF_OK a new reference, NULL = out of memory. LF_E_STATE: nothing is
 * there that could be framed. */
LF_NODISCARD lf_status lf_hld_patch(const lf_scene *scene, double exposure, bool frames,
                                    json_t **out_patch, lf_error *err);

#endif
