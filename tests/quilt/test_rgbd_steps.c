/* What hides what in the views of pictures with depth: against a depth test of all pixels, which
 * the code does without. */
#include "tests/testing.h"

#include "quilt/rgbd.h"

enum { WIDTH = 160, HEIGHT = 40, VIEWS = 9 };

/* Codes are fifths, so that with these every shift is a whole number of pixels. */
#define DISPARITY (40.0 / WIDTH)
#define PLANE 0.4

typedef struct fixture {
    double code[HEIGHT][WIDTH], widened[HEIGHT][WIDTH]; /* drawn; as the views have them */
    uint8_t data[HEIGHT][2 * WIDTH][3], views[VIEWS][HEIGHT][WIDTH][3];
} fixture;

static fixture f;

/* What is in front of a step is one pixel wider. */
static void widen(void)
{
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            f.widened[y][x] = 0;
            for (int k = 0; k < 9; k++) {
                const int i = y + k / 3 - 1, j = x + k % 3 - 1;
                if (i >= 0 && i < HEIGHT && j >= 0 && j < WIDTH)
                    f.widened[y][x] = fmax(f.widened[y][x], f.code[i][j]);
            }
        }
}

/* Colours tell the column, and in blue what f.code was before. */
static void colour_columns(void)
{
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            f.data[y][x][0] = (uint8_t)x;
            f.data[y][x][1] = (uint8_t)(255 - x);
            f.data[y][x][2] = (uint8_t)(100 * f.code[y][x]);
        }
}

static void draw(void)
{
    const lf_rgbd rgbd = {
        .side = LF_RGBD_IN_RIGHT, .disparity = DISPARITY, .plane = PLANE, .zoom = 1};
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            memset(f.data[y][WIDTH + x], (int)lround(255 * fmin(fmax(f.code[y][x], 0), 1)), 3);
    const lf_rgbd_picture picture = {2 * WIDTH, HEIGHT, sizeof f.data[0], f.data[0][0], 0};
    const lf_layout layout = {.columns = VIEWS,
                              .rows = 1,
                              .n_views = VIEWS,
                              .view_width = WIDTH,
                              .view_height = HEIGHT,
                              .aspect = (double)WIDTH / HEIGHT};
    lf_error err;
    lf_assert_ok(lf_rgbd_views(&rgbd, &picture, &layout, NULL, "p", f.views[0][0][0], &err), &err);
}

/* ------------------------------------------------------------------------------ a depth test -- */

/* Where a code moves a column in a view. */
static int moved(int view, int column, double code)
{
    const double camera = (double)view / (VIEWS - 1) - 0.5;
    return column + (int)lround(camera * DISPARITY * WIDTH * (PLANE - code));
}

/* The column of a row of codes that is seen at x in a view by a depth test; -1: none. */
static int seen_at(const double *code, int view, int x)
{
    int seen = -1;
    for (int j = 0; j < WIDTH; j++)
        if (moved(view, j, code[j]) == x && (seen < 0 || code[j] > code[seen]))
            seen = j;
    return seen;
}

/* The code of the nearest gap at x: a gap is between the two sides of a step, and as far as the
 * farther one; -1: none. */
static double gap_at(const double *code, int view, int x)
{
    double nearest = -1;
    for (int j = 1; j < WIDTH; j++)
        if (x >= moved(view, j, code[j - 1]) && x < moved(view, j, code[j]))
            nearest = fmax(nearest, fmin(code[j - 1], code[j]));
    return nearest;
}

/* What the depth test found. */
typedef struct counts {
    int holes, behind, before; /* samples of no pixel; pixels behind a gap, and before one */
} counts;

