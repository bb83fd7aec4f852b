#include "render/import/reader/maps.h"

#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/image_rgba.h"
#include "base/sandbox/reader.h"

/* A requested file. */
typedef struct picture_file {
    const char *path;  /* a map's */
    uint32_t picture;  /* 1 + its number in the mesh; 0: it is none */
    const char *cover; /* the path of what its alpha was taken from; NULL: it is its own */
} picture_file;

typedef struct map_reading {
    lf_source_material *source;
    lf_mesh_data *out;
    picture_file *files; /* [n_files], room for one per map */
    size_t n_files;
    bool *told; /* [LF_MAX_MATERIALS]: there was a warning */
} map_reading;

static lf_status no_memory(lf_error *err)
{
    return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
}

static const char *last_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

lf_status lf_map_begin(unsigned source, lf_map_use use, const char *folder, const char *name,
                       lf_map *out, lf_error *err)
{
    *out = (lf_map){.source = source,
                    .use = use,
                    .path = lf_path_join(folder, name),
                    .beside = lf_path_join(folder, last_name(name)),
                    .texture = {.map = {{1, 0, 0}, {0, -1, 1}}, .scale = 1}};
    if (out->path && out->beside)
        return LF_OK;
    lf_map_finish(out);
    return no_memory(err);
}

void lf_map_finish(lf_map *map)
{
    lf_free(map->path);
    lf_free(map->beside);
    *map = (lf_map){0};
}

/* ------------------------------------------------------------------------------------- files -- */

static lf_status read_bytes(int fd, uint8_t **out, size_t *out_size, lf_error *err)
{
    struct stat info;
    if (fstat(fd, &info) != 0 || info.st_size < 0)
        return lf_error_set(err, LF_E_IO, LF_HERE, "cannot be read");
    size_t size = (size_t)info.st_size, at = 0;
    uint8_t *data = lf_calloc(size, 1);
    ssize_t n = 1;
    if (!data)
        return no_memory(err);
    while (at < size && (n = pread(fd, data + at, size - at, (off_t)at)) > 0)
        at += (size_t)n;
    *out = data;
    *out_size = at;
    return LF_OK;
}

/* If a file is not where the library says, it is searched in the library's folder: people move
 * files. */
static lf_status open_picture(const char *path, const char *beside, int *out_fd, lf_error *err)
{
    if (lf_try_for_file(path, out_fd) == LF_OK ||
        (strcmp(path, beside) != 0 && lf_try_for_file(beside, out_fd) == LF_OK))
        return LF_OK;
    return lf_error_set(err, LF_E_IO, LF_HERE, "missing, or may not be read");
}

lf_status lf_map_decode(int fd, lf_texels *out, lf_error *err)
{
    uint8_t *data = NULL;
    size_t size = 0;
    lf_status status = read_bytes(fd, &data, &size, err);
    if (status == LF_OK)
        status =
            lf_image_rgba_decode(data, size, LF_HERE, &out->rgba, &out->width, &out->height, err);
    lf_free(data);
    return status;
}

/* Adds another image to the mesh. */
static lf_status read_picture(const lf_map *map, lf_mesh_data *out, lf_error *err)
{
    int fd;
    lf_status status = open_picture(map->path, map->beside, &fd, err);
    if (status != LF_OK)
        return status;
    status = lf_map_decode(fd, &out->pictures[out->n_pictures], err);
    close(fd);
    out->n_pictures += status == LF_OK;
    return status;
}

static void warn_once(map_reading *r, const lf_map *map, const char *what)
{
    const lf_source_material *source = &r->source[map->source];
    if (r->told[map->source])
        return;
    r->told[map->source] = true;
    lf_warnings_add(&r->out->warnings, LF_HERE,
                    "%s%.40s%stexture \"%s\": %s; the material is used without it",
                    source->name[0] ? "material \"" : "", source->name,
                    source->name[0] ? "\": " : "", last_name(map->path), what);
}

/* The map's file, without an image if it cannot be decoded. */
static lf_status find_file(map_reading *r, const lf_map *map, picture_file **out, lf_error *err)
{
    for (size_t i = 0; i < r->n_files; i++) {
        *out = &r->files[i];
        if (strcmp(r->files[i].path, map->path) != 0)
            continue;
        if (r->files[i].picture == 0)
            warn_once(r, map, "missing, or not an image");
        return LF_OK;
    }
    lf_error why = {0};
    *out = &r->files[r->n_files++];
    **out = (picture_file){.path = map->path};
    lf_status status = read_picture(map, r->out, &why);
    if (status == LF_E_NOMEM)
        return lf_error_set(err, status, LF_HERE, "texture \"%s\": %s", last_name(map->path),
                            why.what);
    if (status == LF_OK)
        (*out)->picture = (uint32_t)r->out->n_pictures;
    else
        warn_once(r, map, why.what);
    return LF_OK;
}

