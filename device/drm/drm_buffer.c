#include <errno.h>
#include <string.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "device/drm/drm.h"
#include "device/pixels.h"

enum { BYTES = 4, MAX_PITCH = 4 * LF_MAX_SIDE * BYTES };

static lf_status buffer_error(lf_error *err, int e, const char *what, int width, int height)
{
    return lf_error_set(err, e == ENOMEM || e == ENOSPC ? LF_E_NOMEM : LF_E_IO, "drm",
                        "cannot %s %dx%d pixels: %s", what, width, height, lf_errno_text(e));
}

lf_status lf_drm_buffer_init(const lf_kms_calls *kms, int fd, int width, int height,
                             lf_drm_buffer *out, lf_error *err)
{
    uint64_t size = 0;
    uint32_t pitch = 0;
    *out = (lf_drm_buffer){.all_stale = true};
    out->stale = lf_calloc(LF_DEVICE_MAX_RECTS, sizeof *out->stale);
    if (!out->stale)
        return lf_error_set(err, LF_E_NOMEM, "drm", "out of memory");
    int e = kms->buffer_create(fd, (uint32_t)width, (uint32_t)height, &out->handle, &pitch, &size);
    if (e != 0)
        return buffer_error(err, -e, "get video memory for", width, height);
    if (pitch < (uint32_t)width * BYTES || pitch > MAX_PITCH || pitch % BYTES != 0 ||
        size < (uint64_t)pitch * (uint64_t)height || size > (uint64_t)MAX_PITCH * LF_MAX_SIDE)
        return lf_error_set(err, LF_E_FORMAT, "drm",
                            "the driver returned a wrong buffer for %dx%d pixels: rows of %u "
                            "bytes, %llu bytes in total",
                            width, height, pitch, (unsigned long long)size);
    out->pitch = pitch;
    out->size = (size_t)size;
    e = kms->fb_add(fd, (uint32_t)width, (uint32_t)height, pitch, out->handle, &out->fb);
    if (e != 0)
        return buffer_error(err, -e, "register an image of", width, height);
    out->map = kms->buffer_map(fd, out->handle, out->size);
    if (!out->map)
        return buffer_error(err, errno, "map the video memory of", width, height);
    return LF_OK;
}

void lf_drm_buffer_finish(const lf_kms_calls *kms, int fd, lf_drm_buffer *buffer)
{
    if (buffer->map)
        kms->buffer_unmap(buffer->map, buffer->size);
    if (buffer->fb != 0)
        kms->fb_remove(fd, buffer->fb);
    if (buffer->handle != 0)
        kms->buffer_destroy(fd, buffer->handle);
    lf_free(buffer->stale);
    *buffer = (lf_drm_buffer){0};
}

void lf_drm_buffer_age(lf_drm_buffer *buffer, const lf_rect *rects, int n)
{
    if (buffer->all_stale || n > LF_DEVICE_MAX_RECTS - buffer->n_stale) {
        buffer->all_stale = true;
        return;
    }
    if (n > 0)
        memcpy(buffer->stale + buffer->n_stale, rects, (size_t)n * sizeof *rects);
    buffer->n_stale += n;
}

static uint64_t paint_rect(lf_drm_buffer *buffer, const lf_image8 *picture, const lf_rect *r)
{
    for (int y = r->y; y < r->y + r->height; y++) {
        uint8_t *to = buffer->map + (size_t)y * buffer->pitch + (size_t)r->x * BYTES;
        lf_pixels_xrgb8888(to, picture->data + (size_t)y * picture->stride + (size_t)r->x * 3,
                           r->width);
    }
    return (uint64_t)r->width * (uint64_t)r->height * BYTES;
}

uint64_t lf_drm_buffer_paint(lf_drm_buffer *buffer, const lf_image8 *picture)
{
    uint64_t bytes = 0;
    const lf_rect whole = {0, 0, picture->width, picture->height};
    if (buffer->all_stale)
        bytes = paint_rect(buffer, picture, &whole);
    else
        for (int i = 0; i < buffer->n_stale; i++)
            bytes += paint_rect(buffer, picture, &buffer->stale[i]);
    buffer->all_stale = false;
    buffer->n_stale = 0;
    return bytes;
}
