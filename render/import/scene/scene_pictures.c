#include "render/import/scene/scene_pictures.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/image_io.h"
#include "base/sandbox/import.h"
#include "render/import/scene/file_identity.h"
#include "render/import/scene/geometry_textures.h"
#include "render/import/scene/mesh_take.h"

/* An opened image file. */
typedef struct part {
    char *path; /* NULL: there is none */
    int fd;
    char *key;
    lf_texels texels;
} part;

static void close_part(part *p)
{
    if (p->path && p->fd >= 0)
        close(p->fd);
    lf_free(p->path);
    lf_free(p->key);
    lf_free(p->texels.rgba);
}

static lf_status open_part(const lf_picture_desc *picture, const lf_roots *roots,
                           const char *folder, part *out, lf_error *err)
{
    *out = (part){.fd = -1};
    if (!picture->file)
        return LF_OK;
    out->path = lf_path_join(folder, picture->file);
    if (!out->path)
        return lf_error_set(err, LF_E_NOMEM, picture->file, "out of memory");
    lf_status status = lf_file_open(out->path, roots, LF_IMAGE_MAX_BYTES, &out->fd, NULL, err);
    if (status != LF_OK)
        return status;
    out->key = lf_file_key(out->fd, out->path, "");
    return out->key ? LF_OK : lf_error_set(err, LF_E_NOMEM, out->path, "out of memory");
}

/* ----------------------------------------------------------------------------------- sharing -- */

static lf_scene_picture *find_in(const lf_scene *scene, const char *key)
{
    for (int i = 0; scene && i < LF_OWN_SLOTS * scene->n_own_textures; i++) {
        lf_scene_picture *had = scene->own_textures[i / LF_OWN_SLOTS].picture[i % LF_OWN_SLOTS];
        if (had && strcmp(had->key, key) == 0) {
            atomic_fetch_add_explicit(&had->refs, 1, memory_order_relaxed);
            return had;
        }
    }
    return NULL;
}

/* Key of both files and their processing. NULL = out of memory. */
static char *key_of(const part parts[2], lf_slot slot, lf_texels_use use, float threshold)
{
    const char *first = parts[0].key ? parts[0].key : "",
               *second = parts[1].key ? parts[1].key : "";
    const size_t size = strlen(first) + strlen(second) + 64;
    char *key = lf_calloc(size, 1);
    if (key)
        snprintf(key, size, "%d %d %.9g %s\n%s", (int)slot, (int)use, (double)threshold, first,
                 second);
    return key;
}

/* ----------------------------------------------------------------------------------- reading -- */

static lf_status take_texels(const lf_parcel *parcel, const char *path, lf_texels *out,
                             lf_error *err)
{
    lf_mesh_data one = {0};
    lf_error wrong = {0};
    lf_status status = lf_mesh_take_pictures(parcel, &one, &wrong);
    if (status == LF_OK && one.n_pictures != 1)
        status = lf_error_set(&wrong, LF_E_FORMAT, path, "the reader's answer has no image");
    if (status == LF_OK) {
        *out = one.pictures[0];
        one.pictures[0].rgba = NULL;
    } else {
        lf_error_set(err, status, path, "%s", wrong.what);
    }
    lf_mesh_data_finish(&one);
    return status;
}

static lf_status read_part(part *p, lf_digest *digest, lf_error *err)
{
    lf_import_request request = {.kind = LF_IMPORT_TEXTURE};
    lf_parcel parcel = {0};
    if (!p->path)
        return LF_OK;
    lf_status status = lf_file_digest(p->fd, p->path, digest, err);
    /* only for messages: the file is open already */
    snprintf(request.path, sizeof request.path, "%s", p->path);
    if (status == LF_OK)
        status = lf_import_run(&request, p->fd, p->path, NULL, NULL, &parcel, err);
    if (status == LF_OK)
        status = take_texels(&parcel, p->path, &p->texels, err);
    lf_parcel_close(&parcel);
    return status;
}

/* ------------------------------------------------------------------------------ put together -- */

/* Whether an image contains coverage: its alpha, else its brightness. */
static bool has_holes(const lf_texels *p)
{
    const size_t n = (size_t)p->width * (size_t)p->height;
    for (size_t i = 0; i < n; i++)
        if (p->rgba[4 * i + 3] < 255)
            return true;
    return false;
}