/* ---------------------------------------------------------------------------------- coverage -- */

static bool has_holes(const lf_texels *p)
{
    size_t n = (size_t)p->width * (size_t)p->height;
    for (size_t i = 0; i < n; i++)
        if (p->rgba[4 * i + 3] < 255)
            return true;
    return false;
}

/* Copies the mask's alpha if it has any, else its brightness, by nearest texel, because the sizes
 * may differ. */
static void put_cover(lf_texels *to, const lf_texels *mask)
{
    const bool by_alpha = has_holes(mask);
    for (int y = 0; y < to->height; y++)
        for (int x = 0; x < to->width; x++) {
            size_t column = (size_t)((int64_t)x * mask->width / to->width),
                   row = (size_t)((int64_t)y * mask->height / to->height);
            const uint8_t *m = mask->rgba + 4 * (row * (size_t)mask->width + column);
            to->rgba[4 * ((size_t)y * (size_t)to->width + (size_t)x) + 3] =
                by_alpha ? m[3] : (uint8_t)((m[0] + m[1] + m[2] + 1) / 3);
        }
}

/* A mask alone becomes the alpha of a white image, which the material's colour multiplies. */
static void whiten(lf_texels *mask)
{
    const bool by_alpha = has_holes(mask);
    size_t n = (size_t)mask->width * (size_t)mask->height;
    for (size_t i = 0; i < n; i++) {
        uint8_t *p = mask->rgba + 4 * i;
        if (!by_alpha)
            p[3] = (uint8_t)((p[0] + p[1] + p[2] + 1) / 3);
        p[0] = p[1] = p[2] = 255;
    }
}

static picture_file *file_of(map_reading *r, uint32_t picture)
{
    for (size_t i = 0; i < r->n_files; i++)
        if (r->files[i].picture == picture)
            return &r->files[i];
    return NULL;
}

static void take_cover(map_reading *r, const lf_map *map, picture_file *mask)
{
    lf_source_material *source = &r->source[map->source];
    lf_texture *base = &source->textures.slot[LF_SLOT_BASE];
    lf_texels *texels = &r->out->pictures[mask->picture - 1];
    picture_file *beneath = base->picture > 0 ? file_of(r, base->picture) : mask;
    if (beneath == mask && base->picture > 0) {
        source->cover = has_holes(texels) ? LF_COVER_BLEND : source->cover;
        return;
    }
    if (beneath->cover && strcmp(beneath->cover, map->path) != 0) {
        warn_once(r, map, "another texture already gives the opacity of this one's base");
        return;
    }
    if (beneath == mask) {
        whiten(texels);
        *base = map->texture;
        base->picture = mask->picture;
    } else {
        put_cover(&r->out->pictures[base->picture - 1], texels);
    }
    beneath->cover = map->path;
    source->cover = LF_COVER_BLEND;
}

/* -------------------------------------------------------------------------------------- uses -- */

/* Normals are blue, and about grey otherwise. */
static bool holds_normals(const lf_texels *p)
{
    enum { LOOKS = 4096 };
    size_t n = (size_t)p->width * (size_t)p->height, step = n / LOOKS + 1, seen = 0;
    double mean[3] = {0};
    for (size_t i = 0; i < n; i += step, seen++)
        for (int c = 0; c < 3; c++)
            mean[c] += p->rgba[4 * i + (size_t)c];
    for (int c = 0; c < 3; c++)
        mean[c] /= (double)seen;
    return mean[2] > 170 && mean[0] > 80 && mean[0] < 176 && mean[1] > 80 && mean[1] < 176;
}

static const lf_vec3 white = {1, 1, 1};

static void put_texture(map_reading *r, const lf_map *map, lf_slot slot, uint32_t picture)
{
    lf_texture *to = &r->source[map->source].textures.slot[slot];
    *to = map->texture;
    to->picture = picture;
}

