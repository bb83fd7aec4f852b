#include "render/reconstruct/scratch.h"

#include "base/alloc.h"

static void destroy(lf_reconstruct_scratch *s)
{
    for (int i = 0; i < LF_CELL_SIDE; i++)
        lf_pixels_finish(&s->rows[i]);
    lf_table_finish(&s->table);
    lf_free(s->predicted);
    lf_free(s->times);
    lf_pages_free(s->places);
    lf_free(s);
}

static lf_reconstruct_scratch *create(size_t n, bool albedo)
{
    lf_reconstruct_scratch *s = lf_calloc(1, sizeof *s);
    bool whole = s;
    for (int i = 0; i < LF_CELL_SIDE && whole; i++)
        whole = lf_pixels_init(n, albedo, &s->rows[i]) == LF_OK;
    if (whole) {
        s->predicted = lf_calloc(n, sizeof *s->predicted);
        s->places = lf_pages(LF_CELL_SIDE * n, sizeof *s->places);
        s->times = lf_calloc(n, sizeof *s->times);
        whole = s->predicted && s->places && s->times;
    }
    if (!whole && s)
        destroy(s);
    return whole ? s : NULL;
}

lf_reconstruct_scratch *lf_scratch_take(lf_reconstruction *r)
{
    pthread_mutex_lock(&r->lock);
    lf_reconstruct_scratch *s = r->scratch;
    r->scratch = s ? s->next : NULL;
    pthread_mutex_unlock(&r->lock);
    return s ? s : create((size_t)r->view.n_views * (size_t)r->view.width, r->view.albedo);
}

void lf_scratch_give(lf_reconstruction *r, lf_reconstruct_scratch *s)
{
    pthread_mutex_lock(&r->lock);
    s->next = r->scratch;
    r->scratch = s;
    pthread_mutex_unlock(&r->lock);
}

void lf_scratch_drop(lf_reconstruction *r)
{
    while (r->scratch) {
        lf_reconstruct_scratch *next = r->scratch->next;
        destroy(r->scratch);
        r->scratch = next;
    }
}
