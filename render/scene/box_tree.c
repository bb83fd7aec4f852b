#include "render/scene/box_tree.h"

#include <math.h>
#include <stdlib.h>

#include "base/alloc.h"

/* ---------------------------------------------------------------------------------- building -- */

typedef struct coded {
    uint64_t code;
    uint32_t thing;
} coded;

/* Spreads the 21 lowest bits of x to every third position. */
static uint64_t spread_bits(uint64_t x)
{
    x = (x | x << 32) & 0x1f00000000ffff;
    x = (x | x << 16) & 0x1f0000ff0000ff;
    x = (x | x << 8) & 0x100f00f00f00f00f;
    x = (x | x << 4) & 0x10c30c30c30c30c3;
    return (x | x << 2) & 0x1249249249249249;
}

static int by_code(const void *a, const void *b)
{
    const coded *x = a, *y = b;
    if (x->code != y->code)
        return x->code < y->code ? -1 : 1;
    return (x->thing > y->thing) - (x->thing < y->thing);
}

static void grow(lf_box *box, const lf_box *by)
{
    box->min = lf_v3(lf_min(box->min.x, by->min.x), lf_min(box->min.y, by->min.y),
                     lf_min(box->min.z, by->min.z));
    box->max = lf_v3(lf_max(box->max.x, by->max.x), lf_max(box->max.y, by->max.y),
                     lf_max(box->max.z, by->max.z));
}

static lf_box nothing(void)
{
    return (lf_box){lf_v3(INFINITY, INFINITY, INFINITY), lf_v3(-INFINITY, -INFINITY, -INFINITY)};
}

static uint64_t step_of(float low, float high, float min, float max)
{
    double range = (double)max - (double)min, at = 0.5 * ((double)low + (double)high) - (double)min;
    return range > 0.0 ? (uint64_t)(fmin(fmax(at / range, 0.0), 1.0) * 0x1fffff) : 0;
}

static void order_boxes(lf_box_tree *tree, const lf_box *boxes, coded *codes)
{
    lf_box all = nothing();
    for (uint32_t i = 0; i < tree->n; i++)
        grow(&all, &boxes[i]);
    for (uint32_t i = 0; i < tree->n; i++) {
        const lf_box *b = &boxes[i];
        codes[i] = (coded){spread_bits(step_of(b->min.x, b->max.x, all.min.x, all.max.x)) |
                               spread_bits(step_of(b->min.y, b->max.y, all.min.y, all.max.y)) << 1 |
                               spread_bits(step_of(b->min.z, b->max.z, all.min.z, all.max.z)) << 2,
                           i};
    }
    qsort(codes, tree->n, sizeof *codes, by_code);
    for (uint32_t i = 0; i < tree->n; i++) {
        tree->order[i] = codes[i].thing;
        tree->boxes[i] = boxes[codes[i].thing];
    }
}

static size_t lay_out(lf_box_tree *tree)
{
    size_t all = 0;
    for (uint32_t n = tree->n; n > 0; n = (n + LF_BOX_WIDE - 1) / LF_BOX_WIDE) {
        tree->first[tree->n_levels] = all;
        tree->count[tree->n_levels++] = n;
        all += n;
        if (n <= LF_BOX_WIDE)
            break;
    }
    return all;
}

lf_status lf_box_tree_init(lf_box_tree *out, const lf_box *boxes, uint32_t n)
{
    *out = (lf_box_tree){.n = n};
    coded *codes = lf_calloc(n, sizeof *codes);
    out->order = lf_calloc(n, sizeof *out->order);
    out->boxes = lf_calloc(lay_out(out), sizeof *out->boxes);
    bool there = codes && out->order && out->boxes;
    if (there)
        order_boxes(out, boxes, codes);
    for (int level = 1; there && level < out->n_levels; level++) {
        const lf_box *below = out->boxes + out->first[level - 1];
        lf_box *own = out->boxes + out->first[level];
        for (uint32_t i = 0; i < out->count[level]; i++)
            own[i] = nothing();
        for (uint32_t i = 0; i < out->count[level - 1]; i++)
            grow(&own[i / LF_BOX_WIDE], &below[i]);
    }
    lf_free(codes);
    return there ? LF_OK : LF_E_NOMEM;
}

void lf_box_tree_finish(lf_box_tree *tree)
{
    lf_free(tree->order);
    lf_free(tree->boxes);
    *tree = (lf_box_tree){0};
}

/* ----------------------------------------------------------------------------------- walking -- */

/* A function's value in the middle of a box, and its largest deviation in the box. */
static inline double middle_of(const lf_linear *f, const double middle[3], const double half[3],
                               double *out_reach)
{
    double x = f->a * middle[0], y = f->b * middle[1], z = f->c * middle[2];
    *out_reach = fabs(f->a) * half[0] + fabs(f->b) * half[1] + fabs(f->c) * half[2] +
                 1e-14 * (fabs(x) + fabs(y) + fabs(z) + fabs(f->d));
    return x + y + z + f->d;
}

static bool is_wanted(const lf_box *box, const lf_box_cut *cut)
{
    const double low[3] = {(double)box->min.x, (double)box->min.y, (double)box->min.z},
                 high[3] = {(double)box->max.x, (double)box->max.y, (double)box->max.z};
    double middle[3], half[3], reach;
    for (int i = 0; i < 3; i++) {
        middle[i] = 0.5 * (low[i] + high[i]);
        half[i] = 0.5 * (high[i] - low[i]);
    }
    double height = middle_of(&cut->plane, middle, half, &reach);
    bool wanted = fabs(height) <= reach;
    for (int s = 0; s < cut->n_sides && wanted; s++) {
        bool in = false;
        for (int i = 0; i < 2; i++) {
            double value = middle_of(&cut->side[s][i], middle, half, &reach);
            in = in || value <= reach;
        }
        wanted = in;
    }
    return wanted;
}

static void push(lf_box_walk *walk, int level, uint32_t from)
{
    uint32_t end = from + LF_BOX_WIDE, count = walk->tree->count[level];
    walk->stack[walk->n].level = level;
    walk->stack[walk->n].at = from;
    walk->stack[walk->n++].end = end < count ? end : count;
}

void lf_box_walk_begin(lf_box_walk *walk, const lf_box_tree *tree, const lf_box_cut *cut)
{
    walk->tree = tree;
    walk->cut = cut;
    walk->n = 0;
    if (tree->n > 0)
        push(walk, tree->n_levels - 1, 0);
}

bool lf_box_walk_next(lf_box_walk *walk, uint32_t *out)
{
    const lf_box_tree *tree = walk->tree;
    while (walk->n > 0) {
        int level = walk->stack[walk->n - 1].level;
        uint32_t at = walk->stack[walk->n - 1].at++;
        if (at >= walk->stack[walk->n - 1].end) {
            walk->n--;
            continue;
        }
        if (!is_wanted(&tree->boxes[tree->first[level] + at], walk->cut))
            continue;
        if (level == 0) {
            *out = tree->order[at];
            return true;
        }
        push(walk, level - 1, LF_BOX_WIDE * at);
    }
    return false;
}
