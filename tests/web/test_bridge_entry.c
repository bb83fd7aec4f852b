/* What programs of Bridge say of an entry, and what quiltd is told. */
#include "tests/testing.h"

#include <jansson.h>

#include "daemon/web/bridge_entry.h"
#include "daemon/web/bridge_lists.h"

/* The entry of one request, a new reference; NULL: refused, and *out_err says why. */
static json_t *make(const char *body_text, lf_error *out_err)
{
    json_t *body = json_loads(body_text, 0, NULL), *nothing = json_object(), *said = NULL,
           *entry = NULL;
    assert_non_null(body);
    if (lf_bridge_entry_make(nothing, body, &said, &entry, out_err) != LF_OK)
        assert_null(entry);
    json_decref(said);
    json_decref(nothing);
    json_decref(body);
    return entry;
}

static void check(const char *body, const char *expected_text)
{
    lf_error err = {0};
    json_t *entry = make(body, &err), *expected = json_loads(expected_text, 0, NULL);
    char *got = entry ? json_dumps(entry, JSON_SORT_KEYS) : NULL;
    assert_non_null(expected);
    if (!json_equal(entry, expected))
        fail_msg("%s: %s%s, expected %s", body, got ? got : "", err.what, expected_text);
    free(got);
    json_decref(entry);
    json_decref(expected);
}

static void check_refused(const char *body, const char *words)
{
    lf_error err = {0};
    json_t *entry = make(body, &err);
    if (entry)
        fail_msg("%s is taken", body);
    assert_int_equal(err.status, LF_E_ARG);
    if (!strstr(err.what, words) && !strstr(err.where, words))
        fail_msg("%s: %s: %s", body, err.where, err.what);
}

static void a_quilt_has_tiles_and_an_aspect(void **state)
{
    (void)state;
    check("{\"uri\":\"/a.png\"}", "{\"file\":\"/a.png\"}");
    check("{\"uri\":\"/a.png\",\"rows\":6,\"cols\":8,\"view_count\":48,\"aspect\":0.75,"
          "\"isRGBD\":0,\"focus\":0,\"tag\":\"\",\"id\":0}",
          "{\"file\":\"/a.png\",\"rgbd_in\":\"off\",\"quilt\":\"8x6\",\"aspect\":0.75,"
          "\"focus\":0.0}");
    check("{\"uri\":\"/a.png\",\"rows\":\"6\",\"cols\":\"8\",\"viewCount\":\"48\","
          "\"isRGBD\":\"false\",\"durationMS\":\"2500\",\"zoom\":2}",
          "{\"file\":\"/a.png\",\"rgbd_in\":\"off\",\"quilt\":\"8x6\","
          "\"seconds\":2.5,\"zoom\":2.0}");
    check("{\"uri\":\"/a.png\",\"durationMS\":0,\"aspect\":0,\"view_count\":null}",
          "{\"file\":\"/a.png\"}");
    check("{\"uri\":\"/a.png\",\"rows\":9,\"cols\":5,\"view_count\":44}",
          "{\"file\":\"/a.png\",\"quilt\":\"5x9\",\"views\":44}");
}

/* Its rows, columns and views are defaults that mean nothing. */
static void a_picture_with_depth_has_a_side(void **state)
{
    (void)state;
    static const char *const sides[] = {"top", "bottom", "right", "left"};
    check("{\"uri\":\"/a.png\",\"isRGBD\":1,\"rows\":8,\"cols\":13,\"view_count\":104,"
          "\"aspect\":1,\"depth_loc\":2,\"depth_inversion\":0,\"chroma_depth\":0,"
          "\"depthiness\":2,\"zoom\":1}",
          "{\"file\":\"/a.png\",\"rgbd_in\":\"right\",\"depth_inversion\":\"off\","
          "\"chroma_depth\":\"off\",\"depthiness\":2.0,\"zoom\":1.0}");
    check("{\"uri\":\"/a.png\",\"isRGBD\":true}",
          "{\"file\":\"/a.png\",\"rgbd_in\":\"right\",\"depthiness\":1.5}");
    check(
        "{\"uri\":\"/a.png\",\"isRGBD\":\"1\",\"depth_inversion\":\"true\",\"chroma_depth\":true,"
        "\"depth_cutoff\":0.25,\"crop_pos_x\":\"-0.5\",\"crop_pos_y\":1,\"focus\":\"0.02\"}",
        "{\"file\":\"/a.png\",\"rgbd_in\":\"right\",\"depthiness\":1.5,\"depth_inversion\":\"on\","
        "\"chroma_depth\":\"on\",\"depth_cutoff\":0.25,\"crop_x\":-0.5,\"crop_y\":1.0,"
        "\"focus\":0.02}");
    for (int i = 0; i < 4; i++) {
        char body[128], expected[128];
        snprintf(body, sizeof body, "{\"uri\":\"/a\",\"isRGBD\":1,\"depth_loc\":%d}", i);
        snprintf(expected, sizeof expected,
                 "{\"file\":\"/a\",\"rgbd_in\":\"%s\",\"depthiness\":1.5}", sides[i]);
        check(body, expected);
    }
}

