#include "base/frame_name.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"

enum { MOST_DIGITS = 16 };

/* The length of a number field at c; 0: none. *out_digits: its minimum number of digits. */
static size_t place_at(const char *c, int *out_digits)
{
    *out_digits = 1;
    if (c[0] != '%')
        return 0;
    if (c[1] == 'd')
        return 2;
    if (c[1] != '0' || c[2] < '1' || c[2] > '9' || c[3] != 'd')
        return 0;
    *out_digits = c[2] - '0';
    return 4;
}

int lf_frame_name_fields(const char *name)
{
    int digits, n = 0;
    for (const char *c = name; *c; c++)
        n += place_at(c, &digits) > 0;
    return n;
}

bool lf_frame_name_varies(const char *name)
{
    return lf_frame_name_fields(name) > 0;
}

char *lf_frame_name(const char *name, int number)
{
    char *made = lf_calloc((strlen(name) + 1) * MOST_DIGITS, 1), *to = made;
    for (const char *c = name; made && *c;) {
        int digits;
        size_t place = place_at(c, &digits);
        if (place > 0)
            to += snprintf(to, MOST_DIGITS, "%0*d", digits, number);
        else
            *to++ = *c;
        c += place > 0 ? place : 1;
    }
    return made;
}
