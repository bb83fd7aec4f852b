#include "device/usb/gud_plan.h"

#include <assert.h>
#include <string.h>

#include "base/alloc.h"

enum {
    /* Wide, because rendering changes rows of the views, each of which covers a few panel rows from
     * side to side. */
    TILE_WIDTH = 256,
    TILE_HEIGHT = 4,
    /* Cost of announcing a band, in pixels: a third of a millisecond at 40 MB/s. Joining bands for
     * at most this many extra pixels saves time. */
    ANNOUNCE_PIXELS = 4096,
    /* Largest gap of unchanged tiles in a row that is sent along. */
    MAX_GAP = 1,
};

#define UNKNOWN 0 /* no tile has this hash */

/* Tiles that are sent together, some of them unchanged. A run of a single tile row may be divided
 * into several bands. */
typedef struct run {
    lf_rect rect;
    int column, n_columns, row, n_rows; /* in tiles: all tiles that rect touches */
    int bands_left;
} run;

typedef struct band {
    lf_rect rect;
    int run;
} band;

struct lf_gud_plan {
    int width, height, columns, rows;
    /* [rows][columns] hashes of the display's contents, and of the new frame */
    uint64_t *shown, *wanted;
    lf_rect *damage; /* [rows][columns] part of a tile to send; width 0 = none */
    run *runs;       /* [rows * columns] */
    int *newest;     /* [columns] the last run with tiles there, -1 = none */
    band *bands;     /* [max_bands] */
    int n_runs, n_bands, max_bands;
};

/* --------------------------------------------------------------------------- create, destroy -- */

lf_status lf_gud_plan_create(int width, int height, lf_gud_plan **out)
{
    lf_gud_plan *plan = lf_calloc(1, sizeof *plan);
    if (!plan)
        return LF_E_NOMEM;
    plan->width = width;
    plan->height = height;
    plan->columns = (width + TILE_WIDTH - 1) / TILE_WIDTH;
    plan->rows = (height + TILE_HEIGHT - 1) / TILE_HEIGHT;
    size_t n = (size_t)plan->columns * (size_t)plan->rows;
    plan->max_bands = (int)n * TILE_HEIGHT; /* worst case: every row of every tile is a band */
    plan->shown = lf_calloc(n, sizeof *plan->shown);
    plan->wanted = lf_calloc(n, sizeof *plan->wanted);
    plan->damage = lf_calloc(n, sizeof *plan->damage);
    plan->runs = lf_calloc(n, sizeof *plan->runs);
    plan->newest = lf_calloc((size_t)plan->columns, sizeof *plan->newest);
    plan->bands = lf_calloc((size_t)plan->max_bands, sizeof *plan->bands);
    if (!plan->shown || !plan->wanted || !plan->damage || !plan->runs || !plan->newest ||
        !plan->bands) {
        lf_gud_plan_destroy(plan);
        return LF_E_NOMEM;
    }
    *out = plan;
    return LF_OK;
}

void lf_gud_plan_destroy(lf_gud_plan *plan)
{
    if (!plan)
        return;
    lf_free(plan->shown);
    lf_free(plan->wanted);
    lf_free(plan->damage);
    lf_free(plan->runs);
    lf_free(plan->newest);
    lf_free(plan->bands);
    lf_free(plan);
}

void lf_gud_plan_forget(lf_gud_plan *plan)
{
    memset(plan->shown, 0, (size_t)plan->columns * (size_t)plan->rows * sizeof *plan->shown);
}

/* -------------------------------------------------------------------------------------- hash -- */

/* A bijection of h for a fixed word, and of the word for a fixed h: rows that differ in one word
 * never have the same hash. */
static uint64_t mix(uint64_t h, uint64_t word)
{
    h = (h ^ word) * UINT64_C(0x9e3779b97f4a7c15);
    return h ^ h >> 29;
}

static uint64_t word_at(const uint8_t *p)
{
    uint64_t word;
    memcpy(&word, p, sizeof word);
    return word;
}

/* Four independent chains, for speed. */
static void hash_row(uint64_t h[4], const uint8_t *p, size_t n)
{
    for (; n >= 32; p += 32, n -= 32)
        for (int k = 0; k < 4; k++)
            h[k] = mix(h[k], word_at(p + 8 * k));
    for (; n >= 8; p += 8, n -= 8)
        h[0] = mix(h[0], word_at(p));
    if (n > 0) {
        uint64_t word = 0;
        memcpy(&word, p, n);
        h[1] = mix(h[1], word);
    }
}

