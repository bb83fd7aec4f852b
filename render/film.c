#include "render/film.h"

#include <string.h>
#include <sys/mman.h>

#include "base/alloc.h"

lf_status lf_film_init(lf_film *film, int n_views, int width, int height, bool has_w2, bool has_native)
{
    size_t pixels = (size_t)n_views * (size_t)width;
    size_t pixel_bytes =
        sizeof(lf_film_scattered) + sizeof(lf_film_known) + (has_w2 ? sizeof(float) : 0) + (has_native ? 3 * sizeof(float) : 0);
    *film = (lf_film){.n_views = n_views, .width = width, .height = height, .has_w2 = has_w2, .has_native = has_native};
    film->row_bytes = (2 * pixels * pixel_bytes + 63) / 64 * 64;
    film->data_bytes = film->row_bytes * (size_t)height;
    film->rows = lf_calloc((size_t)height, sizeof *film->rows);
    /* Mapped, so that rows cost memory only from their first visit on. */
    void *data = mmap(NULL, film->data_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    film->data = data == MAP_FAILED ? NULL : data;
    if (!film->data || !film->rows) {
        lf_film_finish(film);
        return LF_E_NOMEM;
    }
    lf_film_clear(film);
    return LF_OK;
}

void lf_film_finish(lf_film *film)
{
    if (film->data)
        munmap(film->data, film->data_bytes);
    lf_free(film->rows);
    memset(film, 0, sizeof *film);
}

void lf_film_clear(lf_film *film)
{
    for (int row = 0; row < film->height; row++)
        film->rows[row] = (lf_film_row){.relative_error = -1.0};
}

lf_film_half lf_film_at(const lf_film *film, int row, int half)
{
    size_t pixels = (size_t)film->n_views * (size_t)film->width;
    unsigned char *p = film->data + (size_t)row * film->row_bytes;
    lf_film_half h = {0};
    for (int i = 0; i <= half; i++) {
        h.scattered = (lf_film_scattered *)(void *)p;
        p += pixels * sizeof *h.scattered;
        h.known = (lf_film_known *)(void *)p;
        p += pixels * sizeof *h.known;
        h.w2 = film->has_w2 ? (float *)(void *)p : NULL;
        p += film->has_w2 ? pixels * sizeof(float) : 0;
        h.native = film->has_native ? (float(*)[3])(void *)p : NULL;
        p += film->has_native ? pixels * sizeof *h.native : 0;
    }
    return h;
}

void lf_film_row_begin(lf_film *film, int row)
{
    memset(film->data + (size_t)row * film->row_bytes, 0, film->row_bytes);
}
