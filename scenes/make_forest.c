/* A tree, and where a forest of it stands: what scenes/forest.json is made of.
 *
 *     make_forest OUT.ply tree            about ten thousand triangles, coloured bark and leaves
 *     make_forest OUT.npy places N        N places, float32: x y z, a quaternion, a scale
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST 65536
#define TURN 6.28318530717958647692

typedef struct vertex {
    float p[3];
    uint8_t rgb[3];
} __attribute__((packed)) vertex;

static vertex vertices[MOST];
static uint32_t triangles[MOST][3];
static int n_vertices, n_triangles;

/* In [0, 1); splitmix64. */
static uint64_t state = 7;
static double uniform(void)
{
    uint64_t z = state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static double between(double low, double high)
{
    return low + (high - low) * uniform();
}

/* -------------------------------------------------------------------------------------- tree -- */

static uint32_t put(const double p[3], const int rgb[3])
{
    vertex *v = &vertices[n_vertices];
    for (int i = 0; i < 3; i++) {
        v->p[i] = (float)p[i];
        v->rgb[i] = (uint8_t)rgb[i];
    }
    return (uint32_t)n_vertices++;
}

static void put_triangle(uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t t[3] = {a, b, c};
    memcpy(triangles[n_triangles++], t, sizeof t);
}

static void unit(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; i++)
        v[i] /= length;
}

/* Two directions across a unit one. */
static void across(const double along[3], double u[3], double v[3])
{
    const double axis[3] = {fabs(along[0]) < 0.6, fabs(along[0]) >= 0.6, 0};
    for (int i = 0; i < 3; i++)
        u[i] = along[(i + 1) % 3] * axis[(i + 2) % 3] - along[(i + 2) % 3] * axis[(i + 1) % 3];
    unit(u);
    for (int i = 0; i < 3; i++)
        v[i] = along[(i + 1) % 3] * u[(i + 2) % 3] - along[(i + 2) % 3] * u[(i + 1) % 3];
}

static void leaf(const double at[3], const double along[3], double size)
{
    const int green[3] = {(int)between(100, 150), (int)between(140, 185), (int)between(70, 100)};
    double d[3], u[3], v[3], p[4][3];
    for (int i = 0; i < 3; i++)
        d[i] = along[i] + between(-1, 1);
    d[1] -= 0.3;
    unit(d);
    across(d, u, v);
    for (int i = 0; i < 3; i++) {
        p[0][i] = at[i];
        p[1][i] = at[i] + size * (0.5 * d[i] + 0.25 * u[i]);
        p[2][i] = at[i] + size * (d[i] - 0.1 * v[i]);
        p[3][i] = at[i] + size * (0.5 * d[i] - 0.25 * u[i]);
    }
    uint32_t corner[4];
    for (int i = 0; i < 4; i++)
        corner[i] = put(p[i], green);
    put_triangle(corner[0], corner[1], corner[2]);
    put_triangle(corner[0], corner[2], corner[3]);
}

/* A tube of so many sides from one ring to another. */
static void tube(const double from[3], const double to[3], const double along[3], double r0,
                 double r1, int sides)
{
    const int brown[3] = {110, 86, 66};
    double u[3], v[3];
    uint32_t first = (uint32_t)n_vertices;
    across(along, u, v);
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < sides; i++) {
            double c = cos(TURN * i / sides), s = sin(TURN * i / sides), p[3], r = end ? r1 : r0;
            for (int j = 0; j < 3; j++)
                p[j] = (end ? to : from)[j] + r * (c * u[j] + s * v[j]);
            put(p, brown);
        }
    for (int i = 0; i < sides; i++) {
        uint32_t a = first + (uint32_t)i, b = first + (uint32_t)((i + 1) % sides),
                 n = (uint32_t)sides;
        put_triangle(a, b, b + n);
        put_triangle(a, b + n, a + n);
    }
}

static void grow(const double from[3], const double along[3], double length, double radius,
                 int depth)
{
    double to[3], d[3], u[3], v[3];
    for (int i = 0; i < 3; i++)
        to[i] = from[i] + length * along[i];
    tube(from, to, along, radius, 0.7 * radius, depth > 3 ? 8 : depth > 1 ? 5 : 3);
    if (depth == 0) {
        for (int i = 0; i < 10; i++) {
            double at[3], share = between(0.2, 1);
            for (int j = 0; j < 3; j++)
                at[j] = from[j] + share * length * along[j];
            leaf(at, along, between(0.07, 0.12));
        }
        return;
    }
    across(along, u, v);
    double phase = uniform() * TURN;
    const int n = 4;
    for (int i = 0; i < n; i++) {
        double angle = phase + TURN * i / n, tilt = i == 0 ? 0.15 : between(0.5, 0.9);
        for (int j = 0; j < 3; j++)
            d[j] = cos(tilt) * along[j] + sin(tilt) * (cos(angle) * u[j] + sin(angle) * v[j]);
        d[1] += 0.1;
        unit(d);
        grow(to, d, length * between(0.62, 0.78), 0.62 * radius, depth - 1);
    }
}

static int write_tree(FILE *out)
{
    const double root[3] = {0, 0, 0}, up[3] = {0, 1, 0};
    grow(root, up, 0.7, 0.06, 4);
    fprintf(out,
            "ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty "
            "float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar "
            "blue\nelement face %d\nproperty list uchar uint vertex_indices\nend_header\n",
            n_vertices, n_triangles);
    fwrite(vertices, sizeof *vertices, (size_t)n_vertices, out);
    for (int i = 0; i < n_triangles; i++) {
        fputc(3, out);
        fwrite(triangles[i], sizeof triangles[i], 1, out);
    }
    return 0;
}

/* ------------------------------------------------------------------------------------ places -- */

/* On a square grid, each moved within its field, turned about the upright and as large as it likes.
 */
static int write_places(FILE *out, long n)
{
    char header[128];
    int length = snprintf(header, sizeof header,
                          "{'descr': '<f4', 'fortran_order': False, 'shape': (%ld, 8), }", n);
    const int room = 118; /* with the 10 bytes before it a multiple of 64 */
    fwrite("\x93NUMPY\x01\x00\x76\x00", 1, 10, out);
    fprintf(out, "%s%*s\n", header, room - 1 - length, "");
    long side = (long)ceil(sqrt((double)n));
    for (long i = 0; i < n; i++) {
        double x = (double)(i % side) + between(0.1, 0.9) - 0.5 * (double)side,
               z = (double)(i / side) + between(0.1, 0.9) - 0.5 * (double)side,
               turn = uniform() * TURN;
        const float row[8] = {
            (float)(1.6 * x),       0, (float)(1.6 * z),       0,
            (float)sin(0.5 * turn), 0, (float)cos(0.5 * turn), (float)between(0.6, 1.2)};
        fwrite(row, sizeof row, 1, out);
    }
    return 0;
}

int main(int argc, char **argv)
{
    FILE *out = argc > 2 ? fopen(argv[1], "wb") : NULL;
    if (!out) {
        fprintf(stderr, "usage: make_forest OUT tree | make_forest OUT places N\n");
        return 2;
    }
    int status = strcmp(argv[2], "tree") == 0 ? write_tree(out)
                                              : write_places(out, argc > 3 ? atol(argv[3]) : 1000);
    return fclose(out) == 0 ? status : 1;
}
