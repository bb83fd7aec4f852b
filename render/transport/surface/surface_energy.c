/* Multiple-scattering compensation of GGX microfacets. A rough lobe (lf_ggx_eval) counts light that
 * leaves after one reflection. The remainder, loss(cos) = 1 - E(cos) with E the lobe's directional
 * albedo, meets further microfacets or enters the base:
 *
 *   metal     f = once (1 + rest loss(cos_o) / E(cos_o))
 *   plastic   f = once + rest loss(cos_o) loss(cos_i) |cos_i|
 *
 * `rest` is such that white materials return all light at any angle. Metals follow Turquin (2019,
 * Practical multiple scattering compensation for microfacet models): the lobe keeps its shape,
 * which its own directions sample well, but it is not reciprocal. (The uniform lobe of Kulla and
 * Conty 2017, which is almost 0 for smooth metals and far from their peak, is sampled badly.) The
 * colour is Hill's sum over the reflections (2018). Plastics: surface_plastic.c. The dielectric of
 * a layered surface is a plastic's up to an index of 3. From there to infinity it becomes a
 * metal's, which reflects all (lf_loss_rest). E is integrated once per material, and fitted by a
 * polynomial. */
#include <pthread.h>
#include <string.h>

#include "render/transport/surface/surface_lobes.h"

/* Above it the dielectric of a layered surface becomes a metal. */
#define HIGH_INDEX 3.0f

/* A lobe seen along one direction; all in double. */
typedef struct view {
    double alpha, eta; /* eta of a coat, 0: total reflection */
    double cos_o, sin_o;
    double vx, vz; /* the direction in the space where visible normals are a hemisphere */
    double root_o;
} view;

static double root_of(double alpha, double cosine)
{
    return sqrt(alpha * alpha * (1.0 - cosine * cosine) + cosine * cosine);
}

static view view_along(double alpha, double eta, double cos_o)
{
    double root = root_of(alpha, cos_o), sin_o = sqrt(1.0 - cos_o * cos_o);
    return (view){alpha, eta, cos_o, sin_o, alpha * sin_o / root, cos_o / root, root};
}

/* Cosine of the direction that the visible normal at (z, phi) of the spherical cap reflects to
 * (lf_ggx_sample), and wo.h. */
static double reflect(const view *v, double z, double phi, double *out_cos_oh)
{
    double r = sqrt(fmax((1.0 - z) * (1.0 + z), 0.0));
    double x = v->alpha * (r * cos(phi) + v->vx), y = v->alpha * r * sin(phi), up = z + v->vz;
    double inverse = 1.0 / sqrt(x * x + y * y + up * up);
    *out_cos_oh = (v->sin_o * x + v->cos_o * up) * inverse;
    return 2.0 * *out_cos_oh * up * inverse - v->cos_o;
}

/* Position on the cap's meridian phi at which directions reach the horizon. */
static double horizon(const view *v, double phi)
{
    double low = -v->vz, high = 1.0, cos_oh;
    for (int i = 0; i < 30; i++) {
        double middle = 0.5 * (low + high);
        if (reflect(v, middle, phi, &cos_oh) > 0.0)
            high = middle;
        else
            low = middle;
    }
    return high;
}

/* E(cos_o): the mean of F G2/G1 over visible normals. Uniform steps in phi. From the horizon up,
 * steps are small at both ends, so that the midpoint rule converges as fast as for periodic smooth
 * functions. */
static double albedo_along(double alpha, double eta, double cos_o)
{
    enum { ROUND = 24, UP = 16 };
    view v = view_along(alpha, eta, cos_o);
    double sum = 0.0;
    for (int i = 0; i < ROUND; i++) {
        double phi = (double)LF_PI * (i + 0.5) / ROUND, from = horizon(&v, phi), cos_oh;
        for (int j = 0; j < UP; j++) {
            double s = (j + 0.5) / UP, step = 30.0 * s * s * (1.0 - s) * (1.0 - s);
            double cos_i =
                reflect(&v, from + (1.0 - from) * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s), phi,
                        &cos_oh);
            double fresnel =
                eta > 0.0
                    ? (double)lf_fresnel_dielectric((float)fmin(fmax(cos_oh, 0.0), 1.0), (float)eta)
                    : 1.0;
            double kept =
                cos_i * (cos_o + v.root_o) / (cos_i * v.root_o + cos_o * root_of(alpha, cos_i));
            sum += cos_i > 0.0 ? (1.0 - from) * step * fresnel * kept : 0.0;
        }
    }
    return sum / (ROUND * UP * (1.0 + v.vz));
}

