/* Amounts as people read them. Pure functions; they return buf. */
#ifndef LF_DAEMON_FARM_TEXT_H
#define LF_DAEMON_FARM_TEXT_H

#include <stddef.h>

/* "3.2 s", "35 s", "12 minutes", "2.4 hours", "3.5 days". */
const char *lf_farm_seconds(double seconds, char *buf, size_t size);
/* "300 kB", "1.2 GB". */
const char *lf_farm_bytes(double bytes, char *buf, size_t size);

#endif
