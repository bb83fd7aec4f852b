/* The methods, each in the file of its subject. A method answers its call or defers the answer. */
#ifndef LF_DAEMON_METHODS_INTERNAL_H
#define LF_DAEMON_METHODS_INTERNAL_H

#include "daemon/server/methods.h"
#include "daemon/server/server_internal.h"

/* methods_rights.c: what a client may call */
/* The index of the method with this name, if the client may call it; otherwise -1, with *err. */
int lf_rights_find(lf_client *client, const char *name, lf_error *err);
bool lf_rights_have(lf_client *client, const char *name);
/* Whether there is a method that it may not call. */
bool lf_rights_limited(lf_client *client);
/* The methods of hello that it may call, and the notifications that it may receive. */
json_t *lf_rights_methods_json(lf_client *client);
json_t *lf_rights_events_json(lf_client *client);
/* methods_status.c */
void lf_method_hello(lf_call *call);
void lf_method_status(lf_call *call);
void lf_method_wait(lf_call *call);
void lf_method_subscribe(lf_call *call);
void lf_method_rights_limit(lf_call *call);
void lf_method_shutdown(lf_call *call);
/* methods_scene.c */
/* Queues a load that the call waits for; load NULL = out of memory. */
void lf_method_queue(lf_call *call, lf_load *load);
/* Destroys a load that was not queued and fails its call (lf_fail). Logs this, unless a parameter
 * is wrong. */
void lf_method_refuse(lf_call *call, lf_load *load, const lf_error *err, bool scene);
/* The call's parameter "name" for what is sent instead of a file, or else this one; lf_free.
 * LF_E_ARG, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_method_name(const lf_call *call, const char *otherwise, char **out,
                                      lf_error *err);
void lf_method_scene_load(lf_call *call);
void lf_method_scene_get(lf_call *call);
void lf_method_scene_patch(lf_call *call);
void lf_method_camera_set(lf_call *call);
void lf_method_camera_orbit(lf_call *call);
void lf_method_camera_fit(lf_call *call);
void lf_method_render_set(lf_call *call);
/* methods_quilt.c */
void lf_method_quilt_show(lf_call *call);
/* methods_time.c */
/* The current frame and playback, as in `status`; null: no scene. */
json_t *lf_time_json(const lf_server *server);
void lf_method_time_set(lf_call *call);
void lf_method_time_play(lf_call *call);
void lf_method_time_stop(lf_call *call);
/* methods_device.c */
void lf_method_device_list(lf_call *call);
void lf_method_device_set(lf_call *call);
void lf_method_device_calibration(lf_call *call);
void lf_method_button(lf_call *call);
/* methods_export.c */
void lf_method_job_cancel(lf_call *call);

#endif
