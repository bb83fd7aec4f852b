/* The table of 3DS in docs/reference/formats/meshes.md: each row's chunk in a file that is made
 * here, and what the reader makes of it. */
#include "tests/render/mesh_warnings.h"

/* clang-format off */
#define CHUNK(name, verdict, what, words) \
    {name, verdict, chunk_row, &(const chunk_said){what, words}}
/* clang-format on */

/* --------------------------------------------------------------------------------------- 3DS -- */

/* A chunk is two bytes that say what it is, four that say how long it is, and what it holds. */
typedef struct chunks {
    unsigned char bytes[4096];
    size_t n, open[8];
    int depth;
} chunks;

static void put_bytes(chunks *c, const void *bytes, size_t n)
{
    assert_true(c->n + n <= sizeof c->bytes);
    memcpy(c->bytes + c->n, bytes, n);
    c->n += n;
}

static void put_whole(chunks *c, uint64_t value, int n)
{
    for (int i = 0; i < n; i++)
        put_bytes(c, &(unsigned char){(unsigned char)(value >> 8 * i)}, 1);
}

static void put_floats(chunks *c, const float *values, size_t n)
{
    put_bytes(c, values, n * sizeof *values);
}

static void put_text(chunks *c, const char *text)
{
    put_bytes(c, text, strlen(text) + 1);
}

static void begin_chunk(chunks *c, unsigned what)
{
    c->open[c->depth++] = c->n;
    put_whole(c, what, 2);
    put_whole(c, 0, 4);
}

static void end_chunk(chunks *c)
{
    const size_t at = c->open[--c->depth], n = c->n - at;
    for (int i = 0; i < 4; i++)
        c->bytes[at + 2 + (size_t)i] = (unsigned char)(n >> 8 * i);
}

static void put_colour(chunks *c, unsigned what, unsigned rgb)
{
    begin_chunk(c, what);
    begin_chunk(c, 0x0011);
    put_whole(c, rgb, 3);
    end_chunk(c);
    end_chunk(c);
}

static void put_percent(chunks *c, unsigned what, unsigned percent)
{
    begin_chunk(c, what);
    begin_chunk(c, 0x0030);
    put_whole(c, percent, 2);
    end_chunk(c);
    end_chunk(c);
}

static void put_map(chunks *c, unsigned what)
{
    begin_chunk(c, what);
    begin_chunk(c, 0xa300);
    put_text(c, "picture.png");
    end_chunk(c);
    end_chunk(c);
}

/* What the file says beside a square of a material. what: the chunk. */
static void put_material(chunks *c, unsigned what)
{
    begin_chunk(c, 0xafff);
    begin_chunk(c, 0xa000);
    put_text(c, what == 0xa000 ? "another name" : "m");
    end_chunk(c);
    put_colour(c, 0xa010, what == 0xa010 ? 0x203040 : 0x808080);
    put_colour(c, 0xa020, what == 0xa020 ? 0x2030ff : 0x4060c0);
    begin_chunk(c, 0xa100); /* shading: 3 is Phong's */
    put_whole(c, what == 0xa100 ? 2 : 3, 2);
    end_chunk(c);
    put_colour(c, 0xa030, what == 0xa030 ? 0 : 0xffffff);
    put_percent(c, 0xa040, what == 0xa040 ? 80 : 30);
    put_percent(c, 0xa041, what == 0xa041 ? 0 : 100);
    if (what == 0xa050 || what == 0xa084)
        put_percent(c, what, 50);
    if (what == 0xa081 || what == 0xa085) {
        begin_chunk(c, what);
        end_chunk(c);
    }
    if (what >= 0xa200 && what <= 0xa3ff)
        put_map(c, what);
    end_chunk(c);
}

