/* CBOR of programs: what is read, what is refused, and how little a message can cost. */
#include "tests/testing.h"

#include "daemon/web/cbor.h"

typedef struct heard {
    uint8_t bytes[4096];
    size_t n;
} heard;

static void on_bin(void *context, const uint8_t *data, size_t n)
{
    heard *h = context;
    assert_true(n > 0);
    for (size_t i = 0; i < n; i++)
        if (h->n + i < sizeof h->bytes)
            h->bytes[h->n + i] = data[i];
    h->n += n;
}

/* Bytes of hexadecimal digits; blanks are left out. */
static size_t unhex(const char *hex, uint8_t *out)
{
    size_t n = 0;
    for (unsigned byte; *hex; hex += *hex == ' ' ? 1 : 2)
        if (*hex != ' ' && sscanf(hex, "%2x", &byte) == 1)
            out[n++] = (uint8_t)byte;
    return n;
}

/* In parts of `step` bytes. */
static lf_status read_bytes(const uint8_t *data, size_t n, size_t step, heard *h, json_t **out,
                            lf_error *err)
{
    lf_cbor *cbor = NULL;
    assert_int_equal(lf_cbor_create(on_bin, h, &cbor), LF_OK);
    for (size_t at = 0; at < n; at += step)
        lf_cbor_take(cbor, data + at, n - at < step ? n - at : step);
    lf_status status = lf_cbor_finish(cbor, out, err);
    lf_cbor_destroy(cbor);
    return status;
}

static void check(const char *hex, const char *json)
{
    uint8_t data[1024];
    const size_t n = unhex(hex, data);
    for (size_t step = 1; step <= n; step += step < 9 ? 1 : n) {
        heard h = {0};
        json_t *value = NULL;
        lf_error err = {0};
        lf_assert_ok(read_bytes(data, n, step, &h, &value, &err), &err);
        char *text = json_dumps(value, JSON_COMPACT | JSON_ENCODE_ANY);
        assert_string_equal(text, json);
        free(text);
        json_decref(value);
    }
}

static void check_refused(const char *hex, const char *words)
{
    uint8_t data[1024];
    const size_t n = unhex(hex, data);
    for (size_t step = 1; step <= n; step += step < 9 ? 1 : n) {
        heard h = {0};
        json_t *value = NULL;
        lf_error err = {0};
        lf_assert_status(read_bytes(data, n, step, &h, &value, &err), LF_E_FORMAT, &err);
        if (!strstr(err.what, words))
            fail_msg("%s: %s, expected %s", hex, err.what, words);
    }
}

/* Examples of RFC 8949, appendix A, that JSON can say. */
static void values_are_those_of_the_standard(void **state)
{
    (void)state;
    check("00", "0");
    check("17", "23");
    check("1818", "24");
    check("1903e8", "1000");
    check("1a000f4240", "1000000");
    check("1b000000e8d4a51000", "1000000000000");
    check("1bffffffffffffffff", "1.8446744073709552e19");
    check("3903e7", "-1000");
    check("3b7fffffffffffffff", "-9223372036854775808");
    check("3bffffffffffffffff", "-1.8446744073709552e19");
    check("f93c00", "1.0");
    check("f9c400", "-4.0");
    check("f90001", "5.9604644775390625e-8");
    check("f97bff", "65504.0");
    check("fa47c35000", "100000.0");
    check("fb3ff199999999999a", "1.1000000000000001");
    check("f4", "false");
    check("f5", "true");
    check("f6", "null");
    check("f7", "null");
    check("6449455446", "\"IETF\"");
    check("62c3bc", "\"\xc3\xbc\"");
    check("7f657374726561646d696e67ff", "\"streaming\"");
    check("7fff", "\"\"");
    check("80", "[]");
    check("8301820203820405", "[1,[2,3],[4,5]]");
    check("9f018202039f0405ffff", "[1,[2,3],[4,5]]");
    check("a0", "{}");
    check("a26161016162820203", "{\"a\":1,\"b\":[2,3]}");
    check("bf61610161629f0203ffff", "{\"a\":1,\"b\":[2,3]}");
    check("d9d9f7a0", "{}");
    check("c11a514b67b0", "1363896240");
}

