/* Words of command lines, and shell text of them. Thread: one at a time. */
#ifndef LF_DAEMON_FARM_WORDS_H
#define LF_DAEMON_FARM_WORDS_H

#include <jansson.h>

#include "base/status.h"

/* A list that grows. Zeroed: empty. Release with lf_farm_words_finish. */
typedef struct lf_farm_words {
    char **list; /* ends with NULL; NULL while it is empty */
    int n, room;
    bool failed; /* out of memory: the list is not complete */
} lf_farm_words;

void lf_farm_words_add(lf_farm_words *words, const char *format, ...) LF_PRINTF(2, 3);
/* Adds the texts of a JSON array (NULL: none) from an index on. */
void lf_farm_words_add_json(lf_farm_words *words, const json_t *texts, size_t first);
/* Adds all words of a list that ends with NULL. */
void lf_farm_words_add_list(lf_farm_words *words, char *const list[]);
void lf_farm_words_finish(lf_farm_words *words);

/* The word as a shell reads it back; caller frees with lf_free. NULL = out of memory. */
char *lf_farm_quoted(const char *word);

/* LF_E_NOMEM, "out of memory". */
static inline lf_status lf_farm_no_memory(const char *where, lf_error *err)
{
    return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
}

#endif
