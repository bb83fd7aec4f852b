#include "base/image_metadata.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Longer lines do not fit into a warning. */
enum { LINE = 480 };

static bool is_there(const lf_image_notes *notes, const char *line, size_t length)
{
    const char *at = notes->text, *end = notes->text + notes->length;
    while (at < end) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        if ((size_t)(stop - at) == length && memcmp(at, line, length) == 0)
            return true;
        at = stop + 1;
    }
    return false;
}

void lf_image_note(lf_image_notes *notes, const char *fmt, ...)
{
    char line[LINE];
    va_list arguments;
    if (!notes)
        return;
    va_start(arguments, fmt);
    vsnprintf(line, sizeof line, fmt, arguments);
    va_end(arguments);
    size_t length = strlen(line);
    for (size_t i = 0; i < length; i++)
        if ((unsigned char)line[i] < 0x20 || line[i] == 0x7f)
            line[i] = '?';
    if (length == 0 || length >= sizeof notes->text - notes->length ||
        is_there(notes, line, length))
        return;
    memcpy(notes->text + notes->length, line, length);
    notes->length += length;
    notes->text[notes->length++] = '\n';
}

void lf_image_note_lines(lf_image_notes *notes, const char *text, size_t length)
{
    for (size_t at = 0; at < length;) {
        const char *stop = memchr(text + at, '\n', length - at);
        size_t n = stop ? (size_t)(stop - text) - at : length - at;
        lf_image_note(notes, "%.*s", (int)(n < LINE ? n : LINE), text + at);
        at += n + 1;
    }
}

bool lf_image_notes_next(const lf_image_notes *notes, size_t *at, char *line, size_t size)
{
    if (*at >= notes->length)
        return false;
    const char *from = notes->text + *at, *stop = memchr(from, '\n', notes->length - *at);
    size_t n = stop ? (size_t)(stop - from) : notes->length - *at;
    snprintf(line, size, "%.*s", (int)n, from);
    *at += n + 1;
    return true;
}

void lf_image_metadata_aspect(lf_image_metadata *meta, const char *what, double aspect)
{
    if (!(aspect >= 0.01 && aspect <= 100))
        lf_image_note(&meta->notes, "%s is not a valid pixel aspect ratio; square pixels are used",
                      what);
    else if (fabs(aspect - 1) > 1e-3)
        meta->pixel_aspect = aspect;
}

bool lf_image_depth_is_valid(const lf_image_depth *depth)
{
    const lf_image_depth *d = depth;
    return d->near > 0 && isfinite(d->near) && d->far > d->near && d->distance > 0 &&
           isfinite(d->distance) && d->fov_y > 0 && d->fov_y < 180 && d->aspect > 0 &&
           isfinite(d->aspect) && d->cone > 0 && d->cone < 180 && d->views >= 1 &&
           d->views <= 4096 && d->views == floor(d->views) &&
           (d->centred == 1 || d->centred == 2) && d->width >= 0 && isfinite(d->width) &&
           d->height >= 0 && isfinite(d->height);
}
