/* Textures of glTF: image, coordinates and transform; and loading of the images. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/image_rgba.h"
#include "base/sandbox/reader.h"
#include "render/import/reader/gltf_material.h"

#define NEAREST 9728
#define BILINEAR 9729
#define CLAMP_TO_EDGE 33071
#define MIRRORED_REPEAT 33648

static uint8_t wrap_of(const json_t *sampler, const char *key)
{
    uint64_t wrap = lf_gltf_whole(sampler, key, 0);
    return wrap == CLAMP_TO_EDGE     ? LF_WRAP_CLAMP
           : wrap == MIRRORED_REPEAT ? LF_WRAP_MIRROR
                                     : LF_WRAP_REPEAT;
}

/* The image of a texture: one in a format that cannot be read counts only without another. */
static uint64_t image_of(const lf_gltf *gltf, const json_t *texture)
{
    const json_t *webp = lf_gltf_extension(texture, "EXT_texture_webp");
    uint64_t image = lf_gltf_whole(texture, "source", LF_GLTF_NONE);
    if (image >= LF_GLTF_NONE)
        image = lf_gltf_whole(webp, "source", LF_GLTF_NONE);
    return image < lf_gltf_count(gltf->json, "images") ? image : LF_GLTF_NONE;
}

static void take_transform(const json_t *transform, lf_texture *out)
{
    double offset[2] = {0, 0}, scale[2] = {1, 1};
    (void)lf_gltf_numbers(transform, "offset", 2, offset);
    (void)lf_gltf_numbers(transform, "scale", 2, scale);
    lf_texture_lay(offset, (double)lf_gltf_number(transform, "rotation", 0), scale, out->map);
}

static bool is_sound(const lf_texture *t)
{
    for (int i = 0; i < 6; i++)
        if (!(fabsf(t->map[i / 3][i % 3]) <= LF_MAX_UV))
            return false;
    return fabsf(t->scale) <= LF_MAX_UV;
}

lf_texture lf_gltf_texture(const lf_gltf *gltf, const json_t *object, const char *key,
                           lf_lost *out_why)
{
    const json_t *info = json_object_get(object, key),
                 *transform = lf_gltf_extension(info, "KHR_texture_transform"),
                 *texture = lf_gltf_element(gltf->json, "textures",
                                            lf_gltf_whole(info, "index", LF_GLTF_NONE)),
                 *sampler = lf_gltf_element(gltf->json, "samplers",
                                            lf_gltf_whole(texture, "sampler", LF_GLTF_NONE));
    uint64_t image = image_of(gltf, texture),
             set = lf_gltf_whole(transform, "texCoord", lf_gltf_whole(info, "texCoord", 0));
    if (!json_is_object(info))
        return (lf_texture){0};
    lf_texture out = {.picture = (uint32_t)image + 1,
                      .wrap_u = wrap_of(sampler, "wrapS"),
                      .wrap_v = wrap_of(sampler, "wrapT"),
                      .set = (uint8_t)(set < LF_UV_SETS ? set : 0),
                      .nearest = lf_gltf_whole(sampler, "magFilter", 0) == NEAREST,
                      .scale = lf_gltf_number(info, "scale", 1)};
    uint64_t smaller = lf_gltf_whole(sampler, "minFilter", 0);
    out.finest = smaller == NEAREST || smaller == BILINEAR;
    take_transform(transform, &out);
    if (image < LF_GLTF_NONE && set < LF_UV_SETS && is_sound(&out))
        return out;
    *out_why = image < LF_GLTF_NONE                               ? LF_LOST_UV_SET
               : lf_gltf_extension(texture, "KHR_texture_basisu") ? LF_LOST_KTX2
                                                                  : LF_LOST_TEXTURE;
    return (lf_texture){0};
}

/* ------------------------------------------------------------------------------------ images -- */

/* The bytes of an image. LF_E_PATH: its file is not accessible. *out_own: the caller must free
 * them. */