static lf_rect tile_rect(const lf_gud_plan *plan, int column, int row)
{
    lf_rect r = {column * TILE_WIDTH, row * TILE_HEIGHT, TILE_WIDTH, TILE_HEIGHT};
    if (r.width > plan->width - r.x)
        r.width = plan->width - r.x;
    if (r.height > plan->height - r.y)
        r.height = plan->height - r.y;
    return r;
}

static uint64_t hash_tile(const lf_image8 *frame, lf_rect r)
{
    uint64_t h[4] = {1, 2, 3, 4}, all = 0;
    for (int y = r.y; y < r.y + r.height; y++)
        hash_row(h, frame->data + (size_t)y * frame->stride + (size_t)r.x * 3, (size_t)r.width * 3);
    for (int k = 0; k < 4; k++)
        all = mix(all, h[k]);
    return all == UNKNOWN ? 1 : all;
}

/* ------------------------------------------------------------------------------------ damage -- */

static int least(int a, int b)
{
    return a < b ? a : b;
}

static int most(int a, int b)
{
    return a > b ? a : b;
}

static lf_rect intersection(lf_rect a, lf_rect b)
{
    int x = most(a.x, b.x), y = most(a.y, b.y);
    return (lf_rect){x, y, least(a.x + a.width, b.x + b.width) - x,
                     least(a.y + a.height, b.y + b.height) - y};
}

/* Smallest rectangle around both; width 0 is empty. */
static lf_rect around(lf_rect a, lf_rect b)
{
    if (a.width == 0)
        return b;
    int x = least(a.x, b.x), y = least(a.y, b.y);
    return (lf_rect){x, y, most(a.x + a.width, b.x + b.width) - x,
                     most(a.y + a.height, b.y + b.height) - y};
}

static void touch(lf_gud_plan *plan, lf_rect r)
{
    for (int row = r.y / TILE_HEIGHT; row * TILE_HEIGHT < r.y + r.height; row++)
        for (int column = r.x / TILE_WIDTH; column * TILE_WIDTH < r.x + r.width; column++) {
            lf_rect *damage = &plan->damage[row * plan->columns + column];
            *damage = around(*damage, intersection(r, tile_rect(plan, column, row)));
        }
}

/* Removes the damage of a tile that already shows these pixels; widens it if its contents are
 * unknown. */
static void compare_tile(lf_gud_plan *plan, const lf_image8 *frame, int column, int row)
{
    int i = row * plan->columns + column;
    if (plan->damage[i].width == 0)
        return;
    lf_rect tile = tile_rect(plan, column, row);
    plan->wanted[i] = hash_tile(frame, tile);
    if (plan->shown[i] == plan->wanted[i])
        plan->damage[i].width = 0;
    else if (plan->shown[i] == UNKNOWN)
        plan->damage[i] = tile;
}

static void find_damage(lf_gud_plan *plan, const lf_image8 *frame, const lf_rect *rects, int n)
{
    assert(frame->width == plan->width && frame->height == plan->height && frame->channels == 3);
    memset(plan->damage, 0, (size_t)plan->columns * (size_t)plan->rows * sizeof *plan->damage);
    for (int i = 0; i < n; i++)
        touch(plan, rects[i]);
    for (int row = 0; row < plan->rows; row++)
        for (int column = 0; column < plan->columns; column++)
            compare_tile(plan, frame, column, row);
}

/* ------------------------------------------------------------------------------------- bands -- */

static size_t area(lf_rect r)
{
    return (size_t)r.width * (size_t)r.height;
}

/* Joins a run with one above it if the joined run costs no more and is one band. */
static bool extend_run(run *above, const run *r, size_t max_pixels)
{
    lf_rect both = around(above->rect, r->rect);
    if (area(both) > max_pixels || area(both) > area(above->rect) + area(r->rect) + ANNOUNCE_PIXELS)
        return false;
    int end = most(above->column + above->n_columns, r->column + r->n_columns);
    above->column = least(above->column, r->column);
    above->n_columns = end - above->column;
    above->n_rows = r->row + r->n_rows - above->row;
    above->rect = both;
    return true;
}

