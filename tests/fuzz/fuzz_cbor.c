/* Anything as a message in CBOR, in parts whose size the first byte says. Parts of another size
 * give the same, what is read can be written, and that is read as the same. */
#include "tests/fuzz/fuzz.h"

#include <string.h>

#include "daemon/web/cbor.h"

typedef struct heard {
    uint64_t n, sum;
} heard;

static void on_bin(void *context, const uint8_t *data, size_t n)
{
    heard *h = context;
    lf_fuzz_require(n > 0);
    for (size_t i = 0; i < n; i++)
        h->sum = h->sum * 31 + data[i];
    h->n += n;
}

/* NULL: it is refused. */
static json_t *read_all(const uint8_t *data, size_t n, size_t step, heard *h)
{
    lf_cbor *cbor = NULL;
    lf_error err = {0};
    json_t *value = NULL;
    *h = (heard){0};
    lf_fuzz_require(lf_cbor_create(on_bin, h, &cbor) == LF_OK);
    for (size_t at = 0; at < n; at += step)
        lf_cbor_take(cbor, data + at, n - at < step ? n - at : step);
    lf_status status = lf_cbor_finish(cbor, &value, &err);
    lf_fuzz_require(status == LF_OK || (status == LF_E_FORMAT && err.what[0] != '\0'));
    lf_cbor_destroy(cbor);
    return value;
}

static void check_written(json_t *value)
{
    uint8_t *data = NULL;
    size_t n = 0;
    heard h;
    lf_fuzz_require(lf_cbor_write(value, &data, &n) == LF_OK);
    json_t *back = read_all(data, n, n, &h);
    lf_fuzz_require(back && json_equal(back, value) && h.n == 0);
    json_decref(back);
    free(data);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    heard whole, parts;
    if (size < 1)
        return 0;
    json_t *value = read_all(data + 1, size - 1, size, &whole);
    json_t *other = read_all(data + 1, size - 1, (size_t)data[0] + 1, &parts);
    lf_fuzz_require(!value == !other && whole.n == parts.n && whole.sum == parts.sum);
    lf_fuzz_require(whole.n <= size);
    if (value) {
        lf_fuzz_require(json_equal(value, other));
        check_written(value);
    }
    json_decref(value);
    json_decref(other);
    return 0;
}
