#include "render/film/film_pack.h"

#include <assert.h>
#include <pthread.h>
#include <string.h>

#include "base/alloc.h"

/* Memory behind a packed row is returned from this size on. */
#define RETURN_FROM ((size_t)1 << 16)

/* Memory of an open row. */
typedef struct lf_row_memory {
    unsigned char *data;
    uint64_t used; /* when it was last opened */
    int row;       /* -1: none */
    int users;
    bool changed; /* since it was packed */
    bool busy;    /* it is being packed or unpacked, without the lock */
} lf_row_memory;

struct lf_film_packed {
    lf_pack_planes planes;
    size_t row_bytes, lines, room; /* of a row: open, the same in lines, packed */
    size_t open_bytes;             /* of an open row and what it is arranged with */
    unsigned char *data;           /* [height][room] */
    size_t *bytes;                 /* [height] packed; 0: undefined */
    size_t *touched;               /* [height] */
    unsigned char **at;            /* [height] under the lock; NULL: not open */
    int *open_of;                  /* [height] under the lock; -1: none */
    lf_row_memory *open;
    unsigned char *memory; /* of all open rows */
    uint64_t clock;
    int n_open, n_threads, height;
    pthread_mutex_t lock;
    pthread_cond_t closed;
};

static bool make(lf_film_packed *p)
{
    const size_t height = (size_t)p->height, n = (size_t)p->n_open;
    p->data = lf_pages(height, p->room);
    p->memory = lf_pages(n, p->open_bytes);
    p->bytes = lf_calloc(height, sizeof *p->bytes);
    p->touched = lf_calloc(height, sizeof *p->touched);
    p->at = lf_calloc(height, sizeof *p->at);
    p->open_of = lf_calloc(height, sizeof *p->open_of);
    p->open = lf_calloc(n, sizeof *p->open);
    if (!p->data || !p->memory || !p->bytes || !p->touched || !p->at || !p->open_of || !p->open)
        return false;
    lf_advise_small(p->data, height * p->room);
    for (size_t i = 0; i < n; i++)
        p->open[i].data = p->memory + i * p->open_bytes;
    return true;
}

lf_film_packed *lf_film_packed_create(const lf_pack_planes *planes, size_t row_bytes, int height,
                                      int n_threads)
{
    lf_film_packed *p = lf_calloc(1, sizeof *p);
    if (!p)
        return NULL;
    const size_t page = 4096;
    p->planes = *planes;
    p->row_bytes = row_bytes;
    p->open_bytes = row_bytes + (lf_pack_spare(planes) + 63) / 64 * 64;
    p->lines = row_bytes / LF_PACK_LINE;
    p->room = (lf_pack_most(p->lines) + page - 1) / page * page;
    p->height = height;
    p->n_threads = n_threads;
    p->n_open = lf_pack_open_rows(n_threads);
    pthread_mutex_init(&p->lock, NULL);
    pthread_cond_init(&p->closed, NULL);
    if (make(p)) {
        lf_film_packed_clear(p);
        return p;
    }
    lf_film_packed_destroy(p);
    return NULL;
}

void lf_film_packed_destroy(lf_film_packed *packed)
{
    if (!packed)
        return;
    lf_pages_free(packed->data);
    lf_pages_free(packed->memory);
    lf_free(packed->bytes);
    lf_free(packed->touched);
    lf_free(packed->at);
    lf_free(packed->open_of);
    lf_free(packed->open);
    pthread_cond_destroy(&packed->closed);
    pthread_mutex_destroy(&packed->lock);
    lf_free(packed);
}

void lf_film_packed_clear(lf_film_packed *packed)
{
    for (int row = 0; row < packed->height; row++) {
        packed->bytes[row] = 0;
        packed->at[row] = NULL;
        packed->open_of[row] = -1;
    }
    for (int i = 0; i < packed->n_open; i++)
        packed->open[i] = (lf_row_memory){.data = packed->open[i].data, .row = -1};
}

unsigned char *lf_film_packed_row(const lf_film_packed *packed, int row)
{
    return packed->at[row];
}

int lf_film_packed_threads(const lf_film_packed *packed)
{
    return packed->n_threads;
}

/* The memory that has been unused for longest; NULL: all is in use. */
static lf_row_memory *find_unused(lf_film_packed *p)
{
    lf_row_memory *best = NULL;
    for (int i = 0; i < p->n_open; i++) {
        lf_row_memory *o = &p->open[i];
        if (o->users == 0 && !o->busy && (!best || o->used < best->used))
            best = o;
    }
    return best;
}

static void unpack(lf_film_packed *p, lf_row_memory *o, int row)
{
    if (o->row >= 0)
        p->open_of[o->row] = -1;
    o->row = row;
    o->busy = true;
    p->open_of[row] = (int)(o - p->open);
    pthread_mutex_unlock(&p->lock);
    if (p->bytes[row] > 0) {
        lf_unpack_lines(p->data + (size_t)row * p->room, p->lines, o->data);
        lf_pack_restore(&p->planes, o->data, o->data + p->row_bytes, false);
    }
    pthread_mutex_lock(&p->lock);
    o->busy = false;
    p->at[row] = o->data;
    pthread_cond_broadcast(&p->closed);
}

void lf_film_packed_open(lf_film_packed *packed, int row)
{
    pthread_mutex_lock(&packed->lock);
    for (;;) {
        const int i = packed->open_of[row];
        lf_row_memory *o = i >= 0 ? &packed->open[i] : find_unused(packed);
        if (o && !o->busy) {
            o->users++;
            o->used = ++packed->clock;
            if (i < 0)
                unpack(packed, o, row);
            else if (!packed->at[row]) /* else others read it */
                packed->at[row] = o->data;
            break;
        }
        pthread_cond_wait(&packed->closed, &packed->lock);
    }
    pthread_mutex_unlock(&packed->lock);
}

static void pack(lf_film_packed *p, int row, const lf_row_memory *o)
{
    unsigned char *to = p->data + (size_t)row * p->room;
    lf_pack_arrange(&p->planes, o->data, o->data + p->row_bytes);
    const size_t n = lf_pack_lines(o->data, p->lines, to);
    lf_pack_restore(&p->planes, o->data, o->data + p->row_bytes, true);
    p->bytes[row] = n;
    if (n >= p->touched[row]) {
        p->touched[row] = n;
    } else if (p->touched[row] - n >= RETURN_FROM) {
        lf_pages_return(to + n, p->touched[row] - n);
        p->touched[row] = n;
    }
}

void lf_film_packed_close(lf_film_packed *packed, int row, bool changed)
{
    pthread_mutex_lock(&packed->lock);
    const int i = packed->open_of[row];
    assert(i >= 0 && packed->open[i].users > 0);
    lf_row_memory *o = &packed->open[i];
    o->changed = o->changed || changed;
    o->users--;
    if (o->users == 0 && o->changed) {
        o->busy = true;
        pthread_mutex_unlock(&packed->lock);
        pack(packed, row, o);
        pthread_mutex_lock(&packed->lock);
        o->busy = o->changed = false;
    }
    if (o->users == 0) {
        packed->at[row] = NULL;
        pthread_cond_broadcast(&packed->closed);
    }
    pthread_mutex_unlock(&packed->lock);
}
