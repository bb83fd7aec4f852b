#include "base/text.h"

#include <string.h>

/* Four or more letters, each next to a NUL byte: UTF-16 without a mark. */
static bool looks_wide(const char *bytes, size_t n)
{
    for (size_t odd = 0; odd < 2; odd++) {
        size_t letters = 0;
        while (2 * letters + 1 < n && bytes[2 * letters + odd] == '\0' &&
               bytes[2 * letters + 1 - odd] > 0 && letters < 4)
            letters++;
        if (letters == 4)
            return true;
    }
    return false;
}

lf_status lf_text_begin(const char *bytes, size_t n, const char *where, size_t *out_mark,
                        lf_error *err)
{
    static const struct {
        const char *mark, *name;
        size_t n;
    } others[] = {{"\xff\xfe\0\0", "UTF-32", 4},
                  {"\0\0\xfe\xff", "UTF-32", 4},
                  {"\xff\xfe", "UTF-16", 2},
                  {"\xfe\xff", "UTF-16", 2}};
    const char *name = looks_wide(bytes, n) ? "UTF-16" : NULL;
    for (size_t i = 0; i < sizeof others / sizeof *others && !name; i++)
        if (n >= others[i].n && memcmp(bytes, others[i].mark, others[i].n) == 0)
            name = others[i].name;
    if (name)
        return lf_error_set(err, LF_E_FORMAT, where, "the file is %s text; save it as UTF-8", name);
    *out_mark = n >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    return LF_OK;
}

void lf_text_blank(char *text, size_t n)
{
    char *end = text + n;
    while (text < end && (text = memchr(text, '\0', (size_t)(end - text))))
        *text++ = ' ';
}

size_t lf_text_line_end(const char *text, size_t n, char *likely)
{
    const char first = *likely, second = first == '\n' ? '\r' : '\n';
    const char *end = n > 0 ? memchr(text, first, n) : NULL;
    size_t length = end ? (size_t)(end - text) : n;
    const char *sooner = length > 0 ? memchr(text, second, length) : NULL;
    if (!sooner)
        return length;
    /* the CR of a CR LF is not another line ending */
    if (!(second == '\r' && sooner + 1 == end))
        *likely = second;
    return (size_t)(sooner - text);
}

lf_status lf_text_take(char *text, size_t *n, const char *where, lf_error *err)
{
    size_t mark = 0;
    lf_status status = lf_text_begin(text, *n, where, &mark, err);
    if (status != LF_OK)
        return status;
    *n -= mark;
    if (mark > 0) {
        memmove(text, text + mark, *n);
        text[*n] = '\0';
    }
    lf_text_blank(text, *n);
    for (size_t i = 0; i < *n; i++)
        if (text[i] == '\r' && (i + 1 == *n || text[i + 1] != '\n'))
            text[i] = '\n';
    return LF_OK;
}
