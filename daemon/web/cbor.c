#include "daemon/web/cbor.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"

/* Major types. */
enum { UNSIGNED, NEGATIVE, BYTES, TEXT, ARRAY, MAP, TAG, SIMPLE };
enum { ENDLESS = 31 }; /* no length; of a simple value: a break */

static const char where[] = "CBOR";

/* An array or a map that is not complete. */
typedef struct level {
    json_t *in;    /* borrowed: the outer value holds it */
    uint64_t left; /* values that follow; a pair of a map is two */
    bool endless;
    char *key; /* whose value follows; NULL: a key follows */
} level;

struct lf_cbor {
    lf_cbor_bin_fn bin;
    void *context;
    lf_error failed; /* its status is LF_OK until something fails */
    uint8_t head[9]; /* of the next item */
    size_t n_head;   /* bytes of it that are there */
    int string;      /* BYTES or TEXT: a string is read; else -1 */
    bool chunked;    /* … in chunks of its own lengths … */
    bool in_chunk;   /* … of which one is read */
    uint64_t left;   /* bytes of the string, or chunk, that follow */
    char *text;      /* [n_text] of the string; NULL: nothing yet */
    size_t n_text;
    uint64_t n_bin;
    size_t all_text; /* bytes of all texts */
    int items;
    level levels[LF_CBOR_MAX_DEPTH];
    int depth;
    json_t *root;
    bool done;
};

lf_status lf_cbor_create(lf_cbor_bin_fn bin, void *context, lf_cbor **out)
{
    lf_cbor *cbor = lf_calloc(1, sizeof *cbor);
    if (!cbor)
        return LF_E_NOMEM;
    *cbor = (lf_cbor){.bin = bin, .context = context, .string = -1};
    *out = cbor;
    return LF_OK;
}

void lf_cbor_destroy(lf_cbor *cbor)
{
    if (!cbor)
        return;
    for (int i = 0; i < cbor->depth; i++)
        lf_free(cbor->levels[i].key);
    lf_free(cbor->text);
    json_decref(cbor->root);
    lf_free(cbor);
}

static lf_status fail(lf_cbor *cbor, const char *what)
{
    return lf_error_set(&cbor->failed, LF_E_FORMAT, where, "%s", what);
}

static lf_status fail_memory(lf_cbor *cbor)
{
    return lf_error_set(&cbor->failed, LF_E_NOMEM, where, "out of memory");
}

/* ------------------------------------------------------------------------------------ values -- */

static level *innermost(lf_cbor *cbor)
{
    return cbor->depth > 0 ? &cbor->levels[cbor->depth - 1] : NULL;
}

/* Levels that have all their values are complete. */
static void close_levels(lf_cbor *cbor)
{
    while (cbor->depth > 0 && !innermost(cbor)->endless && innermost(cbor)->left == 0)
        cbor->depth--;
    cbor->done = cbor->depth == 0;
}

static lf_status add_key(lf_cbor *cbor, level *in, const json_t *value)
{
    if (!json_is_string(value))
        return fail(cbor, "a key is not a text");
    if (json_object_get(in->in, json_string_value(value)))
        return fail(cbor, "a key stands twice");
    in->key = lf_strdup(json_string_value(value));
    return in->key ? LF_OK : fail_memory(cbor);
}

/* Adds a value, which is taken, to the innermost level. NULL: out of memory. */
static lf_status add(lf_cbor *cbor, json_t *value)
{
    level *in = innermost(cbor);
    lf_status status = LF_OK;
    if (!value)
        return fail_memory(cbor);
    if (!in) {
        cbor->root = value;
        cbor->done = true;
        return LF_OK;
    }
    if (json_is_array(in->in)) {
        status = json_array_append_new(in->in, value) == 0 ? LF_OK : fail_memory(cbor);
    } else if (!in->key) {
        status = add_key(cbor, in, value);
        json_decref(value);
    } else {
        status = json_object_set_new(in->in, in->key, value) == 0 ? LF_OK : fail_memory(cbor);
        lf_free(in->key);
        in->key = NULL;
    }
    in->left -= in->endless ? 0 : 1;
    return status;
}

static lf_status add_scalar(lf_cbor *cbor, json_t *value)
{
    lf_status status = add(cbor, value);
    if (status == LF_OK)
        close_levels(cbor);
    return status;
}

