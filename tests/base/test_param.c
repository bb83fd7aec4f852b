/* Tables of parameters: what a table says is what the command line, JSON and checks do. */
#include "tests/testing.h"

#include <jansson.h>

#include "base/param.h"

typedef struct lamp {
    double watts, x, y, turn, spot[3];
    int legs, bits;
    bool lit, upright;
    enum { ROUND, FLAT, LONG } shape;
    const char *maker, *kind;
    uint64_t serial;
    unsigned colours;
    bool has_colours;
} lamp;

#define PLACE(field) .place = offsetof(lamp, field)
static const char *const shapes[] = {"round", "flat", "long", NULL};
static const char *const bits[] = {"8", "16", NULL};
static const char *const stands[] = {"lying", "upright", NULL};

static const char *kind_at(int index)
{
    return index == 0 ? "table" : index == 1 ? "street" : NULL;
}

static const char *colour_at(int index)
{
    return index == 0 ? "red" : index == 1 ? "green" : index == 2 ? "blue" : NULL;
}

/* clang-format off */
static const lf_param rows[] = {
    {.name = "watts", .option = "watts", PLACE(watts), .unit = "W", .low = 1, .high = 100,
     .required = true, .help = "how bright"},
    {.name = "legs", .option = "legs", PLACE(legs), .type = LF_PARAM_WHOLE, .low = 3, .high = 5,
     .help = "how many legs", .about = "legs that it stands on"},
    {.name = "x", .option = "at", .joined = "+-", .argument = "X", PLACE(x), .low = -9, .high = 9},
    {.name = "y", .option = "at", .argument = "Y", PLACE(y), .low = -9, .high = 9},
    {.name = "bits", .option = "bits", PLACE(bits), .type = LF_PARAM_WHOLE, .words = bits,
     .initial = 16},
    {.name = "lit", .option = "lit", PLACE(lit), .type = LF_PARAM_SWITCH},
    {.name = "stand", .option = "stand", PLACE(upright), .type = LF_PARAM_SWITCH, .words = stands},
    {.name = "shape", .option = "shape", PLACE(shape), .type = LF_PARAM_WORD, .words = shapes,
     .initial = LONG},
    {.name = "turn", .option = "turn", PLACE(turn), .type = LF_PARAM_ANGLE, .low = 0, .high = 180},
    {.name = "spot", PLACE(spot), .type = LF_PARAM_POINT, .low = -1, .high = 1, .point = {0, 1, 0}},
    {.name = "maker", .option = "maker", PLACE(maker), .type = LF_PARAM_TEXT},
    {.name = "kind", .option = "kind", PLACE(kind), .type = LF_PARAM_NAME, .word_at = kind_at},
    {.option = "serial", PLACE(serial), .type = LF_PARAM_SEED},
    {.option = "colours", PLACE(colours), .type = LF_PARAM_LIST, .word_at = colour_at,
     .has = offsetof(lamp, has_colours)},
    {0},
};
/* clang-format on */

static const lf_param *row_of(const char *option)
{
    const lf_param *row = lf_param_find(rows, option);
    assert_non_null(row);
    return row;
}

static lamp default_lamp(void)
{
    lamp l;
    memset(&l, 0x5a, sizeof l);
    lf_param_defaults(rows, &l);
    return l;
}

static void take(lamp *l, const char *option, const char *text)
{
    lf_error err = {0};
    lf_assert_ok(lf_param_from_text(row_of(option), text, l, &err), &err);
}

static void refuses(const char *option, const char *text, const char *word)
{
    lf_error err = {0};
    lamp l = default_lamp(), before = l;
    assert_int_equal(lf_param_from_text(row_of(option), text, &l, &err), LF_E_ARG);
    assert_memory_equal(&l, &before, sizeof l);
    assert_string_equal(err.where + 2, option);
    if (!strstr(err.what, word))
        fail_msg("\"%s\" does not say \"%s\"", err.what, word);
}

static void text_reaches_the_field_of_its_row_and_no_other(void **state)
{
    (void)state;
    lamp l = default_lamp();
    take(&l, "watts", "12.5");
    take(&l, "legs", "4");
    take(&l, "at", "3+--2.5");
    take(&l, "bits", "8");
    take(&l, "lit", NULL);
    take(&l, "stand", "upright");
    take(&l, "shape", "flat");
    take(&l, "maker", "us");
    take(&l, "turn", "90");
    lf_assert_close(l.turn, asin(1.0), 1e-15, 0.0);
    assert_true(l.watts == 12.5 && l.legs == 4 && l.x == 3 && l.y == -2.5 && l.bits == 8);
    assert_true(l.lit && l.upright && l.shape == FLAT);
    assert_string_equal(l.maker, "us");
    take(&l, "stand", "lying");
    assert_false(l.upright);
    take(&l, "kind", "street");
    assert_ptr_equal(l.kind, kind_at(1));
    take(&l, "serial", "18446744073709551615");
    assert_true(l.serial == UINT64_MAX);
}

