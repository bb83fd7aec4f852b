/* A camera that moves to where what is there fills its views. Thread: any. */
#ifndef LF_DAEMON_FIT_H
#define LF_DAEMON_FIT_H

#include "render/render.h"

/* The patch (RFC 7396) that moves a scene's camera as lf_camera_fit says for the rig of settings; a
 * lens that the scene focuses somewhere is focused on what is framed. On LF_OK a new reference,
 * NULL = out of memory. Errors of lf_camera_fit. */
LF_NODISCARD lf_status lf_fit_patch(const lf_scene *scene, const lf_render_settings *settings,
                                    const char *name, double fill, double steps, json_t **out_patch,
                                    lf_error *err);

#endif
