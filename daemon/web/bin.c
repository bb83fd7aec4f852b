#include "daemon/web/bin.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "daemon/web/bmp.h"
#include "daemon/web/memory.h"

enum { MAGIC = 2 }; /* "BM" */

static const char where[] = "bin";

struct lf_bin {
    lf_bins *bins;
    int fd;     /* -1: no byte came, or it has failed */
    uint64_t n; /* bytes taken, which the common limit counts */
    uint8_t magic[MAGIC];
    lf_bmp *bmp; /* NULL: not a bitmap */
    int width, height;
    lf_error failed; /* its status is LF_OK until something fails */
};

lf_status lf_bin_create(lf_bins *bins, lf_bin **out)
{
    lf_bin *bin = lf_calloc(1, sizeof *bin);
    if (!bin)
        return LF_E_NOMEM;
    *bin = (lf_bin){.bins = bins, .fd = -1};
    *out = bin;
    return LF_OK;
}

static void forget(lf_bin *bin)
{
    bin->bins->used -= bin->n;
    bin->n = 0;
    lf_bmp_destroy(bin->bmp);
    bin->bmp = NULL;
    if (bin->fd >= 0)
        close(bin->fd);
    bin->fd = -1;
}

void lf_bin_destroy(lf_bin *bin)
{
    if (!bin)
        return;
    forget(bin);
    lf_free(bin);
}

static lf_status check_room(lf_bin *bin, size_t n)
{
    lf_bins *bins = bin->bins;
    if (n > bins->limit - bin->n)
        return lf_error_set(&bin->failed, LF_E_ARG, where,
                            "the image is larger than %llu MiB; start quiltweb with a larger "
                            "--image-limit",
                            (unsigned long long)(bins->limit >> 20));
    while (bins->used + n > 2 * bins->limit)
        if (!bins->make_room(bins->context))
            return lf_error_set(&bin->failed, LF_E_BUSY, where,
                                "too many images at once; try again later");
    return LF_OK;
}

static lf_status write_file(lf_bin *bin, const uint8_t *data, size_t n)
{
    for (size_t done = 0; done < n;) {
        const ssize_t more = write(bin->fd, data + done, n - done);
        if (more <= 0)
            return lf_error_set(&bin->failed, LF_E_IO, where, "cannot keep the image: %s",
                                lf_errno_text(errno));
        done += (size_t)more;
    }
    return LF_OK;
}

/* The first bytes are there: they say what the rest is. */
static lf_status begin(lf_bin *bin)
{
    lf_status status = lf_memory_create(&bin->fd, &bin->failed);
    if (status != LF_OK)
        return status;
    if (memcmp(bin->magic, "BM", MAGIC) != 0)
        return write_file(bin, bin->magic, MAGIC);
    if (lf_bmp_create(bin->fd, bin->bins->limit, &bin->bmp) != LF_OK)
        return lf_error_set(&bin->failed, LF_E_NOMEM, where, "out of memory");
    return lf_bmp_take(bin->bmp, bin->magic, MAGIC, &bin->failed);
}

static lf_status take(lf_bin *bin, const uint8_t *data, size_t n)
{
    lf_status status = check_room(bin, n);
    if (status != LF_OK)
        return status;
    while (n > 0 && bin->n < MAGIC && status == LF_OK) {
        bin->magic[bin->n++] = *data++;
        bin->bins->used++;
        n--;
        if (bin->n == MAGIC)
            status = begin(bin);
    }
    bin->n += n;
    bin->bins->used += n;
    if (n == 0 || status != LF_OK)
        return status;
    return bin->bmp ? lf_bmp_take(bin->bmp, data, n, &bin->failed) : write_file(bin, data, n);
}

void lf_bin_take(lf_bin *bin, const uint8_t *data, size_t n)
{
    if (bin->failed.status == LF_OK && take(bin, data, n) != LF_OK)
        forget(bin);
}

lf_status lf_bin_finish(lf_bin *bin, lf_error *err)
{
    lf_status status = bin->failed.status;
    if (status == LF_OK && bin->n < MAGIC)
        status = lf_error_set(&bin->failed, LF_E_ARG, where, "the message has no image");
    if (status == LF_OK && bin->bmp)
        status = lf_bmp_finish(bin->bmp, &bin->width, &bin->height, &bin->failed);
    if (status == LF_OK)
        status = lf_memory_seal(bin->fd, &bin->failed);
    if (status == LF_OK)
        return LF_OK;
    forget(bin);
    if (err)
        *err = bin->failed;
    return status;
}

int lf_bin_fd(const lf_bin *bin)
{
    return bin->fd;
}

int lf_bin_width(const lf_bin *bin)
{
    return bin->width;
}

int lf_bin_height(const lf_bin *bin)
{
    return bin->height;
}