/* The requests that a WebXR page and nngcat have sent. */
static void requests_of_programs_are_read(void **state)
{
    (void)state;
    check("a2 63636d64 a1 64696e666f a0 63 62696e f6", "{\"cmd\":{\"info\":{}},\"bin\":null}");
    check("a263636d64a164696e666fa06362696e60", "{\"cmd\":{\"info\":{}},\"bin\":\"\"}");
}

static void the_image_goes_by(void **state)
{
    (void)state;
    static const char *const forms[] = {"a1 6362696e 450102030405",
                                        "bf 6362696e 5f 42 0102 40 43 030405 ff ff",
                                        "a1 6362696e 5f 41 01 5803 020304 41 05 ff"};
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; i++) {
        uint8_t data[64];
        const size_t n = unhex(forms[i], data);
        for (size_t step = 1; step <= n; step++) {
            heard h = {0};
            json_t *value = NULL;
            lf_error err = {0};
            lf_assert_ok(read_bytes(data, n, step, &h, &value, &err), &err);
            assert_int_equal(json_integer_value(json_object_get(value, "bin")), 5);
            assert_int_equal(h.n, 5);
            assert_memory_equal(h.bytes, "\1\2\3\4\5", 5);
            json_decref(value);
        }
    }
    check("a1 6362696e 40", "{\"bin\":0}");
}

static void what_is_no_message_is_refused(void **state)
{
    (void)state;
    check_refused("18", "too early");
    check_refused("a1", "too early");
    check_refused("a16161", "too early");
    check_refused("6261", "too early");
    check_refused("7f", "too early");
    check_refused("9f", "too early");
    check_refused("d9d9f7", "too early");
    check_refused("a16362696e4101f6", "follows");
    check_refused("0000", "follows");
    check_refused("1c", "reserved");
    check_refused("3e", "reserved");
    check_refused("1f", "length");
    check_refused("df", "length");
    check_refused("ff", "break");
    check_refused("81ff", "break");
    check_refused("bf6161ff", "break");
    check_refused("a10101", "key");
    check_refused("a1f601", "key");
    check_refused("a18001", "key");
    check_refused("a1a001", "key");
    check_refused("a2616101616102", "twice");
    check_refused("f0", "simple");
    check_refused("f820", "simple");
    check_refused("f97c00", "finite");
    check_refused("f97e00", "finite");
    check_refused("fa7f800000", "finite");
    check_refused("61ff", "UTF-8");
    check_refused("6100", "zero");
    check_refused("7f6161 4161 ff", "chunk");
    check_refused("7f 7f 6161 ff ff", "chunk");
    check_refused("7f 01 ff", "chunk");
    check_refused("4101", "other than bin");
    check_refused("a161614101", "other than bin");
    check_refused("a1 6161 a1 6362696e 4101", "other than bin");
    check_refused("81 a1 6362696e 4101", "other than bin");
    check_refused("a1 4362696e 01", "other than bin");
}

static void depth_is_bounded(void **state)
{
    (void)state;
    uint8_t data[1 << 16];
    lf_error err = {0};
    heard h = {0};
    json_t *value = NULL;
    memset(data, 0x81, sizeof data);
    data[LF_CBOR_MAX_DEPTH] = 0;
    lf_assert_ok(read_bytes(data, LF_CBOR_MAX_DEPTH + 1, sizeof data, &h, &value, &err), &err);
    json_decref(value);
    data[LF_CBOR_MAX_DEPTH] = 0x81;
    lf_assert_status(read_bytes(data, sizeof data, 1000, &h, &value, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "deep"));
}

/* Announced lengths cost nothing, and what comes is counted. */
static void lengths_are_bounded(void **state)
{
    (void)state;
    static uint8_t data[(1 << 17) + 16];
    lf_error err = {0};
    heard h = {0};
    json_t *value = NULL;
    check_refused("9b7fffffffffffffff", "many");
    check_refused("bb8000000000000001", "many");
    check_refused("7b7fffffffffffffff", "long");
    check_refused("7a00010001", "long");
    memset(data, 0xf6, sizeof data);
    data[0] = 0x9f;
    lf_assert_status(read_bytes(data, sizeof data, 4096, &h, &value, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "many"));
    memset(data, 0xc1, sizeof data); /* tags count, too */
    lf_assert_status(read_bytes(data, sizeof data, 4096, &h, &value, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "many"));
    for (size_t i = 0; i < sizeof data; i++) /* chunks of a text */
        data[i] = i == 0 ? 0x7f : i % 2 == 1 ? 0x61 : 'a';
    lf_assert_status(read_bytes(data, sizeof data, 4096, &h, &value, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "many"));
    for (size_t i = 0; i < sizeof data; i++) /* large ones */
        data[i] = i == 0 ? 0x7f : (i - 1) % 258 == 0 ? 0x79 : (i - 1) % 258 == 1 ? 0 : 0xff;
    for (size_t i = 1; i + 258 < sizeof data; i += 258)
        memcpy(data + i, "\x79\x00\xff", 3), memset(data + i + 3, 'a', 255);
    lf_assert_status(read_bytes(data, sizeof data, 4096, &h, &value, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "long"));
}

