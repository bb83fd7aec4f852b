#include "tests/stat/brute.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

/* The voxels of patterns.vdb that hold something. */
static const int first_voxel[3] = {-5, 3, -9}, last_voxel[3] = {20, 30, 8};
static const double middle_voxel[3] = {7.5, 16.5, -0.5};

typedef struct vec {
    double x[3];
} vec;

/* What a path of one picture needs: the camera's frame and the media's turns, made once. */
typedef struct tracer {
    const lf_brute_scene *scene;
    vec right, up, forward;
    double distance, cosine[LF_BRUTE_MEDIA], sine[LF_BRUTE_MEDIA];
    vec sun;
    double sun_cosine;
    double sun_radiance[3];
    uint64_t random;
} tracer;

/* ----------------------------------------------------------------------------------- vectors -- */

static vec combine(vec a, double t, vec b)
{
    return (vec){{a.x[0] + t * b.x[0], a.x[1] + t * b.x[1], a.x[2] + t * b.x[2]}};
}

static double dot(vec a, vec b)
{
    return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2];
}

static vec cross(vec a, vec b)
{
    return (vec){{a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2],
                  a.x[0] * b.x[1] - a.x[1] * b.x[0]}};
}

static vec unit(vec a)
{
    double length = sqrt(dot(a, a));
    return (vec){{a.x[0] / length, a.x[1] / length, a.x[2] / length}};
}

static vec of(const double a[3])
{
    return (vec){{a[0], a[1], a[2]}};
}

/* Marsaglia's xorshift64* (Vigna 2016), 0 <= u < 1. */
static double uniform(tracer *t)
{
    t->random ^= t->random >> 12;
    t->random ^= t->random << 25;
    t->random ^= t->random >> 27;
    return (double)((t->random * 2685821657736338717u) >> 11) * 0x1p-53;
}

/* A direction at this cosine from an axis, anywhere around it. */
static vec around(tracer *t, vec axis, double cosine)
{
    vec helper = fabs(axis.x[0]) < 0.7 ? (vec){{1, 0, 0}} : (vec){{0, 1, 0}};
    vec a = unit(cross(axis, helper)), b = cross(axis, a);
    double sine = sqrt(fmax(0, 1 - cosine * cosine)), phi = 2 * PI * uniform(t);
    vec out = {{0}};
    out = combine(out, cosine, axis);
    out = combine(out, sine * cos(phi), a);
    return unit(combine(out, sine * sin(phi), b));
}

/* ------------------------------------------------------------------------------------- media -- */

static double voxel(int i, int j, int k)
{
    int at[3] = {i, j, k};
    for (int c = 0; c < 3; c++)
        if (at[c] < first_voxel[c] || at[c] > last_voxel[c])
            return 0;
    unsigned h = (unsigned)i * 73u ^ (unsigned)j * 19u ^ (unsigned)k * 83u;
    return (double)(h % 65u) / 64.0;
}

/* Value at a place counted in voxels. */
static double voxels_at(const lf_brute_medium *m, vec p)
{
    if (m->nearest)
        return voxel((int)floor(p.x[0] + 0.5), (int)floor(p.x[1] + 0.5), (int)floor(p.x[2] + 0.5));
    int at[3];
    double f[3], sum = 0;
    for (int c = 0; c < 3; c++) {
        at[c] = (int)floor(p.x[c]);
        f[c] = p.x[c] - at[c];
    }
    for (int n = 0; n < 8; n++) {
        double weight = 1;
        for (int c = 0; c < 3; c++)
            weight *= n >> c & 1 ? f[c] : 1 - f[c];
        sum += weight * voxel(at[0] + (n & 1), at[1] + (n >> 1 & 1), at[2] + (n >> 2 & 1));
    }
    return sum;
}

/* From the world to the medium: -1..1 in a box, voxels in a grid. */
static vec inside(const tracer *t, int index, vec a, bool is_point)
{
    const lf_brute_medium *m = &t->scene->media[index];
    if (is_point)
        a = combine(a, -1, of(m->centre));
    double x = t->cosine[index] * a.x[0] - t->sine[index] * a.x[2],
           z = t->sine[index] * a.x[0] + t->cosine[index] * a.x[2];
    vec out = {{x / m->half[0], a.x[1] / m->half[1], z / m->half[2]}};
    return m->grid && is_point ? combine(out, 1, of(middle_voxel)) : out;
}

/* Where the ray is in the medium's box, or where its voxels are not all 0; false = nowhere before
 * end. */
