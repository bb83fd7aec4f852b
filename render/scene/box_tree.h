/* A tree of boxes with eight branches per node, laid out along a Z curve (Morton 1966), and a walk
 * over the boxes that a plane meets; private to render/. It stores only boxes and an order: 32
 * bytes per object. */
#ifndef LF_RENDER_BOX_TREE_H
#define LF_RENDER_BOX_TREE_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "render/scene/scene.h"

#define LF_BOX_WIDE 8
#define LF_BOX_LEVELS 11 /* enough for 8^11 objects */

typedef struct lf_box_tree {
    uint32_t n;
    int n_levels;
    uint32_t *order; /* [n] object numbers; neighbours are neighbours in space */
    /* of the objects in that order, then of every eight of them, and so on up to eight or fewer */
    lf_box *boxes;
    size_t first[LF_BOX_LEVELS];
    uint32_t count[LF_BOX_LEVELS];
} lf_box_tree;

/* Builds the tree of n finite boxes. LF_E_NOMEM; *out may then be finished. */
LF_NODISCARD lf_status lf_box_tree_init(lf_box_tree *out, const lf_box *boxes, uint32_t n);
/* Accepts a zeroed struct. */
void lf_box_tree_finish(lf_box_tree *tree);

/* A linear function of a point: a x + b y + c z + d. */
typedef struct lf_linear {
    double a, b, c, d;
} lf_linear;

#define LF_CUT_SIDES 3

/* Selects boxes that have points on the plane (function value 0). For each side, at least one
 * corner must have a value of at most 0 in either of its two functions. */
typedef struct lf_box_cut {
    lf_linear plane;
    int n_sides;
    lf_linear side[LF_CUT_SIDES][2];
} lf_box_cut;

/* Never allocates; lives on the stack. */
typedef struct lf_box_walk {
    const lf_box_tree *tree;
    const lf_box_cut *cut;
    int n;
    struct {
        int level;
        uint32_t at, end; /* remaining siblings */
    } stack[LF_BOX_LEVELS];
} lf_box_walk;

void lf_box_walk_begin(lf_box_walk *walk, const lf_box_tree *tree, const lf_box_cut *cut);
/* The next object whose box is selected; false: no more. */
bool lf_box_walk_next(lf_box_walk *walk, uint32_t *out);

#endif