static void a_uri_is_a_path_of_this_machine(void **state)
{
    (void)state;
    static const char *const paths[][2] = {
        {"/a b%20.png", "/a b%20.png"}, /* a path is not coded */
        {"file:///a%20b.png", "/a b.png"},      {"file://localhost/a.png", "/a.png"},
        {"FILE:///%C3%A4.png", "/\\u00e4.png"}, {"file:///a%2f..%2Fb", "/a/../b"},
    };
    for (size_t i = 0; i < sizeof paths / sizeof paths[0]; i++) {
        char body[256], expected[256];
        snprintf(body, sizeof body, "{\"uri\":\"%s\"}", paths[i][0]);
        snprintf(expected, sizeof expected, "{\"file\":\"%s\"}", paths[i][1]);
        check(body, expected);
    }
    check_refused("{\"uri\":\"http://a.test/x.png\"}", "download the file");
    check_refused("{\"uri\":\"HTTPS://a.test/x.png\"}", "download the file");
    check_refused("{\"uri\":\"data:image/png;base64,AAAA\"}", "save the data into one");
    check_refused("{\"uri\":\"blob:http://a.test/1\"}", "save the data into one");
    check_refused("{\"uri\":\"a.png\"}", "absolute path");
    check_refused("{\"uri\":\"\"}", "absolute path");
    check_refused("{\"uri\":\"ftp://a.test/a.png\"}", "absolute path");
    check_refused("{\"uri\":\"file://evil.test/a.png\"}", "absolute path");
    check_refused("{\"uri\":\"file:///a%00.png\"}", "UTF-8");
    check_refused("{\"uri\":\"file:///a%4\"}", "UTF-8");
    check_refused("{\"uri\":\"file:///a%\"}", "UTF-8");
    check_refused("{\"uri\":\"file:///a%zz\"}", "UTF-8");
    check_refused("{\"uri\":\"file:///a%FF\"}", "UTF-8");
    check_refused("{}", "missing");
    check_refused("{\"uri\":7}", "missing");
}

static void wrong_numbers_are_refused(void **state)
{
    (void)state;
    check_refused("{\"uri\":\"/a\",\"rows\":6}", "cols");
    check_refused("{\"uri\":\"/a\",\"cols\":6}", "rows");
    check_refused("{\"uri\":\"/a\",\"cols\":6.5,\"rows\":8}", "whole numbers");
    check_refused("{\"uri\":\"/a\",\"cols\":0,\"rows\":8}", "whole numbers");
    check_refused("{\"uri\":\"/a\",\"cols\":1e6,\"rows\":1e6}", "whole numbers");
    check_refused("{\"uri\":\"/a\",\"view_count\":-1}", "whole number");
    check_refused("{\"uri\":\"/a\",\"cols\":8,\"rows\":6,\"view_count\":49}", "at most 48");
    check_refused("{\"uri\":\"/a\",\"focus\":\"much\"}", "focus");
    check_refused("{\"uri\":\"/a\",\"focus\":\"nan\"}", "focus");
    check_refused("{\"uri\":\"/a\",\"focus\":[1]}", "focus");
    check_refused("{\"uri\":\"/a\",\"zoom\":\"1e999\"}", "zoom");
    check_refused("{\"uri\":\"/a\",\"durationMS\":-1}", "durationMS");
    check_refused("{\"uri\":\"/a\",\"isRGBD\":1,\"depth_inversion\":5}", "depth_inversion");
    check_refused("{\"uri\":\"/a\",\"isRGBD\":1,\"depth_loc\":4}", "depth_loc");
    check_refused("{\"uri\":\"/a\",\"isRGBD\":1,\"depth_loc\":-1}", "depth_loc");
}

