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

/* R of pixel i, which is fitted and was predicted; and what was found there. */
void lf_answer_pixel(const lf_answered_row *o, size_t i, lf_fitted *out_found, float out[3]);

#endif
