#include "tests/base/spoiled.h"

#include <lcms2.h>

#include "tests/base/pictures.h"

enum { SIDE = 6 };

/* ---------------------------------------------------------------------------- files to spoil -- */

static void add(lf_bytes *to, const void *data, size_t n)
{
    to->data = realloc(to->data, to->n + n + 1);
    assert_non_null(to->data);
    memcpy(to->data + to->n, data, n);
    to->n += n;
    to->data[to->n] = '\0';
}

static void LF_PRINTF(2, 3) say(lf_bytes *to, const char *format, ...)
{
    char line[512];
    va_list arguments;
    va_start(arguments, format);
    int n = vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    assert_in_range(n, 0, sizeof line - 1);
    add(to, line, (size_t)n);
}

static float height(int i, int j)
{
    return 0.1f * (float)((i * 5 + j * 3) % 7);
}

/* The corners of the c-th triangle of a hilly lattice of SIDE x SIDE points. */
static void triangle_of(int c, int out[3])
{
    int cell = c / 2, at = cell / (SIDE - 1) * SIDE + cell % (SIDE - 1);
    int corners[2][3] = {{at, at + 1, at + SIDE}, {at + 1, at + SIDE + 1, at + SIDE}};
    memcpy(out, corners[c % 2], sizeof corners[0]);
}

enum { POINTS = SIDE * SIDE, TRIANGLES = 2 * (SIDE - 1) * (SIDE - 1) };

static void point_of(int v, float out[3])
{
    out[0] = (float)(v % SIDE);
    out[1] = (float)(v / SIDE);
    out[2] = height(v % SIDE, v / SIDE);
}

static lf_bytes make_obj(void)
{
    lf_bytes out = {0};
    int t[3];
    float p[3];
    say(&out, "mtllib a.mtl\no hills\nusemtl red\n");
    for (int v = 0; v < POINTS; v++) {
        point_of(v, p);
        say(&out, "v %g %g %g\nvn 0 0 1\nvt %g %g\n", (double)p[0], (double)p[1], (double)p[2],
            (double)p[0], (double)p[1]);
    }
    for (int c = 0; c < TRIANGLES; c++) {
        triangle_of(c, t);
        say(&out, "f %d/%d/%d %d/%d/%d %d/%d/%d\n", t[0] + 1, t[0] + 1, t[0] + 1, t[1] + 1,
            t[1] + 1, t[1] + 1, t[2] + 1, t[2] + 1, t[2] + 1);
    }
    return out;
}

static lf_bytes make_mtl(void)
{
    lf_bytes out = {0};
    say(&out, "newmtl red\nKd 0.8 0.1 0.1\nKs 0.5 0.5 0.5\nNs 40\nNi 1.5\nKe 0 0 0\nillum 2\n"
              "map_Kd red.png\nnewmtl glow\nKe 4 4 4\nd 0.5\nTf 1 1 1\nbump -bm 2 b.png\n");
    return out;
}

static lf_bytes make_ply(bool binary)
{
    lf_bytes out = {0};
    int t[3];
    float p[3];
    say(&out,
        "ply\nformat %s 1.0\ncomment hills\nelement vertex %d\nproperty float x\nproperty float y\n"
        "property float z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n",
        binary ? "binary_little_endian" : "ascii", POINTS, TRIANGLES);
    for (int v = 0; v < POINTS; v++) {
        point_of(v, p);
        if (binary)
            add(&out, p, sizeof p);
        else
            say(&out, "%g %g %g\n", (double)p[0], (double)p[1], (double)p[2]);
    }
    for (int c = 0; c < TRIANGLES; c++) {
        triangle_of(c, t);
        if (binary) {
            add(&out, "\3", 1);
            add(&out, t, sizeof t);
        } else {
            say(&out, "3 %d %d %d\n", t[0], t[1], t[2]);
        }
    }
    return out;
}

static lf_bytes make_ascii_ply(void)
{
    return make_ply(false);
}

static lf_bytes make_binary_ply(void)
{
    return make_ply(true);
}

static lf_bytes make_stl(bool binary)
{
    lf_bytes out = {0};
    char title[80] = "hills";
    uint32_t n = TRIANGLES;
    if (binary) {
        add(&out, title, sizeof title);
        add(&out, &n, sizeof n);
    } else {
        say(&out, "solid hills\n");
    }
    for (int c = 0; c < TRIANGLES; c++) {
        static const float normal[3] = {0, 0, 1};
        int t[3];
        float p[3];
        triangle_of(c, t);
        if (binary)
            add(&out, normal, sizeof normal);
        else
            say(&out, "facet normal 0 0 1\nouter loop\n");
        for (int i = 0; i < 3; i++) {
            point_of(t[i], p);
            if (binary)
                add(&out, p, sizeof p);
            else
                say(&out, "vertex %g %g %g\n", (double)p[0], (double)p[1], (double)p[2]);
        }
        if (binary)
            add(&out, "\0\0", 2);
        else
            say(&out, "endloop\nendfacet\n");
    }
    if (!binary)
        say(&out, "endsolid hills\n");
    return out;
}