static void use_map(map_reading *r, const lf_map *map, picture_file *file)
{
    lf_source_material *source = &r->source[map->source];
    switch (map->use) {
    case LF_MAP_BASE:
        put_texture(r, map, LF_SLOT_BASE, file->picture);
        if (!source->has_diffuse || !(lf_max3(source->albedo) > 0))
            /* exporters write black next to a texture and expect it to be ignored */
            source->albedo = white;
        break;
    case LF_MAP_EMISSION:
        put_texture(r, map, LF_SLOT_EMISSION, file->picture);
        if (!(lf_max3(source->emission) > 0))
            source->emission = white;
        break;
    case LF_MAP_NORMAL:
        put_texture(r, map, LF_SLOT_NORMAL, file->picture);
        break;
    case LF_MAP_BUMP:
        if (!holds_normals(&r->out->pictures[file->picture - 1]))
            source->lost |= 1u << LF_LOST_MAPS;
        else if (source->textures.slot[LF_SLOT_NORMAL].picture == 0)
            put_texture(r, map, LF_SLOT_NORMAL, file->picture);
        break;
    case LF_MAP_COVER:
    case LF_MAP_USES:
        take_cover(r, map, file);
        break;
    }
}

static lf_status read_map(map_reading *r, const lf_map *map, lf_error *err)
{
    picture_file *file;
    lf_status status = find_file(r, map, &file, err);
    if (status != LF_OK)
        return status;
    if (file->picture > 0)
        use_map(r, map, file);
    else if (map->use == LF_MAP_EMISSION) /* which is black nearly everywhere */
        r->source[map->source].emission = lf_v3(0, 0, 0);
    return LF_OK;
}

/* Drops masks and height maps, which have been processed. */
static void drop_unused(lf_source_material *source, const lf_map *maps, size_t n_maps,
                        lf_mesh_data *out, uint32_t *number)
{
    int kept = 0;
    for (size_t i = 0; i < n_maps; i++)
        for (int s = 0; s < LF_SLOTS; s++)
            number[source[maps[i].source].textures.slot[s].picture] = 1;
    number[0] = 0;
    for (int i = 0; i < out->n_pictures; i++) {
        if (number[i + 1] == 0) {
            lf_free(out->pictures[i].rgba);
            continue;
        }
        out->pictures[kept++] = out->pictures[i];
        number[i + 1] = (uint32_t)kept;
    }
    out->n_pictures = kept;
}

static void renumber(lf_source_material *source, const lf_map *maps, size_t n_maps,
                     const uint32_t *number, bool *done)
{
    for (size_t i = 0; i < n_maps; i++) {
        lf_texture_set *set = &source[maps[i].source].textures;
        for (int s = 0; s < LF_SLOTS && !done[maps[i].source]; s++)
            set->slot[s].picture = number[set->slot[s].picture];
        done[maps[i].source] = true;
    }
}

lf_status lf_maps_read(const lf_map *maps, size_t n_maps, lf_source_material *source,
                       const bool *used, lf_mesh_data *out, lf_error *err)
{
    bool told[LF_MAX_MATERIALS] = {false}, done[LF_MAX_MATERIALS] = {false};
    if (n_maps == 0)
        return LF_OK;
    map_reading r = {
        .source = source, .out = out, .files = lf_calloc(n_maps, sizeof *r.files), .told = told};
    uint32_t *number = lf_calloc(n_maps + 1, sizeof *number);
    out->pictures = lf_calloc(n_maps, sizeof *out->pictures);
    lf_status status = r.files && number && out->pictures ? LF_OK : no_memory(err);
    for (lf_map_use use = LF_MAP_BASE; use < LF_MAP_USES; use++)
        for (size_t i = 0; i < n_maps && status == LF_OK; i++)
            if (maps[i].use == use && used[maps[i].source])
                status = read_map(&r, &maps[i], err);
    if (status == LF_OK) {
        drop_unused(source, maps, n_maps, out, number);
        renumber(source, maps, n_maps, number, done);
    }
    lf_free(r.files);
    lf_free(number);
    return status;
}

void lf_maps_drop(const lf_map *maps, size_t n_maps, lf_source_material *source, const bool *used,
                  lf_warnings *warnings)
{
    size_t n = 0;
    for (size_t i = 0; i < n_maps; i++) {
        if (!used[maps[i].source])
            continue;
        n++;
        if (maps[i].use == LF_MAP_EMISSION)
            source[maps[i].source].emission = lf_v3(0, 0, 0);
    }
    lf_warnings_count(warnings, LF_HERE, (long long)n,
                      "texture is left out: the mesh has no texture coordinates",
                      "textures are left out: the mesh has no texture coordinates");
}
