/* The accumulation as a file: a header that says whose it is, the rows' counts, and the sums of the rows that were visited. Little-endian;
 * only the same scene, rig, seed and integrator take it back. */
#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "render/renderer.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "the state file is written as it lies in memory; other byte orders need a conversion here"
#endif

typedef struct lf_state_header {
    char magic[8];
    uint32_t version, n_views, width, height;
    uint64_t key, row_bytes;
} lf_state_header;

static uint64_t hash_bytes(uint64_t h, const void *data, size_t n)
{
    const unsigned char *p = data;
    for (size_t i = 0; i < n; i++)
        h = (h ^ p[i]) * 0x100000001b3u;
    return h;
}

static void make_header(const lf_renderer *r, lf_state_header *h)
{
    char *json = json_dumps(r->scene->json, JSON_COMPACT | JSON_SORT_KEYS);
    uint64_t key = hash_bytes(0xcbf29ce484222325u, json ? json : "", json ? strlen(json) : 0);
    free(json);
    key = hash_bytes(key, r->settings.integrator, strlen(r->settings.integrator));
    key = hash_bytes(key, &r->settings.seed, sizeof r->settings.seed);
    key = hash_bytes(key, &r->settings.sampler, sizeof r->settings.sampler);
    key = hash_bytes(key, &r->rig, sizeof r->rig);
    key = hash_bytes(key, &r->plan.max_depth, sizeof r->plan.max_depth);
    for (int i = 0; i < r->scene->n_volumes; i++) {
        const char *file = r->scene->volumes[i].grid ? r->scene->volumes[i].grid->key : "";
        key = hash_bytes(key, file, strlen(file));
    }
    memset(h, 0, sizeof *h);
    memcpy(h->magic, "quiltdST", 8);
    h->version = 3;
    h->n_views = (uint32_t)r->film.n_views;
    h->width = (uint32_t)r->film.width;
    h->height = (uint32_t)r->film.height;
    h->key = key;
    h->row_bytes = r->film.row_bytes;
}

static bool visited(const lf_film_row *row)
{
    return row->visits[0] + row->visits[1] > 0;
}

lf_status lf_renderer_save(const lf_renderer *renderer, lf_outfile *file, const lf_cancel *cancel, lf_error *err)
{
    const lf_film *film = &renderer->film;
    lf_state_header header;
    make_header(renderer, &header);
    lf_status status = lf_outfile_write(file, &header, sizeof header, err);
    if (status == LF_OK)
        status = lf_outfile_write(file, film->rows, (size_t)film->height * sizeof *film->rows, err);
    for (int row = 0; row < film->height && status == LF_OK; row++) {
        if (cancel && atomic_load_explicit(cancel, memory_order_relaxed))
            return lf_error_set(err, LF_E_CANCELLED, "state", "interrupted");
        if (visited(&film->rows[row]))
            status = lf_outfile_write(file, film->data + (size_t)row * film->row_bytes, film->row_bytes, err);
    }
    return status;
}

static lf_status read_all(int fd, void *data, size_t n, lf_error *err)
{
    char *p = data;
    while (n > 0) {
        ssize_t got = read(fd, p, n);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return lf_error_set(err, LF_E_IO, "state", "cannot read: %s", strerror(errno));
        if (got == 0)
            return lf_error_set(err, LF_E_FORMAT, "state", "the file ends too early");
        p += got;
        n -= (size_t)got;
    }
    return LF_OK;
}

static bool plausible(const lf_film_row *row)
{
    for (int h = 0; h < 2; h++) {
        if (!(row->n[h] >= 0.0 && row->n[h] < 1e12) || (row->n[h] > 0.0) != (row->visits[h] > 0))
            return false;
    }
    return row->passes >= 0.0 && row->passes < 1e15;
}

lf_status lf_renderer_restore(lf_renderer *renderer, int fd, lf_error *err)
{
    lf_film *film = &renderer->film, restored = {0};
    lf_state_header header, mine;
    make_header(renderer, &mine);
    lf_status status = read_all(fd, &header, sizeof header, err);
    if (status != LF_OK)
        return status;
    if (memcmp(&header, &mine, sizeof mine) != 0)
        return lf_error_set(err, LF_E_STATE, "state", "the saved picture is of another scene, camera or version");
    if (lf_film_init(&restored, &film->layout) != LF_OK)
        return lf_error_set(err, LF_E_NOMEM, "state", "not enough memory to read it");
    status = read_all(fd, restored.rows, (size_t)film->height * sizeof *film->rows, err);
    for (int row = 0; row < film->height && status == LF_OK; row++) {
        if (!plausible(&restored.rows[row]))
            status = lf_error_set(err, LF_E_FORMAT, "state", "row %d has impossible counts", row);
        else if (visited(&restored.rows[row]))
            status = read_all(fd, restored.data + (size_t)row * film->row_bytes, film->row_bytes, err);
    }
    memcpy(restored.sky, film->sky, sizeof restored.sky);
    if (status != LF_OK) {
        lf_film_finish(&restored);
        return status;
    }
    lf_film_finish(film);
    *film = restored;
    return LF_OK;
}
