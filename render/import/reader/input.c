#include "render/import/reader/input.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/sandbox/reader.h"
#include "base/text.h"

#define BLOCK ((size_t)256 << 10)

bool lf_grow(void *array, size_t *room, size_t needed, size_t each)
{
    void **at = array;
    size_t wanted = *room + *room / 2, bytes;
    if (needed <= *room)
        return true;
    if (wanted < needed)
        wanted = needed < 16 ? 16 : needed;
    if (__builtin_mul_overflow(wanted, each, &bytes))
        return false;
    void *grown = realloc(*at, bytes);
    if (!grown)
        return false;
    *at = grown;
    *room = wanted;
    return true;
}

/* Reads more data after the buffer's content. false: none arrived. */
static bool fill_input(lf_input *in)
{
    if (in->status != LF_OK)
        return false;
    if (in->at > 0 && in->at >= in->end / 2) { /* kept data moves at most once per byte read */
        memmove(in->buffer, in->buffer + in->at, in->end - in->at);
        in->before += in->at;
        in->end -= in->at;
        in->at = 0;
    }
    if (!lf_grow(&in->buffer, &in->room, in->end + BLOCK + 1, 1)) { /* 1: a text's end */
        in->status = LF_E_NOMEM;
        return false;
    }
    ssize_t n = pread(in->fd, in->buffer + in->end, BLOCK, (off_t)(in->before + in->end));
    if (n < 0)
        in->status = LF_E_IO;
    if (n <= 0)
        return false;
    in->end += (size_t)n;
    return true;
}

static bool input_has(lf_input *in, size_t n)
{
    while (in->end - in->at < n)
        if (n > lf_input_left(in) || !fill_input(in))
            return false;
    return true;
}

/* By the first line: a CR with nothing else behind it. */
static bool has_lone_cr(const lf_input *in)
{
    const unsigned char *first = memchr(in->buffer, '\r', in->end);
    return first && !memchr(in->buffer, '\n', (size_t)(first - in->buffer)) &&
           (first + 1 == in->buffer + in->end || first[1] != '\n');
}

lf_status lf_input_open_bytes(lf_input *in, int fd, lf_error *err)
{
    struct stat info;
    *in = (lf_input){.fd = fd, .ends = '\n'};
    if (fstat(fd, &info) != 0)
        return lf_error_set(err, LF_E_IO, LF_HERE, "cannot read: %s", strerror(errno));
    in->size = (uint64_t)info.st_size;
    if (!lf_grow(&in->buffer, &in->room, BLOCK + 1, 1))
        in->status = LF_E_NOMEM;
    if ((in->size > 0 && !fill_input(in)) || in->status != LF_OK)
        return lf_input_ended(in, "a byte", err);
    in->is_alone = has_lone_cr(in);
    in->ends = in->is_alone ? '\r' : '\n';
    return LF_OK;
}

lf_status lf_input_begin_text(lf_input *in, lf_error *err)
{
    return lf_text_begin((const char *)in->buffer, in->end, LF_HERE, &in->at, err);
}

lf_status lf_input_open(lf_input *in, int fd, lf_error *err)
{
    lf_status status = lf_input_open_bytes(in, fd, err);
    return status == LF_OK ? lf_input_begin_text(in, err) : status;
}

void lf_input_close(lf_input *in)
{
    free(in->buffer);
    *in = (lf_input){.fd = -1};
}

const unsigned char *lf_input_bytes(lf_input *in, size_t n)
{
    if (in->end - in->at < n && !input_has(in, n))
        return NULL;
    in->at += n;
    return in->buffer + in->at - n;
}

const unsigned char *lf_input_peek(lf_input *in, size_t n, size_t *out_n)
{
    uint64_t left = lf_input_left(in);
    *out_n = n < left ? n : (size_t)left;
    if (!input_has(in, *out_n))
        *out_n = in->end - in->at;
    return in->buffer + in->at;
}

bool lf_input_skip(lf_input *in, uint64_t n)
{
    size_t here = in->end - in->at;
    if (n <= here) {
        in->at += (size_t)n;
        return true;
    }
    if (n > lf_input_left(in))
        return false;
    lf_input_seek(in, lf_input_offset(in) + n, in->line);
    return true;
}

/* End of the line that begins at `at`, searched from its byte `from` on; the end of the data if
 * there is no terminator. The byte after a CR is in the buffer. */
static size_t line_end(lf_input *in, size_t from)
{
    for (;;) {
        size_t here = in->end - in->at,
               stop = from + lf_text_line_end((const char *)in->buffer + in->at + from, here - from,
                                              &in->ends);
        if (stop + 1 < here || (stop < here && in->buffer[in->at + stop] == '\n'))
            return stop;
        if (!fill_input(in))
            return stop;
        from = stop;
    }
}

/* Bytes that end a line behind its n. */
static size_t end_length(const lf_input *in, size_t n)
{
    const unsigned char *text = in->buffer + in->at;
    const size_t here = in->end - in->at;
    bool both = !in->is_alone && n + 1 < here && text[n] == '\r' && text[n + 1] == '\n';
    return n == here ? 0 : both ? 2 : 1;
}

char *lf_input_line(lf_input *in, bool joins)
{
    if (!input_has(in, 1))
        return NULL;
    size_t n = line_end(in, 0), end;
    in->line++;
    while (joins && (end = end_length(in, n)) > 0 && in->buffer[in->at] != '#') {
        unsigned char *text = in->buffer + in->at;
        if (n == 0 || text[n - 1] != '\\')
            break;
        memset(text + n - 1, ' ', end + 1);
        n = line_end(in, n + end);
        in->line++;
    }
    if (in->status != LF_OK)
        return NULL;
    char *text = (char *)in->buffer + in->at;
    in->at += n + end_length(in, n);
    lf_text_blank(text, n);
    text[n] = '\0';
    return text;
}

uint64_t lf_input_offset(const lf_input *in)
{
    return in->before + in->at;
}

uint64_t lf_input_left(const lf_input *in)
{
    uint64_t offset = lf_input_offset(in);
    return offset < in->size ? in->size - offset : 0;
}

void lf_input_seek(lf_input *in, uint64_t offset, int64_t line)
{
    in->before = offset;
    in->at = in->end = 0;
    in->line = line;
}

lf_status lf_input_ended(const lf_input *in, const char *expected, lf_error *err)
{
    if (in->status == LF_E_NOMEM)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    if (in->status != LF_OK)
        return lf_error_set(err, in->status, LF_HERE, "cannot be read");
    return lf_error_set(err, LF_E_FORMAT, LF_HERE, "the file ends at byte %llu; expected %s",
                        (unsigned long long)in->size, expected);
}
