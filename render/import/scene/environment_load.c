#include "render/import/scene/environment_load.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/image_io.h"
#include "base/log.h"
#include "base/sandbox/raster.h"
#include "render/import/scene/environment_cube.h"
#include "render/import/scene/file_identity.h"
#include "render/transport/light/light.h"

/* Rows of a painted sky: 0.35 degrees each. */
#define PAINTED_HEIGHT 512

static lf_environment *find_in(const lf_scene *scene, const char *key)
{
    for (int i = 0; scene && i < scene->n_lights; i++) {
        lf_environment *environment = scene->lights[i].environment;
        if (environment && strcmp(environment->key, key) == 0) {
            atomic_fetch_add_explicit(&environment->refs, 1, memory_order_relaxed);
            return environment;
        }
    }
    return NULL;
}

/* In this scene or the previous one. */
static lf_environment *find_shared(const lf_scene *scene, const lf_scene *previous, const char *key)
{
    lf_environment *found = find_in(scene, key);
    return found ? found : find_in(previous, key);
}

static void copy_positive(const float *from, size_t n, float *to, const char *path)
{
    size_t clipped = 0;
    for (size_t i = 0; i < n; i++) {
        clipped += from[i] < 0.0f;
        to[i] = fmaxf(from[i], 0.0f);
    }
    if (clipped > 0)
        lf_log(LF_LOG_DEBUG, "%s: %zu values below 0 are read as 0", path, clipped);
}

/* Black, and not committed; NULL = out of memory. */
static lf_environment *create(int width, int height)
{
    lf_environment *environment = lf_calloc(1, sizeof *environment);
    float *rgb = lf_calloc(3 * (size_t)width * (size_t)height, sizeof *rgb);
    if (!environment || !rgb) {
        lf_free(environment);
        lf_free(rgb);
        return NULL;
    }
    atomic_init(&environment->refs, 1);
    environment->width = width;
    environment->height = height;
    environment->rgb = rgb;
    return environment;
}

static void take_warnings(const lf_image_notes *notes, const char *path, lf_warnings *warnings)
{
    char line[512];
    for (size_t at = 0; lf_image_notes_next(notes, &at, line, sizeof line);)
        lf_warnings_add(warnings, path, "%s", line);
}

/* From the image's pixels, or from the converted image of a cube. */
static lf_environment *fill(const lf_raster *picture, const char *path)
{
    const bool cube = picture->meta.layout == LF_IMAGE_CUBE;
    int width = picture->width, height = picture->height;
    if (cube)
        lf_cube_unfolded(picture->width, &width, &height);
    lf_environment *environment = create(width, height);
    if (!environment)
        return NULL;
    if (cube && !lf_cube_unfold(picture->data32, picture->width, width, height, environment->rgb)) {
        lf_environment_unref(environment);
        return NULL;
    }
    copy_positive(cube ? environment->rgb : picture->data32, 3 * (size_t)width * (size_t)height,
                  environment->rgb, path);
    take_warnings(&picture->meta.notes, path, &environment->warnings);
    return environment;
}

static lf_status make_environment(const lf_raster *picture, const char *path, lf_environment **out,
                                  lf_error *err)
{
    lf_environment *environment = fill(picture, path);
    if (!environment)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    lf_status status = lf_environment_commit(environment);
    if (status != LF_OK) {
        lf_environment_unref(environment);
        return lf_error_set(err, status, path, "out of memory for the sampling tables");
    }
    *out = environment;
    return LF_OK;
}

/* Reads and commits. */
static lf_status read_environment(int fd, const char *path, lf_environment **out, lf_error *err)
{
    lf_raster picture;
    lf_status status = lf_raster_import(fd, path, true, &picture, err);
    if (status != LF_OK)
        return status;
    const bool plain = picture.meta.layout == LF_IMAGE_PLAIN;
    if (plain &&
        (picture.width > LF_MAX_ENVIRONMENT_SIDE || picture.height > LF_MAX_ENVIRONMENT_SIDE))
        status = lf_error_set(
            err, LF_E_FORMAT, path,
            "an environment of %d x %d pixels is too large; expected at most %d per side",
            picture.width, picture.height, LF_MAX_ENVIRONMENT_SIDE);
    else
        status = make_environment(&picture, path, out, err);
    lf_raster_close(&picture);
    return status;
}

/* fd: the file, open; what path leads to by now may be another. */
static lf_status share_or_read(int fd, const char *path, const lf_scene *scene,
                               const lf_scene *previous, lf_environment **out, lf_error *err)
{
    lf_digest digest;
    char *key = lf_file_key(fd, path, "");
    if (!key)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    lf_environment *shared = find_shared(scene, previous, key);
    lf_status status = shared ? LF_OK : lf_file_digest(fd, path, &digest, err);
    if (!shared && status == LF_OK)
        status = read_environment(fd, path, out, err);
    if (shared || status != LF_OK) {
        lf_free(key);
        *out = shared ? shared : *out;
        return status;
    }
    (*out)->key = key;
    (*out)->digest = digest;
    return LF_OK;
}

lf_status lf_environment_load(const char *path, const lf_roots *roots, const lf_scene *scene,
                              const lf_scene *previous, lf_environment **out_environment,
                              lf_error *err)
{
    int fd;
    lf_status status = lf_file_open(path, roots, LF_IMAGE_MAX_BYTES, &fd, NULL, err);
    if (status != LF_OK)
        return status;
    status = share_or_read(fd, path, scene, previous, out_environment, err);
    close(fd);
    return status;
}

/* No path begins like that: they are absolute. */
static char *painted_key(const lf_light_kind *kind, const lf_value values[])
{
    char key[1024];
    int at = snprintf(key, sizeof key, "painted %s", kind->name);
    for (int i = 0; kind->keys[i].name; i++) {
        const double *v = values[i].number;
        if (kind->unpainted >> i & 1u)
            continue;
        at += snprintf(key + at, sizeof key - (size_t)at, " %d %.17g %.17g %.17g", values[i].on,
                       v[0], v[1], v[2]);
    }
    return lf_strdup(key);
}

lf_environment *lf_environment_paint(const lf_light_kind *kind, const lf_value values[],
                                     const lf_scene *scene, const lf_scene *previous)
{
    char *key = painted_key(kind, values);
    lf_environment *environment = key ? find_shared(scene, previous, key) : NULL;
    if (!key || environment) {
        lf_free(key);
        return environment;
    }
    environment = create(2 * PAINTED_HEIGHT, PAINTED_HEIGHT);
    if (!environment) {
        lf_free(key);
        return NULL;
    }
    environment->key = key;
    kind->paint(values, environment->width, environment->height, environment->rgb);
    if (lf_environment_commit(environment) == LF_OK)
        return environment;
    lf_environment_unref(environment);
    return NULL;
}
