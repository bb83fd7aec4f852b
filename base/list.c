#include "base/list.h"

#include <stdio.h>
#include <string.h>

void lf_list_add(char *list, size_t size, const char *format, ...)
{
    va_list args;
    if (list[0] != '\0')
        snprintf(list + strlen(list), size - strlen(list), ", ");
    const size_t n = strlen(list);
    va_start(args, format);
    (void)vsnprintf(list + n, size - n, format, args);
    va_end(args);
}
