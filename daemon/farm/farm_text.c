#include "daemon/farm/farm_text.h"

#include <stdio.h>

const char *lf_farm_seconds(double seconds, char *buf, size_t size)
{
    if (seconds > 0 && seconds < 0.1)
        snprintf(buf, size, "below 0.1 s");
    else if (seconds < 10)
        snprintf(buf, size, "%.1f s", seconds);
    else if (seconds < 100)
        snprintf(buf, size, "%.0f s", seconds);
    else if (seconds < 6000)
        snprintf(buf, size, "%.0f minutes", seconds / 60);
    else if (seconds < 48 * 3600.0)
        snprintf(buf, size, "%.1f hours", seconds / 3600);
    else
        snprintf(buf, size, "%.1f days", seconds / 86400);
    return buf;
}

const char *lf_farm_bytes(double bytes, char *buf, size_t size)
{
    static const char *const units[] = {"B", "kB", "MB", "GB", "TB", "PB"};
    int i = 0;
    for (; bytes >= 1000 && i < 5; i++)
        bytes /= 1000;
    snprintf(buf, size, "%.*f %s", i > 0 && bytes < 10 ? 1 : 0, bytes, units[i]);
    return buf;
}
