/* One row of a film as a reconstruction reads it; private to render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_PIXELS_H
#define LF_RENDER_RECONSTRUCT_PIXELS_H

#include "render/reconstruct/kernel.h"

/* Memory for rows of n pixels, all views; albedo: of films that have it. LF_E_NOMEM; *out may then
 * be finished. */
LF_NODISCARD lf_status lf_pixels_init(size_t n, bool albedo, lf_pixels *out);
/* Accepts what is all zero. */
void lf_pixels_finish(lf_pixels *pixels);

/* What is read of a row: the features of both halves together, of all views or of those alone that
 * are summed up (lf_view_is_fitted: the others are left undefined); or of all views, and of those
 * that are summed up each half's as well. */
typedef enum lf_reading { LF_READ_ALL, LF_READ_SUMMED, LF_READ_HALVES } lf_reading;

/* false: the row was never visited. */
bool lf_pixels_read(lf_pixels *pixels, const lf_reconstruction *r, const lf_film *film, int row,
                    lf_reading what);

/* R of n pixels from `first` on, as it is predicted, times their albedo; predicted [n]. Leaves
 * alone what is not fitted. */
void lf_pixels_reflect(const lf_pixels *pixels, int first, int n, float (*predicted)[4]);

/* Where N/W' is less noisy of a row, kept for all that reads the row until the next fit. A worker a
 * row. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_second_keep(lf_reconstruction *r, const lf_film *film, int row);

/* The table for a row from the last fit. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_table_make(lf_row_table *table, const lf_reconstruction *r, int row,
                                     int variant);
void lf_table_finish(lf_row_table *table);

#endif
