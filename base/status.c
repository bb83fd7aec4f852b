#include "base/status.h"

#include <stdio.h>
#include <string.h>

#include "base/escape.h"

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
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (names[i].status == status)
            return names[i].name;
    }
    return "LF_E_UNKNOWN";
}

size_t lf_escape(char *buf, size_t size, const char *text)
{
    static const char hex[] = "0123456789abcdef";
    size_t n = 0;
    if (size == 0)
        return 0;
    for (const unsigned char *s = (const unsigned char *)text; *s != 0;) {
        unsigned char c = *s;
        /* C1 controls are two bytes in UTF-8, and terminals obey them too */
        bool c1 = c == 0xc2 && s[1] >= 0x80 && s[1] < 0xa0;
        size_t length = c1 ? 2 : 1;
        if (!c1 && c >= 0xc2 && c < 0xf5) {
            size_t expected = c < 0xe0 ? 2 : c < 0xf0 ? 3 : 4;
            while (length < expected && (s[length] & 0xc0) == 0x80)
                length++;
        }
        bool plain = !c1 && c >= 0x20 && c != 0x7f && (c < 0x80 || length > 1);
        char out[8];
        size_t out_length = length;
        if (plain) {
            memcpy(out, s, length);
        } else if (c == '\n' || c == '\t' || c == '\r') {
            out_length = 2;
            out[0] = '\\';
            out[1] = c == '\n' ? 'n' : c == '\t' ? 't' : 'r';
        } else {
            unsigned char shown = c1 ? s[1] : c;
            out_length = 4;
            memcpy(out, "\\x", 2);
            out[2] = hex[shown >> 4];
            out[3] = hex[shown & 15];
        }
        if (n + out_length >= size)
            break;
        memcpy(buf + n, out, out_length);
        n += out_length;
        s += length;
    }
    buf[n] = 0;
    return n;
}

static lf_status report(lf_error *err, lf_status status, const char *where, int line, const char *pointer, const char *fmt, va_list ap)
{
    if (!err)
        return status;
    /* the arguments may point into *err itself, so all text is made before any of it is stored */
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

lf_status lf_error_set_at(lf_error *err, lf_status status, const char *where, int line, const char *pointer, const char *fmt, ...)
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
    snprintf(buf, size, "%s%s%s%s%s%s", err->where, line, place ? ": " : "", err->pointer, pointer ? ": " : "", err->what);
    return buf;
}
