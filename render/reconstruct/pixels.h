/* One row of a film, as read by a reconstruction; private to render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_PIXELS_H
#define LF_RENDER_RECONSTRUCT_PIXELS_H

#include "render/reconstruct/kernel.h"

/* Memory for rows of n pixels, all views; albedo: for films with albedo. LF_E_NOMEM; *out may then
 * be finished. */
LF_NODISCARD lf_status lf_pixels_init(size_t n, bool albedo, lf_pixels *out);
/* Accepts a zeroed struct. */
void lf_pixels_finish(lf_pixels *pixels);

/* Data to read of a row. LF_READ_PLACES: q, u and z of all views. LF_READ_ALL: also the features of
 * both halves together. LF_READ_SUMMED: the same only of views with lf_view_is_fitted, and of other
 * views it is undefined. LF_READ_HALVES: as LF_READ_SUMMED, and the features of each half. */
typedef enum lf_reading { LF_READ_PLACES, LF_READ_ALL, LF_READ_SUMMED, LF_READ_HALVES } lf_reading;

/* false: the row has no visit. */
bool lf_pixels_read(lf_pixels *pixels, const lf_reconstruction *r, const lf_film *film, int row,
                    lf_reading what);

/* Multiplies the predicted R of n pixels from `first` on by their albedo; predicted [n]. Pixels
 * without a fit are unchanged. */
void lf_pixels_reflect(const lf_pixels *pixels, int first, int n, float (*predicted)[4]);

/* Stores where N/W' is less noisy in a row, for all readers of the row until the next fit. One
 * worker per row. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_second_keep(lf_reconstruction *r, const lf_film *film, int row);

/* The table for a row from the last fit. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_table_make(lf_row_table *table, const lf_reconstruction *r, int row,
                                     int variant);
void lf_table_finish(lf_row_table *table);

#endif
