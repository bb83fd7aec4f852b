/* render_words: options of quiltrender, written from the values that they set. Thread: any. */
#ifndef LF_DAEMON_RENDER_WORDS_H
#define LF_DAEMON_RENDER_WORDS_H

#include "daemon/output/output.h"

#define LF_RENDER_WORDS 128

/* Words of a command line. Zeroed: none. Release with lf_render_words_finish. */
typedef struct lf_render_words {
    int n;
    bool failed; /* out of memory, or too many: the list is not complete */
    char *list[LF_RENDER_WORDS];
} lf_render_words;
void lf_render_words_finish(lf_render_words *words);

/* Adds a word. */
void lf_render_words_add(lf_render_words *words, const char *format, ...) LF_PRINTF(2, 3);
/* Adds the option of a table's row. */
void lf_render_words_row(lf_render_words *words, const lf_param *row, const void *object);
/* Adds the options of a table among `names` (NULL: all) in which object differs from plain. */
void lf_render_words_differing(lf_render_words *words, const lf_param *params, const char *names,
                               const void *object, const void *plain);
/* Adds the options of a table of which a row's name is a key of `given`, from object. */
void lf_render_words_given(lf_render_words *words, const lf_param *params, const json_t *given,
                           const void *object);
/* Adds how to render: integrator, estimator, sampler, seed, depth, skips and choices, and `denoise`
 * as on or off. */
void lf_render_words_settings(lf_render_words *words, const lf_render_settings *settings,
                              lf_estimator estimator, bool denoise);

#endif