static lf_status find_bytes(lf_gltf *gltf, const json_t *image, lf_gltf_view *out,
                            unsigned char **out_own, lf_error *err)
{
    const char *uri = json_string_value(json_object_get(image, "uri"));
    lf_gltf_bytes bytes;
    *out_own = NULL;
    if (!uri)
        return lf_gltf_view_open(gltf, lf_gltf_whole(image, "bufferView", LF_GLTF_NONE), out, err);
    lf_status status = lf_gltf_fetch(gltf, uri, 0, &bytes, err);
    if (status == LF_OK) {
        *out = (lf_gltf_view){.data = bytes.data, .size = bytes.size};
        *out_own = bytes.data;
    }
    return status;
}

static lf_status decode(lf_gltf *gltf, uint32_t number, lf_texels *out, lf_error *err)
{
    lf_gltf_view view;
    unsigned char *own;
    const json_t *image = lf_gltf_element(gltf->json, "images", number);
    lf_status status = find_bytes(gltf, image, &view, &own, err);
    if (status != LF_OK)
        return status;
    status = lf_image_rgba_decode(view.data, view.size, LF_HERE, &out->rgba, &out->width,
                                  &out->height, err);
    free(own);
    return status;
}

/* State of an image: its number in out->pictures plus 1, or 0 if it was not decoded yet. */
#define FAILED UINT32_MAX

/* By its file, its name, or else its number. */
static void warn_of(const lf_gltf *gltf, uint32_t number, bool missing, const char *what,
                    lf_mesh_data *out)
{
    const json_t *image = lf_gltf_element(gltf->json, "images", number);
    const char *uri = lf_gltf_text(image, "uri"), *name = lf_gltf_text(image, "name"),
               *called = uri[0] && strncmp(uri, "data:", 5) != 0 ? uri : name;
    if (missing)
        lf_warnings_add(
            &out->warnings, LF_HERE,
            "texture \"%.200s\" is missing or may not be read; the material is used without it",
            called);
    else if (called[0])
        lf_warnings_add(&out->warnings, LF_HERE,
                        "texture \"%.200s\": %s; the material is used without it", called, what);
    else
        lf_warnings_add(&out->warnings, LF_HERE,
                        "texture %u (images[%u]): %s; the material is used without it", number,
                        number, what);
}

static void find_picture(lf_gltf *gltf, uint32_t image, uint32_t *found, lf_mesh_data *out)
{
    lf_error wrong = {0};
    if (*found != 0)
        return;
    *found = FAILED;
    lf_status status = decode(gltf, image, &out->pictures[out->n_pictures], &wrong);
    if (status == LF_OK)
        *found = (uint32_t)++out->n_pictures;
    else if (wrong.what[0])
        warn_of(gltf, image, status == LF_E_PATH, wrong.what, out);
}

static void take_pictures(lf_gltf *gltf, lf_source_material *source, uint32_t *found,
                          lf_mesh_data *out)
{
    for (int slot = 0; slot < LF_SLOTS; slot++) {
        lf_texture *texture = &source->textures.slot[slot];
        if (texture->picture == 0)
            continue;
        uint32_t image = texture->picture - 1;
        find_picture(gltf, image, &found[image], out);
        if (found[image] != FAILED) {
            texture->picture = found[image];
            continue;
        }
        *texture = (lf_texture){0};
        source->lost |= slot == LF_SLOT_EMISSION ? 1u << LF_LOST_EMISSION : 0;
        source->lacks_base = source->lacks_base || slot == LF_SLOT_BASE;
    }
}

lf_status lf_gltf_pictures(lf_gltf *gltf, lf_source_material *source, size_t n, const bool *used,
                           lf_mesh_data *out, lf_error *err)
{
    size_t n_images = lf_gltf_count(gltf->json, "images");
    uint32_t *found = lf_calloc(n_images + 1, sizeof *found);
    out->pictures = lf_calloc(n_images + 1, sizeof *out->pictures);
    if (!found || !out->pictures) {
        lf_free(found);
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    }
    for (size_t i = 0; i < n; i++)
        if (used[i])
            take_pictures(gltf, &source[i], found, out);
        else
            source[i].textures = (lf_texture_set){0};
    lf_free(found);
    if (out->n_pictures == 0) {
        lf_free(out->pictures);
        out->pictures = NULL;
    }
    return LF_OK;
}
