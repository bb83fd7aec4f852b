/* What a reader hands over: sealed memory of sections, taken whole or not at all. */
#include "tests/testing.h"

#include "render/import/scene/mesh_take.h"
#include "tests/render/fake_reader.h"

static void a_parcel_holds_what_was_put_into_it(void **state)
{
    (void)state;
    lf_parcel parcel = {0};
    lf_error err;
    int fd = fake_parcel("");
    size_t n;
    lf_assert_ok(lf_parcel_open(fd, &parcel, &err), &err);
    close(fd);
    assert_memory_equal(lf_parcel_get(&parcel, LF_PARCEL_WARNINGS, &n), "one\ntwo\n", 8);
    assert_int_equal(n, 8);
    const uint32_t *triangles = lf_parcel_get(&parcel, LF_PARCEL_TRIANGLES, &n);
    assert_true(n == 3 && triangles[2] == 2);
    const lf_parcel_material *materials = lf_parcel_get(&parcel, LF_PARCEL_MATERIALS, &n);
    assert_true(n == 2 && materials[1].kind == 1);
    assert_null(lf_parcel_get(&parcel, LF_PARCEL_VALUES, &n));
    assert_int_equal(n, 0);
    lf_parcel_close(&parcel);
}

static lf_parcel_section *section_of(unsigned char *data, lf_parcel_tag tag)
{
    return &((lf_parcel_header *)(void *)data)->section[tag];
}

static void end_outside(unsigned char *data, size_t size, void *context)
{
    (void)size, (void)context;
    section_of(data, LF_PARCEL_TRIANGLES)->count = UINT64_C(1) << 40;
}

/* The product with the size of an element is a small number again. */
static void overflow(unsigned char *data, size_t size, void *context)
{
    (void)size, (void)context;
    section_of(data, LF_PARCEL_TRIANGLES)->count = (UINT64_C(1) << 62) + 1;
}

static void begin_outside(unsigned char *data, size_t size, void *context)
{
    (void)context;
    section_of(data, LF_PARCEL_TRIANGLES)->offset = (size + 63) / 64 * 64 + 64;
}

static void begin_in_the_header(unsigned char *data, size_t size, void *context)
{
    (void)size, (void)context;
    section_of(data, LF_PARCEL_TRIANGLES)->offset = 0;
}

static void begin_between(unsigned char *data, size_t size, void *context)
{
    (void)size, (void)context;
    section_of(data, LF_PARCEL_TRIANGLES)->offset += 1;
}

static void be_another_version(unsigned char *data, size_t size, void *context)
{
    (void)size, (void)context;
    data[0] ^= 1;
}

static void a_parcel_that_is_no_such_thing_is_refused(void **state)
{
    (void)state;
    enum { ALL = FAKE_SEALS, WHOLE = 1 << 30 };
    static const struct {
        void (*edit)(unsigned char *data, size_t size, void *context);
        int cut, seals;
        const char *what;
    } cases[] = {
        {NULL, WHOLE, ALL & ~F_SEAL_WRITE, "not sealed"},
        {NULL, WHOLE, ALL & ~F_SEAL_SHRINK, "not sealed"},
        {NULL, WHOLE, ALL & ~F_SEAL_SEAL, "not sealed"},
        {NULL, 20, ALL, "cut off"},
        {NULL, sizeof(lf_parcel_header) + 8, ALL, "out of range"},
        {end_outside, WHOLE, ALL, "out of range"},
        {overflow, WHOLE, ALL, "out of range"},
        {begin_outside, WHOLE, ALL, "out of range"},
        {begin_in_the_header, WHOLE, ALL, "out of range"},
        {begin_between, WHOLE, ALL, "out of range"},
        {be_another_version, WHOLE, ALL, "another version"},
        {NULL, WHOLE, ALL, NULL}, /* the negative control */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_parcel parcel = {0};
        lf_error err = {0};
        int fd =
            fake_copy(fake_parcel(""), cases[i].edit, NULL, (size_t)cases[i].cut, cases[i].seals);
        lf_status status = lf_parcel_open(fd, &parcel, &err);
        close(fd);
        if (status != (cases[i].what ? LF_E_FORMAT : LF_OK) ||
            (cases[i].what && !strstr(err.what, cases[i].what)))
            fail_msg("case %zu: %s \"%s\"", i, lf_status_name(status), err.what);
        lf_parcel_close(&parcel);
    }
    lf_parcel parcel = {0};
    int pipes[2];
    assert_int_equal(pipe(pipes), 0);
    assert_int_equal(lf_parcel_open(pipes[0], &parcel, NULL), LF_E_FORMAT);
    assert_int_equal(lf_parcel_open(-1, &parcel, NULL), LF_E_FORMAT);
    close(pipes[0]);
    close(pipes[1]);
}

/* Two triangles, a part each, in three places of these parts. */
static lf_status take_parts(const uint32_t part_of[3])
{
    static const double positions[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1};
    static const float normals[18] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    static const uint32_t triangles[6] = {0, 1, 2, 3, 4, 5}, parts[8] = {0, 1, 0, 3, 1, 1, 3, 3};
    static const double own[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    double places[36];
    lf_parcel_writer writer;
    lf_parcel parcel = {0};
    lf_mesh_data data = {0};
    int fd = -1;
    for (int i = 0; i < 36; i++)
        places[i] = own[i % 12];
    lf_assert_ok(lf_parcel_begin(&writer, NULL), NULL);
    lf_assert_ok(lf_parcel_put(&writer, LF_PARCEL_POSITIONS, positions, 18, NULL), NULL);
    lf_assert_ok(lf_parcel_put(&writer, LF_PARCEL_NORMALS, normals, 18, NULL), NULL);
    lf_assert_ok(lf_parcel_put(&writer, LF_PARCEL_TRIANGLES, triangles, 6, NULL), NULL);
    lf_assert_ok(lf_parcel_put(&writer, LF_PARCEL_INSTANCES, places, 36, NULL), NULL);
    lf_assert_ok(lf_parcel_put(&writer, LF_PARCEL_PARTS, parts, 8, NULL), NULL);
    lf_assert_ok(lf_parcel_put(&writer, LF_PARCEL_PART_OF, part_of, 3, NULL), NULL);
    lf_assert_ok(lf_parcel_seal(&writer, &fd, NULL), NULL);
    lf_assert_ok(lf_parcel_open(fd, &parcel, NULL), NULL);
    close(fd);
    lf_status status = lf_mesh_take(&parcel, (lf_mesh_asked){0}, &data, NULL);
    lf_mesh_data_finish(&data);
    lf_parcel_close(&parcel);
    return status;
}

/* A part is looked at once, however many places there are. */
static void places_of_a_part_follow_each_other(void **state)
{
    (void)state;
    assert_int_equal(take_parts((const uint32_t[3]){0, 0, 1}), LF_OK);
    assert_int_equal(take_parts((const uint32_t[3]){0, 1, 1}), LF_OK);
    assert_int_equal(take_parts((const uint32_t[3]){0, 1, 0}), LF_E_FORMAT);
    assert_int_equal(take_parts((const uint32_t[3]){0, 1, 2}), LF_E_FORMAT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_parcel_holds_what_was_put_into_it),
        cmocka_unit_test(a_parcel_that_is_no_such_thing_is_refused),
        cmocka_unit_test(places_of_a_part_follow_each_other),
    };
    return cmocka_run_group_tests_name("parcel", tests, NULL, NULL);
}
