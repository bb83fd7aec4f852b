/* Memory of a thread that reads or resolves rows; private to render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_SCRATCH_H
#define LF_RENDER_RECONSTRUCT_SCRATCH_H

#include "render/reconstruct/pixels.h"

/* A cell of level 0, in its band. */
typedef struct lf_cell_at {
    int u, z;
} lf_cell_at;

typedef struct lf_reconstruct_scratch {
    lf_pixels row;
    lf_row_table table;
    float (*predicted)[4]; /* [view][column] */
    float (*times)[3];     /* [column] */
    /* [LF_CELL_SIDE][view][column], of which only the first are used: lf_pages */
    lf_cell_at *places;
    struct lf_reconstruct_scratch *next;
} lf_reconstruct_scratch;

/* Takes an unused one, for any thread; makes one if there is none. NULL: no memory. */
lf_reconstruct_scratch *lf_scratch_take(lf_reconstruction *r);
void lf_scratch_give(lf_reconstruction *r, lf_reconstruct_scratch *scratch);
/* Releases all of them; none may be in use. */
void lf_scratch_drop(lf_reconstruction *r);

#endif