static void put_mesh(chunks *c, unsigned what)
{
    static const float points[12] = {0, 0, 0, 2, 0, 0, 2, 3, 0, 0, 3, 1},
                       others[12] = {0, 0, 0, 2, 0, 0, 2, 3, 0, 0, 3, 2},
                       uvs[8] = {0, 0, 1, 0, 1, 1, 0, 1},
                       matrix[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    begin_chunk(c, 0x4000);
    put_text(c, what == 0x4000 ? "another" : "square");
    if (what == 0x4010) {
        begin_chunk(c, what);
        end_chunk(c);
    }
    begin_chunk(c, 0x4100);
    begin_chunk(c, 0x4110);
    put_whole(c, 4, 2);
    put_floats(c, what == 0x4110 ? others : points, 12);
    end_chunk(c);
    if (what == 0x4140 || (what >= 0xa200 && what <= 0xa3ff)) {
        begin_chunk(c, 0x4140);
        put_whole(c, 4, 2);
        put_floats(c, uvs, 8);
        end_chunk(c);
    }
    if (what == 0x4160) {
        begin_chunk(c, what);
        put_floats(c, matrix, 12);
        end_chunk(c);
    }
    begin_chunk(c, 0x4120);
    put_whole(c, what == 0x4120 ? 1 : 2, 2);
    for (unsigned i = 0; i < (what == 0x4120 ? 1u : 2u); i++) {
        put_whole(c, 0, 2);
        put_whole(c, i + 1, 2);
        put_whole(c, i + 2, 2);
        put_whole(c, 7, 2);
    }
    if (what != 0x4130) {
        begin_chunk(c, 0x4130);
        put_text(c, what == 0xa000 ? "another name" : "m");
        put_whole(c, what == 0x4120 ? 1 : 2, 2);
        for (unsigned i = 0; i < (what == 0x4120 ? 1u : 2u); i++)
            put_whole(c, i, 2);
        end_chunk(c);
    }
    if (what == 0x4150) {
        begin_chunk(c, what);
        put_whole(c, 1, 4);
        put_whole(c, 2, 4);
        end_chunk(c);
    }
    end_chunk(c);
    end_chunk(c);
    end_chunk(c);
}

static void put_other(chunks *c, unsigned what)
{
    static const float lamp[3] = {0, 0, 9}, eye[8] = {0, 0, 9, 0, 0, 0, 0, 50};
    begin_chunk(c, 0x4000);
    put_text(c, "other");
    begin_chunk(c, what);
    put_floats(c, what == 0x4600 ? lamp : eye, what == 0x4600 ? 3 : 8);
    end_chunk(c);
    end_chunk(c);
}

/* A track of places of the square: two keys. */
static void put_keys(chunks *c)
{
    static const float places[2][3] = {{0, 0, 0}, {5, 0, 0}};
    begin_chunk(c, 0xb000);
    begin_chunk(c, 0xb002);
    begin_chunk(c, 0xb010);
    put_text(c, "square");
    put_whole(c, 0, 4);
    put_whole(c, 0xffff, 2);
    end_chunk(c);
    begin_chunk(c, 0xb020);
    put_whole(c, 0, 2);
    put_whole(c, 0, 8);
    put_whole(c, 2, 4);
    for (unsigned i = 0; i < 2; i++) {
        put_whole(c, 10 * i, 4);
        put_whole(c, 0, 2);
        put_floats(c, places[i], 3);
    }
    end_chunk(c);
    end_chunk(c);
    end_chunk(c);
}

static result read_3ds(unsigned what)
{
    chunks c = {.n = 0};
    begin_chunk(&c, 0x4d4d);
    begin_chunk(&c, 0x0002);
    put_whole(&c, what == 0x0002 ? 2 : 3, 4);
    end_chunk(&c);
    begin_chunk(&c, 0x3d3d);
    if (what == 0x0100) {
        begin_chunk(&c, what);
        put_floats(&c, &(float){4}, 1);
        end_chunk(&c);
    }
    put_material(&c, what);
    put_mesh(&c, what);
    if (what == 0x4600 || what == 0x4700)
        put_other(&c, what);
    if (what == 0x2100)
        put_colour(&c, what, 0x202020);
    else if (what >= 0x1000 && what < 0x3000) {
        begin_chunk(&c, what);
        put_text(&c, "whatever");
        end_chunk(&c);
    }
    end_chunk(&c);
    if (what == 0xb000)
        put_keys(&c);
    end_chunk(&c);
    if (what == 0x4d4d)
        c.bytes[2]++;
    if (what == 0xffff)
        c.bytes[0]++;
    return read_bytes(c.bytes, what == 0xfffd ? 0 : what == 0xfffe ? c.n - 20 : c.n);
}

typedef struct chunk_said {
    unsigned what;
    const char *words;
} chunk_said;

static void chunk_row(const lf_format_row *row)
{
    const chunk_said *s = row->with;
    result with = read_3ds(s->what), without = read_3ds(0);
    assert_read(row, &without);
    if (strcmp(row->verdict, "refused") == 0) {
        if (with.status != LF_E_FORMAT || !strstr(with.err.what, s->words))
            fail_msg("%s: %s \"%s\"", row->name, lf_status_name(with.status), with.err.what);
    } else {
        assert_read(row, &with);
        if (strcmp(row->verdict, "warned") != 0)
            assert_quiet(row, &with);
        else if (!warns(&with, s->words))
            fail_msg("%s is not told; the first warning: %s", row->name,
                     lf_warnings_at(&with.data.warnings, 0) ? lf_warnings_at(&with.data.warnings, 0)
                                                            : "none");
        if (strcmp(row->verdict, "used") == 0 && with.print == without.print)
            fail_msg("%s changes nothing", row->name);
        if (strcmp(row->verdict, "ignored") == 0 && with.print != without.print)
            fail_msg("%s changes the mesh", row->name);
    }
    lf_mesh_data_finish(&with.data);
    lf_mesh_data_finish(&without.data);
}

#define NO_TEXTURES "textures are not read, the colours beside them alone count"

static const lf_format_row tds_rows[] = {
    CHUNK("0002 version", "ignored", 0x0002, NULL),
    CHUNK("0100 master scale", "used", 0x0100, NULL),
    CHUNK("1101 background picture", "warned", 0x1101, "chunks that are left out: 1101"),
    CHUNK("1201 background", "warned", 0x1201, "chunks that are left out: 1201"),
    CHUNK("1301 background", "warned", 0x1301, "chunks that are left out: 1301"),
    CHUNK("2100 ambient light", "warned", 0x2100, "chunks that are left out: 2100"),
    CHUNK("2201 fog", "warned", 0x2201, "chunks that are left out: 2201"),
    CHUNK("2301 fog of layers", "warned", 0x2301, "chunks that are left out: 2301"),
    CHUNK("4000 object", "ignored", 0x4000, NULL),
    CHUNK("4010 hidden object", "warned", 0x4010, "chunks that are left out: 4010"),
    CHUNK("4110 vertices", "used", 0x4110, NULL),
    CHUNK("4120 faces", "used", 0x4120, NULL),
    CHUNK("4130 material of faces", "used", 0x4130, NULL),
    CHUNK("4140 texture coordinates", "ignored", 0x4140, NULL),
    CHUNK("4150 smoothing groups", "used", 0x4150, NULL),
    CHUNK("4160 local axes", "ignored", 0x4160, NULL),
    CHUNK("4600 light", "warned", 0x4600, "light is not used"),
    CHUNK("4700 camera", "warned", 0x4700, "camera is not used"),
    CHUNK("a000 name of a material", "ignored", 0xa000, NULL),
    CHUNK("a010 ambient", "ignored", 0xa010, NULL),
    CHUNK("a020 diffuse", "used", 0xa020, NULL),
    CHUNK("a030 specular", "used", 0xa030, NULL),
    CHUNK("a040 shininess", "used", 0xa040, NULL),
    CHUNK("a041 strength of the highlight", "used", 0xa041, NULL),
    CHUNK("a050 transparency", "warned", 0xa050, "transparency is left out: opaque"),
    CHUNK("a081 two sides", "ignored", 0xa081, NULL),
    CHUNK("a084 self-illumination", "used", 0xa084, NULL),
    CHUNK("a085 wire frame", "warned", 0xa085, "chunks that are left out: a085 wire frame"),
    CHUNK("a100 shading", "used", 0xa100, NULL),
    CHUNK("a200 texture", "warned", 0xa200, NO_TEXTURES),
    CHUNK("a204 specular map", "warned", 0xa204, NO_TEXTURES),
    CHUNK("a210 opacity map", "warned", 0xa210, NO_TEXTURES),
    CHUNK("a220 reflection map", "warned", 0xa220, NO_TEXTURES),
    CHUNK("a230 bump map", "warned", 0xa230, NO_TEXTURES),
    CHUNK("a33a second texture", "warned", 0xa33a, "chunks that are left out: a33a"),
    CHUNK("a33c shininess map", "warned", 0xa33c, NO_TEXTURES),
    CHUNK("a33d self-illumination map", "warned", 0xa33d, NO_TEXTURES),
    CHUNK("b000 key frames", "warned", 0xb000, "animation is not used"),
    CHUNK("any other chunk", "ignored", 0x1234, NULL),
    CHUNK("a chunk that is too long", "refused", 0x4d4d,
          "the 3DS chunk 4d4d at byte 0 says that it has"),
    CHUNK("a file that is cut off", "refused", 0xfffe, "the file is cut off or damaged"),
    CHUNK("an empty file", "refused", 0xfffd, "0 bytes, less than a 3DS file has"),
    CHUNK("another first chunk", "refused", 0xffff, "not 3DS, which begins with the chunk 4d4d"),
};

static void every_chunk_of_3ds_is_what_the_table_says(void **state)
{
    (void)state;
    WALK("3DS", "said.3ds", "said.3ds", NULL, tds_rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_chunk_of_3ds_is_what_the_table_says),
    };
    return cmocka_run_group_tests(tests, begin_said, finish_said);
}
