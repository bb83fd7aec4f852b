/* One row of a film as a reconstruction reads it; private to render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_PIXELS_H
#define LF_RENDER_RECONSTRUCT_PIXELS_H

#include <string.h>

#include "render/reconstruct/kernel.h"

/* Memory for rows of n pixels, all views. LF_E_NOMEM; *out may then be finished. */
LF_NODISCARD lf_status lf_pixels_init(size_t n, lf_pixels *out);
/* Accepts what is all zero. */
void lf_pixels_finish(lf_pixels *pixels);

/* What is read of a row: the features of both halves together, of all views or of those alone that
 * are summed up (lf_view_is_fitted: the others are left undefined); or of all views, and of those
 * that are summed up each half's as well. */
typedef enum lf_reading { LF_READ_ALL, LF_READ_SUMMED, LF_READ_HALVES } lf_reading;

/* false: the row was never visited. */
bool lf_pixels_read(lf_pixels *pixels, const lf_reconstruction *r, const lf_film *film, int row,
                    lf_reading what);

/* R as it is shown: the prediction, and N/W by its share (predicted[3], below 0 where no node is
 * near). n was found, over w, which is 0 where that is no answer. A prediction of -x is off by x at
 * least: of what the pixel itself has found it does not outweigh as much. */
static inline void lf_pixel_show(const float n[3], float w, const float predicted[4], float out[3])
{
    const bool near = predicted[3] >= 0.0f, found = w > 0.0f;
    const float share = near ? predicted[3] : 1.0f, over = found ? w : 1.0f,
                sum[4] = {n[0], n[1], n[2], 0.0f};
    float shown[4]; /* without a branch, and one more than there are channels: vectors */
    for (int c = 0; c < 4; c++) {
        float x = near ? predicted[c] : 0.0f, own = found ? sum[c] / over : x,
              least = own < -x ? own : -x;
        least = own > 0.0f ? least : 0.0f;
        x = x < 0.0f ? least : x;
        float mixed = found ? x + share * (own - x) : x;
        shown[c] = mixed > 0.0f ? mixed : 0.0f;
    }
    memcpy(out, shown, 3 * sizeof *out);
}

/* The table for a row from the last fit. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_table_make(lf_row_table *table, const lf_reconstruction *r, int row,
                                     int variant);
void lf_table_finish(lf_row_table *table);

#endif
