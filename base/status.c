#include "base/status.h"

#include <stdio.h>
#include <string.h>

#include "base/escape.h"

#undef lf_error_set
#undef lf_error_set_at

static const struct {
    lf_status status;
    const char *name;
} names[] = {
    {LF_OK, "LF_OK"},
    {LF_E_NOMEM, "LF_E_NOMEM"},
    {LF_E_ARG, "LF_E_ARG"},
    {LF_E_STATE, "LF_E_STATE"},
    {LF_E_IO, "LF_E_IO"},
    {LF_E_FORMAT, "LF_E_FORMAT"},
    {LF_E_PATH, "LF_E_PATH"},
    {LF_E_NODEV, "LF_E_NODEV"},
    {LF_E_TIMEOUT, "LF_E_TIMEOUT"},
    {LF_E_CANCELLED, "LF_E_CANCELLED"},
    {LF_E_BUSY, "LF_E_BUSY"},
    {LF_E_EXISTS, "LF_E_EXISTS"},
};

const char *lf_status_name(lf_status status)
{
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (names[i].status == status)
            return names[i].name;
    return "LF_E_UNKNOWN";
}

/* Length of the UTF-8 character at s; 0: invalid. */
static size_t utf8_length(const unsigned char *s)
{
    if (s[0] < 0x80)
        return 1;
    if (s[0] < 0xc2 || s[0] > 0xf4)
        return 0;
    size_t length = s[0] < 0xe0 ? 2 : s[0] < 0xf0 ? 3 : 4;
    for (size_t i = 1; i < length; i++)
        if ((s[i] & 0xc0) != 0x80)
            return 0;
    return length;
}

/* The escape of one byte, into out[4]; returns its length. */
static size_t escape_byte(unsigned char c, char out[static 4])
{
    static const char hex[] = "0123456789abcdef";
    out[0] = '\\';
    if (c == '\n' || c == '\t' || c == '\r') {
        out[1] = c == '\n' ? 'n' : c == '\t' ? 't' : 'r';
        return 2;
    }
    out[1] = 'x';
    out[2] = hex[c >> 4];
    out[3] = hex[c & 15];
    return 4;
}

size_t lf_escape(char *buf, size_t size, const char *text)
{
    size_t n = 0;
    if (size == 0)
        return 0;
    for (const unsigned char *s = (const unsigned char *)text; *s != 0;) {
        size_t length = utf8_length(s);
        /* C1 controls are two bytes in UTF-8, and terminals interpret them too */
        bool control =
            length == 1 ? s[0] < 0x20 || s[0] == 0x7f : length == 2 && s[0] == 0xc2 && s[1] < 0xa0;
        char escaped[4];
        const void *out = s;
        size_t out_length = length;
        if (length == 0 || control) {
            out = escaped;
            out_length = escape_byte(length == 2 ? s[1] : s[0], escaped);
        }
        if (n + out_length >= size)
            break;
        memcpy(buf + n, out, out_length);
        n += out_length;
        s += length == 0 ? 1 : length;
    }
    buf[n] = 0;
    return n;
}

static lf_status report(lf_error *err, lf_status status, const char *where, int line,
                        const char *pointer, const char *fmt, va_list ap)
{
    if (!err)
        return status;
    /* arguments may point into *err, so all text is made before any is stored */
    lf_error made = {.status = status, .line = line};
    char text[2048];
    vsnprintf(text, sizeof text, fmt, ap);
    lf_escape(made.what, sizeof made.what, text);
    lf_escape(made.where, sizeof made.where, where ? where : "");
    lf_escape(made.pointer, sizeof made.pointer, pointer ? pointer : "");
    *err = made;
    return status;
}

lf_status lf_error_set(lf_error *err, lf_status status, const char *where, const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    report(err, status, where, 0, NULL, fmt, ap);
    va_end(ap);
    return status;
}

lf_status lf_error_set_at(lf_error *err, lf_status status, const char *where, int line,
                          const char *pointer, const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    report(err, status, where, line, pointer, fmt, ap);
    va_end(ap);
    return status;
}

char *lf_error_format(const lf_error *err, char *buf, size_t size)
{
    char line[16] = "";
    if (err->line > 0)
        snprintf(line, sizeof line, ":%d", err->line);
    bool place = err->where[0] != 0 || line[0] != 0;
    bool pointer = err->pointer[0] != 0;
    snprintf(buf, size, "%s%s%s%s%s%s", err->where, line, place ? ": " : "", err->pointer,
             pointer ? ": " : "", err->what);
    return buf;
}
