#include "base/sandbox/parcel.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#define ALIGNMENT 64
#define ALL_SEALS (F_SEAL_SEAL | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE)

static const size_t element_size[LF_PARCEL_TAGS] = {
    [LF_PARCEL_WARNINGS] = 1,
    [LF_PARCEL_POSITIONS] = sizeof(double),
    [LF_PARCEL_NORMALS] = sizeof(float),
    [LF_PARCEL_TRIANGLES] = sizeof(uint32_t),
    [LF_PARCEL_CHOICES] = sizeof(uint16_t),
    [LF_PARCEL_MATERIALS] = sizeof(lf_parcel_material),
    [LF_PARCEL_SCALARS] = sizeof(float),
    [LF_PARCEL_UVS] = sizeof(float),
    [LF_PARCEL_COLOURS] = sizeof(float),
    [LF_PARCEL_TANGENTS] = sizeof(float),
    [LF_PARCEL_PICTURES] = sizeof(lf_parcel_picture),
    [LF_PARCEL_TEXELS] = 1,
    [LF_PARCEL_SIZE] = sizeof(int64_t),
    [LF_PARCEL_MAP] = sizeof(double),
    [LF_PARCEL_BRICKS] = sizeof(uint32_t),
    [LF_PARCEL_VALUES] = sizeof(float),
    [LF_PARCEL_OTHERS] = 1,
    [LF_PARCEL_SHAPE] = sizeof(int64_t),
    [LF_PARCEL_PIXELS8] = 1,
    [LF_PARCEL_PIXELS32] = sizeof(float),
    [LF_PARCEL_SPAN] = sizeof(double),
    [LF_PARCEL_LIGHTS] = sizeof(lf_parcel_light),
    [LF_PARCEL_CAMERAS] = sizeof(lf_parcel_camera),
    [LF_PARCEL_INSTANCES] = sizeof(double),
    [LF_PARCEL_PARTS] = sizeof(uint32_t),
    [LF_PARCEL_PART_OF] = sizeof(uint32_t),
    [LF_PARCEL_ODD] = sizeof(double),
    [LF_PARCEL_DEPTH] = sizeof(double),
};

size_t lf_parcel_element_size(lf_parcel_tag tag)
{
    return element_size[tag];
}

static lf_status write_at(lf_parcel_writer *writer, uint64_t offset, const void *data, size_t size,
                          lf_error *err)
{
    const char *at = data;
    while (size > 0) {
        ssize_t n = pwrite(writer->fd, at, size, (off_t)offset);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return lf_error_set(err, LF_E_NOMEM, "",
                                "not enough memory for the data that was read: %s",
                                strerror(errno));
        at += n;
        offset += (uint64_t)n;
        size -= (size_t)n;
    }
    return LF_OK;
}

lf_status lf_parcel_begin(lf_parcel_writer *writer, lf_error *err)
{
    *writer =
        (lf_parcel_writer){.header = {.magic = LF_PARCEL_MAGIC}, .size = sizeof(lf_parcel_header)};
    writer->fd = memfd_create("quiltimport", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    if (writer->fd < 0)
        return lf_error_set(err, LF_E_IO, "", "cannot create a memory file: %s", strerror(errno));
    return LF_OK;
}

lf_status lf_parcel_append(lf_parcel_writer *writer, lf_parcel_tag tag, const void *data,
                           size_t count, lf_error *err)
{
    lf_parcel_section *section = &writer->header.section[tag];
    size_t size = count * element_size[tag];
    if (section->count == 0)
        section->offset = writer->size = (writer->size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    lf_status status = write_at(writer, writer->size, data, size, err);
    section->count += count;
    writer->size += size;
    return status;
}

lf_status lf_parcel_put(lf_parcel_writer *writer, lf_parcel_tag tag, const void *data, size_t count,
                        lf_error *err)
{
    return data && count > 0 ? lf_parcel_append(writer, tag, data, count, err) : LF_OK;
}

lf_status lf_parcel_seal(lf_parcel_writer *writer, int *out_fd, lf_error *err)
{
    lf_status status = write_at(writer, 0, &writer->header, sizeof writer->header, err);
    if (status == LF_OK && fcntl(writer->fd, F_ADD_SEALS, ALL_SEALS) != 0)
        status = lf_error_set(err, LF_E_IO, "", "cannot seal the memory file: %s", strerror(errno));
    if (status != LF_OK)
        return status;
    *out_fd = writer->fd;
    writer->fd = -1;
    return LF_OK;
}

void lf_parcel_abandon(lf_parcel_writer *writer)
{
    if (writer->fd >= 0)
        close(writer->fd);
    writer->fd = -1;
}

static const char *fault_of(const lf_parcel_header *header, uint64_t size)
{
    if (header->magic != LF_PARCEL_MAGIC)
        return "it has another version";
    for (int i = 0; i < LF_PARCEL_TAGS; i++) {
        const lf_parcel_section *s = &header->section[i];
        if (s->count == 0)
            continue;
        if (s->offset % ALIGNMENT != 0 || s->offset < sizeof *header || s->offset > size ||
            s->count > (size - s->offset) / element_size[i])
            return "a section is out of range";
    }
    return NULL;
}

lf_status lf_parcel_open(int fd, lf_parcel *out, lf_error *err)
{
    struct stat info;
    int seals = fcntl(fd, F_GET_SEALS);
    if (seals < 0 || (seals & ALL_SEALS) != ALL_SEALS || fstat(fd, &info) != 0)
        return lf_error_set(err, LF_E_FORMAT, "", "the reader's answer is not sealed");
    if (info.st_size < (off_t)sizeof(lf_parcel_header))
        return lf_error_set(err, LF_E_FORMAT, "", "the reader's answer is cut off");
    size_t size = (size_t)info.st_size;
    void *data = mmap(NULL, size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (data == MAP_FAILED)
        return lf_error_set(err, LF_E_NOMEM, "", "out of memory");
    const char *fault = fault_of(data, size);
    if (fault) {
        munmap(data, size);
        return lf_error_set(err, LF_E_FORMAT, "", "the reader's answer is wrong: %s", fault);
    }
    *out = (lf_parcel){data, size};
    return LF_OK;
}

const void *lf_parcel_get(const lf_parcel *parcel, lf_parcel_tag tag, size_t *out_count)
{
    const lf_parcel_header *header = (const void *)parcel->data;
    const lf_parcel_section *section = &header->section[tag];
    *out_count = (size_t)section->count;
    return section->count > 0 ? parcel->data + section->offset : NULL;
}

void lf_parcel_close(lf_parcel *parcel)
{
    if (parcel->data)
        munmap((void *)(uintptr_t)parcel->data, parcel->size);
    *parcel = (lf_parcel){0};
}
