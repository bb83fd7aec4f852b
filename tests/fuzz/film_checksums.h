/* Checksums of film files that fit after a mutation, so that a target meets more than checksums. */
#ifndef LF_TESTS_FUZZ_FILM_CHECKSUMS_H
#define LF_TESTS_FUZZ_FILM_CHECKSUMS_H

#include <stdint.h>
#include <string.h>
#include <zlib.h>

enum { START_BYTES = 12, HEAD_BYTES = 16 };

/* The checksum of every part that is whole, and of all heads at the end. */
static inline void mend_checksums(uint8_t *p, size_t size)
{
    uint64_t n = 0;
    uLong heads = 0;
    for (size_t at = START_BYTES; size >= HEAD_BYTES && at <= size - HEAD_BYTES;
         at += HEAD_BYTES + n) {
        uint8_t *head = p + at;
        memcpy(&n, head + 8, sizeof n);
        if (n > size - HEAD_BYTES - at)
            return;
        const uint32_t of_all = (uint32_t)heads;
        if (memcmp(head, "END ", 4) == 0 && n == sizeof of_all)
            memcpy(head + HEAD_BYTES, &of_all, sizeof of_all);
        uLong crc = crc32_z(0, head, 4);
        crc = crc32_z(crc, head + 8, 8 + n);
        const uint32_t fit = (uint32_t)crc;
        memcpy(head + 4, &fit, sizeof fit);
        heads = crc32_z(heads, head, HEAD_BYTES);
    }
}

#endif