/* Compares a row of a view with a depth test; codes: as wide as they are drawn. */
static void assert_row(const double *code, int view, const uint8_t *row, counts *n)
{
    for (int x = 24; x < WIDTH - 24; x++) { /* what is beyond the sides moves in, too */
        const uint8_t *at = row + 3 * x;
        const int seen = seen_at(code, view, x);
        const double gap = gap_at(code, view, x);
        assert_int_equal(at[0] + at[1], 255); /* no mixture, no black */
        if (seen >= 0 && code[seen] >= gap)
            assert_int_equal(at[0], seen);
        else
            lf_assert_close(code[at[0]], gap, 1e-9, 1e-9);
        n->holes += seen < 0;
        n->behind += seen >= 0 && code[seen] < gap;
        n->before += seen >= 0 && code[seen] > gap && gap >= 0;
    }
}

static void make_blocks(uint32_t *seed)
{
    int x = 0;
    while (x < WIDTH) {
        *seed = *seed * 1664525 + 1013904223;
        const double code = (*seed >> 16) % 6 / 5.0;
        const int end = x + 7 + (int)((*seed >> 24) % 20);
        for (; x < end && x < WIDTH; x++)
            for (int y = 0; y < HEIGHT; y++)
                f.code[y][x] = code;
    }
}

static void the_nearer_wins_and_gaps_get_the_background(void **state)
{
    (void)state;
    uint32_t seed = 7;
    counts n = {0};
    for (int round = 0; round < 40; round++) {
        make_blocks(&seed);
        widen();
        colour_columns();
        draw();
        for (int view = 0; view < VIEWS; view++)
            assert_row(f.widened[1], view, f.views[view][1][0], &n);
    }
    assert_true(n.holes > 1000 && n.behind > 50 && n.before > 100);
}

/* ------------------------------------------------------------------------------ three depths -- */

/* A front over the side of a middle, before a ground. */
static double depth_of(int x, int y)
{
    const bool front = x >= 60 && x < 80 && y >= 14 && y < 28,
               middle = x >= 70 && x < 104 && y >= 6 && y < 34;
    return front ? 1 : middle ? 0.8 : 0;
}

static void make_objects(void)
{
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            f.code[y][x] = depth_of(x, y);
    widen();
    colour_columns();
}

/* The middle keeps its code next to the front, though it is near the nearest code there. */
static void a_depth_between_two_others_stays(void **state)
{
    (void)state;
    counts n = {0};
    make_objects();
    draw();
    for (int view = 0; view < VIEWS; view++)
        for (int y = 0; y < HEIGHT; y++)
            assert_row(f.widened[y], view, f.views[view][y][0], &n);
    assert_true(n.holes > 500);
}

/* A depth as JPEG and networks make it: soft at its steps, with ripples. */
static void make_depth_rough(void)
{
    uint32_t seed = 5;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            double sum = 0;
            for (int k = 0; k < 9; k++)
                sum += depth_of(x + k % 3 - 1, y + k / 3 - 1);
            seed = seed * 1664525 + 1013904223;
            f.code[y][x] = sum / 9 + ((seed >> 16) % 17 - 8.0) / 255;
        }
}

/* The pixels of row y of a view that show the ground between the first and the last one of objects;
 * a rim, which is one pixel wide, is none. */
static int cracks_of(const uint8_t (*row)[3], int y)
{
    int first = WIDTH, last = 0, n = 0;
    for (int x = 0; x < WIDTH; x++)
        if (row[x][2] > 40) {
            first = x < first ? x : first;
            last = x;
        }
    for (int x = first; x < last; x++)
        n += row[x][2] <= 40 && depth_of(row[x][0] - 1, y) + depth_of(row[x][0] + 1, y) == 0;
    return n;
}

static void a_rough_depth_opens_no_cracks(void **state)
{
    (void)state;
    int cracks = 0;
    make_objects();
    make_depth_rough();
    draw();
    for (int view = 0; view < VIEWS; view++)
        for (int y = 8; y < 32; y++)
            cracks += cracks_of((const uint8_t(*)[3])f.views[view][y], y);
    assert_int_equal(cracks, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_nearer_wins_and_gaps_get_the_background),
        cmocka_unit_test(a_depth_between_two_others_stays),
        cmocka_unit_test(a_rough_depth_opens_no_cracks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
