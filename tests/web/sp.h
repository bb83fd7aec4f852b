/* Messages of the older protocol: requests in CBOR, and answers as JSON. */
#ifndef LF_TESTS_WEB_SP_H
#define LF_TESTS_WEB_SP_H

#include "tests/testing.h"

#include <jansson.h>

#include "daemon/web/cbor.h"

static inline void sp_no_bin(void *context, const uint8_t *data, size_t n)
{
    (void)context;
    (void)data;
    (void)n;
    fail_msg("an answer has an image");
}

/* A message: the id, {cmd: the JSON in `cmd`, bin: data[n]}; no `bin` if data is NULL. *out_n
 * bytes, which the caller frees. */
static inline uint8_t *sp_request(uint32_t id, const char *cmd, const uint8_t *data, size_t n,
                                  size_t *out_n)
{
    json_t *value = json_loads(cmd, 0, NULL);
    uint8_t *body = NULL, *message;
    size_t n_body = 0, at = 0;
    assert_non_null(value);
    assert_int_equal(lf_cbor_write(value, &body, &n_body), LF_OK);
    message = malloc(n_body + n + 32);
    assert_non_null(message);
    for (int i = 3; i >= 0; i--)
        message[at++] = (uint8_t)(id >> 8 * i);
    message[at++] = data ? 0xa2 : 0xa1;
    memcpy(message + at,
           "\x63"
           "cmd",
           4);
    at += 4;
    memcpy(message + at, body, n_body);
    at += n_body;
    if (data) {
        memcpy(message + at,
               "\x63"
               "bin\x5a",
               5);
        at += 5;
        for (int i = 3; i >= 0; i--)
            message[at++] = (uint8_t)(n >> 8 * i);
        memcpy(message + at, data, n);
        at += n;
    }
    free(body);
    json_decref(value);
    *out_n = at;
    return message;
}

/* The answer in data[n], which must have this id. */
static inline json_t *sp_answer(uint32_t id, const uint8_t *data, size_t n)
{
    lf_cbor *cbor = NULL;
    lf_error err = {0};
    json_t *value = NULL;
    assert_true(n > 4);
    assert_int_equal(
        (uint32_t)data[0] << 24 | (uint32_t)data[1] << 16 | (uint32_t)data[2] << 8 | data[3], id);
    assert_int_equal(lf_cbor_create(sp_no_bin, NULL, &cbor), LF_OK);
    lf_cbor_take(cbor, data + 4, n - 4);
    lf_assert_ok(lf_cbor_finish(cbor, &value, &err), &err);
    lf_cbor_destroy(cbor);
    return value;
}

static inline int sp_error(const json_t *answer)
{
    const json_t *error = json_object_get(answer, "error");
    assert_true(json_is_integer(error));
    return (int)json_integer_value(error);
}

#endif
