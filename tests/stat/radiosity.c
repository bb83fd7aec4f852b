#include "tests/stat/radiosity.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* corners of a quad after up to six cuts */
enum { MAX_CORNERS = 10 };

typedef struct polygon {
    double at[MAX_CORNERS][3];
    int n;
} polygon;

typedef struct patch {
    double centre[3], u[3], v[3];
    int quad;
} patch;

struct lf_radiosity {
    lf_room room;
    patch *patches;
    double *radiosity; /* of all depths together */
    int n_patches;
};

/* --- form factors -- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    const double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                         a[0] * b[1] - a[1] * b[0]};
    memcpy(out, c, sizeof c);
}

/* Keeps the part where normal . x > least. */
static void cut(polygon *of, const double normal[3], double least)
{
    polygon kept = {.n = 0};
    for (int i = 0; i < of->n; i++) {
        const double *a = of->at[i], *b = of->at[(i + 1) % of->n];
        double da = dot(normal, a) - least, db = dot(normal, b) - least;
        if (da > 0.0)
            memcpy(kept.at[kept.n++], a, sizeof kept.at[0]);
        if ((da > 0.0) != (db > 0.0)) {
            for (int k = 0; k < 3; k++)
                kept.at[kept.n][k] = a[k] + (b[k] - a[k]) * da / (da - db);
            kept.n++;
        }
    }
    *of = kept;
}

/* Of a polygon around the origin, without what lies below the horizon (Lambert 1760). */
static double lambert(polygon of, const double n[3])
{
    double sum = 0.0;
    cut(&of, n, 0.0);
    for (int i = 0; i < of.n; i++) {
        const double *a = of.at[i], *b = of.at[(i + 1) % of.n];
        double c[3];
        cross(a, b, c);
        double length = sqrt(dot(c, c));
        if (length > 0.0)
            sum += atan2(length, dot(a, b)) * dot(n, c) / length;
    }
    return fabs(sum) / (2.0 * M_PI);
}

static polygon corners(const double centre[3], const double u[3], const double v[3],
                       const double p[3])
{
    static const int s[4] = {-1, 1, 1, -1}, t[4] = {-1, -1, 1, 1};
    polygon out = {.n = 4};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++)
            out.at[i][k] = centre[k] + s[i] * u[k] + t[i] * v[k] - p[k];
    return out;
}

/* The part of a polygon around p that the shade hides. */
static void cut_shadow(polygon *of, const lf_room_quad *shade, const double p[3])
{
    const polygon rim = corners(shade->centre, shade->u, shade->v, p);
    double normal[3], middle[3];
    cross(shade->u, shade->v, normal);
    for (int k = 0; k < 3; k++)
        middle[k] = shade->centre[k] - p[k];
    double away = dot(normal, middle), sign = away < 0.0 ? -1.0 : 1.0;
    if (fabs(away) < 1e-9 * sqrt(dot(normal, normal))) { /* p lies in its plane */
        of->n = 0;
        return;
    }
    for (int k = 0; k < 3; k++)
        normal[k] *= sign;
    cut(of, normal, sign * away * (1.0 + 1e-9));
    for (int i = 0; i < 4 && of->n > 0; i++) {
        double side[3];
        cross(rim.at[i], rim.at[(i + 1) % 4], side);
        double inwards = dot(side, middle) < 0.0 ? -1.0 : 1.0;
        for (int k = 0; k < 3; k++)
            side[k] *= inwards;
        cut(of, side, 0.0);
    }
}

static double factor(const lf_room *room, const patch *of, const double p[3], const double n[3])
{
    double normal[3], to[3];
    cross(of->u, of->v, normal);
    for (int k = 0; k < 3; k++)
        to[k] = p[k] - of->centre[k];
    if (!(dot(normal, to) > 1e-9 * sqrt(dot(normal, normal))))
        return 0.0;
    polygon whole = corners(of->centre, of->u, of->v, p), hidden = whole;
    if (room->shade < 0)
        return lambert(whole, n);
    cut_shadow(&hidden, &room->quads[room->shade], p);
    return lambert(whole, n) - lambert(hidden, n);
}

static patch whole_quad(const lf_room *room, int quad)
{
    const lf_room_quad *q = &room->quads[quad];
    patch out = {.quad = quad};
    memcpy(out.centre, q->centre, sizeof out.centre);
    memcpy(out.u, q->u, sizeof out.u);
    memcpy(out.v, q->v, sizeof out.v);
    return out;
}

double lf_room_factor(const lf_room *room, int quad, const double p[3], const double n[3])
{
    const patch all = whole_quad(room, quad);
    return factor(room, &all, p, n);
}

/* --- solver -- */