static bool interval(const lf_brute_medium *m, vec o, vec d, double end, double *t0, double *t1)
{
    *t0 = 0;
    *t1 = end;
    for (int c = 0; c < 3; c++) {
        double low = m->grid ? first_voxel[c] - 1 : -1, high = m->grid ? last_voxel[c] + 1 : 1;
        double a = (low - o.x[c]) / d.x[c], b = (high - o.x[c]) / d.x[c];
        *t0 = fmax(*t0, fmin(a, b));
        *t1 = fmin(*t1, fmax(a, b));
    }
    return *t0 < *t1;
}

/* Distance of the next collision with a medium, by Woodcock's tracking (1965) against its greatest
 * density; end when there is none before. */
static double collide(tracer *t, int index, vec origin, vec direction, double end)
{
    const lf_brute_medium *m = &t->scene->media[index];
    vec o = inside(t, index, origin, true), d = inside(t, index, direction, false);
    double at, last;
    if (!interval(m, o, d, end, &at, &last))
        return end;
    for (;;) {
        at -= log(1 - uniform(t)) / m->density;
        if (at >= last)
            return end;
        if (!m->grid || uniform(t) < voxels_at(m, combine(o, at, d)))
            return at;
    }
}

/* Henyey and Greenstein (1941): cosine to the direction of travel. */
static double scattering_cosine(tracer *t, double g)
{
    double u = uniform(t);
    if (fabs(g) < 1e-6)
        return 1 - 2 * u;
    double s = (1 - g * g) / (1 - g + 2 * g * u);
    return (1 + g * g - s * s) / (2 * g);
}

/* ---------------------------------------------------------------------------------- surfaces -- */

/* Distance to a quad; INFINITY when it is missed. */
static double meet(const lf_brute_quad *q, vec o, vec d)
{
    vec u = of(q->u), v = of(q->v), n = cross(u, v), to = combine(of(q->centre), -1, o);
    double t = dot(to, n) / dot(d, n);
    if (!(t > 0))
        return INFINITY;
    vec p = combine(combine(o, t, d), -1, of(q->centre));
    double nn = dot(n, n), a = dot(cross(p, v), n) / nn, b = dot(cross(u, p), n) / nn;
    return fabs(a) <= 1 && fabs(b) <= 1 ? t : (double)INFINITY;
}

static vec diffuse(tracer *t, const lf_brute_quad *q, vec d)
{
    vec n = unit(cross(of(q->u), of(q->v)));
    if (dot(n, d) > 0)
        n = combine((vec){{0}}, -1, n);
    return around(t, n, sqrt(1 - uniform(t)));
}

/* ------------------------------------------------------------------------------------- paths -- */

static void add_sky(const tracer *t, vec d, const double throughput[3], double radiance[3])
{
    bool in_sun = t->scene->sun_angle > 0 && -dot(d, t->sun) > t->sun_cosine;
    for (int c = 0; c < 3; c++)
        radiance[c] += throughput[c] * (t->scene->sky[c] + (in_sun ? t->sun_radiance[c] : 0));
}

/* Ends paths that carry little, at random, so that the rest carries the more. */
static bool goes_on(tracer *t, double throughput[3])
{
    double most = fmax(throughput[0], fmax(throughput[1], throughput[2]));
    if (most >= 0.2)
        return true;
    if (uniform(t) >= most)
        return false;
    for (int c = 0; c < 3; c++)
        throughput[c] /= most;
    return true;
}

static void trace(tracer *t, vec o, vec d, double radiance[3])
{
    const lf_brute_scene *s = t->scene;
    double throughput[3] = {1, 1, 1};
    int left = -1; /* the quad that the path comes from: flat, so it is not met again */
    do {
        double end = INFINITY;
        int quad = -1, medium = -1;
        for (int i = 0; i < s->n_quads; i++) {
            double at = i == left ? (double)INFINITY : meet(&s->quads[i], o, d);
            if (at < end) {
                end = at;
                quad = i;
            }
        }
        for (int i = 0; i < s->n_media; i++) {
            double at = collide(t, i, o, d, end);
            if (at < end) {
                end = at;
                medium = i;
            }
        }
        if (medium < 0 && quad < 0) {
            add_sky(t, d, throughput, radiance);
            return;
        }
        o = combine(o, end, d);
        left = medium < 0 ? quad : -1;
        const double *albedo = medium < 0 ? s->quads[quad].albedo : s->media[medium].albedo;
        for (int c = 0; c < 3; c++) {
            radiance[c] += medium < 0 ? throughput[c] * s->quads[quad].emission[c] : 0;
            throughput[c] *= albedo[c];
        }
        d = medium < 0 ? diffuse(t, &s->quads[quad], d)
                       : around(t, d, scattering_cosine(t, s->media[medium].g));
    } while (goes_on(t, throughput));
}