static lf_status add_number(lf_cbor *cbor, double number)
{
    if (!isfinite(number))
        return fail(cbor, "a number is not finite");
    return add_scalar(cbor, json_real(number));
}

static lf_status open_level(lf_cbor *cbor, int major, bool endless, uint64_t n)
{
    level *parent = innermost(cbor);
    json_t *value = major == MAP ? json_object() : json_array();
    if (parent && json_is_object(parent->in) && !parent->key) {
        json_decref(value);
        return fail(cbor, "a key is not a text");
    }
    lf_status status = LF_OK;
    if (cbor->depth == LF_CBOR_MAX_DEPTH)
        status = fail(cbor, "the message is nested too deeply");
    else if (!endless && n > LF_CBOR_MAX_ITEMS)
        status = fail(cbor, "the message has too many values");
    if (status != LF_OK) {
        json_decref(value);
        return status;
    }
    status = add(cbor, value);
    if (status != LF_OK)
        return status;
    cbor->levels[cbor->depth++] =
        (level){.in = value, .left = major == MAP ? 2 * n : n, .endless = endless};
    close_levels(cbor);
    return LF_OK;
}

static lf_status close_endless(lf_cbor *cbor)
{
    const level *in = innermost(cbor);
    if (!in || !in->endless || in->key)
        return fail(cbor, "a break stands where a value is expected");
    cbor->depth--;
    close_levels(cbor);
    return LF_OK;
}

/* ----------------------------------------------------------------------------------- strings -- */

static lf_status end_string(lf_cbor *cbor)
{
    const bool is_text = cbor->string == TEXT;
    json_t *value = NULL;
    cbor->string = -1;
    if (!is_text)
        return add_scalar(cbor, json_integer((json_int_t)cbor->n_bin));
    if (cbor->n_text > 0 && memchr(cbor->text, '\0', cbor->n_text))
        return fail(cbor, "a text holds a zero byte");
    value = json_stringn(cbor->text ? cbor->text : "", cbor->n_text);
    lf_free(cbor->text);
    cbor->text = NULL;
    cbor->n_text = 0;
    return value ? add_scalar(cbor, value) : fail(cbor, "a text is not UTF-8");
}

/* True if the value that follows is `bin` of the outermost map. */
static bool expects_bin(lf_cbor *cbor)
{
    const level *in = innermost(cbor);
    return cbor->depth == 1 && in->key && strcmp(in->key, "bin") == 0;
}

/* A string, or a chunk of one, of n bytes begins. */
static lf_status begin_bytes(lf_cbor *cbor, int major, uint64_t n)
{
    if (major == TEXT && n > LF_CBOR_MAX_TEXT - cbor->all_text)
        return fail(cbor, "the texts are too long");
    if (major == TEXT && n > 0) {
        char *text = lf_calloc(cbor->n_text + (size_t)n, 1);
        if (!text)
            return fail_memory(cbor);
        if (cbor->text)
            memcpy(text, cbor->text, cbor->n_text);
        lf_free(cbor->text);
        cbor->text = text;
        cbor->all_text += (size_t)n;
    }
    cbor->left = n;
    cbor->in_chunk = true;
    return LF_OK;
}

/* All bytes of a string or chunk are there. */
static lf_status end_bytes(lf_cbor *cbor)
{
    cbor->in_chunk = false;
    return cbor->chunked ? LF_OK : end_string(cbor);
}

static lf_status begin_string(lf_cbor *cbor, int major, bool endless, uint64_t n)
{
    if (major == BYTES && !expects_bin(cbor))
        return fail(cbor, "a byte string other than bin");
    cbor->string = major;
    cbor->chunked = endless;
    cbor->n_bin = 0;
    if (endless)
        return LF_OK;
    lf_status status = begin_bytes(cbor, major, n);
    return status == LF_OK && n == 0 ? end_bytes(cbor) : status;
}

