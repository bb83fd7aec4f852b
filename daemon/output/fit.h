/* Camera fitting. Thread: any. */
#ifndef LF_DAEMON_FIT_H
#define LF_DAEMON_FIT_H

#include "render/render.h"

/* Makes the merge patch (RFC 7396) that moves a scene's camera as lf_camera_fit computes for the
 * rig of settings. If the scene sets a focus distance, the patch focuses on the framed objects. On
 * LF_OK *out_patch is a new reference, or NULL when out of memory. Errors of lf_camera_fit. */
LF_NODISCARD lf_status lf_fit_patch(const lf_scene *scene, const lf_render_settings *settings,
                                    const char *name, double fill, double steps, json_t **out_patch,
                                    lf_error *err);

#endif