/* An image in small chunks is not a message of many values. */
static void an_image_has_any_number_of_chunks(void **state)
{
    (void)state;
    static uint8_t data[6 + 3 * LF_CBOR_MAX_ITEMS + 1];
    lf_error err = {0};
    heard h = {0};
    json_t *value = NULL;
    size_t n = unhex("a1 6362696e 5f", data);
    while (n + 3 < sizeof data) {
        data[n++] = 0x41;
        data[n++] = 'x';
    }
    data[n++] = 0xff;
    lf_assert_ok(read_bytes(data, n, 4096, &h, &value, &err), &err);
    assert_int_equal(json_integer_value(json_object_get(value, "bin")), (json_int_t)h.n);
    assert_true(h.n > LF_CBOR_MAX_ITEMS);
    json_decref(value);
}

static void what_is_written_is_read(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "{}",
        "[]",
        "0",
        "-1",
        "23",
        "24",
        "255",
        "256",
        "65535",
        "65536",
        "4294967296",
        "-9223372036854775808",
        "9223372036854775807",
        "0.5",
        "-1e300",
        "true",
        "false",
        "null",
        "\"\xc3\xbc\"",
        "{\"error\":0,\"devices\":[{\"calibration\":{\"pitch\":{\"value\":52.5}}}]}"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        json_t *value = json_loads(texts[i], JSON_DECODE_ANY, NULL), *back = NULL;
        uint8_t *data = NULL;
        size_t n = 0;
        heard h = {0};
        lf_error err = {0};
        assert_non_null(value);
        assert_int_equal(lf_cbor_write(value, &data, &n), LF_OK);
        lf_assert_ok(read_bytes(data, n, 3, &h, &back, &err), &err);
        assert_true(json_equal(value, back));
        free(data);
        json_decref(value);
        json_decref(back);
    }
}

/* As the reply that satisfied a WebXR page. */
static void writing_takes_the_shortest_form(void **state)
{
    (void)state;
    uint8_t expected[64], *data = NULL;
    size_t n = 0;
    json_t *value = json_pack("{s:i, s:[], s:i, s:f}", "error", 0, "devices", "a", 324, "b", 0.5);
    const size_t n_expected = unhex(
        "a4 656572726f72 00 6764657669636573 80 6161 190144 6162 fb3fe0000000000000", expected);
    assert_int_equal(lf_cbor_write(value, &data, &n), LF_OK);
    assert_int_equal(n, n_expected);
    assert_memory_equal(data, expected, n);
    free(data);
    json_decref(value);
}

static void what_is_too_deep_is_not_written(void **state)
{
    (void)state;
    uint8_t *data = NULL;
    size_t n = 0;
    json_t *value = json_array();
    for (int i = 0; i <= LF_CBOR_MAX_DEPTH; i++)
        value = json_pack("[o]", value);
    assert_int_equal(lf_cbor_write(value, &data, &n), LF_E_ARG);
    assert_int_equal(lf_cbor_write(NULL, &data, &n), LF_E_ARG);
    json_decref(value);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_are_those_of_the_standard),
        cmocka_unit_test(requests_of_programs_are_read),
        cmocka_unit_test(the_image_goes_by),
        cmocka_unit_test(what_is_no_message_is_refused),
        cmocka_unit_test(depth_is_bounded),
        cmocka_unit_test(lengths_are_bounded),
        cmocka_unit_test(an_image_has_any_number_of_chunks),
        cmocka_unit_test(what_is_written_is_read),
        cmocka_unit_test(writing_takes_the_shortest_form),
        cmocka_unit_test(what_is_too_deep_is_not_written),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
