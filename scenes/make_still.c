/* make_still FILE.glb: writes what the scene still-life.json is made of: a tiled floor, a plant
 * whose leaves are cut out of cards by alpha, and a veil that is there in part; with their pictures
 * in the file.
 * make_still FILE.png checker: writes the picture of bench/checker.json and bench/turning.json. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
#define SIDE 128 /* of the pictures */
#define MOST_VERTICES 2048
#define LEAVES 26
#define SEGMENTS 6 /* along a leaf */

/* ------------------------------------------------------------------------------------- bytes -- */

typedef struct bytes {
    uint8_t *data;
    size_t size, room;
} bytes;

static void put(bytes *b, const void *data, size_t size)
{
    if (b->size + size > b->room) {
        b->room = 2 * (b->size + size);
        b->data = realloc(b->data, b->room);
        if (!b->data)
            exit(1);
    }
    memcpy(b->data + b->size, data, size);
    b->size += size;
}

static void put_little(bytes *b, uint32_t value, int n)
{
    for (int i = 0; i < n; i++)
        put(b, &(uint8_t){(uint8_t)(value >> 8 * i)}, 1);
}

static void put_big(bytes *b, uint32_t value)
{
    for (int i = 3; i >= 0; i--)
        put(b, &(uint8_t){(uint8_t)(value >> 8 * i)}, 1);
}

static void pad(bytes *b, char with)
{
    while (b->size % 4)
        put(b, &with, 1);
}

/* --------------------------------------------------------------------------------------- PNG -- */

/* 0 .. 1; colour and alpha at a place of the picture, u to the right and v downwards. */
typedef void (*paint_fn)(double u, double v, double rgba[4]);

