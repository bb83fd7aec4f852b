/* PLY files promise their numbers of elements in a header, and Assimp makes room for what is
 * promised: a promise that the file is too short to keep must not get that far. */
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "render/reader/reader.h"

#define MAX_HEADER 65536

/* Bytes that one element takes at the least: a digit and a separator in text, one byte a property
 * in binary. */
static uint64_t least_size(bool text, uint64_t n_properties)
{
    uint64_t each = text ? 2 : 1;
    return each * (n_properties > 0 ? n_properties : 1);
}

/* Walks the lines of a header; the bytes that the elements after it need at the least, capped. */
static uint64_t promised_bytes(char *header)
{
    const uint64_t cap = (uint64_t)1 << 60;
    uint64_t sum = 0, count = 0, n_properties = 0;
    bool text = true;
    char *rest = NULL;
    for (char *line = strtok_r(header, "\r\n", &rest); line; line = strtok_r(NULL, "\r\n", &rest)) {
        unsigned long long n = 0;
        bool element = sscanf(line, " element %*s %llu", &n) == 1;
        if (strstr(line, "format binary"))
            text = false;
        if (strncmp(line, "property", 8) == 0)
            n_properties++;
        bool end = strncmp(line, "end_header", 10) == 0;
        if (!element && !end)
            continue;
        sum += count < cap / MAX_HEADER / 2 ? count * least_size(text, n_properties) : cap;
        if (end || sum >= cap)
            break;
        count = n;
        n_properties = 0;
    }
    return sum < cap ? sum : cap;
}

lf_status lf_ply_check(int fd, lf_error *err)
{
    struct stat info;
    char *header = lf_calloc(MAX_HEADER + 1, 1);
    if (!header)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    lf_status status = LF_OK;
    if (fstat(fd, &info) != 0 || pread(fd, header, MAX_HEADER, 0) < 0)
        status = lf_error_set(err, LF_E_IO, LF_HERE, "cannot be read");
    uint64_t size = status == LF_OK ? (uint64_t)info.st_size : 0,
             promised = status == LF_OK ? promised_bytes(header) : 0;
    /* The last separator of a text may be missing. */
    if (promised > size + 1)
        status =
            lf_error_set(err, LF_E_FORMAT, LF_HERE,
                         "the header promises at least %llu bytes of elements, the file has %llu",
                         (unsigned long long)promised, (unsigned long long)size);
    lf_free(header);
    return status;
}