static void lists_are_bits_of_their_words(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        unsigned bits;
    } cases[] = {{"all", 7}, {"none", 0}, {"blue", 4}, {"blue,red", 5}, {"red,red", 1}};
    static const char *const wrong[] = {"", "red,", ",red", "red, blue", "re", "Red", "red,none"};
    lamp l = default_lamp();
    l.has_colours = false;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        refuses("colours", wrong[i], "all, none or some of red, green, blue");
    assert_false(l.has_colours);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        take(&l, "colours", cases[i].text);
        assert_int_equal(l.colours, cases[i].bits);
    }
    assert_true(l.has_colours);
}

static void options_are_found_by_their_whole_names(void **state)
{
    (void)state;
    assert_string_equal(lf_param_find(rows, "at")->name, "x");
    assert_null(lf_param_find(rows, "spot")); /* a key alone */
    assert_null(lf_param_find(rows, "a"));
    assert_true(lf_param_among(row_of("at"), "watts at legs"));
    assert_true(lf_param_among(row_of("legs"), "watts at  legs"));
    assert_true(lf_param_among(row_of("at"), NULL));
    assert_false(lf_param_among(row_of("at"), "watts att a t"));
    assert_false(lf_param_among(row_of("at"), ""));
}

static void defaults_are_those_of_the_rows(void **state)
{
    (void)state;
    const lamp l = default_lamp();
    assert_true(l.watts == 0 && l.x == 0 && l.legs == 0 && l.bits == 16 && !l.lit && !l.upright);
    assert_int_equal(l.shape, LONG);
    assert_true(l.spot[0] == 0 && l.spot[1] == 1 && l.spot[2] == 0);
    assert_null(l.maker);
    assert_null(l.kind);
}

static void refused_text_is_told_what_was_expected(void **state)
{
    (void)state;
    refuses("watts", "101", "from 1 to 100 W, not");
    refuses("watts", "nan", "from 1 to 100");
    refuses("legs", "3.5", "a whole number from 3 to 5");
    refuses("at", "3", "X+-Y, X a number from -9 to 9, Y a number");
    refuses("at", "3+-", "X+-Y");
    refuses("at", "3+-4+-5", "X+-Y");
    refuses("bits", "12", "8 or 16");
    refuses("stand", "leaning", "lying or upright");
    refuses("shape", "", "round, flat or long, not \"\"");
    refuses("kind", "garden", "table or street, not \"garden\"");
    refuses("serial", "-1", "a whole number from 0");
}

static json_t *object(const char *text)
{
    json_t *value = json_loads(text, 0, NULL);
    assert_non_null(value);
    return value;
}

static void what_is_written_as_json_reads_back_the_same(void **state)
{
    (void)state;
    lf_error err = {0};
    lamp l = default_lamp(), back = default_lamp();
    take(&l, "watts", "12.5");
    take(&l, "legs", "4");
    take(&l, "at", "3+--2.5");
    take(&l, "lit", NULL);
    take(&l, "stand", "upright");
    take(&l, "shape", "flat");
    take(&l, "maker", "us");
    take(&l, "kind", "table");
    l.spot[0] = 0.25;
    l.spot[2] = -1;
    json_t *json = lf_param_json(rows, &l);
    json_t *expected = object("{\"watts\":12.5,\"legs\":4,\"x\":3.0,\"y\":-2.5,\"bits\":16,"
                              "\"lit\":true,\"stand\":\"upright\",\"shape\":\"flat\","
                              "\"turn\":0.0,\"spot\":[0.25,1.0,-1.0],\"maker\":\"us\","
                              "\"kind\":\"table\"}");
    assert_true(json_equal(json, expected));
    lf_assert_ok(lf_param_from_json(rows, json, &back, "here", &err), &err);
    assert_string_equal(back.maker, "us");
    back.maker = l.maker;
    assert_memory_equal(&back, &l, sizeof l);
    json_decref(json);
    json_decref(expected);
}

