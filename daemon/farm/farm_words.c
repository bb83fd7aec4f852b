#include "daemon/farm/farm_words.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"

static bool grow(lf_farm_words *words)
{
    if (words->n + 1 < words->room)
        return true;
    const int room = words->room > 0 ? 2 * words->room : 32;
    char **list = lf_calloc((size_t)room, sizeof *list);
    if (!list)
        return false;
    if (words->n > 0)
        memcpy(list, words->list, (size_t)words->n * sizeof *list);
    lf_free(words->list);
    words->list = list;
    words->room = room;
    return true;
}

static void add(lf_farm_words *words, char *word)
{
    if (word && grow(words)) {
        words->list[words->n++] = word;
        return;
    }
    lf_free(word);
    words->failed = true;
}

void lf_farm_words_add(lf_farm_words *words, const char *format, ...)
{
    va_list args, again;
    va_start(args, format);
    va_copy(again, args);
    const int n = vsnprintf(NULL, 0, format, args);
    char *word = n >= 0 ? lf_calloc((size_t)n + 1, 1) : NULL;
    if (word)
        (void)vsnprintf(word, (size_t)n + 1, format, again);
    va_end(again);
    va_end(args);
    add(words, word);
}

void lf_farm_words_add_json(lf_farm_words *words, const json_t *texts, size_t first)
{
    for (size_t i = first; i < json_array_size(texts); i++)
        add(words, lf_strdup(json_string_value(json_array_get(texts, i))));
}

void lf_farm_words_add_list(lf_farm_words *words, char *const list[])
{
    for (; *list; list++)
        add(words, lf_strdup(*list));
}

void lf_farm_words_finish(lf_farm_words *words)
{
    for (int i = 0; i < words->n; i++)
        lf_free(words->list[i]);
    lf_free(words->list);
    *words = (lf_farm_words){0};
}

char *lf_farm_quoted(const char *word)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                "-_./:=,+@%";
    if (word[0] != '\0' && word[strspn(word, plain)] == '\0')
        return lf_strdup(word);
    char *quoted = lf_calloc(strlen(word) * 4 + 3, 1), *out = quoted;
    if (!quoted)
        return NULL;
    *out++ = '\'';
    for (; *word; word++)
        out = *word == '\'' ? stpcpy(out, "'\\''") : (*out = *word, out + 1);
    *out = '\'';
    return quoted;
}