/* What was said before stays; what differs is a change. */
static void an_update_keeps_the_rest(void **state)
{
    (void)state;
    lf_error err = {0};
    json_t *nothing = json_object(), *said = NULL, *entry = NULL, *said_then = NULL, *then = NULL;
    json_t *body =
        json_loads("{\"uri\":\"/a.png\",\"rows\":6,\"cols\":8,\"aspect\":0.75}", 0, NULL);
    json_t *update = json_loads("{\"focus\":\"0.02\",\"rows\":\"4\",\"viewCount\":32}", 0, NULL);
    lf_assert_ok(lf_bridge_entry_make(nothing, body, &said, &entry, &err), &err);
    lf_assert_ok(lf_bridge_entry_make(said, update, &said_then, &then, &err), &err);
    json_t *changes = lf_bridge_entry_changes(then, entry);
    json_t *expected = json_pack("{s:f, s:s}", "focus", 0.02, "quilt", "8x4");
    assert_true(json_equal(changes, expected));
    assert_string_equal(json_string_value(json_object_get(then, "file")), "/a.png");
    assert_null(json_object_get(entry, "focus"));
    json_t *all[] = {nothing, said, entry, said_then, then, body, update, changes, expected};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        json_decref(all[i]);
}

/* ------------------------------------------------------------------------------------- lists -- */

static lf_bridge_lists *begin_lists(void)
{
    lf_error err = {0};
    lf_bridge_lists *lists = NULL;
    lf_assert_ok(lf_bridge_lists_create(&lists, &err), &err);
    return lists;
}

static const char *enter(lf_bridge_lists *lists, const char *kept)
{
    lf_error err = {0};
    lf_orchestration *o = NULL;
    lf_assert_ok(lf_bridge_lists_enter(lists, kept, &o, &err), &err);
    static char tokens[32][LF_BRIDGE_TOKEN + 1];
    static unsigned n;
    return strcpy(tokens[n++ % 32], lf_orchestration_token(o));
}

static void a_token_is_a_uuid(void **state)
{
    (void)state;
    lf_bridge_lists *lists = begin_lists();
    const char *a = enter(lists, NULL), *b = enter(lists, NULL);
    assert_int_equal(strlen(a), LF_BRIDGE_TOKEN);
    assert_string_not_equal(a, b);
    for (int i = 0; i < LF_BRIDGE_TOKEN; i++)
        assert_true(i == 8 || i == 13 || i == 18 || i == 23
                        ? a[i] == '-'
                        : strchr("0123456789abcdef", a[i]) != 0);
    assert_non_null(lf_bridge_lists_find(lists, a));
    lf_bridge_lists_exit(lists, lf_bridge_lists_find(lists, a));
    assert_null(lf_bridge_lists_find(lists, a));
    assert_null(lf_bridge_lists_find(lists, ""));
    assert_non_null(lf_bridge_lists_find(lists, b));
    lf_bridge_lists_destroy(lists);
}

/* A page that is closed says nothing. What is played stays, however long ago it was used. */
static void the_orchestration_not_used_longest_makes_room(void **state)
{
    (void)state;
    const char *tokens[LF_BRIDGE_ORCHESTRATIONS + 2];
    lf_bridge_lists *lists = begin_lists();
    for (int i = 0; i < LF_BRIDGE_ORCHESTRATIONS; i++)
        tokens[i] = enter(lists, NULL);
    assert_non_null(lf_bridge_lists_find(lists, tokens[1])); /* it is used again */
    (void)enter(lists, tokens[0]);
    assert_non_null(lf_bridge_lists_find(lists, tokens[1]));
    assert_null(lf_bridge_lists_find(lists, tokens[2]));
    assert_non_null(lf_bridge_lists_find(lists, tokens[0]));
    (void)enter(lists, NULL);
    assert_null(lf_bridge_lists_find(lists, tokens[3]));
    lf_bridge_lists_destroy(lists);
}

static lf_status make_list(lf_bridge_lists *lists, const char *token, const char *name,
                           const char *kept, lf_bridge_list **out)
{
    lf_error err = {0};
    return lf_orchestration_make(lists, lf_bridge_lists_find(lists, token), name, true, kept, out,
                                 &err);
}

