/* counts: what the gateway does, in numbers, as Prometheus text format 0.0.4. Thread: any. */
#ifndef LF_DAEMON_WEB_COUNTS_H
#define LF_DAEMON_WEB_COUNTS_H

#include <stdint.h>
#include <stdio.h>

typedef struct lf_web_counts {
    uint64_t requests, refused; /* since the start; refused: by the guard or for want of a token */
    uint64_t uploads;           /* bodies received whole since the start */
    int connections, websockets, streams;
    int upload_files, download_files;
    uint64_t upload_bytes, download_bytes;
    uint64_t bridge_requests, bridge_failures; /* since the start */
    uint64_t driver_commands, driver_failures; /* likewise, of the older protocol */
    uint64_t driver_bytes;                     /* of its images */
} lf_web_counts;

/* Writes HELP, TYPE and sample of each quantity. The caller checks errors of out (ferror). */
void lf_web_counts_write(const lf_web_counts *counts, FILE *out);

#endif