/* ------------------------------------------------------------------------------------ camera -- */

static void aim(tracer *t)
{
    const lf_brute_scene *s = t->scene;
    vec along = combine(of(s->target), -1, of(s->position));
    t->distance = sqrt(dot(along, along));
    t->forward = unit(along);
    t->right = unit(cross(t->forward, (vec){{0, 1, 0}}));
    t->up = cross(t->right, t->forward);
    for (int i = 0; i < s->n_media; i++) {
        t->cosine[i] = cos(s->media[i].turn * PI / 180);
        t->sine[i] = sin(s->media[i].turn * PI / 180);
    }
    if (s->sun_angle > 0) {
        double half = s->sun_angle * PI / 360;
        t->sun = unit(of(s->sun_direction));
        t->sun_cosine = cos(half);
        for (int c = 0; c < 3; c++)
            t->sun_radiance[c] = s->sun_irradiance[c] / (PI * sin(half) * sin(half));
    }
}

/* From one camera to the next, on average. */
static double step(const tracer *t)
{
    if (t->scene->track > 0)
        return t->scene->track / (t->scene->n_views - 1);
    double outer = (0.5 - 0.5 / t->scene->n_views) * t->scene->cone * PI / 180;
    return 2 * t->distance * tan(outer) / (t->scene->n_views - 1);
}

/* How far a camera is from the middle one. */
static double offset(const tracer *t, int view)
{
    const lf_brute_scene *s = t->scene;
    double angle = ((view + 0.5) / s->n_views - 0.5) * s->cone * PI / 180;
    return s->track > 0 ? (view - 0.5 * (s->n_views - 1)) * step(t) : t->distance * tan(angle);
}

/* Radiance that arrives at a point (0..1 from the left and the top) of a view's film, by one path.
 */
static void look(tracer *t, int view, double u, double v, double radiance[3])
{
    const lf_brute_scene *s = t->scene;
    double b = offset(t, view);
    double height = 2 * t->distance * tan(s->fov_y * PI / 360), width = s->aspect * height;
    double x = (u - 0.5) * width, y = (0.5 - v) * height, lens[2] = {0, 0},
           sharp = s->focus > 0 ? s->focus : t->distance;
    if (s->lens_radius > 0) {
        double r = s->lens_radius * sqrt(uniform(t)), phi = 2 * PI * uniform(t);
        lens[0] = r * cos(phi);
        lens[1] = r * sin(phi);
    }
    if (s->view_blur > 0)
        lens[0] = s->view_blur * step(t) * (uniform(t) - 0.5);
    /* from the lens to where the ray through its middle meets the plane in focus; a blurred view of
     * a track is of cameras that look the same way */
    double aside = s->track > 0 ? x : x - b, kept = s->track > 0 && s->view_blur > 0 ? 0 : lens[0];
    double dx = aside * sharp / t->distance - kept, dy = y * sharp / t->distance - lens[1];
    vec o = combine(combine(of(s->position), b + lens[0], t->right), lens[1], t->up), d = {{0}};
    d = combine(combine(combine(d, dx, t->right), dy, t->up), sharp, t->forward);
    trace(t, o, unit(d), radiance);
}

void lf_brute_picture(const lf_brute_scene *scene, uint64_t seed, int width, int height, int strata,
                      double *out)
{
    tracer t = {.scene = scene, .random = (seed + 1) * 0x9e3779b97f4a7c15u};
    aim(&t);
    for (int row = 0; row < height; row++)
        for (int view = 0; view < scene->n_views; view++)
            for (int column = 0; column < width; column++) {
                double sum[3] = {0};
                for (int n = 0; n < strata * strata; n++)
                    look(&t, view, (column + (n % strata + uniform(&t)) / strata) / width,
                         (row + ((double)(n / strata) + uniform(&t)) / strata) / height, sum);
                *out++ = (0.5 * sum[0] + 0.3 * sum[1] + 0.2 * sum[2]) / (strata * strata);
            }
}

/* -------------------------------------------------------------------------------------- text -- */

typedef struct text {
    char at[16384];
    size_t n;
} text;

__attribute__((format(printf, 2, 3))) static void say(text *t, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    int n = vsnprintf(t->at + t->n, sizeof t->at - t->n, format, list);
    va_end(list);
    if (n < 0 || (size_t)n >= sizeof t->at - t->n)
        abort();
    t->n += (size_t)n;
}