/* The polynomial in x of order LF_LOSS_TERMS - 1 through y at Chebyshev's nodes. */
static void fit(const double y[LF_LOSS_TERMS], float out[LF_LOSS_TERMS])
{
    enum { N = LF_LOSS_TERMS };
    /* Chebyshev's polynomials; their sum, in powers of x */
    double power[N][N] = {{1.0}, {0.0, 1.0}}, sum[N] = {0};
    for (int j = 0; j < N; j++) {
        double c = 0.0;
        for (int k = 0; k < N; k++) {
            c += y[k] * cos((double)LF_PI * j * (k + 0.5) / N) * (j == 0 ? 1.0 : 2.0) / N;
            if (j > 1)
                power[j][k] = (k > 0 ? 2.0 * power[j - 1][k - 1] : 0.0) - power[j - 2][k];
        }
        for (int k = 0; k < N; k++)
            sum[k] += c * power[j][k];
    }
    for (int k = 0; k < N; k++)
        out[k] = (float)sum[k];
}

/* The part of the loss that the polynomial does not fit. */
typedef struct smooth_part {
    float ior, scale; /* ior 0: 0, for a metal */
} smooth_part;

static double smooth(const smooth_part *part, double cosine)
{
    return part->ior > 0.0f
               ? (double)(part->scale * lf_coat_transmittance(part->ior, (float)cosine))
               : 0.0;
}

/* rest: the fraction of a metal's loss at that roughness that is finally reflected (lf_loss_rest).
 */
static void fit_loss(lf_material *m, float ior, const smooth_part *part, double rest)
{
    double alpha = (double)lf_material_alpha(m), a = (double)LF_LOSS_SCALE * alpha,
           y[LF_LOSS_TERMS];
    for (int k = 0; k < LF_LOSS_TERMS; k++) {
        double t = 0.5 + 0.5 * cos((double)LF_PI * (k + 0.5) / LF_LOSS_TERMS),
               cosine = a * t * t / (1.0 + a - t * t),
               albedo = albedo_along(alpha, (double)ior, cosine);
        if (rest > 0.0)
            albedo *= 1.0 + rest * (1.0 / albedo_along(alpha, 0.0, cosine) - 1.0);
        y[k] = 1.0 - albedo - smooth(part, cosine);
        y[k] *= (cosine + a) / a;
    }
    fit(y, m->loss);
}

static double mean_loss(const lf_material *m, const smooth_part *part)
{
    double sum = 0.0;
    for (int i = 0; i < LF_MEAN_STEPS; i++) {
        double weight, cosine = lf_mean_cosine(i, &weight);
        sum += weight * (double)lf_loss(m, (float)smooth(part, cosine), (float)cosine);
    }
    return sum;
}

void lf_loss_fit(lf_material *m, float ior)
{
    fit_loss(m, ior, &(smooth_part){ior, 1.0f}, 0.0);
}

double lf_loss_mean(const lf_material *m, float ior)
{
    return mean_loss(m, &(smooth_part){ior, 1.0f});
}

static float straight_on(float ior)
{
    return 4.0f * ior / ((1.0f + ior) * (1.0f + ior));
}

float lf_loss_smooth(float ior, float alpha, float *out_scale)
{
    *out_scale = 1.0f;
    if (!(ior > HIGH_INDEX))
        return ior;
    float blur = alpha * ior, least = 1.0f / HIGH_INDEX,
          part = 1.0f / (least - (least - 1.0f / ior) / (1.0f + blur * blur));
    *out_scale = straight_on(ior) / straight_on(part);
    return part;
}

/* --------------------------------------------------------------------------------- the table -- */

/* Nodes: roughness from the value for LF_ALPHA_MIN to 1 in uniform steps; first metal, then index 1
 * to 3, and above uniform steps of its logarithm. */
enum { ROUGH_NODES = 33, INDEX_NODES = 21, HIGH_STEPS = 64, FIRST_HIGH = 1 + INDEX_NODES };
enum { ROWS = FIRST_HIGH + HIGH_STEPS + 1 };
#define LEAST_ROUGHNESS 0.0316228f
#define HIGH_STEP 0.2f /* in the logarithm, up to LF_MAX_INDEX and a little beyond */

typedef struct loss_row {
    float loss[ROUGH_NODES][LF_LOSS_TERMS], mean[ROUGH_NODES];
} loss_row;

static loss_row rows[ROWS];
static atomic_bool is_made[ROWS];
static pthread_mutex_t making = PTHREAD_MUTEX_INITIALIZER;

static float index_of(int row)
{
    if (row == 0)
        return 0.0f;
    if (row <= INDEX_NODES)
        return 1.0f + 0.1f * (float)(row - 1);
    return HIGH_INDEX * expf(HIGH_STEP * (float)(row - FIRST_HIGH));
}