/* Takes up to n bytes of a string; *out_used: how many. */
static lf_status take_string(lf_cbor *cbor, const uint8_t *data, size_t n, size_t *out_used)
{
    const size_t used = n < cbor->left ? n : (size_t)cbor->left;
    *out_used = used;
    if (cbor->string == TEXT) {
        memcpy(cbor->text + cbor->n_text, data, used);
        cbor->n_text += used;
    } else {
        cbor->n_bin += used;
        cbor->bin(cbor->context, data, used);
    }
    cbor->left -= used;
    return cbor->left == 0 ? end_bytes(cbor) : LF_OK;
}

/* ------------------------------------------------------------------------------------- heads -- */

/* RFC 8949, appendix D. */
static double half_of(uint64_t bits)
{
    const int exponent = (int)(bits >> 10 & 31), fraction = (int)(bits & 1023);
    const double size = exponent == 0    ? ldexp(fraction, -24)
                        : exponent == 31 ? (fraction == 0 ? (double)INFINITY : (double)NAN)
                                         : ldexp(fraction + 1024, exponent - 25);
    return bits & 0x8000 ? -size : size;
}

static double single_of(uint64_t bits)
{
    const uint32_t word = (uint32_t)bits;
    float number;
    memcpy(&number, &word, sizeof number);
    return (double)number;
}

