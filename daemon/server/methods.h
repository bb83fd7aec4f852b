/* methods: what clients can call, and what they are told. One table of methods (name, schema of the
 * parameters, function), one of the fields of answers and notifications. */
#ifndef LF_DAEMON_METHODS_H
#define LF_DAEMON_METHODS_H

#include "daemon/server/server_internal.h"

typedef struct lf_method {
    const char *name;
    const char *summary; /* one line for hello */
    const char *example; /* a call by quiltctl, without its name */
    const char *schema;  /* JSON Schema of the parameters, as text; those of structs are added */
    void (*run)(lf_call *call);
} lf_method;

/* NULL behind the last. */
const lf_method *lf_method_at(int index);
/* The schema, parsed once; borrowed. NULL behind the last. */
json_t *lf_method_schema(int index);

/* methods_fields.c */
/* A notification: a method that the daemon calls. */
typedef struct lf_notification {
    const char *name;  /* of the method */
    const char *event; /* of subscribe */
    const char *summary;
} lf_notification;
/* NULL behind the last. */
const lf_notification *lf_notification_at(int index);
/* {name: {summary, params, result, example}} of the methods, and {name: {summary, event, params}}
 * of the notifications, as hello has them: made once, borrowed. Thread: any. */
json_t *lf_methods_json(void);
json_t *lf_events_json(void);

/* methods_status.c */
void lf_method_hello(lf_call *call);
void lf_method_status(lf_call *call);
void lf_method_wait(lf_call *call);
void lf_method_subscribe(lf_call *call);
void lf_method_shutdown(lf_call *call);
/* methods_scene.c */
/* Queues a load that the call waits for; load NULL = out of memory. */
void lf_method_queue(lf_call *call, lf_load *load);
void lf_method_scene_load(lf_call *call);
void lf_method_scene_get(lf_call *call);
void lf_method_scene_patch(lf_call *call);
void lf_method_camera_set(lf_call *call);
void lf_method_camera_orbit(lf_call *call);
void lf_method_camera_fit(lf_call *call);
void lf_method_render_set(lf_call *call);
/* methods_time.c */
/* Which frame is shown, and what is played, as `status` shows it; null: no scene. */
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
