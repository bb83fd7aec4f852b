#include "daemon/web/bmp.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"

/* Offsets in the file: file header, info header, and the masks behind its 40 bytes. */
enum { PIXELS_AT = 10, INFO_AT = 14, WIDTH_AT = 18, HEIGHT_AT = 22, BITS_AT = 28, METHOD_AT = 30 };
enum { MASKS_AT = 54, HEAD = 54, HEAD_WITH_MASKS = 66, MIN_INFO = 40, MAX_PIXELS_AT = 65536 };
enum { UNCOMPRESSED = 0, BIT_FIELDS = 3 };

static const char where[] = "BMP";

struct lf_bmp {
    int fd;
    uint64_t limit, at; /* at: bytes that were taken */
    uint8_t head[HEAD_WITH_MASKS];
    size_t n_head;      /* bytes that the head has, as far as is known */
    uint32_t pixels_at; /* 0: the head is not complete */
    int width, height, bytes;
    bool from_top;
    uint8_t *row, *rgb; /* [stride] as it comes; [3 width] */
    size_t stride, used;
    int n_rows; /* rows that are written */
};

lf_status lf_bmp_create(int fd, uint64_t limit, lf_bmp **out)
{
    lf_bmp *bmp = lf_calloc(1, sizeof *bmp);
    if (!bmp)
        return LF_E_NOMEM;
    *bmp = (lf_bmp){.fd = fd, .limit = limit, .n_head = HEAD};
    *out = bmp;
    return LF_OK;
}

void lf_bmp_destroy(lf_bmp *bmp)
{
    if (!bmp)
        return;
    lf_free(bmp->row);
    lf_free(bmp->rgb);
    lf_free(bmp);
}