static void put_chunk(bytes *b, const char *name, const bytes *content)
{
    uint32_t crc = 0xffffffffu;
    put_big(b, (uint32_t)content->size);
    size_t first = b->size;
    put(b, name, 4);
    if (content->size)
        put(b, content->data, content->size);
    for (size_t i = first; i < b->size; i++) {
        crc ^= b->data[i];
        for (int k = 0; k < 8; k++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    put_big(b, ~crc);
}

/* zlib's wrapping of bytes as they are. */
static bytes store(const bytes *from)
{
    bytes out = {0};
    uint32_t a = 1, c = 0;
    put(&out, "\x78\x01", 2);
    for (size_t at = 0; at < from->size; at += 65535) {
        size_t n = from->size - at < 65535 ? from->size - at : 65535;
        put_little(&out, at + n == from->size, 1);
        put_little(&out, (uint32_t)n, 2);
        put_little(&out, ~(uint32_t)n, 2);
        put(&out, from->data + at, n);
    }
    for (size_t i = 0; i < from->size; i++) {
        a = (a + from->data[i]) % 65521;
        c = (c + a) % 65521;
    }
    put_big(&out, c << 16 | a);
    return out;
}

static void put_png(bytes *b, paint_fn paint)
{
    bytes rows = {0}, head = {0}, none = {0};
    for (int y = 0; y < SIDE; y++) {
        put_little(&rows, 0, 1);
        for (int x = 0; x < SIDE; x++) {
            double c[4];
            paint((x + 0.5) / SIDE, (y + 0.5) / SIDE, c);
            for (int i = 0; i < 4; i++)
                put_little(&rows, (uint32_t)(255 * fmin(fmax(c[i], 0), 1) + 0.5), 1);
        }
    }
    put_big(&head, SIDE);
    put_big(&head, SIDE);
    put(&head, "\x08\x06\0\0\0", 5); /* 8 bits, RGBA */
    bytes stored = store(&rows);
    put(b, "\x89PNG\r\n\x1a\n", 8);
    put_chunk(b, "IHDR", &head);
    put_chunk(b, "IDAT", &stored);
    put_chunk(b, "IEND", &none);
    free(rows.data);
    free(head.data);
    free(stored.data);
}

/* ---------------------------------------------------------------------------------- pictures -- */

/* Two by two tiles with joints; every other one has a star. */
static void tiles(double u, double v, double rgba[4])
{
    static const double clay[3] = {0.72, 0.42, 0.28}, blue[3] = {0.2, 0.33, 0.5},
                        cream[3] = {0.86, 0.8, 0.68}, joint[3] = {0.32, 0.3, 0.28};
    double x = fmod(2 * u, 1) - 0.5, y = fmod(2 * v, 1) - 0.5, r = hypot(x, y),
           star = 0.26 + 0.1 * cos(8 * atan2(y, x));
    int odd = ((int)(2 * u) + (int)(2 * v)) & 1;
    const double *c = odd ? clay : r < star ? blue : cream;
    if (fmax(fabs(x), fabs(y)) > 0.47)
        c = joint;
    for (int i = 0; i < 3; i++)
        rgba[i] = c[i];
    rgba[3] = 1;
}

/* A leaf from left to right, with teeth and veins. */
static void leaf(double u, double v, double rgba[4])
{
    double across = fabs(2 * v - 1), width = 0.9 * pow(sin(PI * pow(u, 0.8)), 0.8);
    double teeth = 0.93 + 0.07 * fabs(sin(24 * PI * u)), from_rib = u - 0.25 * across;
    double vein = fmax(exp(-pow(across / 0.05, 2)), 0.6 * pow(fabs(cos(9 * PI * from_rib)), 24));
    rgba[0] = 0.16 + 0.3 * vein;
    rgba[1] = 0.42 + 0.25 * vein;
    rgba[2] = 0.1 + 0.12 * vein;
    rgba[3] = u > 0.01 && u < 0.99 && across < width * teeth ? 1 : 0;
}

/* Folds of a thin cloth. */
static void veil(double u, double v, double rgba[4])
{
    double fold = 0.5 + 0.5 * sin(14 * PI * u + 1.5 * sin(3 * PI * v));
    rgba[0] = 0.9;
    rgba[1] = 0.75 - 0.1 * fold;
    rgba[2] = 0.6 - 0.1 * fold;
    rgba[3] = 0.15 + 0.5 * fold * fold;
}

/* Seven checkers, each with cells half as large as the one before (64 pixels to 1), in colours of
 * their own. */
static void checker(double u, double v, double rgba[4])
{
    for (int i = 0; i < 3; i++)
        rgba[i] = 0.5;
    for (int octave = 0; octave < 7; octave++) {
        int cells = 2 << octave, odd = ((int)(u * cells) + (int)(v * cells)) & 1;
        for (int i = 0; i < 3; i++)
            rgba[i] += (odd ? 1 : -1) * (0.04 + 0.07 * cos(2.1 * octave + 2 * PI / 3 * i));
    }
    rgba[3] = 1;
}

/* ------------------------------------------------------------------------------------ meshes -- */

typedef struct mesh {
    float p[MOST_VERTICES][3], n[MOST_VERTICES][3], uv[MOST_VERTICES][2];
    uint16_t index[3 * MOST_VERTICES];
    int n_vertices, n_indices;
} mesh;

/* The middle line and the direction across of a strip at t, 0 to 1. */
typedef struct section {
    double p[3], across[3], n[3];
} section;

/* Appends what is between two sections; u goes from one to the other, v across. */
static void add_section(mesh *m, const section *s, double u, double copies, int joins)
{
    for (int side = 0; side < 2; side++) {
        int at = m->n_vertices + side;
        for (int i = 0; i < 3; i++) {
            m->p[at][i] = (float)(s->p[i] + (side ? 1 : -1) * s->across[i]);
            m->n[at][i] = (float)s->n[i];
        }
        m->uv[at][0] = (float)(copies * u);
        m->uv[at][1] = (float)(copies * side);
    }
    if (joins) {
        static const int corner[6] = {-2, -1, 1, -2, 1, 0};
        for (int i = 0; i < 6; i++)
            m->index[m->n_indices++] = (uint16_t)(m->n_vertices + corner[i]);
    }
    m->n_vertices += 2;
}

static void make_floor(mesh *m)
{
    for (int i = 0; i < 2; i++) {
        const section s = {{1.2 * (2 * i - 1), 0, 0}, {0, 0, -1.2}, {0, 1, 0}};
        add_section(m, &s, i, 4, i);
    }
}

/* A leaf that leaves the stem at a height in a direction and bends down. */
static void make_leaf(mesh *m, double height, double direction, double length, double rise)
{
    const double out[2] = {cos(direction), -sin(direction)};
    double x = 0.02, y = height;
    for (int i = 0; i <= SEGMENTS; i++) {
        double angle = rise - 1.3 * i / SEGMENTS, half = 0.22 * length;
        const section s = {{x * out[0], y, x * out[1]},
                           {half * out[1], 0, -half * out[0]},
                           {-sin(angle) * out[0], cos(angle), -sin(angle) * out[1]}};
        add_section(m, &s, (double)i / SEGMENTS, 1, i);
        x += cos(angle) * length / SEGMENTS;
        y += sin(angle) * length / SEGMENTS;
    }
}

static void make_plant(mesh *m)
{
    for (int i = 0; i < LEAVES; i++) {
        double up = (double)i / (LEAVES - 1);
        make_leaf(m, 0.3 + 0.95 * up, 2.39996 * i, 0.8 - 0.4 * up, 0.5 + 0.7 * up);
    }
}

static void make_veil(mesh *m)
{
    const int n = 24;
    for (int i = 0; i <= n; i++) {
        double t = (double)i / n, bend = 14 * PI * t;
        const section s = {
            {2 * t - 1, 1.1, -0.8 + 0.03 * sin(bend)}, {0, -1.1, 0}, {-0.5 * cos(bend), 0, 1}};
        double length = hypot(s.n[0], s.n[2]);
        const section unit = {
            {s.p[0], s.p[1], s.p[2]}, {0, -1.1, 0}, {s.n[0] / length, 0, s.n[2] / length}};
        add_section(m, &unit, t, 1, i);
    }
}

/* -------------------------------------------------------------------------------------- glTF -- */

static const struct {
    const char *name, *material; /* what glTF says of it besides its picture */
    void (*make)(mesh *m);
    paint_fn paint;
    double roughness;
} parts[] = {
    {"floor", "\"doubleSided\":true", make_floor, tiles, 0.5},
    {"plant", "\"doubleSided\":true,\"alphaMode\":\"MASK\"", make_plant, leaf, 0.6},
    {"veil", "\"doubleSided\":true,\"alphaMode\":\"BLEND\"", make_veil, veil, 0.9},
};
enum { N_PARTS = 3, BLOCKS = 5 }; /* of bytes, a part: p, n, uv, indices, picture */

typedef struct text {
    char at[16384];
    size_t size;
} text;

#define SAY(t, ...)                                                                                \
    (t)->size += (size_t)snprintf((t)->at + (t)->size, sizeof(t)->at - (t)->size, __VA_ARGS__)

/* Appends the bytes of a part; the views and accessors of them to their texts. */
static void add_part(int part, bytes *b, text *views, text *accessors)
{
    static mesh m;
    m.n_vertices = m.n_indices = 0;
    parts[part].make(&m);
    const size_t n = (size_t)m.n_vertices;
    const void *data[] = {m.p, m.n, m.uv, m.index};
    const size_t size[] = {n * 12, n * 12, n * 8, 2 * (size_t)m.n_indices};
    static const char *const types[] = {"VEC3", "VEC3", "VEC2", "SCALAR"};
    double low[3] = {1e9, 1e9, 1e9}, high[3] = {-1e9, -1e9, -1e9};
    for (int i = 0; i < 3 * m.n_vertices; i++) {
        low[i % 3] = fmin(low[i % 3], (double)m.p[i / 3][i % 3]);
        high[i % 3] = fmax(high[i % 3], (double)m.p[i / 3][i % 3]);
    }
    for (int i = 0; i < BLOCKS; i++) {
        size_t first = b->size;
        if (i < 4)
            put(b, data[i], size[i]);
        else
            put_png(b, parts[part].paint);
        SAY(views, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", views->size ? "," : "",
            first, b->size - first);
        if (i < 4)
            SAY(accessors, "%s{\"bufferView\":%d,\"componentType\":%d,\"count\":%d,\"type\":\"%s\"",
                accessors->size ? "," : "", BLOCKS * part + i, i < 3 ? 5126 : 5123,
                i < 3 ? m.n_vertices : m.n_indices, types[i]);
        if (i == 0)
            SAY(accessors, ",\"min\":[%.9g,%.9g,%.9g],\"max\":[%.9g,%.9g,%.9g]", low[0], low[1],
                low[2], high[0], high[1], high[2]);
        if (i < 4)
            SAY(accessors, "}");
        pad(b, '\0');
    }
}

/* A member of the document that has one element a part. */
static void say_parts(text *t, const char *name, void (*say)(text *t, int part))
{
    SAY(t, ",\"%s\":[", name);
    for (int i = 0; i < N_PARTS; i++) {
        SAY(t, "%s", i ? "," : "");
        say(t, i);
    }
    SAY(t, "]");
}

static void say_node(text *t, int i)
{
    SAY(t, "{\"name\":\"%s\",\"mesh\":%d}", parts[i].name, i);
}

static void say_mesh(text *t, int i)
{
    SAY(t,
        "{\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d,\"TEXCOORD_0\":%d},"
        "\"indices\":%d,\"material\":%d}]}",
        4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3, i);
}

static void say_material(text *t, int i)
{
    SAY(t,
        "{\"name\":\"%s\",%s,\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":%d},"
        "\"metallicFactor\":0,\"roughnessFactor\":%g}}",
        parts[i].name, parts[i].material, i, parts[i].roughness);
}

static void say_texture(text *t, int i)
{
    SAY(t, "{\"source\":%d}", i);
}

static void say_image(text *t, int i)
{
    SAY(t, "{\"mimeType\":\"image/png\",\"bufferView\":%d}", BLOCKS * i + BLOCKS - 1);
}

static bytes make_glb(void)
{
    static text json, views, accessors;
    bytes binary = {0}, document = {0}, out = {0};
    for (int i = 0; i < N_PARTS; i++)
        add_part(i, &binary, &views, &accessors);
    SAY(&json, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"make_still\"},\"scene\":0,"
               "\"scenes\":[{\"nodes\":[0,1,2]}]");
    say_parts(&json, "nodes", say_node);
    say_parts(&json, "meshes", say_mesh);
    say_parts(&json, "materials", say_material);
    say_parts(&json, "textures", say_texture);
    say_parts(&json, "images", say_image);
    SAY(&json, ",\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[%s],\"accessors\":[%s]}",
        binary.size, views.at, accessors.at);
    put(&document, json.at, json.size);
    pad(&document, ' ');
    put(&out, "glTF", 4);
    put_little(&out, 2, 4);
    put_little(&out, (uint32_t)(12 + 8 + document.size + 8 + binary.size), 4);
    put_little(&out, (uint32_t)document.size, 4);
    put(&out, "JSON", 4);
    put(&out, document.data, document.size);
    put_little(&out, (uint32_t)binary.size, 4);
    put(&out, "BIN\0", 4);
    put(&out, binary.data, binary.size);
    free(binary.data);
    free(document.data);
    return out;
}

int main(int argc, char **argv)
{
    int is_checker = argc == 3 && strcmp(argv[2], "checker") == 0;
    FILE *file = argc == 2 || is_checker ? fopen(argv[1], "wb") : NULL;
    if (!file) {
        fprintf(stderr,
                argc == 2 || is_checker ? "make_still: cannot write %s\n"
                                        : "usage: make_still FILE.glb | FILE.png checker\n",
                argv[1]);
        return 2;
    }
    bytes out = {0};
    if (is_checker)
        put_png(&out, checker);
    else
        out = make_glb();
    size_t written = fwrite(out.data, 1, out.size, file);
    int failed = fclose(file) != 0 || written != out.size;
    free(out.data);
    return failed;
}
