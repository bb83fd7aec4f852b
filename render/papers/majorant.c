#include "render/papers/majorant.h"

static void sort(double *x, int n)
{
    for (int i = 1; i < n; i++) {
        double moved = x[i];
        int j = i;
        for (; j > 0 && x[j - 1] > moved; j--)
            x[j] = x[j - 1];
        x[j] = moved;
    }
}

static double majorant_between(const lf_span *spans, int n, double begin, double end)
{
    double mu = 0.0;
    for (int i = 0; i < n; i++)
        if (spans[i].begin <= begin && spans[i].end >= end)
            mu += spans[i].mu;
    return mu;
}

void lf_majorant_make(lf_majorant *out, int n, const lf_span *spans, double end)
{
    double cut[2 * LF_MAX_VOLUMES] = {0.0};
    for (int i = 0; i < n; i++) {
        cut[2 * i] = fmin(fmax(spans[i].begin, 0.0), end);
        cut[2 * i + 1] = fmin(fmax(spans[i].end, 0.0), end);
    }
    sort(cut, 2 * n);
    out->n = 0;
    out->length = out->depth = 0.0;
    for (int i = 0; i + 1 < 2 * n; i++) {
        double mu = cut[i] < cut[i + 1] ? majorant_between(spans, n, cut[i], cut[i + 1]) : 0.0;
        if (!(mu > 0.0))
            continue;
        out->section[out->n++] =
            (lf_majorant_section){cut[i], cut[i + 1], mu, out->length, out->depth};
        out->length += cut[i + 1] - cut[i];
        out->depth += mu * (cut[i + 1] - cut[i]);
    }
}

/* The last section that begins before t; NULL: none does. */
static const lf_majorant_section *section_before(const lf_majorant *m, double t)
{
    const lf_majorant_section *last = NULL;
    for (int i = 0; i < m->n && m->section[i].begin <= t; i++)
        last = &m->section[i];
    return last;
}

double lf_majorant_length(const lf_majorant *m, double t)
{
    const lf_majorant_section *s = section_before(m, t);
    return s ? s->length + (fmin(t, s->end) - s->begin) : 0.0;
}

double lf_majorant_depth(const lf_majorant *m, double t)
{
    const lf_majorant_section *s = section_before(m, t);
    return s ? s->depth + s->mu * (fmin(t, s->end) - s->begin) : 0.0;
}

static lf_majorant_point point_in(const lf_majorant_section *s, double from_begin)
{
    return (lf_majorant_point){fmin(s->begin + from_begin, s->end), s->mu};
}

bool lf_majorant_at_length(const lf_majorant *m, double length, lf_majorant_point *out)
{
    if (m->n == 0 || !(length >= 0.0 && length <= m->length))
        return false;
    int i = m->n - 1;
    while (i > 0 && m->section[i].length > length)
        i--;
    *out = point_in(&m->section[i], length - m->section[i].length);
    return true;
}

bool lf_majorant_at_depth(const lf_majorant *m, double depth, lf_majorant_point *out)
{
    if (m->n == 0 || !(depth >= 0.0 && depth <= m->depth))
        return false;
    int i = m->n - 1;
    while (i > 0 && m->section[i].depth > depth)
        i--;
    *out = point_in(&m->section[i], (depth - m->section[i].depth) / m->section[i].mu);
    return true;
}