static uint32_t word_at(const lf_bmp *bmp, int offset)
{
    const uint8_t *b = bmp->head + offset;
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* Blue, green, red, and a byte of no meaning. */
static bool has_usual_masks(const lf_bmp *bmp)
{
    return word_at(bmp, MASKS_AT) == 0xff0000 && word_at(bmp, MASKS_AT + 4) == 0xff00 &&
           word_at(bmp, MASKS_AT + 8) == 0xff;
}

static lf_status check_kind(const lf_bmp *bmp, lf_error *err)
{
    const uint32_t bits = word_at(bmp, BITS_AT) & 0xffff, method = word_at(bmp, METHOD_AT);
    const bool known =
        (bits == 24 && method == UNCOMPRESSED) ||
        (bits == 32 && (method == UNCOMPRESSED || (method == BIT_FIELDS && has_usual_masks(bmp))));
    if (memcmp(bmp->head, "BM", 2) != 0 || word_at(bmp, INFO_AT) < MIN_INFO || !known)
        return lf_error_set(err, LF_E_FORMAT, where,
                            "expects 24 or 32 bits per pixel without compression");
    if (word_at(bmp, PIXELS_AT) < bmp->n_head || word_at(bmp, PIXELS_AT) > MAX_PIXELS_AT)
        return lf_error_set(err, LF_E_FORMAT, where, "the pixels do not follow the header");
    return LF_OK;
}

/* The head is there. */
static lf_status begin_pixels(lf_bmp *bmp, lf_error *err)
{
    if (bmp->n_head == HEAD && word_at(bmp, METHOD_AT) == BIT_FIELDS) {
        bmp->n_head = HEAD_WITH_MASKS;
        return LF_OK;
    }
    lf_status status = check_kind(bmp, err);
    if (status != LF_OK)
        return status;
    const int64_t width = (int32_t)word_at(bmp, WIDTH_AT);
    const int64_t signed_height = (int32_t)word_at(bmp, HEIGHT_AT);
    const int64_t height = signed_height < 0 ? -signed_height : signed_height;
    if (width < 1 || height < 1 || width > LF_BMP_MAX_SIDE || height > LF_BMP_MAX_SIDE)
        return lf_error_set(err, LF_E_FORMAT, where, "expects sides of 1 to %d pixels",
                            LF_BMP_MAX_SIDE);
    if ((uint64_t)(3 * width * height) > bmp->limit)
        return lf_error_set(err, LF_E_FORMAT, where,
                            "%dx%d pixels are more than quiltweb takes; see --image-limit",
                            (int)width, (int)height);
    bmp->bytes = (int)(word_at(bmp, BITS_AT) & 0xffff) / 8;
    bmp->width = (int)width;
    bmp->height = (int)height;
    bmp->from_top = signed_height < 0;
    bmp->stride = ((size_t)width * (size_t)bmp->bytes + 3) / 4 * 4;
    bmp->row = lf_calloc(bmp->stride, 1);
    bmp->rgb = lf_calloc((size_t)width, 3);
    if (!bmp->row || !bmp->rgb)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    bmp->pixels_at = word_at(bmp, PIXELS_AT);
    return LF_OK;
}

static lf_status write_row(lf_bmp *bmp, lf_error *err)
{
    const size_t n = 3 * (size_t)bmp->width;
    const int y = bmp->from_top ? bmp->n_rows : bmp->height - 1 - bmp->n_rows;
    for (int x = 0; x < bmp->width; x++) {
        const uint8_t *bgr = bmp->row + x * bmp->bytes;
        bmp->rgb[3 * x] = bgr[2];
        bmp->rgb[3 * x + 1] = bgr[1];
        bmp->rgb[3 * x + 2] = bgr[0];
    }
    for (size_t done = 0; done < n;) {
        const ssize_t more =
            pwrite(bmp->fd, bmp->rgb + done, n - done, (off_t)((size_t)y * n + done));
        if (more <= 0)
            return lf_error_set(err, LF_E_IO, where, "cannot keep the pixels: %s",
                                lf_errno_text(errno));
        done += (size_t)more;
    }
    bmp->n_rows++;
    bmp->used = 0;
    return LF_OK;
}

/* Takes what belongs to the head, to the gap behind it or to one row; *out_used: bytes. */
static lf_status take_some(lf_bmp *bmp, const uint8_t *data, size_t n, size_t *out_used,
                           lf_error *err)
{
    size_t used = n;
    lf_status status = LF_OK;
    if (bmp->pixels_at == 0) {
        used = n < bmp->n_head - bmp->at ? n : bmp->n_head - (size_t)bmp->at;
        memcpy(bmp->head + bmp->at, data, used);
        if (bmp->at + used == bmp->n_head)
            status = begin_pixels(bmp, err);
    } else if (bmp->at < bmp->pixels_at) {
        used = n < bmp->pixels_at - bmp->at ? n : bmp->pixels_at - (size_t)bmp->at;
    } else if (bmp->n_rows < bmp->height) {
        used = n < bmp->stride - bmp->used ? n : bmp->stride - bmp->used;
        memcpy(bmp->row + bmp->used, data, used);
        bmp->used += used;
        if (bmp->used == bmp->stride)
            status = write_row(bmp, err);
    }
    *out_used = used;
    return status;
}

lf_status lf_bmp_take(lf_bmp *bmp, const uint8_t *data, size_t n, lf_error *err)
{
    lf_status status = LF_OK;
    for (size_t done = 0, used = 0; done < n && status == LF_OK; done += used) {
        status = take_some(bmp, data + done, n - done, &used, err);
        bmp->at += used;
    }
    return status;
}

lf_status lf_bmp_finish(const lf_bmp *bmp, int *out_width, int *out_height, lf_error *err)
{
    if (bmp->pixels_at == 0 || bmp->n_rows < bmp->height)
        return lf_error_set(err, LF_E_FORMAT, where, "the bitmap ends too early");
    *out_width = bmp->width;
    *out_height = bmp->height;
    return LF_OK;
}