static double double_of(uint64_t bits)
{
    double number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

static lf_status take_simple(lf_cbor *cbor, int info, uint64_t bits)
{
    switch (info) {
    case 20:
    case 21:
        return add_scalar(cbor, json_boolean(info == 21));
    case 22:
    case 23: /* undefined */
        return add_scalar(cbor, json_null());
    case 25:
        return add_number(cbor, half_of(bits));
    case 26:
        return add_number(cbor, single_of(bits));
    case 27:
        return add_number(cbor, double_of(bits));
    default:
        return fail(cbor, "a simple value has no meaning");
    }
}

static lf_status take_integer(lf_cbor *cbor, bool negative, uint64_t n)
{
    if (n > INT64_MAX)
        return add_number(cbor, negative ? -1.0 - (double)n : (double)n);
    return add_scalar(cbor, json_integer(negative ? -1 - (json_int_t)n : (json_int_t)n));
}

/* A head within a string of chunks. */
static lf_status take_chunk(lf_cbor *cbor, int major, int info, uint64_t n)
{
    if (major == SIMPLE && info == ENDLESS)
        return end_string(cbor);
    if (major != cbor->string || info == ENDLESS)
        return fail(cbor, "a string has a chunk of another kind");
    lf_status status = begin_bytes(cbor, major, n);
    return status == LF_OK && n == 0 ? end_bytes(cbor) : status;
}

static lf_status take_item(lf_cbor *cbor, int major, int info, uint64_t n)
{
    const bool endless = info == ENDLESS;
    if (cbor->string != BYTES && ++cbor->items > LF_CBOR_MAX_ITEMS)
        return fail(cbor, "the message has too many values");
    if (cbor->string >= 0)
        return take_chunk(cbor, major, info, n);
    if (cbor->done)
        return fail(cbor, "something follows the message");
    if (major == SIMPLE && endless)
        return close_endless(cbor);
    if (endless && (major == UNSIGNED || major == NEGATIVE || major == TAG))
        return fail(cbor, "a number has no length");
    switch (major) {
    case UNSIGNED:
    case NEGATIVE:
        return take_integer(cbor, major == NEGATIVE, n);
    case BYTES:
    case TEXT:
        return begin_string(cbor, major, endless, n);
    case ARRAY:
    case MAP:
        return open_level(cbor, major, endless, n);
    case TAG:
        return LF_OK;
    default:
        return take_simple(cbor, info, n);
    }
}

/* Bytes that follow the first of a head; -1: there is no such head. */
static int argument_bytes(uint8_t first)
{
    const int info = first & 31;
    return info < 24 || info == ENDLESS ? 0 : info < 28 ? 1 << (info - 24) : -1;
}

/* Takes one byte of a head. */
static lf_status take_head(lf_cbor *cbor, uint8_t byte)
{
    uint64_t n = 0;
    cbor->head[cbor->n_head++] = byte;
    const int more = argument_bytes(cbor->head[0]), info = cbor->head[0] & 31;
    if (more < 0)
        return fail(cbor, "a head is reserved");
    if (cbor->n_head < 1 + (size_t)more)
        return LF_OK;
    for (int i = 1; i <= more; i++)
        n = n << 8 | cbor->head[i];
    cbor->n_head = 0;
    return take_item(cbor, cbor->head[0] >> 5, info, more == 0 ? (uint64_t)info : n);
}

void lf_cbor_take(lf_cbor *cbor, const uint8_t *data, size_t n)
{
    lf_status status = cbor->failed.status;
    for (size_t at = 0, used = 1; at < n && status == LF_OK; at += used) {
        used = 1;
        if (cbor->string >= 0 && cbor->in_chunk)
            status = take_string(cbor, data + at, n - at, &used);
        else
            status = take_head(cbor, data[at]);
    }
}

lf_status lf_cbor_finish(lf_cbor *cbor, json_t **out, lf_error *err)
{
    lf_status status = cbor->failed.status;
    if (status == LF_OK && (!cbor->done || cbor->n_head > 0 || cbor->string >= 0))
        status = fail(cbor, "the message ends too early");
    if (status == LF_OK)
        *out = json_incref(cbor->root);
    else if (err)
        *err = cbor->failed;
    return status;
}

/* ----------------------------------------------------------------------------------- writing -- */

static void write_head(FILE *out, int major, uint64_t n)
{
    const int size = n < 24            ? 0
                     : n <= UINT8_MAX  ? 1
                     : n <= UINT16_MAX ? 2
                     : n <= UINT32_MAX ? 4
                                       : 8;
    const int info = size == 0 ? (int)n : size == 1 ? 24 : size == 2 ? 25 : size == 4 ? 26 : 27;
    fputc(major << 5 | info, out);
    for (int i = size - 1; i >= 0; i--)
        fputc((int)(n >> 8 * i & 255), out);
}

static void write_text(FILE *out, const char *text, size_t n)
{
    write_head(out, TEXT, n);
    fwrite(text, 1, n, out);
}

static void write_real(FILE *out, double number)
{
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    fputc(SIMPLE << 5 | 27, out);
    for (int i = 7; i >= 0; i--)
        fputc((int)(bits >> 8 * i & 255), out);
}

static bool write_value(FILE *out, json_t *value, int depth);

static bool write_array(FILE *out, json_t *value, int depth)
{
    bool written = true;
    write_head(out, ARRAY, json_array_size(value));
    for (size_t i = 0; i < json_array_size(value) && written; i++)
        written = write_value(out, json_array_get(value, i), depth);
    return written;
}

static bool write_map(FILE *out, json_t *value, int depth)
{
    json_t *member;
    const char *key;
    bool written = true;
    write_head(out, MAP, json_object_size(value));
    json_object_foreach(value, key, member)
    {
        write_text(out, key, strlen(key));
        written = written && write_value(out, member, depth);
    }
    return written;
}

static bool write_value(FILE *out, json_t *value, int depth)
{
    const json_int_t n = json_integer_value(value);
    switch (value && depth <= LF_CBOR_MAX_DEPTH ? (int)json_typeof(value) : -1) {
    case JSON_OBJECT:
        return write_map(out, value, depth + 1);
    case JSON_ARRAY:
        return write_array(out, value, depth + 1);
    case JSON_STRING:
        write_text(out, json_string_value(value), json_string_length(value));
        return true;
    case JSON_INTEGER:
        write_head(out, n < 0 ? NEGATIVE : UNSIGNED, (uint64_t)(n < 0 ? -1 - n : n));
        return true;
    case JSON_REAL:
        write_real(out, json_real_value(value));
        return true;
    case JSON_TRUE:
    case JSON_FALSE:
    case JSON_NULL:
        fputc(SIMPLE << 5 | (json_is_true(value) ? 21 : json_is_false(value) ? 20 : 22), out);
        return true;
    default:
        return false;
    }
}

lf_status lf_cbor_write(json_t *value, uint8_t **out_data, size_t *out_n)
{
    char *data = NULL;
    size_t n = 0;
    FILE *out = open_memstream(&data, &n);
    if (!out)
        return LF_E_NOMEM;
    const bool written = write_value(out, value, 0), lost = ferror(out) != 0;
    if (fclose(out) != 0 || lost || !written) {
        free(data);
        return written ? LF_E_NOMEM : LF_E_ARG;
    }
    *out_data = (uint8_t *)data;
    *out_n = n;
    return LF_OK;
}