static lf_bytes make_ascii_stl(void)
{
    return make_stl(false);
}

static lf_bytes make_binary_stl(void)
{
    return make_stl(true);
}

/* A triangle: 36 bytes of positions, 6 of indices, 2 to fill. */
static void say_gltf(lf_bytes *out, const char *uri)
{
    say(out, "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
             "\"nodes\":[{\"mesh\":0,\"translation\":[1,2,3]}],\"meshes\":[{\"primitives\":[{"
             "\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}],");
    say(out,
        "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0,0,1],"
        "\"metallicFactor\":0,\"roughnessFactor\":0.5}}],\"buffers\":[{%s\"byteLength\":44}],",
        uri);
    say(out, "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,"
             "\"byteLength\":6}],");
    say(out,
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
        "\"min\":[0,0,0],\"max\":[1,1,0]},{\"bufferView\":1,\"componentType\":5123,"
        "\"count\":3,\"type\":\"SCALAR\"}]}");
}

static lf_bytes make_gltf(void)
{
    lf_bytes out = {0};
    say_gltf(&out, "\"uri\":\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAA"
                   "AAAAAAAAgD8AAAAAAAABAAIAAAA=\",");
    return out;
}

static lf_bytes make_glb(void)
{
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint16_t indices[4] = {0, 1, 2, 0};
    lf_bytes json = {0}, out = {0};
    say_gltf(&json, "");
    while (json.n % 4 != 0)
        say(&json, " ");
    uint32_t binary = 44,
             header[5] = {0x46546c67, 2, (uint32_t)(12 + 8 + json.n + 8 + binary), (uint32_t)json.n,
                          0x4e4f534a},
             chunk[2] = {binary, 0x004e4942};
    add(&out, header, sizeof header);
    add(&out, json.data, json.n);
    add(&out, chunk, sizeof chunk);
    add(&out, positions, sizeof positions);
    add(&out, indices, sizeof indices);
    free(json.data);
    return out;
}

/* 3DS: chunks of an identifier and a length that counts all within. */
static void say_chunk(lf_bytes *out, uint16_t id, const void *data, size_t n)
{
    uint32_t size = (uint32_t)(6 + n);
    add(out, &id, sizeof id);
    add(out, &size, sizeof size);
    add(out, data, n);
}

static lf_bytes chunk_of(uint16_t id, const char *name, lf_bytes inner)
{
    lf_bytes out = {0}, named = {0};
    if (name)
        add(&named, name, strlen(name) + 1);
    add(&named, inner.data, inner.n);
    say_chunk(&out, id, named.data, named.n);
    free(named.data);
    free(inner.data);
    return out;
}

static lf_bytes make_3ds(void)
{
    lf_bytes points = {0}, faces = {0}, mesh = {0};
    uint16_t n = POINTS;
    float p[3];
    int t[3];
    add(&points, &n, sizeof n);
    for (int v = 0; v < POINTS; v++) {
        point_of(v, p);
        add(&points, p, sizeof p);
    }
    n = TRIANGLES;
    add(&faces, &n, sizeof n);
    for (int c = 0; c < TRIANGLES; c++) {
        triangle_of(c, t);
        add(&faces, (uint16_t[4]){(uint16_t)t[0], (uint16_t)t[1], (uint16_t)t[2], 7}, 8);
    }
    say_chunk(&mesh, 0x4110, points.data, points.n);
    say_chunk(&mesh, 0x4120, faces.data, faces.n);
    free(points.data);
    free(faces.data);
    return chunk_of(
        0x4d4d, NULL,
        chunk_of(0x3d3d, NULL, chunk_of(0x4000, "hills", chunk_of(0x4100, NULL, mesh))));
}

/* ---------------------------------------------------------------------------------- pictures -- */

/* What write makes of a name in a folder of its own. */
static lf_bytes made(void (*write)(const char *path))
{
    char *folder = lf_test_folder();
    const char *path = lf_test_path(folder, "picture");
    write(path);
    lf_bytes out = lf_bytes_read(path);
    lf_test_folder_remove(folder);
    return out;
}

static void write_png(const char *path)
{
    lf_image8 image = lf_picture_noise(12, 9);
    lf_picture_save_png(path, &image, 6, NULL, 0);
    lf_image8_finish(&image);
}

static void write_jpeg(const char *path)
{
    lf_picture_jpeg(path, 16, 12, 3, JCS_RGB);
}

static void write_exr(const char *path)
{
    lf_picture_half_exr(path, (int[4]){0, 0, 15, 11}, (int[4]){0, 0, 15, 11}, IMF_PIZ_COMPRESSION,
                        IMF_WRITE_RGB, true);
}

static lf_bytes make_png(void)
{
    return made(write_png);
}

