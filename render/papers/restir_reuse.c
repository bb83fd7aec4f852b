#include <math.h>
#include <stdlib.h>

#include "render/papers/restir.h"
#include "render/papers/restir_state.h"

_Static_assert(LF_RESTIR_BLOCK_COLUMNS <= LF_MAX_BLOCK &&
                   LF_MVRESTIR_BLOCK_VIEWS * LF_MVRESTIR_BLOCK_COLUMNS <= LF_MAX_BLOCK,
               "blocks are larger than they can be");

static lf_reuse_input input_of(const lf_path_sample *sample, const lf_camera_ray *ray)
{
    return (lf_reuse_input){sample, ray, sample->m};
}

void lf_restir_look_back(const lf_restir *s, lf_restir_worker *w, const lf_restir_left *before,
                         int at)
{
    const lf_restir_pixel *old = &before->pixels[at];
    lf_restir_pixel *own = &w->pixels[at];
    lf_path_sample out;
    if (!(old->sample.m > 0.0))
        return;
    lf_reuse_input inputs[2] = {input_of(&own->sample, &own->ray),
                                input_of(&old->sample, &old->ray)};
    inputs[1].m = fmin(inputs[1].m, LF_RESTIR_HISTORY * own->sample.m);
    lf_path_sample_combine(&s->space, 2, inputs, s->weights, &w->tracer, &out);
    own->sample = out;
}

/* A number within reach of 0, symmetric, never 0. */
static int draw_step(lf_restir_worker *w, int reach)
{
    int step = (int)(lf_rng(&w->tracer) * 2.0f * (float)reach);
    return step - reach + (step >= reach);
}

/* A neighbouring pixel, -1: none. In another view: near the same position in the window. */
static int draw_neighbour(const lf_restir *s, lf_restir_worker *w, int at)
{
    int view = at / s->rig.width, column = at % s->rig.width;
    if (s->across) {
        view += draw_step(w, LF_MVRESTIR_VIEWS);
        column += (int)(lf_rng(&w->tracer) * (2 * LF_MVRESTIR_REACH + 1)) - LF_MVRESTIR_REACH;
    } else {
        column += draw_step(w, LF_RESTIR_REACH);
    }
    return view >= 0 && view < s->rig.n_views && column >= 0 && column < s->rig.width
               ? view * s->rig.width + column
               : -1;
}

/* With neighbours in the same visit. */
static void meet_neighbours(const lf_restir *s, lf_restir_worker *w, int at)
{
    lf_reuse_input inputs[1 + LF_RESTIR_NEIGHBOURS] = {
        input_of(&w->pixels[at].sample, &w->pixels[at].ray)};
    int n = 1;
    for (int i = 0; i < LF_RESTIR_NEIGHBOURS; i++) {
        int beside = draw_neighbour(s, w, at);
        if (beside >= 0 && w->pixels[beside].sample.m > 0.0)
            inputs[n++] = input_of(&w->pixels[beside].sample, &w->pixels[beside].ray);
    }
    lf_path_sample_combine(&s->space, n, inputs, s->weights, &w->tracer, &w->spread[at]);
}

/* Pixels of a block are consecutive: of one view, or of a few views near the same position in the
 * window. The visit sets the offset of blocks. */
typedef struct block_grid {
    int width, views, columns, first_view, first_column;
} block_grid;

static block_grid grid_of(const lf_restir *s, uint64_t key)
{
    block_grid g = {.width = s->rig.width,
                    .views = s->across ? LF_MVRESTIR_BLOCK_VIEWS : 1,
                    .columns = s->across ? LF_MVRESTIR_BLOCK_COLUMNS : LF_RESTIR_BLOCK_COLUMNS};
    g.first_view = (int)(key % (uint64_t)g.views);
    g.first_column = (int)((key >> 32) % (uint64_t)g.columns);
    return g;
}

static int block_of(const block_grid *g, int at)
{
    const int view = at / g->width + g->first_view, column = at % g->width + g->first_column;
    return view / g->views * (g->width + 1) + column / g->columns;
}

static int compare(const void *a, const void *b)
{
    const lf_restir_instanced *x = a, *y = b;
    return x->block != y->block ? (x->block > y->block) - (x->block < y->block)
                                : (x->at > y->at) - (x->at < y->at);
}

static void sort_by_block(const block_grid *g, lf_restir_worker *w)
{
    for (int i = 0; i < w->n_visited; i++)
        w->order[i] = (lf_restir_instanced){block_of(g, w->visited[i]), w->visited[i]};
    qsort(w->order, (size_t)w->n_visited, sizeof *w->order, compare);
}

static void meet_block(const lf_restir *s, lf_restir_worker *w, int n,
                       const lf_restir_instanced *order)
{
    lf_block_pixel pixels[LF_MAX_BLOCK];
    for (int i = 0; i < n; i++)
        pixels[i] = (lf_block_pixel){&w->pixels[order[i].at].ray, &w->pixels[order[i].at].sample,
                                     &w->spread[order[i].at]};
    lf_path_block_combine(&s->space, n, pixels, &w->tracer);
}

/* false: cancelled. */
static bool meet_blocks(const lf_restir *s, lf_restir_worker *w, uint64_t key,
                        const lf_cancel *cancel)
{
    const block_grid grid = grid_of(s, key);
    sort_by_block(&grid, w);
    for (int i = 0, end; i < w->n_visited; i = end) {
        for (end = i + 1; end < w->n_visited && end - i < LF_MAX_BLOCK &&
                          w->order[end].block == w->order[i].block;)
            end++;
        if (cancel && atomic_load_explicit(cancel, memory_order_relaxed))
            return false;
        meet_block(s, w, end - i, w->order + i);
    }
    return true;
}

static bool meet_all_neighbours(const lf_restir *s, lf_restir_worker *w, const lf_cancel *cancel)
{
    for (int i = 0; i < w->n_visited; i++) {
        if (cancel && atomic_load_explicit(cancel, memory_order_relaxed))
            return false;
        meet_neighbours(s, w, w->visited[i]);
    }
    return true;
}

bool lf_restir_look_beside(const lf_restir *s, lf_restir_worker *w, uint64_t key,
                           const lf_cancel *cancel)
{
    if (s->reuse->beside == LF_RESTIR_ALONE)
        return true;
    if (s->reuse->beside == LF_RESTIR_BLOCKS ? !meet_blocks(s, w, key, cancel)
                                             : !meet_all_neighbours(s, w, cancel))
        return false;
    for (int i = 0; i < w->n_visited; i++)
        w->pixels[w->visited[i]].sample = w->spread[w->visited[i]];
    return true;
}
