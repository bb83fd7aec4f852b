/* methods: the methods that clients can call and the notifications they get. One table of methods
 * (name, schema of the parameters, function), one of the fields of results and notifications. */
#ifndef LF_DAEMON_METHODS_H
#define LF_DAEMON_METHODS_H

#include <jansson.h>

typedef struct lf_call lf_call; /* a call being answered by its method */

typedef struct lf_method {
    const char *name;
    const char *summary; /* one line for hello */
    const char *example; /* arguments of an example call with quiltctl */
    const char *schema;  /* JSON Schema of the parameters, as text; parameters from tables are
                          * added */
    void (*run)(lf_call *call);
} lf_method;

#define LF_MAX_METHODS 64 /* bits of lf_client_denied */

/* NULL after the last. */
const lf_method *lf_method_at(int index);
/* The schema, parsed once; borrowed. NULL after the last. */
json_t *lf_method_schema(int index);

/* methods_fields.c */
/* A notification: a method that the daemon calls. */
typedef struct lf_notification {
    const char *name;  /* name of the method */
    const char *event; /* event of subscribe */
    const char *summary;
} lf_notification;
/* NULL after the last. */
const lf_notification *lf_notification_at(int index);
/* {name: {summary, params, result, example}} of the methods, and {name: {summary, event, params}}
 * of the notifications, as `hello` returns them. Built once, borrowed. Thread: any. */
json_t *lf_methods_json(void);
json_t *lf_events_json(void);

#endif
