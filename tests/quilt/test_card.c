/* Cards: words on a picture of our own, whatever the words. */
#include "tests/testing.h"

#include "quilt/font.h"
#include "quilt/quilt.h"

enum { WIDTH = 240, HEIGHT = 320 };

static lf_image8 card_of(const char *text, int width, int height)
{
    lf_image8 card = {0};
    lf_assert_ok(lf_card_draw(text, width, height, &card), NULL);
    return card;
}

static bool is_ground(const lf_image8 *card, int x, int y)
{
    const uint8_t *at = card->data + (size_t)y * card->stride + (size_t)x * 3;
    return memcmp(at, card->data, 3) == 0;
}

/* Columns and rows with ink: the first and the one behind the last; all 0: there is none. */
typedef struct extent {
    int x0, x1, y0, y1;
} extent;

/* Of the words, without the name below them. */
static extent ink_of(const lf_image8 *card)
{
    extent e = {card->width, 0, card->height, 0};
    for (int y = 0; y < card->height * 9 / 10; y++) {
        for (int x = 0; x < card->width; x++) {
            if (is_ground(card, x, y))
                continue;
            e.x0 = x < e.x0 ? x : e.x0;
            e.x1 = x + 1 > e.x1 ? x + 1 : e.x1;
            e.y0 = y < e.y0 ? y : e.y0;
            e.y1 = y + 1;
        }
    }
    return e.x1 > 0 ? e : (extent){0};
}

static bool same(const char *text, const char *other)
{
    lf_image8 a = card_of(text, WIDTH, HEIGHT), b = card_of(other, WIDTH, HEIGHT);
    bool equal = memcmp(a.data, b.data, a.stride * HEIGHT) == 0;
    lf_image8_finish(&a);
    lf_image8_finish(&b);
    return equal;
}

static void every_character_has_a_picture_of_its_own(void **state)
{
    (void)state;
    for (int c = '!'; c <= '~'; c++)
        for (int d = ' '; d < c; d++)
            assert_memory_not_equal(lf_font_rows((char)c), lf_font_rows((char)d), LF_FONT_ROWS);
    assert_ptr_equal(lf_font_rows('\n'), lf_font_rows('?'));
    assert_ptr_equal(lf_font_rows((char)200), lf_font_rows('?'));
}

static void what_the_font_lacks_is_seen_to_be_missing(void **state)
{
    static const char *const pairs[][2] = {
        {"Stra\303\237e \303\244\303\226\303\251", "Strase aOe"}, /* accents are left out */
        {"\346\227\245\346\234\254", "??"},
        {"a\tb\x1b[2J\x7f", "a b [2J "},
        {"\xff\xc3(\xe6\x97", "?"
                              "?(?"}, /* no UTF-8 */
        {"\xf0\x9f\x98\x80", "?"},
    };
    char ascii[64];
    (void)state;
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        lf_font_ascii(pairs[i][0], ascii, sizeof ascii);
        assert_string_equal(ascii, pairs[i][1]);
    }
    lf_font_ascii("\346\227\245abc", ascii, 3);
    assert_string_equal(ascii, "?a");
    assert_true(same("\346\227\245", "?"));
    assert_false(same("?", ""));
}

static void words_lie_in_the_middle_and_within_the_margins(void **state)
{
    static const int sizes[][2] = {{240, 320}, {320, 180}, {180, 320}, {64, 64}, {1200, 300}};
    static const char *const texts[] = {
        "No scene", "Cannot show a_file_with_a_long_name_and_no_blank_in_it_anywhere.json:12",
        "one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen"};
    (void)state;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
            const int width = sizes[i][0], height = sizes[i][1];
            lf_image8 card = card_of(texts[k], width, height);
            const extent e = ink_of(&card);
            assert_true(e.x1 > 0);
            assert_in_range(e.x0, width / 20, width / 2);
            assert_in_range(e.x1, width / 2, width - width / 20);
            /* glyphs have room on their right that lines do not count */
            assert_in_range(abs(e.x0 + e.x1 - width), 0, width / 20 + 4);
            assert_in_range(abs(e.y0 + e.y1 - height), 0, height / 10 + 4);
            lf_image8_finish(&card);
        }
    }
}

/* What is refused and what to do: the longest words that quiltd has for a file. */
static void an_error_with_its_remedy_is_whole(void **state)
{
    static const int panels[][2] = {{1536, 2048}, {3840, 2160}, {2160, 3840}};
    char text[LF_CARD_TEXT];
    int width, height;
    (void)state;
    for (size_t i = 0; i < sizeof panels / sizeof *panels; i++) {
        snprintf(text, sizeof text,
                 "Cannot show a_scene_of_mine.json:12: exploding_barrel.glb: outside the folders "
                 "that quiltd may read; load the scene with quiltctl, again if needed, or start "
                 "quiltd with --allow-path DIR");
        lf_card_size(panels[i][0], panels[i][1], &width, &height);
        lf_image8 whole = card_of(text, width, height);
        text[strlen(text) - 1] = '!';
        lf_image8 other = card_of(text, width, height);
        assert_memory_not_equal(whole.data, other.data, whole.stride * (size_t)height);
        lf_image8_finish(&whole);
        lf_image8_finish(&other);
    }
}

static void words_too_long_are_cut_with_dots(void **state)
{
    char text[LF_CARD_TEXT], more[LF_CARD_TEXT];
    (void)state;
    memset(text, 'm', sizeof text - 1);
    text[sizeof text - 1] = '\0';
    memcpy(more, text, sizeof more);
    more[sizeof more - 2] = 'i'; /* far behind what there is room for */
    assert_true(same(text, more));
    more[20] = 'i';
    assert_false(same(text, more));
}

static void a_card_has_the_aspect_of_its_panel(void **state)
{
    static const int panels[][2] = {{1536, 2048}, {3840, 2160}, {2560, 1600}, {7680, 4320}};
    int width, height;
    (void)state;
    for (size_t i = 0; i < sizeof panels / sizeof *panels; i++) {
        lf_card_size(panels[i][0], panels[i][1], &width, &height);
        assert_in_range(width * panels[i][1] / 1000 - height * panels[i][0] / 1000 + 8, 0, 16);
        assert_true(width >= 480 && height >= 360 && width <= 2400);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_character_has_a_picture_of_its_own),
        cmocka_unit_test(what_the_font_lacks_is_seen_to_be_missing),
        cmocka_unit_test(words_lie_in_the_middle_and_within_the_margins),
        cmocka_unit_test(an_error_with_its_remedy_is_whole),
        cmocka_unit_test(words_too_long_are_cut_with_dots),
        cmocka_unit_test(a_card_has_the_aspect_of_its_panel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
