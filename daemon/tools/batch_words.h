/* batch_words: what the log says of the images of a batch, counted. Lines that differ only in the
 * image and in numbers are one line. Thread: the main thread. */
#ifndef LF_DAEMON_BATCH_WORDS_H
#define LF_DAEMON_BATCH_WORDS_H

#include "base/log.h"

/* More kinds of lines are counted together. */
#define LF_BATCH_WORDS 32

typedef struct lf_batch_word {
    lf_log_level level;
    int n_images;
    int number;      /* of the last of them */
    char key[320];   /* without image and numbers */
    char first[640]; /* the line about the first image */
} lf_batch_word;

/* Zeroed: nothing was said. */
typedef struct lf_batch_words {
    const char *image; /* path of the current one; lines begin with it */
    int number;        /* of the current one, from 1 */
    int n, n_left_out;
    lf_batch_word word[LF_BATCH_WORDS];
} lf_batch_words;

/* Counts a line; words is an lf_batch_words (for lf_log_take). */
void lf_batch_words_take(void *words, lf_log_level level, const char *text);
/* Logs each kind of line once, with the number of its images. */
void lf_batch_words_tell(const lf_batch_words *words);

#endif
