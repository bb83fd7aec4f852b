/* A 3DS file is a chunk that contains chunks: two bytes for its kind, four for its length,
 * including these six. */
#include "render/import/reader/assimp_words.h"

#include <stdint.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"

enum {
    HEADER = 6,
    MAIN = 0x4d4d,    /* of a file */
    PROJECT = 0xc23d, /* of a project of 3D Studio's */
    EDITOR = 0x3d3d,
    OBJECT = 0x4000, /* a name precedes its chunks */
    MESH = 0x4100,
    MATERIAL = 0xafff,
    LONGEST_NAME = 256,
    MOST_CHUNKS = 100000
};

typedef struct chunk {
    unsigned what;
    int64_t at, end; /* bytes of the file; end is the chunk's declared end */
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

/* Start of the first contained chunk; the chunk's end if there is none. */
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

/* Position of a walk through all chunks. */
typedef struct walk {
    int fd, depth, n;
    int64_t at, ends[8]; /* of the enclosing chunks; the file's first */
} walk;

/* The next chunk in the order of the file. A chunk with contents is followed by its first one.
 * false: no more, or *out ends after its enclosing chunk. */
static bool next_chunk(walk *w, chunk *out, bool *out_whole)
{
    *out_whole = true;
    while (w->depth > 0 && w->at >= w->ends[w->depth])
        w->depth--;
    if (w->n++ == MOST_CHUNKS || w->at + HEADER > w->ends[w->depth] ||
        !read_chunk(w->fd, w->at, out))
        return false;
    *out_whole = out->end >= out->at + HEADER && out->end <= w->ends[w->depth];
    if (!*out_whole)
        return false;
    w->at = first_within(w->fd, out);
    if (w->at < out->end && w->depth + 1 < (int)(sizeof w->ends / sizeof *w->ends))
        w->ends[++w->depth] = out->end;
    else
        w->at = out->end;
    return true;
}

/* The first chunk that ends after its enclosing one. */
static bool find_fault(int fd, int64_t size, chunk *out, int64_t *out_room)
{
    walk w = {.fd = fd, .ends = {size}};
    bool whole;
    while (next_chunk(&w, out, &whole))
        ;
    *out_room = w.ends[w.depth] - w.at;
    return !whole;
}

void lf_3ds_warn(int fd, const char *path, lf_warnings *warnings)
{
    static const struct {
        unsigned what;
        const char *name;
    } lost[] = {{0x1101, "1101 background picture"},
                {0x1201, "1201 background"},
                {0x1301, "1301 background"},
                {0x2100, "2100 ambient light"},
                {0x2201, "2201 fog"},
                {0x2301, "2301 layered fog"},
                {0x2302, "2302 layered fog"},
                {0x2303, "2303 layered fog"},
                {0x4010, "4010 hidden object"},
                {0xa085, "a085 wire frame"},
                {0xa33a, "a33a second texture"}};
    lf_left_out list = {.names = ""};
    struct stat info;
    bool whole;
    chunk c;
    if (!lf_path_has_ending(path, ".3ds") || fstat(fd, &info) != 0)
        return;
    for (walk w = {.fd = fd, .ends = {info.st_size}}; next_chunk(&w, &c, &whole);)
        for (size_t i = 0; i < sizeof lost / sizeof *lost; i++)
            if (c.what == lost[i].what)
                lf_leave_out(&list, lost[i].name, strlen(lost[i].name));
    lf_left_out_warn(&list, "ignored chunks", warnings);
}

static bool refuse_chunks(int fd, const char *path, int64_t size, lf_error *err)
{
    chunk c;
    int64_t room;
    if (!read_chunk(fd, 0, &c)) {
        (void)lf_error_set(err, LF_E_FORMAT, path,
                           "cannot be read as a mesh: %lld bytes are too few for a 3DS file",
                           (long long)size);
        return true;
    }
    if (c.what != MAIN && c.what != PROJECT && c.what != EDITOR) {
        (void)lf_error_set(err, LF_E_FORMAT, path,
                           "cannot be read as a mesh: a 3DS file begins with chunk 4d4d, but this "
                           "file begins with %04x",
                           c.what);
        return true;
    }
    if (!find_fault(fd, size, &c, &room))
        return false;
    (void)lf_error_set(err, LF_E_FORMAT, path,
                       "cannot be read as a mesh: 3DS chunk %04x at byte %lld needs %lld bytes but "
                       "has %lld; the file is cut off or damaged",
                       c.what, (long long)c.at, (long long)(c.end - c.at), (long long)room);
    return true;
}

void lf_assimp_refuse(int fd, const char *path, const char *source, lf_error *err)
{
    struct stat info;
    const bool is_3ds = lf_path_has_ending(path, ".3ds");
    if (is_3ds && fstat(fd, &info) == 0 && refuse_chunks(fd, path, (int64_t)info.st_size, err))
        return;
    (void)lf_error_set(err, LF_E_FORMAT, path,
                       "cannot be read as a mesh%s; the library for %s reports: %s",
                       is_3ds ? ": the contents of its 3DS chunks are invalid" : "",
                       is_3ds ? "3DS" : "this format", source);
}