static lf_bytes make_jpeg(void)
{
    return made(write_jpeg);
}

static lf_bytes make_exr(void)
{
    return made(write_exr);
}

/* Rows of 16 pixels by run lengths: each channel a run of 9 and 7 bytes as they are. */
static lf_bytes make_hdr(void)
{
    lf_bytes out = {0};
    say(&out, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 6 +X 16\n");
    for (int y = 0; y < 6; y++) {
        add(&out, "\2\2\0\20", 4);
        for (int c = 0; c < 4; c++)
            add(&out,
                (unsigned char[10]){128 + 9, (unsigned char)(120 + y), 7, 1, 2, 3, 4, 5, 6, 130},
                10);
    }
    return out;
}

/* ------------------------------------------------------------------------------------ others -- */

static lf_bytes make_icc(void)
{
    lf_bytes out = {0};
    cmsUInt32Number n = 0;
    cmsHPROFILE profile = cmsCreate_sRGBProfile();
    assert_true(profile && cmsSaveProfileToMem(profile, NULL, &n));
    unsigned char *data = malloc(n);
    assert_true(data && cmsSaveProfileToMem(profile, data, &n));
    add(&out, data, n);
    free(data);
    cmsCloseProfile(profile);
    return out;
}

static lf_bytes make_calibration(void)
{
    lf_bytes out = {0};
    say(&out, "{\"configVersion\":\"1.0\",\"serial\":\"LKG-TEST\",\"pitch\":{\"value\":52.5},"
              "\"slope\":{\"value\":-7.2},\"center\":{\"value\":0.3},"
              "\"viewCone\":{\"value\":40},\"invView\":{\"value\":1},\"DPI\":{\"value\":324},");
    say(&out,
        "\"screenW\":{\"value\":96},\"screenH\":{\"value\":128},"
        "\"flipImageX\":{\"value\":0},\"flipImageY\":{\"value\":0},\"flipSubp\":{\"value\":0}}");
    return out;
}

static lf_bytes make_vdb(void)
{
    return lf_bytes_read(lf_test_built("testdata/names.vdb"));
}

const lf_spoiled_kind lf_spoiled_kinds[] = {
    {"a.obj", "a.obj", LF_SPOILED_MESH, make_obj},
    {"b.obj", "a.mtl", LF_SPOILED_MESH, make_mtl},
    {"a.ply", "a.ply", LF_SPOILED_MESH, make_ascii_ply},
    {"b.ply", "b.ply", LF_SPOILED_MESH, make_binary_ply},
    {"a.stl", "a.stl", LF_SPOILED_MESH, make_ascii_stl},
    {"b.stl", "b.stl", LF_SPOILED_MESH, make_binary_stl},
    {"a.gltf", "a.gltf", LF_SPOILED_MESH, make_gltf},
    {"a.glb", "a.glb", LF_SPOILED_MESH, make_glb},
    {"a.3ds", "a.3ds", LF_SPOILED_MESH, make_3ds},
    {"a.vdb", "a.vdb", LF_SPOILED_GRID, make_vdb},
    {"a.exr", "a.exr", LF_SPOILED_SKY, make_exr},
    {"a.hdr", "a.hdr", LF_SPOILED_SKY, make_hdr},
    {"a_qs2x1a1.png", "a_qs2x1a1.png", LF_SPOILED_QUILT, make_png},
    {"a_qs2x1a1.jpg", "a_qs2x1a1.jpg", LF_SPOILED_QUILT, make_jpeg},
    {"a.icc", "a.icc", LF_SPOILED_PROFILE, make_icc},
    {"visual.json", "visual.json", LF_SPOILED_CALIBRATION, make_calibration},
    {0},
};

/* ---------------------------------------------------------------------------------- spoiling -- */

lf_bytes lf_bytes_read(const char *path)
{
    lf_bytes out = {0};
    char block[4096];
    size_t n;
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    while ((n = fread(block, 1, sizeof block, file)) > 0)
        add(&out, block, n);
    fclose(file);
    return out;
}

void lf_bytes_write(const char *path, const void *data, size_t n)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_true(fwrite(data, 1, n, file) == n && fclose(file) == 0);
}

void lf_spoil(const lf_bytes *whole, int i, int n_cuts, const char *path)
{
    size_t n = i < n_cuts ? whole->n * (size_t)i / (size_t)n_cuts : whole->n;
    uint64_t state = (lf_test_seed() + whole->n) * UINT64_C(0x9e3779b97f4a7c15) + (uint64_t)i;
    unsigned char *data = malloc(whole->n);
    assert_non_null(data);
    memcpy(data, whole->data, whole->n);
    for (int k = 0; k < 1 + i % 8 && i >= n_cuts; k++) {
        for (int mix = 0; mix < 2; mix++)
            state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        data[(size_t)(state >> 33) % whole->n] = (unsigned char)(state >> 20);
    }
    lf_bytes_write(path, data, n);
    free(data);
}