static void playlists_are_bounded(void **state)
{
    (void)state;
    lf_bridge_lists *lists = begin_lists();
    lf_bridge_list *list = NULL;
    char name[300];
    const char *played = enter(lists, NULL), *old = enter(lists, NULL), *a = enter(lists, NULL);
    assert_int_equal(make_list(lists, played, "played", NULL, &list), LF_OK);
    assert_int_equal(make_list(lists, old, "old", NULL, &list), LF_OK);
    for (int i = 0; i < LF_BRIDGE_PLAYLISTS - 1; i++) {
        snprintf(name, sizeof name, "list %d", i);
        assert_int_equal(make_list(lists, a, name, played, &list), LF_OK);
    }
    assert_null(lf_bridge_lists_find(lists, old)); /* it made room */
    assert_non_null(lf_bridge_lists_find(lists, played));
    assert_int_equal(make_list(lists, a, "one more", played, &list), LF_E_BUSY);
    assert_int_equal(make_list(lists, a, "list 0", played, &list), LF_OK); /* the same again */
    lf_orchestration_drop(lf_bridge_lists_find(lists, a), list);
    assert_int_equal(make_list(lists, a, "one more", played, &list), LF_OK);
    memset(name, 'n', LF_BRIDGE_MAX_NAME + 1);
    name[LF_BRIDGE_MAX_NAME + 1] = '\0';
    assert_int_equal(make_list(lists, a, name, played, &list), LF_E_ARG);
    assert_int_equal(make_list(lists, a, "", played, &list), LF_E_ARG);
    lf_bridge_lists_destroy(lists);
}

static lf_status insert(lf_bridge_list *list, int index, const char *file, int *out)
{
    lf_error err = {0};
    return lf_bridge_list_insert(list, index, json_object(), json_pack("{s:s}", "file", file),
                                 json_string(file), out, &err);
}

static void entries_are_bounded_and_in_order(void **state)
{
    (void)state;
    lf_bridge_lists *lists = begin_lists();
    lf_bridge_list *list = NULL;
    lf_error err = {0};
    int at = -1;
    assert_int_equal(make_list(lists, enter(lists, NULL), "a", NULL, &list), LF_OK);
    assert_int_equal(insert(list, 7, "b", &at), LF_OK);
    assert_int_equal(at, 0);
    assert_int_equal(insert(list, 0, "a", &at), LF_OK);
    assert_int_equal(at, 0);
    assert_int_equal(insert(list, -1, "c", &at), LF_OK);
    assert_int_equal(at, 2);
    for (int i = 0; i < 3; i++) {
        const json_t *tag = json_array_get(list->tags, (size_t)i);
        const char expected[] = {(char)('a' + i), '\0'};
        assert_string_equal(json_string_value(tag), expected);
    }
    for (int i = 3; i < LF_BRIDGE_ENTRIES; i++)
        assert_int_equal(insert(list, -1, "x", &at), LF_OK);
    assert_int_equal(insert(list, -1, "x", &at), LF_E_BUSY);
    assert_int_equal(lf_bridge_list_length(list), LF_BRIDGE_ENTRIES);
    assert_int_equal(make_list(lists, enter(lists, NULL), "b", NULL, &list), LF_OK);
    char *name = malloc(LF_BRIDGE_LIST_BYTES);
    memset(name, 'n', LF_BRIDGE_LIST_BYTES - 1);
    name[LF_BRIDGE_LIST_BYTES / 4] = '\0';
    assert_int_equal(insert(list, -1, name, &at), LF_OK);
    assert_int_equal(insert(list, -1, name, &at), LF_E_BUSY);
    /* a change takes the place of what was there */
    lf_assert_ok(
        lf_bridge_list_change(list, 0, json_object(), json_pack("{s:s}", "file", name), &err),
        &err);
    lf_assert_status(lf_bridge_list_change(list, 0, json_pack("{s:s}", "file", name),
                                           json_pack("{s:s, s:s}", "file", name, "b", name), &err),
                     LF_E_BUSY, &err);
    free(name);
    lf_bridge_lists_destroy(lists);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_quilt_has_tiles_and_an_aspect),
        cmocka_unit_test(a_picture_with_depth_has_a_side),
        cmocka_unit_test(a_uri_is_a_path_of_this_machine),
        cmocka_unit_test(wrong_numbers_are_refused),
        cmocka_unit_test(an_update_keeps_the_rest),
        cmocka_unit_test(a_token_is_a_uuid),
        cmocka_unit_test(the_orchestration_not_used_longest_makes_room),
        cmocka_unit_test(playlists_are_bounded),
        cmocka_unit_test(entries_are_bounded_and_in_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