static void wrong_json_is_refused_with_its_key(void **state)
{
    (void)state;
    static const char *const bad[][3] = {
        {"{\"watts\": \"5\"}", "/watts", "a number from 1 to 100"},
        {"{\"watts\": 0.5}", "/watts", "from 1"},
        {"{\"legs\": 3.5}", "/legs", "whole number"},
        {"{\"bits\": 9}", "/bits", "8 or 16"},
        {"{\"lit\": 1}", "/lit", "true or false"},
        {"{\"stand\": true}", "/stand", "lying or upright"},
        {"{\"shape\": \"square\"}", "/shape", "round, flat or long"},
        {"{\"turn\": 181}", "/turn", "from 0 to 180"},
        {"{\"spot\": [0, 1]}", "/spot", "three numbers"},
        {"{\"spot\": [0, 1, 2]}", "/spot", "three numbers"},
        {"{\"maker\": 7}", "/maker", "a string"},
        {"{\"kind\": \"garden\"}", "/kind", "table or street"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lf_error err = {0};
        lamp l = default_lamp();
        json_t *json = object(bad[i][0]);
        assert_int_equal(lf_param_from_json(rows, json, &l, "here", &err), LF_E_ARG);
        assert_string_equal(err.pointer, bad[i][1]);
        assert_non_null(strstr(err.what, bad[i][2]));
        json_decref(json);
    }
}

static void checks_know_what_is_required_and_what_was_not_given(void **state)
{
    (void)state;
    lf_error err = {0};
    lamp l = default_lamp();
    json_t *none = object("{\"legs\": 4}"), *some = object("{\"watts\": 4}");
    assert_int_equal(lf_param_check(rows, &l, "lamp", &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "watts"));
    assert_string_equal(lf_param_missing(rows, none), "watts");
    assert_null(lf_param_missing(rows, some));
    l.watts = 5;
    lf_assert_ok(lf_param_check(rows, &l, "lamp", &err), &err); /* legs 0: not given */
    l.legs = 2;
    assert_int_equal(lf_param_check(rows, &l, "lamp", &err), LF_E_ARG);
    l.legs = 3;
    l.bits = 12;
    assert_int_equal(lf_param_check(rows, &l, "lamp", &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "bits 12: expected 8 or 16"));
    l.bits = 8;
    l.x = (double)NAN;
    assert_int_equal(lf_param_check(rows, &l, "lamp", &err), LF_E_ARG);
    json_decref(none);
    json_decref(some);
}

/* Degrees that are radians in between are no longer what they were. */
static void an_angle_at_the_end_of_its_range_is_within_it(void **state)
{
    (void)state;
    for (int degrees = 1; degrees < 180; degrees++) {
        const lf_param table[] = {{.name = "turn",
                                   .option = "turn",
                                   PLACE(turn),
                                   .type = LF_PARAM_ANGLE,
                                   .low = -degrees,
                                   .high = degrees},
                                  {0}};
        char text[16];
        lf_error err = {0};
        lamp l = default_lamp();
        for (int sign = -1; sign <= 1; sign += 2) {
            snprintf(text, sizeof text, "%d", sign * degrees);
            lf_assert_ok(lf_param_from_text(table, text, &l, &err), &err);
            lf_assert_ok(lf_param_check(table, &l, "lamp", &err), &err);
            json_t *json = lf_param_json(table, &l);
            lf_assert_ok(lf_param_from_json(table, json, &l, "here", &err), &err);
            json_decref(json);
        }
        l.turn *= 1.0 + 1e-6;
        assert_int_equal(lf_param_check(table, &l, "lamp", &err), LF_E_ARG);
    }
}

static void the_schema_says_what_the_rows_say(void **state)
{
    (void)state;
    json_t *schema = lf_param_schema(rows);
    json_t *expected = object(
        "{\"watts\":{\"type\":\"number\",\"minimum\":1.0,\"maximum\":100.0,"
        "\"description\":\"how bright\",\"unit\":\"W\"},"
        "\"legs\":{\"type\":\"integer\",\"minimum\":3.0,\"maximum\":5.0,"
        "\"description\":\"legs that it stands on\"},"
        "\"x\":{\"type\":\"number\",\"minimum\":-9.0,\"maximum\":9.0,\"default\":0},"
        "\"y\":{\"type\":\"number\",\"minimum\":-9.0,\"maximum\":9.0,\"default\":0},"
        "\"bits\":{\"type\":\"integer\",\"enum\":[8,16],\"default\":16},"
        "\"lit\":{\"type\":\"boolean\",\"default\":false},"
        "\"stand\":{\"type\":\"string\",\"enum\":[\"lying\",\"upright\"],\"default\":\"lying\"},"
        "\"shape\":{\"type\":\"string\",\"enum\":[\"round\",\"flat\",\"long\"],"
        "\"default\":\"long\"},"
        "\"turn\":{\"type\":\"number\",\"minimum\":0.0,\"maximum\":180.0,\"default\":0},"
        "\"spot\":{\"type\":\"array\",\"items\":{\"type\":\"number\",\"minimum\":-1.0,"
        "\"maximum\":1.0},\"minItems\":3,\"maxItems\":3},"
        "\"maker\":{\"type\":\"string\"},"
        "\"kind\":{\"type\":\"string\",\"enum\":[\"table\",\"street\"]}}");
    assert_true(json_equal(schema, expected));
    json_decref(schema);
    json_decref(expected);
}

static void fields_of_every_type_with_a_name_get_their_initial_values(void **state)
{
    (void)state;
    struct things {
        double tint[3], towards[3];
        const char *file, *note;
        uint64_t seed;
        unsigned list;
        int n, other;
    } t, before;
    const lf_param table[] = {
        {.name = "tint",
         .type = LF_PARAM_COLOUR,
         .place = offsetof(struct things, tint),
         .point = {1, 2, 3}},
        {.name = "towards",
         .type = LF_PARAM_DIRECTION,
         .place = offsetof(struct things, towards),
         .point = {0, 1, 0}},
        {.name = "file", .type = LF_PARAM_FILE, .place = offsetof(struct things, file)},
        {.option = "note", .type = LF_PARAM_TEXT, .place = offsetof(struct things, note)},
        {.option = "seed", .type = LF_PARAM_SEED, .place = offsetof(struct things, seed)},
        {.option = "list",
         .type = LF_PARAM_LIST,
         .place = offsetof(struct things, list),
         .word_at = colour_at},
        {.name = "n",
         .option = "n",
         .type = LF_PARAM_WHOLE,
         .place = offsetof(struct things, n),
         .initial = 7},
        {.option = "again", .type = LF_PARAM_WHOLE, .place = offsetof(struct things, n)},
        {0},
    };
    memset(&t, 0x5a, sizeof t);
    before = t;
    lf_param_defaults(table, &t);
    assert_true(t.tint[0] == 1 && t.tint[1] == 2 && t.tint[2] == 3);
    assert_true(t.towards[0] == 0 && t.towards[1] == 1 && t.towards[2] == 0);
    assert_null(t.file);
    assert_int_equal(t.n, 7);
    assert_ptr_equal(t.note, before.note);
    assert_true(t.seed == before.seed && t.list == before.list && t.other == before.other);
}

/* A number in whose place a word may stand: infinity on either side. */
static void numbers_may_have_words_beside_them(void **state)
{
    (void)state;
    static const char *const words[] = {"much", "little", NULL};
    const lf_param mixed[] = {
        {.name = "x", .option = "x", PLACE(x), .low = -9, .high = 9, .words = words}, {0}};
    lamp l = {.x = 1};
    lf_error err;
    static const struct {
        const char *text;
        double value;
    } good[] = {{"much", (double)INFINITY}, {"little", -(double)INFINITY}, {"-2.5", -2.5}};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        lf_assert_ok(lf_param_from_text(mixed, good[i].text, &l, &err), &err);
        assert_true(l.x == good[i].value);
        lf_assert_ok(lf_param_check(mixed, &l, "l", &err), &err);
        json_t *json = lf_param_json(mixed, &l);
        lamp back = {0};
        lf_assert_ok(lf_param_from_json(mixed, json, &back, "l", &err), &err);
        assert_true(back.x == good[i].value);
        json_decref(json);
        json = json_pack("{s:s}", "x", good[i].text);
        lf_assert_ok(lf_param_from_json(mixed, json, &back, "l", &err), &err);
        assert_true(back.x == good[i].value);
        json_decref(json);
    }
    lf_assert_status(lf_param_from_text(mixed, "more", &l, &err), LF_E_ARG, &err);
    assert_non_null(strstr(err.what, "a number from -9 to 9, much or little"));
    lf_assert_status(lf_param_from_text(mixed, "10", &l, &err), LF_E_ARG, &err);
    lf_assert_status(lf_param_from_text(mixed, "inf", &l, &err), LF_E_ARG, &err);
    json_t *schema = lf_param_schema(mixed),
           *type = json_object_get(json_object_get(schema, "x"), "type");
    assert_int_equal(json_array_size(type), 2);
    json_decref(schema);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_may_have_words_beside_them),
        cmocka_unit_test(fields_of_every_type_with_a_name_get_their_initial_values),
        cmocka_unit_test(text_reaches_the_field_of_its_row_and_no_other),
        cmocka_unit_test(lists_are_bits_of_their_words),
        cmocka_unit_test(options_are_found_by_their_whole_names),
        cmocka_unit_test(defaults_are_those_of_the_rows),
        cmocka_unit_test(refused_text_is_told_what_was_expected),
        cmocka_unit_test(what_is_written_as_json_reads_back_the_same),
        cmocka_unit_test(wrong_json_is_refused_with_its_key),
        cmocka_unit_test(checks_know_what_is_required_and_what_was_not_given),
        cmocka_unit_test(an_angle_at_the_end_of_its_range_is_within_it),
        cmocka_unit_test(the_schema_says_what_the_rows_say),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