static void make_row(int row)
{
    for (int i = 0; i < ROUGH_NODES; i++) {
        lf_material m = {.roughness = lf_lerp(LEAST_ROUGHNESS, 1.0f, (float)i / (ROUGH_NODES - 1))};
        double metal = row >= FIRST_HIGH ? (double)lf_loss_look_up(0.0f, m.roughness, NULL) : 0.0;
        smooth_part part;
        part.ior = lf_loss_smooth(index_of(row), lf_material_alpha(&m), &part.scale);
        fit_loss(&m, index_of(row), &part, (double)lf_loss_rest(index_of(row), metal));
        memcpy(rows[row].loss[i], m.loss, sizeof m.loss);
        rows[row].mean[i] = (float)mean_loss(&m, &part);
    }
}

static const loss_row *row_of(int row)
{
    if (row >= FIRST_HIGH) /* the row uses the metal's */
        (void)row_of(0);
    if (!atomic_load_explicit(&is_made[row], memory_order_acquire)) {
        pthread_mutex_lock(&making);
        if (!atomic_load_explicit(&is_made[row], memory_order_relaxed)) {
            make_row(row);
            atomic_store_explicit(&is_made[row], true, memory_order_release);
        }
        pthread_mutex_unlock(&making);
    }
    return &rows[row];
}

/* Adds weight times what the row has at this roughness. */
static float add_row(const loss_row *row, float roughness, float weight, float *out)
{
    float at =
        lf_min(lf_max((roughness - LEAST_ROUGHNESS) / (1.0f - LEAST_ROUGHNESS), 0.0f), 1.0f) *
        (ROUGH_NODES - 1);
    int i = (int)lf_min(at, ROUGH_NODES - 2);
    float f = at - (float)i;
    for (int t = 0; out && t < LF_LOSS_TERMS; t++)
        out[t] += weight * lf_lerp(row->loss[i][t], row->loss[i + 1][t], f);
    return weight * lf_lerp(row->mean[i], row->mean[i + 1], f);
}

static float look_up_high(float ior, float roughness, float *out)
{
    float at = logf(ior / HIGH_INDEX) / HIGH_STEP;
    int i = (int)lf_min(at, HIGH_STEPS - 1);
    float f = at - (float)i;
    return add_row(row_of(FIRST_HIGH + i), roughness, 1.0f - f, out) +
           add_row(row_of(FIRST_HIGH + i + 1), roughness, f, out);
}

/* The metal-like share of the surface grows from 0 at an index of 3. Up to 3 nothing changes: there
 * the base receives the light that is not reflected at once. */
float lf_loss_rest(float ior, double metal_loss)
{
    if (!(ior > HIGH_INDEX))
        return 0.0f;
    double r = ((double)ior - 1.0) / ((double)ior + 1.0), like_metal = (r * r - 0.25) / 0.75,
           mean = 1.0 - (double)lf_loss_look_up(ior, 0.0f, NULL);
    return (float)(like_metal * mean * (1.0 - metal_loss) / (1.0 - mean * metal_loss));
}

/* Below a nearly total reflector almost no light remains; this avoids a division by 0. */
#define LEAST_LOSS 1e-3f

void lf_loss_of_dielectric(lf_material *m, double metal_loss)
{
    const bool rough = lf_material_alpha(m) >= LF_ALPHA_MIN;
    const float mean = lf_loss_look_up(m->ior, rough ? m->roughness : 0.0f, rough ? m->loss : NULL);
    m->energy.mean_loss = lf_max(1.0f - m->specular * (1.0f - mean), LEAST_LOSS);
    m->energy.rest = rough ? lf_loss_rest(m->ior, metal_loss) : 0.0f;
    m->energy.smooth_ior = m->ior;
    m->energy.smooth_scale = 1.0f;
    if (rough)
        m->energy.smooth_ior =
            lf_loss_smooth(m->ior, lf_material_alpha(m), &m->energy.smooth_scale);
}

float lf_loss_look_up(float ior, float roughness, float *out)
{
    if (out)
        memset(out, 0, LF_LOSS_TERMS * sizeof *out);
    if (!(roughness > 0.0f)) {
        lf_material m = {.roughness = 0.0f};
        return (float)lf_loss_mean(&m, ior);
    }
    if (!(ior > 0.0f))
        return add_row(row_of(0), roughness, 1.0f, out);
    if (ior > HIGH_INDEX)
        return look_up_high(ior, roughness, out);
    float at = lf_min(lf_max((ior - 1.0f) * 10.0f, 0.0f), INDEX_NODES - 1), nearest = roundf(at);
    if (fabsf(at - nearest) < 1e-4f)
        return add_row(row_of(1 + (int)nearest), roughness, 1.0f, out);
    int i = (int)lf_min(at, INDEX_NODES - 2);
    float f = at - (float)i;
    return add_row(row_of(1 + i), roughness, 1.0f - f, out) +
           add_row(row_of(2 + i), roughness, f, out);
}
