#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/quilt.h"

#define MAX_RECTS 300

static uint32_t random_bits(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*seed >> 33);
}

static lf_image8 frame(int width, int height, int channels)
{
    lf_image8 image = {0};
    assert_int_equal(lf_image8_init(&image, width, height, channels), LF_OK);
    for (size_t i = 0; i < image.stride * (size_t)height; i++)
        image.data[i] = (uint8_t)(i * 31 >> 3);
    return image;
}

static bool differs(const lf_image8 *a, const lf_image8 *b, int x, int y)
{
    size_t channels = (size_t)a->channels;
    return memcmp(a->data + (size_t)y * a->stride + (size_t)x * channels,
                  b->data + (size_t)y * b->stride + (size_t)x * channels, channels) != 0;
}

static bool line_differs(const lf_image8 *a, const lf_image8 *b, int x0, int y0, int x1, int y1)
{
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++)
            if (differs(a, b, x, y))
                return true;
    return false;
}

/* Inside the frame, disjoint, every difference in one of them, and each with differences on all
 * four sides. */
static int assert_rects(const lf_image8 *a, const lf_image8 *b, int max_rects)
{
    lf_rect r[MAX_RECTS];
    uint64_t before = lf_alloc_count();
    int n = lf_changed_rects(a, b, r, max_rects);
    assert_int_equal(lf_alloc_count(), before);
    assert_in_range(n, 0, max_rects);
    uint8_t *count = calloc((size_t)a->width, (size_t)a->height);
    assert_non_null(count);
    for (int i = 0; i < n; i++) {
        int x1 = r[i].x + r[i].width, y1 = r[i].y + r[i].height;
        assert_true(r[i].x >= 0 && r[i].y >= 0 && r[i].width > 0 && r[i].height > 0 &&
                    x1 <= a->width && y1 <= a->height);
        assert_true(line_differs(a, b, r[i].x, r[i].y, x1, r[i].y + 1));
        assert_true(line_differs(a, b, r[i].x, y1 - 1, x1, y1));
        assert_true(line_differs(a, b, r[i].x, r[i].y, r[i].x + 1, y1));
        assert_true(line_differs(a, b, x1 - 1, r[i].y, x1, y1));
        for (int y = r[i].y; y < y1; y++)
            for (int x = r[i].x; x < x1; x++)
                count[(size_t)y * (size_t)a->width + (size_t)x]++;
    }
    for (int y = 0; y < a->height; y++)
        for (int x = 0; x < a->width; x++) {
            int times = count[(size_t)y * (size_t)a->width + (size_t)x];
            assert_in_range(times, differs(a, b, x, y) ? 1 : 0, 1);
        }
    free(count);
    return n;
}

/* Two frames of the same colour. */
typedef struct pair {
    lf_image8 a, b;
} pair;

static pair two(int width, int height, int channels)
{
    return (pair){frame(width, height, channels), frame(width, height, channels)};
}

static void drop(pair *p)
{
    lf_image8_finish(&p->a);
    lf_image8_finish(&p->b);
}

static void equal_frames_have_no_rectangles(void **state)
{
    (void)state;
    pair p = two(300, 200, 3);
    assert_int_equal(assert_rects(&p.a, &p.b, 16), 0);
    drop(&p);
}

static void one_changed_pixel_is_one_pixel(void **state)
{
    (void)state;
    pair p = two(300, 200, 3);
    const int places[][2] = {{0, 0}, {299, 199}, {63, 64}, {64, 63}, {150, 7}};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        uint8_t *byte =
            p.b.data + (size_t)places[i][1] * p.b.stride + (size_t)places[i][0] * 3 + i % 3;
        *byte ^= 1;
        assert_int_equal(assert_rects(&p.a, &p.b, 1), 1);
        lf_rect r;
        assert_int_equal(lf_changed_rects(&p.a, &p.b, &r, 1), 1);
        assert_true(r.x == places[i][0] && r.y == places[i][1] && r.width == 1 && r.height == 1);
        *byte ^= 1;
    }
    drop(&p);
}

static void a_frame_that_changed_everywhere_is_one_rectangle(void **state)
{
    (void)state;
    pair p = two(1000, 700, 3);
    for (size_t i = 0; i < p.b.stride * 700; i++)
        p.b.data[i] ^= 0x80;
    assert_int_equal(assert_rects(&p.a, &p.b, 64), 1);
    drop(&p);
}

static void distant_changes_keep_their_own_rectangles(void **state)
{
    (void)state;
    pair p = two(1000, 700, 3);
    p.b.data[5 * p.b.stride + 15] ^= 1;
    p.b.data[600 * p.b.stride + 2700] ^= 1;
    p.b.data[600 * p.b.stride + 3] ^= 1;
    assert_int_equal(assert_rects(&p.a, &p.b, 64), 3);
    assert_int_equal(assert_rects(&p.a, &p.b, 1), 1);
    drop(&p);
}

static void random_changes_are_covered_within_any_number_of_rectangles(void **state)
{
    (void)state;
    uint64_t seed = lf_test_seed();
    for (int round = 0; round < 120; round++) {
        int width = 1 + (int)(random_bits(&seed) % 700),
            height = 1 + (int)(random_bits(&seed) % 500);
        pair p = two(width, height, 1 + round % 4);
        uint32_t n = random_bits(&seed) % (round % 3 ? 30 : 3000);
        for (uint32_t i = 0; i < n; i++)
            p.b.data[random_bits(&seed) % (p.b.stride * (size_t)height)] ^= 1;
        assert_rects(&p.a, &p.b, 1 + (int)(random_bits(&seed) % (round % 2 ? 6 : MAX_RECTS)));
        drop(&p);
    }
}

static void padding_of_rows_is_not_looked_at(void **state)
{
    (void)state;
    lf_image8 a = frame(100, 50, 3), wide = frame(120, 50, 3);
    for (int y = 0; y < 50; y++)
        memcpy(wide.data + (size_t)y * wide.stride, a.data + (size_t)y * a.stride, a.stride);
    lf_image8 b = wide;
    b.width = 100;
    assert_int_equal(assert_rects(&a, &b, 4), 0);
    b.data[20 * b.stride + 299] ^= 1;
    assert_int_equal(assert_rects(&a, &b, 4), 1);
    lf_image8_finish(&a);
    lf_image8_finish(&wide);
}

static void very_large_frames_are_within_the_bounds(void **state)
{
    (void)state;
    pair p = two(65536, 3, 1);
    for (size_t i = 0; i < 65536; i += 700)
        p.b.data[i + i % 3 * 65536] ^= 1;
    assert_true(assert_rects(&p.a, &p.b, MAX_RECTS) > 50);
    assert_rects(&p.a, &p.b, 7);
    drop(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_frames_have_no_rectangles),
        cmocka_unit_test(one_changed_pixel_is_one_pixel),
        cmocka_unit_test(a_frame_that_changed_everywhere_is_one_rectangle),
        cmocka_unit_test(distant_changes_keep_their_own_rectangles),
        cmocka_unit_test(random_changes_are_covered_within_any_number_of_rectangles),
        cmocka_unit_test(padding_of_rows_is_not_looked_at),
        cmocka_unit_test(very_large_frames_are_within_the_bounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
