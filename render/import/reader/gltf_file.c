#include "render/import/reader/gltf_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/sandbox/reader.h"
#include "base/text.h"
#include "render/import/reader/words.h"

#define JSON_CHUNK 0x4e4f534au
#define BINARY_CHUNK 0x004e4942u

static lf_status refuse(lf_error *err, const char *what, uint64_t has, uint64_t room)
{
    return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                        "cannot be read as a mesh: %s needs %llu bytes but has %llu", what,
                        (unsigned long long)has, (unsigned long long)room);
}

static bool read_words(int fd, uint64_t at, uint32_t *words, size_t n)
{
    return pread(fd, words, n * sizeof *words, (off_t)at) == (ssize_t)(n * sizeof *words);
}

static bool is_kind(uint32_t word)
{
    return word == JSON_CHUNK || word == BINARY_CHUNK;
}

/* Start of the next chunk, from this one's length. Some writers count the bytes that pad a chunk to
 * a multiple of four, some do not write them, and some write but do not count them. */
static uint64_t behind_chunk(int fd, uint64_t at, uint32_t length)
{
    uint64_t end = at + length, padded = end + (4 - length % 4) % 4;
    uint32_t here[2] = {0}, there[2] = {0};
    if (padded == end || (read_words(fd, end, here, 2) && is_kind(here[1])))
        return end;
    return read_words(fd, padded, there, 2) && is_kind(there[1]) ? padded : end;
}

/* A GLB: 12 bytes, then chunks of a length, a kind, and their bytes. Other kinds are ignored, as
 * are bytes after the last chunk. */
static lf_status find_chunks(lf_gltf *gltf, lf_error *err)
{
    uint32_t header[3] = {0}, chunk[2];
    (void)read_words(gltf->fd, 0, header, 3);
    if (header[2] > gltf->size)
        return refuse(err, "the GLB file", header[2], gltf->size);
    if (header[1] != 2)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "cannot be read as a mesh: GLB version %u; expected 2", header[1]);
    for (uint64_t at = sizeof header, end = header[2];
         at + sizeof chunk <= end && read_words(gltf->fd, at, chunk, 2);) {
        at += sizeof chunk;
        if (chunk[0] > end - at && !is_kind(chunk[1]) && gltf->length > 0)
            break;
        if (chunk[0] > end - at)
            return refuse(err, "a chunk", chunk[0], end - at);
        if (chunk[1] == JSON_CHUNK && gltf->length == 0) {
            gltf->begin = at;
            gltf->length = chunk[0];
        } else if (chunk[1] == BINARY_CHUNK && !gltf->has_binary) {
            gltf->binary_at = at;
            gltf->binary = chunk[0];
            gltf->has_binary = true;
        }
        at = behind_chunk(gltf->fd, at, chunk[0]);
    }
    return LF_OK;
}

/* Start of a text with a JSON object, after a byte order mark and blanks; its size if there is
 * none. LF_E_FORMAT: text that is not UTF-8. */
static lf_status find_object(int fd, uint64_t size, uint64_t *out, lf_error *err)
{
    char begin[256];
    ssize_t n = pread(fd, begin, sizeof begin, 0);
    size_t at = 0, end = n > 0 ? (size_t)n : 0;
    lf_status status = lf_text_begin(begin, end, LF_HERE, &at, err);
    while (at < end && lf_is_blank(begin[at]))
        at++;
    *out = at < end && begin[at] == '{' ? at : size;
    return status;
}

static lf_status no_json(const json_error_t *wrong, lf_error *err)
{
    if (wrong->text[0] && json_error_code(wrong) == json_error_out_of_memory)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    if (wrong->text[0])
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "cannot be read as a mesh: line %d of its JSON: %s", wrong->line,
                            wrong->text);
    return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                        "cannot be read as a mesh: neither a JSON object nor a GLB file");
}

static lf_status load_json(lf_gltf *gltf, lf_error *err)
{
    json_error_t wrong = {.text = ""};
    char *text = malloc((size_t)gltf->length + 1);
    if (!text)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    size_t n = (size_t)gltf->length;
    lf_status status = LF_OK;
    if (n > 0 && pread(gltf->fd, text, n, (off_t)gltf->begin) == (ssize_t)n) {
        text[n] = '\0';
        status = lf_text_take(text, &n, LF_HERE, err);
        if (status == LF_OK)
            gltf->json =
                json_loadb(text, n, JSON_DISABLE_EOF_CHECK | JSON_DECODE_INT_AS_REAL, &wrong);
    }
    free(text);
    if (status != LF_OK)
        return status;
    return json_is_object(gltf->json) ? LF_OK : no_json(&wrong, err);
}

