/* rpc: JSON-RPC 2.0 messages, one JSON object per line, UTF-8 (quiltd(1), PROTOCOL). Parses
 * requests, checks parameters against a method's schema and builds answers; no sockets here. Thread
 * safe: no shared state. */
#ifndef LF_DAEMON_RPC_H
#define LF_DAEMON_RPC_H

#include <jansson.h>

#include "base/status.h"

/* Longest line that either side may send, without the newline. */
#define LF_RPC_MAX_LINE ((size_t)1 << 20)
/* Longest string id, in bytes. */
#define LF_RPC_MAX_ID ((size_t)1024)
#define LF_RPC_PROTOCOL 1

/* Error codes of JSON-RPC, then quiltd's own. */
enum {
    LF_RPC_PARSE_ERROR = -32700,
    LF_RPC_INVALID_REQUEST = -32600,
    LF_RPC_METHOD_NOT_FOUND = -32601,
    LF_RPC_INVALID_PARAMS = -32602,
    LF_RPC_INTERNAL = -32603,
    LF_RPC_BUSY = -32000,
    LF_RPC_PATH_REFUSED = -32001,
    LF_RPC_BAD_SCENE = -32002,
    LF_RPC_NO_DEVICE = -32003,
    LF_RPC_TIMEOUT = -32004,
};

/* A well-formed request. method and params are borrowed from message. */
typedef struct lf_rpc_request {
    json_t *message;  /* owned */
    const json_t *id; /* string, integer, real or null; NULL = a notification, which gets no
                       * answer */
    const char *method;
    json_t *params; /* an object, empty if the message had none; owned (a reference) */
} lf_rpc_request;

/* Parses line[n] (no newline). True: *out is filled; release it with lf_rpc_request_finish. False:
 * *out_answer is the error object to send, a new reference, or NULL when out of memory. A batch is
 * refused as one invalid request. */
bool lf_rpc_parse(const char *line, size_t n, lf_rpc_request *out, json_t **out_answer);
/* Accepts zeroed structs. */
void lf_rpc_request_finish(lf_rpc_request *request);

/* Messages to send: new references, NULL = out of memory. id is borrowed (NULL = null); ownership
 * of result, data and params is taken. data NULL: the member is omitted. */
json_t *lf_rpc_result(const json_t *id, json_t *result);
json_t *lf_rpc_error(const json_t *id, int code, const char *message, json_t *data);
/* A text from outside, for example a file name. Bytes that are not UTF-8 are escaped. */
json_t *lf_rpc_text(const char *text);
json_t *lf_rpc_notification(const char *method, json_t *params);

/* The error object for a failure. `data` holds file, line and pointer if err has them. Codes:
 * - PATH: -32001
 * - FORMAT, IO, NOMEM, ARG, TIMEOUT: -32002 if `scene`; otherwise TIMEOUT -32004, ARG -32602
 * - NODEV: -32003
 * - BUSY, STATE: -32000
 * - all others: -32603 */
json_t *lf_rpc_error_of(const json_t *id, const lf_error *err, bool scene);
/* The same with a message of the caller's, for errors whose place the client knows otherwise. */
json_t *lf_rpc_error_saying(const json_t *id, const lf_error *err, bool scene, const char *message);

/* Checks params (an object) against a schema. Supports the part of JSON Schema that the methods
 * use: type (also a list), properties, required, enum, minimum, maximum, items, minItems, maxItems.
 * Unknown keys are errors unless additionalProperties is true. LF_E_ARG: err->pointer names the
 * value. */
LF_NODISCARD lf_status lf_schema_check(const json_t *schema, json_t *value, const char *where,
                                       lf_error *err);

/* The key of an object that is nearest to word (lf_nearest_name); NULL: none is near enough. */
const char *lf_nearest_key(const char *word, json_t *object);

/* Adds "key=value" of a command line to params, typed by the schema's property of that name.
 * Numbers, integers and booleans are parsed, arrays are comma separated, strings are taken
 * literally. "key:=JSON" is raw JSON. LF_E_ARG. */
LF_NODISCARD lf_status lf_schema_argument(const json_t *schema, const char *text, json_t *params,
                                          lf_error *err);

#endif