static void add_patches(lf_radiosity *r, int quad, int fineness)
{
    const lf_room_quad *q = &r->room.quads[quad];
    int across = q->across * fineness, down = q->down * fineness;
    for (int j = 0; j < down; j++) {
        for (int i = 0; i < across; i++) {
            patch *to = &r->patches[r->n_patches++];
            to->quad = quad;
            for (int k = 0; k < 3; k++) {
                to->centre[k] = q->centre[k] + q->u[k] * ((2 * i + 1.0) / across - 1.0) +
                                q->v[k] * ((2 * j + 1.0) / down - 1.0);
                to->u[k] = q->u[k] / across;
                to->v[k] = q->v[k] / down;
            }
        }
    }
}

static void normal_of(const patch *of, double out[3])
{
    cross(of->u, of->v, out);
    double length = sqrt(dot(out, out));
    for (int k = 0; k < 3; k++)
        out[k] /= length;
}

/* Points of Gauss on a patch, all with the weight 1/4. */
static void gauss(const patch *of, int i, double out[3])
{
    static const double at = 0.5773502691896258;
    for (int k = 0; k < 3; k++)
        out[k] = of->centre[k] + (i & 1 ? at : -at) * of->u[k] + (i & 2 ? at : -at) * of->v[k];
}

/* What a patch gets from lamps, in its mean: of its quarters, because half shadows are narrow. */
static double direct_of(const lf_radiosity *r, const patch *of, const double n[3])
{
    double sum = 0.0;
    for (int i = 0; i < 16; i++) {
        patch quarter = *of;
        for (int k = 0; k < 3; k++) {
            quarter.centre[k] += (i & 4 ? 0.5 : -0.5) * of->u[k] + (i & 8 ? 0.5 : -0.5) * of->v[k];
            quarter.u[k] *= 0.5;
            quarter.v[k] *= 0.5;
        }
        double p[3];
        gauss(&quarter, i, p);
        sum += lf_radiosity_direct(r, p, n) / 16.0;
    }
    return sum;
}

static void first_light(const lf_radiosity *r, double *out)
{
    for (int i = 0; i < r->n_patches; i++) {
        double n[3], albedo = r->room.quads[r->patches[i].quad].albedo;
        normal_of(&r->patches[i], n);
        out[i] = albedo > 0.0 ? albedo * direct_of(r, &r->patches[i], n) : 0.0;
    }
}

static double *factors_of(const lf_radiosity *r)
{
    size_t n = (size_t)r->n_patches;
    double *out = malloc(n * n * sizeof *out);
    for (size_t i = 0; i < n; i++) {
        double normal[3];
        normal_of(&r->patches[i], normal);
        for (size_t j = 0; j < n; j++)
            out[i * n + j] = factor(&r->room, &r->patches[j], r->patches[i].centre, normal);
    }
    return out;
}

/* One more reflection of `from`. */
static void reflect(const lf_radiosity *r, const double *factors, const double *from, double *to)
{
    size_t n = (size_t)r->n_patches;
    for (size_t i = 0; i < n; i++) {
        double sum = 0.0;
        for (size_t j = 0; j < n; j++)
            sum += factors[i * n + j] * from[j];
        to[i] = r->room.quads[r->patches[i].quad].albedo * sum;
    }
}

lf_radiosity *lf_radiosity_solve(const lf_room *room, int fineness, int max_depth)
{
    lf_radiosity *r = calloc(1, sizeof *r);
    size_t n = 0;
    r->room = *room;
    for (int i = 0; i < room->n_quads; i++)
        n += (size_t)(room->quads[i].across * room->quads[i].down * fineness * fineness);
    r->patches = calloc(n, sizeof *r->patches);
    r->radiosity = calloc(n, sizeof *r->radiosity);
    for (int i = 0; i < room->n_quads; i++)
        add_patches(r, i, fineness);
    if (max_depth < 2)
        return r;
    double *now = malloc(2 * n * sizeof *now), *next = now + n, *const both = now;
    double *factors = factors_of(r);
    first_light(r, now);
    for (int depth = 2; depth <= max_depth; depth++) {
        for (size_t i = 0; i < n; i++)
            r->radiosity[i] += now[i];
        reflect(r, factors, now, next);
        double *swapped = now;
        now = next;
        next = swapped;
    }
    free(factors);
    free(both);
    return r;
}

void lf_radiosity_free(lf_radiosity *radiosity)
{
    free(radiosity->patches);
    free(radiosity->radiosity);
    free(radiosity);
}

double lf_radiosity_direct(const lf_radiosity *r, const double p[3], const double n[3])
{
    double sum = 0.0;
    for (int i = 0; i < r->room.n_quads; i++)
        if (r->room.quads[i].emission > 0.0)
            sum += M_PI * r->room.quads[i].emission * lf_room_factor(&r->room, i, p, n);
    return sum;
}

double lf_radiosity_indirect(const lf_radiosity *r, const double p[3], const double n[3])
{
    double sum = 0.0;
    for (int i = 0; i < r->n_patches; i++)
        if (r->radiosity[i] > 0.0)
            sum += r->radiosity[i] * factor(&r->room, &r->patches[i], p, n);
    return sum;
}
