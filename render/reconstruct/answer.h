/* The answer of a row before what its tiles lack is added; private to render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_ANSWER_H
#define LF_RENDER_RECONSTRUCT_ANSWER_H

#include "render/reconstruct/bright.h"

/* What a row is answered from. */
typedef struct lf_answered_row {
    const lf_reconstruction *r;
    const lf_film *film;
    lf_reconstruct_scratch *scratch, *bounded; /* bounded NULL: nothing is */
    lf_row_halves halves;
    int row;
} lf_answered_row;

/* Reads a row and tables of its nodes. LF_E_NOMEM. Close it whatever comes of it. */
LF_NODISCARD lf_status lf_answer_open(lf_reconstruction *r, const lf_film *film, int row,
                                      lf_reading what, lf_answered_row *out);
void lf_answer_close(lf_reconstruction *r, lf_answered_row *o);

/* Predicts the pixels [first, first + n), by all fits. */
void lf_answer_predict(const lf_answered_row *o, int first, int n);
/* R of pixel i times its albedo, which is fitted and was predicted; and what each half has found
 * there, w what it is fitted by. */
void lf_answer_pixel(const lf_answered_row *o, size_t i, lf_pixel_found out_found[2], float out[3]);

#endif
