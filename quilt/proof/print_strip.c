#include "quilt/proof/print_strip.h"

#include <string.h>
#include <zlib.h>

#include "base/alloc.h"

#define IN_BYTES (32 << 10)

enum { LZW_CLEAR = 256, LZW_END = 257, LZW_FIRST = 258, LZW_CODES = 4096 };

/* The code words of TIFF's LZW: a word is that of its prefix and one more byte. */
typedef struct lzw {
    uint32_t bits; /* read and not used, the last n_bits of it */
    int n_bits, width, next, last;
    uint16_t prefix[LZW_CODES], length[LZW_CODES];
    uint8_t suffix[LZW_CODES], word[LZW_CODES];
    int word_at, word_end; /* of the current word, what was not yet given out */
    bool ended;
} lzw;

struct lf_strip {
    const lf_tiff *tiff;
    uint64_t at, left; /* of the strip, in the file */
    uint8_t in[IN_BYTES];
    size_t in_at, in_end;
    z_stream zip;
    lzw lzw;
};

/* Reads more of the strip into the empty buffer. False: it has ended. */
static bool fill(lf_strip *strip)
{
    const size_t n = strip->left < IN_BYTES ? (size_t)strip->left : IN_BYTES;
    strip->in_at = strip->in_end = 0;
    if (n == 0 || !lf_tiff_bytes(strip->tiff, strip->at, strip->in, n))
        return false;
    strip->at += n;
    strip->left -= n;
    strip->in_end = n;
    return true;
}

/* --------------------------------------------------------------------------------------- LZW -- */

static void lzw_reset(lzw *z)
{
    z->width = 9;
    z->next = LZW_FIRST;
    z->last = -1;
}

static void lzw_begin(lzw *z)
{
    z->bits = 0;
    z->n_bits = z->word_at = z->word_end = 0;
    z->ended = false;
    for (int i = 0; i < 256; i++) {
        z->length[i] = 1;
        z->suffix[i] = (uint8_t)i;
    }
    lzw_reset(z);
}

/* -1: the strip has ended. */
static int lzw_code(lf_strip *strip)
{
    lzw *z = &strip->lzw;
    while (z->n_bits < z->width) {
        if (strip->in_at == strip->in_end && !fill(strip))
            return -1;
        z->bits = z->bits << 8 | strip->in[strip->in_at++];
        z->n_bits += 8;
    }
    z->n_bits -= z->width;
    return (int)(z->bits >> z->n_bits & ((1U << z->width) - 1));
}

/* Unfolds a word; returns its first byte. */
static uint8_t lzw_unfold(lzw *z, int code)
{
    z->word_at = 0;
    z->word_end = z->length[code];
    for (int i = z->word_end; i-- > 0; code = z->prefix[code])
        z->word[i] = z->suffix[code];
    return z->word[0];
}

/* Adds the word of the last code and one more byte. */
static void lzw_learn(lzw *z, uint8_t byte)
{
    z->prefix[z->next] = (uint16_t)z->last;
    z->suffix[z->next] = byte;
    z->length[z->next] = (uint16_t)(z->length[z->last] + 1);
    z->next++;
    /* the width grows one code early */
    if (z->next >= (1 << z->width) - 1 && z->width < 12)
        z->width++;
}

/* Takes codes up to the next word. False: damaged, or the strip has ended. */
static bool lzw_next(lf_strip *strip)
{
    lzw *z = &strip->lzw;
    int code = z->ended ? LZW_END : lzw_code(strip);
    while (code == LZW_CLEAR) {
        lzw_reset(z);
        code = lzw_code(strip);
    }
    z->ended = code == LZW_END;
    if (code < 0 || z->ended || code > z->next || (z->last < 0 && code >= 256) ||
        (code == z->next && z->next >= LZW_CODES))
        return false;
    if (code == z->next) { /* the last word and its own first byte */
        lzw_learn(z, lzw_unfold(z, z->last));
        lzw_unfold(z, code);
    } else {
        const uint8_t first = lzw_unfold(z, code);
        if (z->last >= 0 && z->next < LZW_CODES)
            lzw_learn(z, first);
    }
    z->last = code;
    return true;
}

static bool lzw_read(lf_strip *strip, uint8_t *out, size_t n)
{
    lzw *z = &strip->lzw;
    while (n > 0) {
        if (z->word_at == z->word_end && !lzw_next(strip))
            return false;
        const size_t left = (size_t)(z->word_end - z->word_at), some = n < left ? n : left;
        memcpy(out, z->word + z->word_at, some);
        z->word_at += (int)some;
        out += some;
        n -= some;
    }
    return true;
}

/* ----------------------------------------------------------------------------- the other two -- */

static bool zip_read(lf_strip *strip, uint8_t *out, size_t n)
{
    z_stream *zip = &strip->zip;
    zip->next_out = out;
    zip->avail_out = (uInt)n;
    while (zip->avail_out > 0) {
        if (strip->in_at == strip->in_end)
            fill(strip); /* at the end, zlib may still hold some bytes */
        zip->next_in = strip->in + strip->in_at;
        zip->avail_in = (uInt)(strip->in_end - strip->in_at);
        const int result = inflate(zip, Z_NO_FLUSH);
        strip->in_at = strip->in_end - zip->avail_in;
        if (result != Z_OK && !(result == Z_STREAM_END && zip->avail_out == 0))
            return false;
    }
    return true;
}

static bool plain_read(lf_strip *strip, uint8_t *out, size_t n)
{
    if (n > strip->left || !lf_tiff_bytes(strip->tiff, strip->at, out, n))
        return false;
    strip->at += n;
    strip->left -= n;
    return true;
}

/* ------------------------------------------------------------------------------------ public -- */

lf_status lf_strip_create(const lf_tiff *tiff, lf_strip **out)
{
    lf_strip *strip = lf_calloc(1, sizeof *strip);
    if (!strip)
        return LF_E_NOMEM;
    strip->tiff = tiff;
    if (inflateInit(&strip->zip) != Z_OK) {
        lf_free(strip);
        return LF_E_NOMEM;
    }
    *out = strip;
    return LF_OK;
}

void lf_strip_destroy(lf_strip *strip)
{
    if (!strip)
        return;
    inflateEnd(&strip->zip);
    lf_free(strip);
}

bool lf_strip_begin(lf_strip *strip, int number)
{
    const lf_tiff *tiff = strip->tiff;
    strip->in_at = strip->in_end = 0;
    strip->left = 0;
    lzw_begin(&strip->lzw);
    return inflateReset(&strip->zip) == Z_OK &&
           lf_tiff_element(tiff, &tiff->offsets, (uint64_t)number, &strip->at) &&
           lf_tiff_element(tiff, &tiff->byte_counts, (uint64_t)number, &strip->left) &&
           strip->at <= tiff->size && strip->left <= tiff->size - strip->at;
}

bool lf_strip_read(lf_strip *strip, void *out, size_t n)
{
    const int compression = strip->tiff->tags.compression;
    return compression == 1   ? plain_read(strip, out, n)
           : compression == 5 ? lzw_read(strip, out, n)
                              : zip_read(strip, out, n);
}

bool lf_strip_skip(lf_strip *strip, uint64_t n)
{
    if (n > strip->left)
        return false;
    strip->at += n;
    strip->left -= n;
    return true;
}
