/* A 3DS file is a chunk that holds chunks: two bytes that say what it is, four that say how long it
 * is, its own six among them. */
#include "render/reader/assimp_words.h"

#include <stdint.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"

enum {
    HEADER = 6,
    MAIN = 0x4d4d,    /* of a file */
    PROJECT = 0xc23d, /* of a project of 3D Studio's */
    EDITOR = 0x3d3d,
    OBJECT = 0x4000, /* whose name stands in front of its chunks */
    MESH = 0x4100,
    MATERIAL = 0xafff,
    LONGEST_NAME = 256,
    MOST_CHUNKS = 100000
};

typedef struct chunk {
    unsigned what;
    int64_t at, end; /* bytes of the file; end as the chunk says */
} chunk;

static bool read_chunk(int fd, int64_t at, chunk *out)
{
    unsigned char b[HEADER];
    if (pread(fd, b, sizeof b, (off_t)at) != HEADER)
        return false;
    const uint32_t size =
        (uint32_t)b[2] | (uint32_t)b[3] << 8 | (uint32_t)b[4] << 16 | (uint32_t)b[5] << 24;
    *out = (chunk){.what = b[0] | (unsigned)b[1] << 8, .at = at, .end = at + size};
    return true;
}

/* Where the first chunk within begins; the chunk's end: there are none. */
static int64_t first_within(int fd, const chunk *c)
{
    char name[LONGEST_NAME];
    ssize_t n, length = 0;
    if (c->what == MAIN || c->what == PROJECT || c->what == EDITOR || c->what == MESH ||
        c->what == MATERIAL)
        return c->at + HEADER;
    if (c->what != OBJECT)
        return c->end;
    n = pread(fd, name, sizeof name, (off_t)(c->at + HEADER));
    while (length < n && name[length])
        length++;
    return length < n ? c->at + HEADER + length + 1 : c->end;
}

/* The first chunk, in the order of the file, that ends behind the one that holds it. A chunk that
 * holds others is followed by its first; what is behind it is found by its end. */
static bool find_fault(int fd, int64_t size, chunk *out, int64_t *out_room)
{
    int64_t ends[8] = {size}, at = 0;
    int depth = 0;
    for (int n = 0; n < MOST_CHUNKS; n++) {
        chunk c;
        while (depth > 0 && at >= ends[depth])
            depth--;
        if (at + HEADER > ends[depth] || !read_chunk(fd, at, &c))
            return false;
        if (c.end < c.at + HEADER || c.end > ends[depth]) {
            *out = c;
            *out_room = ends[depth] - c.at;
            return true;
        }
        at = first_within(fd, &c);
        if (at < c.end && depth + 1 < (int)(sizeof ends / sizeof *ends))
            ends[++depth] = c.end;
        else
            at = c.end;
    }
    return false;
}

static bool refuse_chunks(int fd, const char *path, int64_t size, lf_error *err)
{
    chunk c;
    int64_t room;
    if (!read_chunk(fd, 0, &c)) {
        (void)lf_error_set(err, LF_E_FORMAT, path,
                           "cannot be read as a mesh: %lld bytes, less than a 3DS file has",
                           (long long)size);
        return true;
    }
    if (c.what != MAIN && c.what != PROJECT && c.what != EDITOR) {
        (void)lf_error_set(err, LF_E_FORMAT, path,
                           "cannot be read as a mesh: not 3DS, which begins with the chunk 4d4d; "
                           "this file begins with %04x",
                           c.what);
        return true;
    }
    if (!find_fault(fd, size, &c, &room))
        return false;
    (void)lf_error_set(err, LF_E_FORMAT, path,
                       "cannot be read as a mesh: the 3DS chunk %04x at byte %lld says that it has "
                       "%lld bytes, where there are %lld; the file is cut off or damaged",
                       c.what, (long long)c.at, (long long)(c.end - c.at), (long long)room);
    return true;
}

void lf_assimp_refuse(int fd, const char *path, const char *said, lf_error *err)
{
    struct stat info;
    const bool is_3ds = lf_path_has_ending(path, ".3ds");
    if (is_3ds && fstat(fd, &info) == 0 && refuse_chunks(fd, path, (int64_t)info.st_size, err))
        return;
    (void)lf_error_set(err, LF_E_FORMAT, path,
                       "cannot be read as a mesh%s; the library that reads %s says: %s",
                       is_3ds ? ": its 3DS chunks hold something else than they should" : "",
                       is_3ds ? "3DS" : "this format", said);
}
