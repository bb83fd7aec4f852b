#include "render/scene/warnings.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"

static void count_more(lf_warnings *w, int n)
{
    w->more += n;
    if (w->more > 0)
        snprintf(w->rest, sizeof w->rest, "and %d more", w->more);
}

static void add_line(lf_warnings *w, const char *line)
{
    for (int i = 0; i < w->n; i++)
        if (strcmp(w->line[i], line) == 0)
            return;
    char *copy = w->n < LF_MAX_WARNINGS ? lf_strdup(line) : NULL;
    if (copy)
        w->line[w->n++] = copy;
    else
        count_more(w, 1);
}

void lf_warnings_add(lf_warnings *w, const char *where, const char *fmt, ...)
{
    lf_error line;
    char what[sizeof line.what], text[sizeof line.where + sizeof line.what];
    va_list arguments;
    va_start(arguments, fmt);
    vsnprintf(what, sizeof what, fmt, arguments);
    va_end(arguments);
    (void)lf_error_set(&line, LF_OK, where, "%s", what);
    add_line(w, lf_error_format(&line, text, sizeof text));
}

void lf_warnings_count(lf_warnings *w, const char *where, long long n, const char *one,
                       const char *many)
{
    if (n > 0)
        lf_warnings_add(w, where, "%lld %s", n, n == 1 ? one : many);
}

void lf_warnings_add_all(lf_warnings *w, const lf_warnings *others)
{
    for (int i = 0; i < others->n; i++)
        add_line(w, others->line[i]);
    count_more(w, others->more);
}

const char *lf_warnings_at(const lf_warnings *w, int index)
{
    if (index < w->n)
        return w->line[index];
    return index == w->n && w->more > 0 ? w->rest : NULL;
}

void lf_warnings_finish(lf_warnings *w)
{
    for (int i = 0; i < w->n; i++)
        lf_free(w->line[i]);
    *w = (lf_warnings){0};
}