static void say_three(text *t, const char *name, const double x[3])
{
    say(t, "'%s': [%.17g, %.17g, %.17g]", name, x[0], x[1], x[2]);
}

static void say_camera(text *t, const lf_brute_scene *s)
{
    say(t, "{ 'quiltd': 1, 'camera': { ");
    say_three(t, "position", s->position);
    say(t, ", ");
    say_three(t, "target", s->target);
    say(t, ", 'fov_y': %.17g, 'aspect': %.17g, 'lens_radius': %.17g", s->fov_y, s->aspect,
        s->lens_radius);
    if (s->track > 0)
        say(t, ", 'views': { 'track': { 'count': %d, 'length': %.17g } }", s->n_views, s->track);
    else
        say(t, ", 'cone': %.17g, 'views': %d", s->cone, s->n_views);
    if (s->focus > 0)
        say(t, ", 'focus_distance': %.17g", s->focus);
    if (s->view_blur > 0)
        say(t, ", 'view_blur': %.17g", s->view_blur);
    say(t, " }, ");
}

static void say_media(text *t, const lf_brute_scene *s, const char *vdb)
{
    say(t, "'volumes': { ");
    for (int i = 0; i < s->n_media; i++) {
        const lf_brute_medium *m = &s->media[i];
        say(t, "%s'm%d': { ", i ? ", " : "", i);
        if (m->grid)
            say(t, "'file': '%s', 'grid': 'half', 'scale': %.17g, 'interpolation': '%s', ", vdb,
                m->density, m->nearest ? "nearest" : "linear");
        else
            say(t, "'shape': 'box', 'density': %.17g, ", m->density);
        say_three(t, "albedo", m->albedo);
        /* scale, turn and move in one matrix, behind the one that puts the middle of the voxels at
         * 0 */
        double c = cos(m->turn * PI / 180), n = sin(m->turn * PI / 180), x[3];
        for (int k = 0; k < 3; k++)
            x[k] = m->grid ? -middle_voxel[k] * m->half[k] : 0;
        say(t,
            ", 'g': %.17g, 'transform': { 'matrix': [%.17g, 0, %.17g, %.17g, 0, %.17g, 0, %.17g, "
            "%.17g, 0, %.17g, %.17g, "
            "0, 0, 0, 1] } }",
            m->g, c * m->half[0], n * m->half[2], c * x[0] + n * x[2] + m->centre[0], m->half[1],
            x[1] + m->centre[1], -n * m->half[0], c * m->half[2],
            c * x[2] - n * x[0] + m->centre[2]);
    }
    say(t, " }, ");
}

static void say_quads(text *t, const lf_brute_scene *s)
{
    say(t, "'meshes': { ");
    for (int i = 0; i < s->n_quads; i++) {
        const lf_brute_quad *q = &s->quads[i];
        vec n = unit(cross(of(q->v), of(q->u)));
        say(t, "%s'q%d': { 'shape': 'quad', 'material': 'q%d', 'transform': { 'matrix': [",
            i ? ", " : "", i, i);
        for (int k = 0; k < 3; k++)
            say(t, "%.17g, %.17g, %.17g, %.17g, ", q->u[k], n.x[k], q->v[k], q->centre[k]);
        say(t, "0, 0, 0, 1] } }");
    }
    say(t, " }, 'materials': { ");
    for (int i = 0; i < s->n_quads; i++) {
        say(t, "%s'q%d': { 'type': 'diffuse', ", i ? ", " : "", i);
        say_three(t, "albedo", s->quads[i].albedo);
        say(t, ", ");
        say_three(t, "emission", s->quads[i].emission);
        say(t, " }");
    }
    say(t, " }, ");
}

char *lf_brute_text(const lf_brute_scene *s, const char *vdb)
{
    text *t = calloc(1, sizeof *t);
    if (!t)
        abort();
    say_camera(t, s);
    say_media(t, s, vdb);
    say_quads(t, s);
    say(t, "'lights': { 'sky': { 'type': 'environment', ");
    say_three(t, "radiance", s->sky);
    say(t, " }");
    if (s->sun_angle > 0) {
        say(t, ", 'sun': { 'type': 'distant', 'angle': %.17g, ", s->sun_angle);
        say_three(t, "direction", s->sun_direction);
        say(t, ", ");
        say_three(t, "irradiance", s->sun_irradiance);
        say(t, " }");
    }
    say(t, " } }");
    char *out = strdup(t->at);
    free(t);
    if (!out)
        abort();
    return out;
}