/* Returns the run that now has the tiles of r: one above it, or r itself. */
static int place_run(lf_gud_plan *plan, const run *r, size_t max_pixels)
{
    for (int column = r->column, tried = -1; column < r->column + r->n_columns; column++) {
        int above = plan->newest[column];
        if (above < 0 || above == tried)
            continue;
        if (extend_run(&plan->runs[above], r, max_pixels))
            return above;
        tried = above;
    }
    plan->runs[plan->n_runs] = *r;
    return plan->n_runs++;
}

/* The changed tiles of a row from `column` on, including gaps that are not worth a band. */
static run run_from(const lf_gud_plan *plan, int row, int column)
{
    const lf_rect *damage = plan->damage + row * plan->columns;
    run r = {.column = column, .row = row, .n_rows = 1};
    for (int c = column; c < plan->columns && c <= column + MAX_GAP; c++)
        if (damage[c].width > 0) {
            r.rect = around(r.rect, damage[c]);
            column = c;
        }
    r.n_columns = column + 1 - r.column;
    return r;
}

/* Joins damage within each tile row, then tile rows. */
static void find_runs(lf_gud_plan *plan, size_t max_pixels)
{
    plan->n_runs = 0;
    for (int column = 0; column < plan->columns; column++)
        plan->newest[column] = -1;
    for (int row = 0; row < plan->rows; row++)
        for (int column = 0; column < plan->columns; column++) {
            if (plan->damage[row * plan->columns + column].width == 0)
                continue;
            run r = run_from(plan, row, column);
            int placed = place_run(plan, &r, max_pixels);
            column = r.column + r.n_columns - 1;
            for (int c = r.column; c <= column; c++)
                plan->newest[c] = placed;
        }
}

static void cut_run(lf_gud_plan *plan, int index, size_t max_pixels)
{
    run *r = &plan->runs[index];
    size_t rows = max_pixels / (size_t)r->rect.width;
    int step = rows < 1 ? 1 : rows < (size_t)r->rect.height ? (int)rows : r->rect.height;
    for (int y = 0; y < r->rect.height; y += step) {
        assert(plan->n_bands < plan->max_bands);
        lf_rect rect = {r->rect.x, r->rect.y + y, r->rect.width, least(step, r->rect.height - y)};
        plan->bands[plan->n_bands++] = (band){rect, index};
        r->bands_left++;
    }
}

int lf_gud_plan_update(lf_gud_plan *plan, const lf_image8 *frame, const lf_rect *rects, int n,
                       size_t max_pixels)
{
    find_damage(plan, frame, rects, n);
    find_runs(plan, max_pixels);
    plan->n_bands = 0;
    for (int i = 0; i < plan->n_runs; i++)
        cut_run(plan, i, max_pixels);
    return plan->n_bands;
}

int lf_gud_plan_update_whole(lf_gud_plan *plan, const lf_image8 *frame)
{
    const lf_rect whole = {0, 0, plan->width, plan->height};
    find_damage(plan, frame, &whole, 1);
    plan->n_runs = plan->n_bands = 0;
    bool changed = false;
    for (int i = 0; i < plan->columns * plan->rows; i++)
        changed = changed || plan->damage[i].width > 0;
    if (!changed)
        return 0;
    plan->runs[plan->n_runs++] = (run){whole, 0, plan->columns, 0, plan->rows, 1};
    plan->bands[plan->n_bands++] = (band){whole, 0};
    return 1;
}

lf_rect lf_gud_plan_band(const lf_gud_plan *plan, int i)
{
    assert(i >= 0 && i < plan->n_bands);
    return plan->bands[i].rect;
}

/* Records what the tiles of a run show: the new pixels where they changed, or unknown. */
static void set_shown(lf_gud_plan *plan, const run *r, bool known)
{
    for (int row = r->row; row < r->row + r->n_rows; row++)
        for (int column = r->column; column < r->column + r->n_columns; column++) {
            int i = row * plan->columns + column;
            if (!known)
                plan->shown[i] = UNKNOWN;
            else if (plan->damage[i].width > 0)
                plan->shown[i] = plan->wanted[i];
        }
}

void lf_gud_plan_shown(lf_gud_plan *plan, int i)
{
    run *r = &plan->runs[plan->bands[i].run];
    if (--r->bands_left == 0)
        set_shown(plan, r, true);
}

void lf_gud_plan_failed(lf_gud_plan *plan)
{
    for (int i = 0; i < plan->n_runs; i++)
        if (plan->runs[i].bands_left > 0)
            set_shown(plan, &plan->runs[i], false);
}
