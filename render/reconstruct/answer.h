/* The result of a row before the correction per tile is applied; private to render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_ANSWER_H
#define LF_RENDER_RECONSTRUCT_ANSWER_H

#include "render/reconstruct/bright.h"

/* Input for a row's result. */
typedef struct lf_answered_row {
    const lf_reconstruction *r;
    const lf_film *film;
    lf_reconstruct_scratch *scratch, *bounded; /* bounded NULL: no bounded fit */
    lf_row_halves halves;
    int row;
} lf_answered_row;

/* Reads a row and tables of its nodes. LF_E_NOMEM. Close it also after a failure. */
LF_NODISCARD lf_status lf_answer_open(lf_reconstruction *r, const lf_film *film, int row,
                                      lf_reading what, lf_answered_row *out);
void lf_answer_close(lf_reconstruction *r, lf_answered_row *o);

/* Predicts the pixels [first, first + n), by all fits. */
void lf_answer_predict(const lf_answered_row *o, int first, int n);
/* R of pixel i times its albedo; the pixel must be fitted and predicted. Also what each half has
 * received there; w is the weight by which it is fitted. */
void lf_answer_pixel(const lf_answered_row *o, size_t i, lf_pixel_found out_found[2], float out[3]);

#endif
