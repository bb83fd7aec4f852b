#include "daemon/tools/batch_words.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

/* The line without the image's name, and with # for each number. */
static void make_key(const char *image, const char *text, char *key, size_t size)
{
    const size_t n = image ? strlen(image) : 0;
    const char *from = n > 0 && strncmp(text, image, n) == 0 ? text + n : text;
    size_t used = 0;
    for (; *from && used + 1 < size; from++) {
        const bool is_number =
            isdigit((unsigned char)*from) || (*from == '.' && isdigit((unsigned char)from[1]));
        if (!is_number)
            key[used++] = *from;
        else if (used == 0 || key[used - 1] != '#')
            key[used++] = '#';
    }
    key[used] = '\0';
}

void lf_batch_words_take(void *words, lf_log_level level, const char *text)
{
    lf_batch_words *all = words;
    char key[sizeof all->word[0].key];
    int i = 0;
    make_key(all->image, text, key, sizeof key);
    while (i < all->n && strcmp(all->word[i].key, key) != 0)
        i++;
    if (i == LF_BATCH_WORDS) {
        all->n_left_out++;
        return;
    }
    lf_batch_word *word = &all->word[i];
    if (i == all->n) {
        all->n++;
        word->level = level;
        memcpy(word->key, key, sizeof key);
        snprintf(word->first, sizeof word->first, "%s", text);
    }
    word->n_images += word->number != all->number;
    word->number = all->number;
}

void lf_batch_words_tell(const lf_batch_words *words)
{
    for (int i = 0; i < words->n; i++) {
        const lf_batch_word *word = &words->word[i];
        if (word->n_images > 1)
            lf_log(word->level, "%s; similarly for %d other images", word->first,
                   word->n_images - 1);
        else
            lf_log(word->level, "%s", word->first);
    }
    if (words->n_left_out > 0)
        lf_log(LF_LOG_WARNING, "%d more lines of other kinds are left out", words->n_left_out);
}
