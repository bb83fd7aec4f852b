/* Holes of a row: pixels in which scattering is possible but no path has found any yet. */
#include "render/rows/outlines.h"
#include "render/rows/visit_steps.h"

/* Film points of B and q: of one visit, in one of its planes. */
typedef struct film_points {
    lf_visit_number number;
    int plane;
    /* maximum number of samples per pixel; 0: remaining holes count as dark from now on */
    int tries;
} film_points;

/* Takes native samples in a hole, the first at its film point, until it is none: *out_hole. false =
 * cancelled. */
static bool fill_pixel(lf_visit *visit, const film_points *at, const lf_film_half halves[2],
                       int view, int column, bool *out_hole, const lf_cancel *cancel)
{
    const double *n = visit->plan->film->rows[visit->row].n;
    const size_t pixel = (size_t)view * (size_t)visit->rig->width + (size_t)column;
    const uint64_t key = at->number.key;
    const uint32_t index = at->number.index;
    for (int i = 0; i < at->tries && *out_hole; i++) {
        const lf_base base = {
            .view = view,
            .column = column,
            .film = i > 0 ? -1.0f : lf_outlines_column(key, column, index, at->plane),
            .key = lf_hash64(key, 6 + 16 * (uint64_t)at->tries + 1024 * (uint64_t)at->plane),
            .index = index * (uint32_t)at->tries + (uint32_t)i};
        if (lf_cancelled(cancel))
            return false;
        lf_base_sample(visit, &base);
        *out_hole = lf_film_is_hole(halves, n, pixel);
    }
    return true;
}

/* Fills the holes of a row until none is farther than hole_reach columns from a filled pixel.
 * *out_left: number of remaining holes. false: cancelled. */
static bool fill(lf_visit *visit, const film_points *at, int *out_left, const lf_cancel *cancel)
{
    const lf_film *film = visit->plan->film;
    const double *n = film->rows[visit->row].n;
    const lf_film_half halves[2] = {lf_film_at(film, visit->row, 0),
                                    lf_film_at(film, visit->row, 1)};
    const int width = visit->rig->width;
    *out_left = 0;
    for (int view = 0; view < visit->rig->n_views; view++) {
        for (int column = 0, filled = -1; column < width; column++) {
            const size_t pixel = (size_t)view * (size_t)width + (size_t)column;
            /* No reader needs the pixel. */
            if (visit->expected && !(visit->expected[pixel] > 0.0f))
                continue;
            const bool far = column - filled >= visit->plan->order.hole_reach;
            const bool settled = far && at->tries == 0;
            bool hole = lf_film_is_hole(halves, n, pixel);
            if (hole && settled)
                lf_film_settle(halves, visit->half, pixel);
            else if (hole && far && !fill_pixel(visit, at, halves, view, column, &hole, cancel))
                return false;
            *out_left += hole && far;
            filled = hole && !settled ? filled : column;
        }
    }
    return true;
}

/* Fills holes in the planes of earlier visits of a stream, of which the first of `now` is left out
 * (< 0: of none). false = cancelled. */
static bool replay(lf_visit *visit, int64_t now, const lf_film_stream *from, int *left,
                   const lf_cancel *cancel)
{
    enum { REPLAYS = 8 };
    for (int i = 0; *left > 0 && i < 2 * REPLAYS; i++) {
        const int half = i % 2 ? 1 - visit->half : visit->half;
        const int64_t index = (int64_t)from->rows[visit->row].visits[half] - 1 - i / 2;
        film_points at = {.number = {lf_visit_key(lf_film_stream_random(from), visit->row, half),
                                     (uint32_t)index},
                          .tries = 1};
        const int first = half == visit->half && index == now ? 1 : 0,
                  end = index >= 0 ? lf_visit_planes(visit->plan, index) : 0;
        if (first < end && visit->plan->shutter)
            lf_visit_set_shutter_time(visit, at.number);
        for (at.plane = first; *left > 0 && at.plane < end; at.plane++) {
            lf_visit_cut(visit, at.number, at.plane);
            if (!fill(visit, &at, left, cancel))
                return false;
        }
    }
    return true;
}

bool lf_fill_holes(lf_visit *visit, int64_t now, const lf_cancel *cancel)
{
    enum { TRIES = 4 };
    const lf_visit_plan *plan = visit->plan;
    const lf_film *film = plan->film;
    const film_points own = {.number = visit->number, .tries = TRIES}, none = {.tries = 0};
    int left = 1;
    visit->acting = plan->native;
    visit->sums = lf_film_sums_of(plan->film, visit->row, visit->half);
    visit->weight = (float)film->rows[visit->row].n[visit->half];
    if (now >= 0 && !fill(visit, &own, &left, cancel))
        return false;
    if (!replay(visit, now, &film->streams[plan->order.stream], &left, cancel))
        return false;
    for (int i = 0; i < film->n_streams && left > 0; i++)
        if (i != plan->order.stream && !replay(visit, -1, &film->streams[i], &left, cancel))
            return false;
    return left == 0 || fill(visit, &none, &left, cancel);
}
