#include "render/transport/surface/surface_sheen.h"

#include <pthread.h>

/* The lobe has no limit as this goes to 0. */
#define LEAST_ALPHA 0.01f

static float alpha_of(float roughness)
{
    return lf_max(roughness * roughness, LEAST_ALPHA);
}

/* The fit of the paper's table 1 between alpha = 1 and alpha = 0, by (1 - alpha)^2. */
static float fitted(float x, float alpha)
{
    static const float rough[5] = {21.5473f, 3.82987f, 0.19823f, -1.97760f, -4.32054f},
                       smooth[5] = {25.3245f, 3.32435f, 0.16801f, -1.27393f, -4.85967f};
    float t = (1.0f - alpha) * (1.0f - alpha), p[5];
    for (int i = 0; i < 5; i++)
        p[i] = lf_lerp(rough[i], smooth[i], t);
    return p[0] / (1.0f + p[1] * powf(x, p[2])) + p[3] * x + p[4];
}

static float lambda(float cosine, float alpha)
{
    return cosine < 0.5f ? expf(fitted(cosine, alpha))
                         : expf(2.0f * fitted(0.5f, alpha) - fitted(1.0f - cosine, alpha));
}

/* Density of normals, at the half vector of two directions. */
static float normals(float alpha, lf_vec3 wo, lf_vec3 wi)
{
    lf_vec3 h = lf_normalize(lf_add(wo, wi));
    float sine2 = h.x * h.x + h.y * h.y;
    return (2.0f + 1.0f / alpha) * powf(sine2, 0.5f / alpha) * 0.5f * LF_INV_PI;
}

float lf_sheen_eval(float roughness, lf_vec3 wo, lf_vec3 wi)
{
    float alpha = alpha_of(roughness);
    if (!(wo.z > LF_MIN_COS) || !(wi.z > LF_MIN_COS))
        return 0.0f;
    return normals(alpha, wo, wi) /
           ((1.0f + lambda(wo.z, alpha) + lambda(wi.z, alpha)) * 4.0f * wo.z);
}

/* ------------------------------------------------------------------------------------ albedo -- */

/* Over roughness and the root of the cosine, where the table is most curved. */
enum { SIDE = 24, STEPS = 32 };
static float table[SIDE][SIDE];
static pthread_once_t once = PTHREAD_ONCE_INIT;

static float integrate(float roughness, float cos_o)
{
    double sum = 0.0;
    float alpha = alpha_of(roughness), hidden = 1.0f + lambda(cos_o, alpha);
    lf_vec3 wo = lf_v3(sqrtf(1.0f - cos_o * cos_o), 0.0f, cos_o);
    for (int i = 0; i < STEPS; i++) {
        /* cos = x^2, for the horizon's sake */
        float x = ((float)i + 0.5f) / STEPS, cosine = x * x, sine = sqrtf(1.0f - cosine * cosine);
        float share = 2.0f * x / ((hidden + lambda(cosine, alpha)) * 4.0f * cos_o);
        for (int j = 0; j < STEPS; j++) {
            float phi = LF_PI * ((float)j + 0.5f) / STEPS;
            lf_vec3 wi = lf_v3(sine * cosf(phi), sine * sinf(phi), cosine);
            sum += (double)(share * normals(alpha, wo, wi));
        }
    }
    return (float)(sum * 2.0 * (double)LF_PI / (STEPS * STEPS));
}

static void fill_table(void)
{
    for (int i = 0; i < SIDE; i++)
        for (int j = 0; j < SIDE; j++) {
            float root = lf_max((float)j / (SIDE - 1), 0.01f);
            table[i][j] = lf_min(integrate((float)i / (SIDE - 1), root * root), 1.0f);
        }
}

float lf_sheen_albedo(float roughness, float cos_o)
{
    pthread_once(&once, fill_table);
    float x = lf_min(lf_max(roughness, 0.0f), 1.0f) * (SIDE - 1),
          y = sqrtf(lf_min(lf_max(cos_o, 0.0f), 1.0f)) * (SIDE - 1);
    int i = (int)lf_min(x, (float)(SIDE - 2)), j = (int)lf_min(y, (float)(SIDE - 2));
    float fx = x - (float)i, fy = y - (float)j;
    return lf_lerp(lf_lerp(table[i][j], table[i + 1][j], fx),
                   lf_lerp(table[i][j + 1], table[i + 1][j + 1], fx), fy);
}
