/* Any line of a client's, up to what would run its method: a request with parameters that fit the
 * method's own schema, or an answer in the protocol's form. The line is also read as one of
 * quiltctl's arguments for every method. */
#include "tests/fuzz/fuzz.h"

#include <string.h>

#include "base/alloc.h"
#include "daemon/server/methods.h"
#include "daemon/wire/rpc.h"

static void check_answer(json_t *answer)
{
    lf_fuzz_require(answer);
    const json_t *error = json_object_get(answer, "error");
    lf_fuzz_require(json_integer_value(json_object_get(error, "code")) < 0);
    lf_fuzz_require_text(json_string_value(json_object_get(error, "message")));
    char *text = json_dumps(answer, JSON_COMPACT);
    lf_fuzz_require(text && !strchr(text, '\n'));
    free(text);
    json_decref(answer);
}

static void check_schema(const json_t *schema, json_t *params, const json_t *id)
{
    lf_error err = {0};
    lf_status status = lf_schema_check(schema, params, "fuzz", &err);
    lf_fuzz_require(status == LF_OK || (status == LF_E_ARG && err.what[0] != 0));
    if (status != LF_OK)
        check_answer(lf_rpc_error_of(id, &err, false));
}

static void request(const char *line, size_t n)
{
    lf_rpc_request request;
    json_t *answer = NULL;
    if (!lf_rpc_parse(line, n, &request, &answer)) {
        check_answer(answer);
        return;
    }
    lf_fuzz_require(!answer && request.method && json_is_object(request.params));
    for (int i = 0; lf_method_at(i); i++)
        if (strcmp(lf_method_at(i)->name, request.method) == 0)
            check_schema(lf_method_schema(i), request.params, request.id);
    lf_rpc_request_finish(&request);
}

static void argument(const char *text)
{
    for (int i = 0; lf_method_at(i); i++) {
        json_t *params = json_object();
        lf_error err = {0};
        if (lf_schema_argument(lf_method_schema(i), text, params, &err) == LF_OK)
            check_schema(lf_method_schema(i), params, NULL);
        else
            lf_fuzz_require(err.what[0] != 0);
        json_decref(params);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *text = lf_calloc(size + 1, 1);
    lf_fuzz_require(text);
    memcpy(text, data, size);
    request(text, size);
    argument(text);
    lf_free(text);
    return 0;
}
