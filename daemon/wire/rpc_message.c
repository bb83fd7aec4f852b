#include "daemon/wire/rpc.h"

#include <limits.h>
#include <string.h>

#include "base/escape.h"

static bool refuse(json_t **out_answer, const json_t *id, int code, const char *message)
{
    *out_answer = lf_rpc_error(id, code, message, NULL);
    return false;
}

static bool parse_members(lf_rpc_request *out, json_t **out_answer)
{
    const json_t *message = out->message;
    const json_t *id = json_object_get(message, "id");
    if (id && !json_is_string(id) && !json_is_number(id) && !json_is_null(id))
        return refuse(out_answer, NULL, LF_RPC_INVALID_REQUEST,
                      "id must be a string, a number or null");
    if (json_string_length(id) > LF_RPC_MAX_ID)
        return refuse(out_answer, NULL, LF_RPC_INVALID_REQUEST, "id is longer than 1024 bytes");
    const char *version = json_string_value(json_object_get(message, "jsonrpc"));
    if (!version || strcmp(version, "2.0") != 0)
        return refuse(out_answer, id, LF_RPC_INVALID_REQUEST, "\"jsonrpc\" must be \"2.0\"");
    out->id = id;
    out->method = json_string_value(json_object_get(message, "method"));
    if (!out->method)
        return refuse(out_answer, id, LF_RPC_INVALID_REQUEST, "\"method\" must be a string");
    const char *key;
    json_t *value;
    json_object_foreach(out->message, key, value)
    {
        if (strcmp(key, "jsonrpc") != 0 && strcmp(key, "id") != 0 && strcmp(key, "method") != 0 &&
            strcmp(key, "params") != 0) {
            return refuse(out_answer, id, LF_RPC_INVALID_REQUEST,
                          "unknown key in the request; expected jsonrpc, id, method and params");
        }
    }
    json_t *params = json_object_get(message, "params");
    if (params && !json_is_object(params))
        return refuse(out_answer, id, LF_RPC_INVALID_PARAMS,
                      "\"params\" must be an object with parameters by name");
    out->params = params ? json_incref(params) : json_object();
    if (!out->params)
        return refuse(out_answer, id, LF_RPC_INTERNAL, "out of memory");
    return true;
}

bool lf_rpc_parse(const char *line, size_t n, lf_rpc_request *out, json_t **out_answer)
{
    *out = (lf_rpc_request){0};
    *out_answer = NULL;
    if (memchr(line, '\0', n))
        return refuse(out_answer, NULL, LF_RPC_PARSE_ERROR,
                      "not JSON: the line contains a zero byte");
    json_error_t error;
    out->message = json_loadb(line, n, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, &error);
    if (!out->message) {
        lf_error text;
        lf_error_set(&text, LF_E_FORMAT, "", "not JSON: column %d: %s", error.column, error.text);
        return refuse(out_answer, NULL, LF_RPC_PARSE_ERROR, text.what);
    }
    bool ok;
    if (json_is_array(out->message)) {
        ok = refuse(out_answer, NULL, LF_RPC_INVALID_REQUEST,
                    "batches are not supported; send one object per line");
    } else if (!json_is_object(out->message)) {
        ok = refuse(out_answer, NULL, LF_RPC_INVALID_REQUEST, "a request must be an object");
    } else {
        ok = parse_members(out, out_answer);
    }
    if (!ok)
        lf_rpc_request_finish(out);
    return ok;
}

void lf_rpc_request_finish(lf_rpc_request *request)
{
    json_decref(request->params);
    json_decref(request->message);
    *request = (lf_rpc_request){0};
}

/* json_pack takes ownership of its members even on failure; an absent id is sent as null. */
static json_t *id_or_null(const json_t *id)
{
    return id ? json_deep_copy(id) : json_null();
}

json_t *lf_rpc_result(const json_t *id, json_t *result)
{
    return json_pack("{s:s, s:o, s:o}", "jsonrpc", "2.0", "id", id_or_null(id), "result", result);
}

json_t *lf_rpc_error(const json_t *id, int code, const char *message, json_t *data)
{
    json_t *error = json_pack("{s:i, s:s, s:o*}", "code", code, "message", message, "data", data);
    return json_pack("{s:s, s:o, s:o}", "jsonrpc", "2.0", "id", id_or_null(id), "error", error);
}

json_t *lf_rpc_notification(const char *method, json_t *params)
{
    return json_pack("{s:s, s:s, s:o}", "jsonrpc", "2.0", "method", method, "params", params);
}

static int code_of(lf_status status, bool scene)
{
    switch (status) {
    case LF_E_PATH:
    case LF_E_EXISTS:
        return LF_RPC_PATH_REFUSED;
    case LF_E_NODEV:
        return LF_RPC_NO_DEVICE;
    case LF_E_BUSY:
    case LF_E_STATE:
        return LF_RPC_BUSY;
    case LF_E_NOMEM:
    case LF_E_ARG:
    case LF_E_FORMAT:
    case LF_E_IO:
        if (scene)
            return LF_RPC_BAD_SCENE;
        return status == LF_E_ARG ? LF_RPC_INVALID_PARAMS : LF_RPC_INTERNAL;
    case LF_E_TIMEOUT:
        return scene ? LF_RPC_BAD_SCENE : LF_RPC_TIMEOUT;
    case LF_OK:
    case LF_E_CANCELLED:
        break;
    }
    return LF_RPC_INTERNAL;
}

json_t *lf_rpc_text(const char *text)
{
    json_t *plain = json_string(text);
    char escaped[4 * PATH_MAX];
    if (!plain) {
        (void)lf_escape(escaped, sizeof escaped, text);
        plain = json_string(escaped);
    }
    return plain;
}

json_t *lf_rpc_error_saying(const json_t *id, const lf_error *err, bool scene, const char *message)
{
    json_t *data = json_object();
    if (err->where[0] != '\0')
        json_object_set_new(data, "file", lf_rpc_text(err->where));
    if (err->line > 0)
        json_object_set_new(data, "line", json_integer(err->line));
    if (err->pointer[0] != '\0' || scene)
        json_object_set_new(data, "pointer", lf_rpc_text(err->pointer));
    return lf_rpc_error(id, code_of(err->status, scene), message, data);
}

json_t *lf_rpc_error_of(const json_t *id, const lf_error *err, bool scene)
{
    char text[sizeof *err + 32];
    return lf_rpc_error_saying(id, err, scene, lf_error_format(err, text, sizeof text));
}
