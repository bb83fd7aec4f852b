#include "render/load/environment_load.h"

#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/image_io.h"
#include "base/log.h"
#include "render/load/file_identity.h"
#include "render/transport/light.h"

static lf_environment *find_shared(const lf_scene *previous, const char *key)
{
    for (int i = 0; previous && i < previous->n_lights; i++) {
        lf_environment *environment = previous->lights[i].environment;
        if (environment && strcmp(environment->key, key) == 0) {
            atomic_fetch_add_explicit(&environment->refs, 1, memory_order_relaxed);
            return environment;
        }
    }
    return NULL;
}

static void clip_negative(lf_image32 *image, const char *path)
{
    size_t n = (size_t)image->width * (size_t)image->height * 3, clipped = 0;
    for (size_t i = 0; i < n; i++) {
        clipped += image->data[i] < 0.0f;
        image->data[i] = fmaxf(image->data[i], 0.0f);
    }
    if (clipped > 0)
        lf_log(LF_LOG_DEBUG, "%s: %zu values below 0 taken as 0", path, clipped);
}

/* Reads and commits. */
static lf_status read_environment(int fd, const char *path, lf_environment **out, lf_error *err)
{
    lf_image32 image = {0};
    lf_status status = lf_image32_read_open(fd, path, &image, err);
    if (status != LF_OK)
        return status;
    if (image.width > LF_MAX_ENVIRONMENT_SIDE || image.height > LF_MAX_ENVIRONMENT_SIDE) {
        lf_image32_finish(&image);
        return lf_error_set(err, LF_E_FORMAT, path,
                            "%d x %d pixels; an environment has at most %d a side", image.width,
                            image.height, LF_MAX_ENVIRONMENT_SIDE);
    }
    clip_negative(&image, path);
    lf_environment *environment = lf_calloc(1, sizeof *environment);
    if (!environment) {
        lf_image32_finish(&image);
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    }
    atomic_init(&environment->refs, 1);
    environment->width = image.width;
    environment->height = image.height;
    environment->rgb = image.data;
    status = lf_environment_commit(environment);
    if (status != LF_OK) {
        lf_environment_unref(environment);
        return lf_error_set(err, status, path, "out of memory for the sampling tables");
    }
    *out = environment;
    return LF_OK;
}

/* fd: the file, open; what path leads to by now may be another. */
static lf_status share_or_read(int fd, const char *path, const lf_scene *previous,
                               lf_environment **out, lf_error *err)
{
    lf_digest digest;
    char *key = lf_file_key(fd, path, "");
    if (!key)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    lf_environment *shared = find_shared(previous, key);
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

lf_status lf_environment_load(const char *path, const lf_roots *roots, const lf_scene *previous,
                              lf_environment **out_environment, lf_error *err)
{
    int fd;
    lf_status status = lf_file_open(path, roots, (uint64_t)4 << 30, &fd, NULL, err);
    if (status != LF_OK)
        return status;
    status = share_or_read(fd, path, previous, out_environment, err);
    close(fd);
    return status;
}
