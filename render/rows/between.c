#include "render/rows/between.h"

bool lf_between_find(const lf_film *film, int row, lf_between *out)
{
    int at[2];
    out->tinted = film->layout.has_albedo;
    out->film = film;
    for (int i = 0; i < 2; i++) {
        const int step = i == 0 ? -1 : 1;
        at[i] = row + step;
        while (at[i] >= 0 && at[i] < film->height && !lf_film_visited(film->rows[at[i]].visits))
            at[i] += step;
        if (at[i] < 0 || at[i] >= film->height)
            return false;
    }
    if (at[1] - at[0] > LF_UNSCATTERED_COARSE)
        return false;
    for (int i = 0; i < 2; i++) {
        double n[2];
        lf_film_row_known(&film->rows[at[i]], n);
        lf_film_open(film, at[i]);
        out->row[i] = at[i];
        const lf_film_half half = lf_film_at(film, at[i], n[0] > 0.0 ? 0 : 1);
        out->q[i] = half.q;
        out->feature[i] = half.feature;
        out->known[i] = lf_film_known_at(film, at[i]);
    }
    return true;
}

void lf_between_close(const lf_between *rows)
{
    for (int i = 0; i < 2; i++)
        lf_film_close(rows->film, rows->row[i], false);
}

/* A smaller share of a surface does not justify a texture look-up. */
#define LEAST_SURFACE 0.05f

/* Compared quantities: minimum and maximum over both rows, in one column or more. */
enum { PIVOTS, NEARNESS, LIGHT, KNOWN, TOLD = KNOWN + 3 };
typedef struct told_range {
    float low[TOLD], high[TOLD];
    float surface; /* the maximum */
} told_range;

static inline float lesser(float a, float b)
{
    return a < b ? a : b;
}

static inline float greater(float a, float b)
{
    return a > b ? a : b;
}

static void read_told(const lf_between *rows, int i, size_t pixel, float x[TOLD], float *surface)
{
    const lf_feature f = lf_feature_unpack(rows->feature[i][pixel]);
    x[PIVOTS] = rows->q[i][pixel];
    x[NEARNESS] = f.nearness;
    x[LIGHT] = f.light;
    for (int c = 0; c < 3; c++)
        x[KNOWN + c] = rows->known[i] ? rows->known[i][pixel].b[c] : 0.0f;
    *surface = f.surface;
}

static void column_range(const lf_between *rows, size_t pixel, told_range *out)
{
    float x[2][TOLD], surface[2];
    for (int i = 0; i < 2; i++)
        read_told(rows, i, pixel, x[i], &surface[i]);
    for (int j = 0; j < TOLD; j++) {
        out->low[j] = lesser(x[0][j], x[1][j]);
        out->high[j] = greater(x[0][j], x[1][j]);
    }
    out->surface = greater(surface[0], surface[1]);
}

/* Whether two columns differ little. apart: allowed difference of nearness if there is a surface.
 * Light through media may differ as much as without media. */
static bool is_smooth(const told_range *a, const told_range *b, float apart)
{
    const float least = 1e-3f, most_q = 0.25f, q = lesser(a->low[PIVOTS], b->low[PIVOTS]),
                surface = greater(a->surface, b->surface),
                most_light = 0.5f / greater(surface, 0.1f),
                most_known = 0.25f / greater(1.0f - q, 0.1f);
    const float most[TOLD] = {0.0f, 0.0f, most_light, most_known, most_known, most_known};
    bool smooth = true;
    for (int j = 0; j < TOLD; j++) {
        const float low = lesser(a->low[j], b->low[j]), high = greater(a->high[j], b->high[j]);
        float other = j == PIVOTS ? most_q : least;
        other = j == NEARNESS ? (surface * (q + most_q) > 0.1f ? apart : LF_NEARNESS_MAX) : other;
        smooth = smooth && high - low <= most[j] * high + other;
    }
    return smooth;
}

bool lf_between_mark(const lf_between *rows, const lf_rig *rig, uint32_t smooth[LF_MAX_CHUNKS])
{
    const float apart = 6.0f * LF_UNSCATTERED_COARSE * rig->dx / rig->distance;
    const int last = rig->width - 1, n = (last + LF_UNSCATTERED_COARSE - 1) / LF_UNSCATTERED_COARSE;
    bool all = true;
    for (int i = 0; i <= n; i++)
        smooth[i] = ~UINT32_C(0);
    for (int view = 0; view < rig->n_views; view++) {
        const size_t start = (size_t)view * (size_t)rig->width;
        told_range ends[2];
        column_range(rows, start, &ends[0]);
        for (int i = 0; i < n; i++) {
            const int column =
                (i + 1) * LF_UNSCATTERED_COARSE < last ? (i + 1) * LF_UNSCATTERED_COARSE : last;
            column_range(rows, start + (size_t)column, &ends[(i + 1) % 2]);
            if (!(rows->tinted && greater(ends[0].surface, ends[1].surface) > LEAST_SURFACE) &&
                is_smooth(&ends[0], &ends[1], apart))
                continue;
            smooth[i] &= ~(UINT32_C(1) << (view / LF_LANES));
            all = false;
        }
    }
    return all;
}
