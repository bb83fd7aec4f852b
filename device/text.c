#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "device/device_table.h"

/* Length of the UTF-8 character at s; 0: invalid, or a control character. */
static size_t character_length(const unsigned char *s)
{
    if (s[0] < 0x80)
        return s[0] >= 0x20 && s[0] != 0x7f;
    size_t n = s[0] >= 0xc2 && s[0] < 0xe0   ? 2
               : (s[0] & 0xf0) == 0xe0       ? 3
               : s[0] >= 0xf0 && s[0] < 0xf5 ? 4
                                             : 0;
    for (size_t i = 1; i < n; i++)
        if ((s[i] & 0xc0) != 0x80)
            return 0;
    if (s[0] == 0xc2 && s[1] < 0xa0)
        return 0; /* C1 controls */
    if ((s[0] == 0xe0 && s[1] < 0xa0) || (s[0] == 0xed && s[1] > 0x9f) ||
        (s[0] == 0xf0 && s[1] < 0x90) || (s[0] == 0xf4 && s[1] > 0x8f))
        return 0; /* overlong, surrogates, beyond U+10FFFF */
    return n;
}

void lf_device_text(char *out, size_t size, const char *text)
{
    assert(size > 0);
    const unsigned char *s = (const unsigned char *)text;
    size_t used = 0;
    while (*s != 0) {
        size_t n = character_length(s);
        size_t wide = n > 0 ? n : 1;
        if (used + wide >= size)
            break;
        if (n > 0)
            memcpy(out + used, s, n);
        else
            out[used] = '?';
        used += wide;
        s += wide;
    }
    out[used] = 0;
}

void lf_device_problem(char *out, size_t size, const lf_error *why)
{
    char text[sizeof why->pointer + sizeof why->what + 2];
    snprintf(text, sizeof text, "%s%s%s", why->pointer, why->pointer[0] != 0 ? ": " : "",
             why->what);
    lf_device_text(out, size, text);
}