/* The texel of p at the position of (x, y) in an image of another size. */
static const uint8_t *texel_at(const lf_texels *p, const lf_texels *of, int x, int y)
{
    const size_t column = (size_t)((int64_t)x * p->width / of->width),
                 row = (size_t)((int64_t)y * p->height / of->height);
    return p->rgba + 4 * (row * (size_t)p->width + column);
}

static void put_cover(const uint8_t *from, bool by_alpha, uint8_t *to)
{
    to[3] = by_alpha ? from[3] : (uint8_t)((from[0] + from[1] + from[2] + 1) / 3);
}

/* Combines the second part with the first, which is white if there is none: coverage, or metallic.
 */
static void combine(lf_slot slot, const part parts[2], lf_texels *out)
{
    const lf_texels *first = &parts[0].texels, *second = &parts[1].texels;
    const bool by_alpha = second->rgba && slot == LF_SLOT_BASE && has_holes(second);
    for (int y = 0; y < out->height; y++)
        for (int x = 0; x < out->width; x++) {
            uint8_t *to = out->rgba + 4 * ((size_t)y * (size_t)out->width + (size_t)x);
            memset(to, 255, 4);
            if (first->rgba)
                memcpy(to, texel_at(first, out, x, y), slot == LF_SLOT_BASE ? 3 : 2);
            if (second->rgba && slot == LF_SLOT_BASE)
                put_cover(texel_at(second, out, x, y), by_alpha, to);
            else if (second->rgba)
                to[2] = texel_at(second, out, x, y)[2];
        }
}

static lf_status put_together(lf_slot slot, part parts[2], lf_texels *out)
{
    part *first = &parts[parts[0].path ? 0 : 1];
    *out = (lf_texels){first->texels.width, first->texels.height, NULL};
    if (slot != LF_SLOT_BASE && slot != LF_SLOT_METAL_ROUGH) {
        *out = first->texels;
        first->texels.rgba = NULL;
        return LF_OK;
    }
    out->rgba = lf_calloc((size_t)out->width * (size_t)out->height, 4);
    if (!out->rgba)
        return LF_E_NOMEM;
    combine(slot, parts, out);
    return LF_OK;
}

static lf_status make(lf_slot slot, part parts[2], lf_texels_use use, float threshold,
                      lf_scene_picture **out, int *out_part, lf_error *err)
{
    lf_scene_picture *picture = lf_calloc(1, sizeof *picture);
    lf_status status = picture ? LF_OK : lf_error_set(err, LF_E_NOMEM, "picture", "out of memory");
    if (!picture)
        return status;
    atomic_init(&picture->refs, 1);
    for (int i = 0; i < 2 && status == LF_OK; i++) {
        *out_part = i;
        status = read_part(&parts[i], &picture->digest[i], err);
    }
    if (status == LF_OK &&
        (put_together(slot, parts, &picture->texels) != LF_OK ||
         lf_pyramid_make(&picture->texels, use, threshold, &picture->pyramid) != LF_OK))
        status = lf_error_set(err, LF_E_NOMEM, "picture", "out of memory");
    if (status == LF_OK)
        *out = picture;
    else
        lf_scene_picture_unref(picture);
    return status;
}

lf_status lf_scene_picture_load(const lf_picture_desc picture[2], const lf_material *material,
                                lf_slot slot, const lf_roots *roots, const lf_scene *scene,
                                const lf_scene *previous, lf_scene_picture **out, int *out_part,
                                lf_error *err)
{
    part parts[2] = {{.fd = -1}, {.fd = -1}};
    float threshold;
    const lf_texels_use use = lf_slot_use(material, (int)slot, &threshold);
    lf_status status = LF_OK;
    for (int i = 0; i < 2 && status == LF_OK; i++) {
        *out_part = i;
        status = open_part(&picture[i], roots, scene->file.folder, &parts[i], err);
    }
    char *key = status == LF_OK ? key_of(parts, slot, use, threshold) : NULL;
    lf_scene_picture *shared = key ? find_in(scene, key) : NULL;
    if (key && !shared)
        shared = find_in(previous, key);
    if (status == LF_OK && !key)
        status = lf_error_set(err, LF_E_NOMEM, "picture", "out of memory");
    *out = shared;
    if (status == LF_OK && !shared) {
        status = make(slot, parts, use, threshold, out, out_part, err);
        if (status == LF_OK) {
            (*out)->key = key;
            key = NULL;
        }
    }
    lf_free(key);
    for (int i = 0; i < 2; i++)
        close_part(&parts[i]);
    return status;
}
