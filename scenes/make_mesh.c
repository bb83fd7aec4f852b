/* make_mesh FILE.obj: writes the torus knot of the shipped scenes: the (2,3) knot, 20,480 triangles
 * with smooth normals, inside the unit ball, the axis of the torus along z. */
#include <math.h>
#include <stdio.h>

#define ALONG 320
#define AROUND 32
#define TUBE 0.2
#define PI 3.14159265358979323846

typedef struct vec3 {
    double x, y, z;
} vec3;

static vec3 cross(vec3 a, vec3 b)
{
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static vec3 normalize(vec3 a)
{
    double length = sqrt(a.x * a.x + a.y * a.y + a.z * a.z);
    return (vec3){a.x / length, a.y / length, a.z / length};
}

static vec3 knot(double t)
{
    double r = 0.5 + 0.25 * cos(3 * t);
    return (vec3){r * cos(2 * t), r * sin(2 * t), 0.35 * sin(3 * t)};
}

/* Point and unit normal of the tube: the ring at t stands across the curve. */
static void tube(double t, double phi, vec3 *out_p, vec3 *out_n)
{
    const double h = 1e-4;
    vec3 p = knot(t), ahead = knot(t + h), behind = knot(t - h);
    vec3 tangent = normalize((vec3){ahead.x - behind.x, ahead.y - behind.y, ahead.z - behind.z});
    vec3 outward = {p.x, p.y, 0};
    vec3 u = normalize(cross(tangent, outward)), v = cross(u, tangent);
    *out_n = (vec3){cos(phi) * v.x + sin(phi) * u.x, cos(phi) * v.y + sin(phi) * u.y,
                    cos(phi) * v.z + sin(phi) * u.z};
    *out_p = (vec3){p.x + TUBE * out_n->x, p.y + TUBE * out_n->y, p.z + TUBE * out_n->z};
}

static void write_mesh(FILE *file)
{
    fprintf(file, "# a (2,3) torus knot, made by make_mesh\n");
    for (int i = 0; i < ALONG; i++) {
        for (int j = 0; j < AROUND; j++) {
            vec3 p, n;
            tube(2 * PI * i / ALONG, 2 * PI * j / AROUND, &p, &n);
            fprintf(file, "v %.7f %.7f %.7f\nvn %.6f %.6f %.6f\n", p.x, p.y, p.z, n.x, n.y, n.z);
        }
    }
    for (int i = 0; i < ALONG; i++) {
        for (int j = 0; j < AROUND; j++) {
            int a = 1 + i * AROUND + j, b = 1 + i * AROUND + (j + 1) % AROUND;
            int c = 1 + (i + 1) % ALONG * AROUND + j,
                d = 1 + (i + 1) % ALONG * AROUND + (j + 1) % AROUND;
            fprintf(file, "f %d//%d %d//%d %d//%d\nf %d//%d %d//%d %d//%d\n", a, a, b, b, d, d, a,
                    a, d, d, c, c);
        }
    }
}

int main(int argc, char **argv)
{
    FILE *file = argc == 2 ? fopen(argv[1], "w") : NULL;
    if (!file) {
        fprintf(stderr, argc == 2 ? "make_mesh: cannot write %s\n" : "usage: make_mesh FILE.obj\n",
                argv[1]);
        return 2;
    }
    write_mesh(file);
    return fclose(file) == 0 ? 0 : 1;
}