/* ----------------------------------------------------------------------- required extensions -- */

static const char *const known_extensions[] = {"EXT_mesh_gpu_instancing",
                                               "EXT_meshopt_compression",
                                               "EXT_texture_webp",
                                               "KHR_animation_pointer",
                                               "KHR_draco_mesh_compression",
                                               "KHR_lights_punctual",
                                               "KHR_materials_anisotropy",
                                               "KHR_materials_clearcoat",
                                               "KHR_materials_diffuse_transmission",
                                               "KHR_materials_dispersion",
                                               "KHR_materials_emissive_strength",
                                               "KHR_materials_ior",
                                               "KHR_materials_iridescence",
                                               "KHR_materials_pbrSpecularGlossiness",
                                               "KHR_materials_sheen",
                                               "KHR_materials_specular",
                                               "KHR_materials_transmission",
                                               "KHR_materials_unlit",
                                               "KHR_materials_variants",
                                               "KHR_materials_volume",
                                               "KHR_mesh_quantization",
                                               "KHR_node_visibility",
                                               "KHR_texture_basisu",
                                               "KHR_texture_transform",
                                               "KHR_xmp_json_ld"};

bool lf_gltf_knows(const char *name)
{
    for (size_t i = 0; i < sizeof known_extensions / sizeof *known_extensions; i++)
        if (strcmp(name, known_extensions[i]) == 0)
            return true;
    return false;
}

/* minVersion: what a reader has to know at least. */
static lf_status check_version(const json_t *asset, lf_error *err)
{
    const char *version = lf_gltf_text(asset, "version"),
               *least = lf_gltf_text(asset, "minVersion");
    if (least[0] && strcmp(least, "2.0") != 0)
        version = least;
    else if (!version[0] || strncmp(version, "2.", 2) == 0)
        return LF_OK;
    return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                        "cannot be read as a mesh: glTF version %.16s; expected 2.0", version);
}

static lf_status check_required(const lf_gltf *gltf, lf_error *err)
{
    const json_t *required = json_object_get(gltf->json, "extensionsRequired");
    char names[256] = "";
    size_t at = 0;
    for (size_t i = 0; i < json_array_size(required) && at < sizeof names; i++) {
        const char *name = json_string_value(json_array_get(required, i));
        if (name && !lf_gltf_knows(name))
            at += (size_t)snprintf(names + at, sizeof names - at, "%s%.80s", at ? ", " : "", name);
    }
    if (names[0])
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "it requires glTF extensions that are not supported: %s", names);
    return LF_OK;
}

/* --------------------------------------------------------------------------------------- all -- */

static lf_status make_tables(lf_gltf *gltf, lf_error *err)
{
    gltf->n_buffers = lf_gltf_count(gltf->json, "buffers");
    gltf->n_views = lf_gltf_count(gltf->json, "bufferViews");
    gltf->buffers = calloc(gltf->n_buffers + 1, sizeof *gltf->buffers);
    gltf->views = calloc(gltf->n_views + 1, sizeof *gltf->views);
    return gltf->buffers && gltf->views ? LF_OK
                                        : lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
}

lf_status lf_gltf_open(lf_gltf *gltf, int fd, const char *path, lf_error *err)
{
    struct stat info;
    char first[4] = "";
    lf_status status = LF_OK;
    *gltf = (lf_gltf){.fd = fd, .path = path};
    if (fstat(fd, &info) != 0)
        return lf_error_set(err, LF_E_IO, LF_HERE, "cannot be read");
    gltf->size = (uint64_t)info.st_size;
    (void)!pread(fd, first, sizeof first, 0);
    if (memcmp(first, "glTF", sizeof first) == 0) {
        status = find_chunks(gltf, err);
    } else {
        status = find_object(fd, gltf->size, &gltf->begin, err);
        gltf->length = gltf->size - gltf->begin;
    }
    if (status == LF_OK)
        status = load_json(gltf, err);
    if (status == LF_OK)
        status = check_version(json_object_get(gltf->json, "asset"), err);
    if (status == LF_OK)
        status = check_required(gltf, err);
    return status == LF_OK ? make_tables(gltf, err) : status;
}

void lf_gltf_close(lf_gltf *gltf)
{
    for (size_t i = 0; gltf->buffers && i < gltf->n_buffers; i++)
        free(gltf->buffers[i].data);
    for (size_t i = 0; gltf->views && i < gltf->n_views; i++)
        free(gltf->views[i].data);
    free(gltf->buffers);
    free(gltf->views);
    json_decref(gltf->json);
    *gltf = (lf_gltf){0};
}
