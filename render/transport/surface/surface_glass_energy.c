/* The albedo of rough glass along one direction after one reflection or refraction: integrated over
 * visible normals, stored in a table over index, side, roughness and cosine. Fitted polynomials
 * (surface_energy.c) would blur the critical angle. */
#include <pthread.h>

#include "render/transport/surface/surface_glass.h"

/* Steps in roughness from the value for LF_ALPHA_MIN to 1, increasing; uniform steps in the index
 * from 1 to 3, and in the cube root of the cosine, which resolves grazing angles. */
enum { ROUGH_NODES = 24, INDEX_NODES = 21 };
#define LEAST_ROUGHNESS 0.0316228f

/* A direction, and a face of relative index eta = beyond / here; double throughout. */
typedef struct view {
    double alpha, eta, cos_o, sin_o;
    double vx, vz; /* the direction in the space where visible normals are a hemisphere */
    double root_o;
} view;

static double root_of(double alpha, double cosine)
{
    return sqrt(alpha * alpha * (1.0 - cosine * cosine) + cosine * cosine);
}

/* For the visible normal at (z, phi) of the spherical cap (lf_ggx_normal): F G2/G1 if it reflects
 * above the horizon, plus (1 - F) G2/G1 if it refracts below. */
static double kept_by(const view *v, double z, double cos_phi, double sin_phi)
{
    double r = sqrt(fmax((1.0 - z) * (1.0 + z), 0.0));
    double x = v->alpha * (r * cos_phi + v->vx), y = v->alpha * r * sin_phi, up = z + v->vz;
    double inverse = 1.0 / sqrt(x * x + y * y + up * up + 1e-24), h_z = up * inverse,
           oh = fmin((v->sin_o * x + v->cos_o * up) * inverse, 1.0);
    double cos2 = 1.0 - (1.0 - oh * oh) / (v->eta * v->eta), fresnel = 1.0, sum = 0.0;
    if (cos2 > 0.0) {
        double c = sqrt(cos2), s = (oh - v->eta * c) / (oh + v->eta * c),
               p = (v->eta * oh - c) / (v->eta * oh + c),
               below = v->cos_o / v->eta - (oh / v->eta - c) * h_z;
        fresnel = 0.5 * (s * s + p * p);
        if (below > 0.0)
            sum = (1.0 - fresnel) * 2.0 * below / (below + root_of(v->alpha, below));
    }
    double above = 2.0 * oh * h_z - v->cos_o;
    if (above > 0.0)
        sum += fresnel * above * (v->cos_o + v->root_o) /
               (above * v->root_o + v->cos_o * root_of(v->alpha, above));
    return sum;
}

/* A Fibonacci lattice over the cap: phi in 0..pi, and z folded (a tent), so that the function is
 * continuous where the lattice repeats, and the kink at the critical angle is sampled everywhere.
 */
enum { POINTS = 987, POINTS_BEFORE = 610 };
typedef struct point {
    double z, cos_phi, sin_phi;
} point;

static void make_points(point out[POINTS])
{
    for (int i = 0; i < POINTS; i++) {
        double phi = (double)LF_PI * (i + 0.5) / POINTS,
               t = (double)(i * POINTS_BEFORE % POINTS) / POINTS;
        out[i] = (point){1.0 - fabs(2.0 * t - 1.0), cos(phi), sin(phi)};
    }
}

static double kept_along(const point points[POINTS], double alpha, double eta, double cos_o)
{
    double root = root_of(alpha, cos_o), sin_o = sqrt(1.0 - cos_o * cos_o), sum = 0.0;
    view v = {alpha, eta, cos_o, sin_o, alpha * sin_o / root, cos_o / root, root};
    for (int i = 0; i < POINTS; i++)
        sum += kept_by(&v, (1.0 + v.vz) * points[i].z - v.vz, points[i].cos_phi, points[i].sin_phi);
    return sum / POINTS;
}

void lf_glass_fit(float ior, bool inside, float roughness, float out[LF_GLASS_NODES])
{
    double alpha = (double)roughness * (double)roughness,
           eta = inside ? 1.0 / (double)ior : (double)ior;
    point points[POINTS];
    make_points(points);
    for (int k = 0; k < LF_GLASS_NODES; k++) {
        double c = fmax((double)k / (LF_GLASS_NODES - 1), 1e-2);
        out[k] = (float)kept_along(points, alpha, eta, c * c * c);
    }
}

typedef float row[ROUGH_NODES][LF_GLASS_NODES];
static row rows[2][INDEX_NODES];
static atomic_bool is_made[2][INDEX_NODES];
static pthread_mutex_t making = PTHREAD_MUTEX_INITIALIZER;

static void make_row(int side, int index)
{
    for (int i = 0; i < ROUGH_NODES; i++) {
        float step = (float)i / (ROUGH_NODES - 1);
        lf_glass_fit(1.0f + 0.1f * (float)index, side,
                     lf_lerp(LEAST_ROUGHNESS, 1.0f, step * sqrtf(step)), rows[side][index][i]);
    }
}

static row *row_of(int side, int index)
{
    if (!atomic_load_explicit(&is_made[side][index], memory_order_acquire)) {
        pthread_mutex_lock(&making);
        if (!atomic_load_explicit(&is_made[side][index], memory_order_relaxed)) {
            make_row(side, index);
            atomic_store_explicit(&is_made[side][index], true, memory_order_release);
        }
        pthread_mutex_unlock(&making);
    }
    return &rows[side][index];
}

static void add_row(row *from, float roughness, float weight, float out[LF_GLASS_NODES])
{
    float of_all = (roughness - LEAST_ROUGHNESS) / (1.0f - LEAST_ROUGHNESS), root = cbrtf(of_all);
    float at = lf_min(lf_max(root * root, 0.0f), 1.0f) * (ROUGH_NODES - 1);
    int i = (int)lf_min(at, ROUGH_NODES - 2);
    for (int k = 0; k < LF_GLASS_NODES; k++)
        out[k] += weight * lf_lerp((*from)[i][k], (*from)[i + 1][k], at - (float)i);
}

void lf_glass_look_up(float ior, bool inside, float roughness, float out[LF_GLASS_NODES])
{
    float at = lf_min(lf_max((ior - 1.0f) * 10.0f, 0.0f), INDEX_NODES - 1), nearest = roundf(at);
    for (int k = 0; k < LF_GLASS_NODES; k++)
        out[k] = 0.0f;
    if (fabsf(at - nearest) < 1e-4f) {
        add_row(row_of(inside, (int)nearest), roughness, 1.0f, out);
        return;
    }
    int i = (int)lf_min(at, INDEX_NODES - 2);
    add_row(row_of(inside, i), roughness, 1.0f - at + (float)i, out);
    add_row(row_of(inside, i + 1), roughness, at - (float)i, out);
}
