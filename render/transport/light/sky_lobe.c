#include "render/transport/light/sky_lobe.h"

#include <string.h>

#include "base/alloc.h"
#include "render/transport/light/light_types.h"

/* Radiance of a bright texel over the mean of the picture. */
#define BRIGHT 64.0
/* Angle from the middle of a lobe to that of a texel. */
#define LOBE_RADIUS LF_RADIANS(12.0)
/* Most between the middle and any direction; texels that reach beyond it are left out. */
#define MOST_RADIUS LF_RADIANS(60.0)
/* A lobe with a smaller share of what is bright is left to camera paths. */
#define LEAST_SHARE 0.02
/* Bright texels around which a lobe is sought, at most. */
enum { TRIES = 64 };

/* Of cosines. */
#define ROUNDING 3e-7f

/* A bright texel. */
typedef struct bright_texel {
    uint32_t number;
    bool taken;         /* by a lobe */
    double probability; /* of being drawn for the sky */
    lf_vec3 middle;     /* direction in the scene */
} bright_texel;

typedef struct bright_texels {
    bright_texel *of;
    size_t n;
    double sum;  /* of probabilities */
    double half; /* bound of the angle between the middle of a texel and any direction of it */
} bright_texels;

/* The sampling density of texels that are BRIGHT times as bright as the mean. */
static float least_pdf(const lf_environment *e)
{
    return (float)((BRIGHT - 1.0) * (double)e->mean /
                   (4.0 * (double)LF_PI * (double)e->above_mean));
}

/* An angle is at most the hypotenuse of the differences in latitude and longitude. A middle halves
 * the area of its texel: that of a texel at a pole is farthest from an edge, the pole. */
static double half_of(const lf_environment *e)
{
    const double from_pole = 2.0 * asin(sqrt(0.5) * sin(0.5 * M_PI / e->height));
    return hypot(from_pole, M_PI / e->width);
}

static lf_status find_bright(const lf_light *light, bright_texels *out)
{
    const lf_environment *e = light->environment;
    const size_t w = (size_t)e->width, all = w * (size_t)e->height;
    const float least = least_pdf(e);
    size_t n = 0;
    for (size_t i = 0; i < all; i++)
        n += e->pdf[i] > least;
    *out = (bright_texels){.half = half_of(e)};
    if (n == 0)
        return LF_OK;
    out->of = lf_calloc(n, sizeof *out->of);
    if (!out->of)
        return LF_E_NOMEM;
    for (size_t i = 0; i < all; i++) {
        if (!(e->pdf[i] > least))
            continue;
        bright_texel *t = &out->of[out->n++];
        t->number = (uint32_t)i;
        t->probability = (double)e->pdf[i] * lf_environment_texel_angle(e, (int)(i / w));
        t->middle = lf_environment_direction(light, t->number, 0.5f, 0.5f);
        out->sum += t->probability;
    }
    return LF_OK;
}

static double angle_between(lf_vec3 a, lf_vec3 b)
{
    return 2.0 * asin(fmin(0.5 * (double)lf_length(lf_sub(a, b)), 1.0));
}

static bool is_near(const bright_texels *bright, const bright_texel *t, lf_vec3 axis)
{
    const double angle = angle_between(t->middle, axis);
    return !t->taken && angle < LOBE_RADIUS && angle + bright->half < MOST_RADIUS;
}

/* The middle of what is bright around the texel most likely drawn of those that no lobe has. */
static lf_vec3 find_axis(const bright_texels *bright)
{
    const bright_texel *most = NULL;
    lf_vec3 sum = {0.0f, 0.0f, 0.0f};
    for (size_t i = 0; i < bright->n; i++)
        if (!bright->of[i].taken && (!most || bright->of[i].probability > most->probability))
            most = &bright->of[i];
    for (size_t i = 0; most && i < bright->n; i++)
        if (is_near(bright, &bright->of[i], most->middle))
            sum = lf_madd(sum, (float)bright->of[i].probability, bright->of[i].middle);
    return lf_dot(sum, sum) > 0.0f ? lf_normalize(sum) : sum;
}

/* Fills the tables of a lobe with its texels; total: their probability. */
static lf_status fill(lf_sky_lobe *lobe, const bright_texels *bright, double total, size_t n)
{
    double sum = 0.0;
    lobe->texel = lf_calloc(n, sizeof *lobe->texel);
    lobe->cumulative = lf_calloc(n + 1, sizeof *lobe->cumulative);
    if (!lobe->texel || !lobe->cumulative)
        return LF_E_NOMEM;
    for (size_t i = 0; i < bright->n; i++) {
        bright_texel *t = &bright->of[i];
        if (!is_near(bright, t, lobe->axis))
            continue;
        t->taken = true;
        sum += t->probability / total;
        lobe->texel[lobe->n++] = t->number;
        lobe->cumulative[lobe->n] = (size_t)lobe->n == n ? 1.0f : lf_cumulative_round(sum);
    }
    return LF_OK;
}

/* One lobe. *out_n: its texels, 0 if too little is bright there; then no other lobe has them. */
static lf_status find_lobe(bright_texels *bright, lf_sky_lobe *lobe, size_t *out_n)
{
    double total = 0.0, widest = 0.0;
    lobe->axis = find_axis(bright);
    *out_n = 0;
    for (size_t i = 0; i < bright->n; i++)
        if (is_near(bright, &bright->of[i], lobe->axis)) {
            total += bright->of[i].probability;
            widest = fmax(widest, angle_between(bright->of[i].middle, lobe->axis));
            ++*out_n;
        }
    if (!(total > LEAST_SHARE * bright->sum)) {
        for (size_t i = 0; i < bright->n; i++)
            bright->of[i].taken |= is_near(bright, &bright->of[i], lobe->axis);
        *out_n = 0;
        return LF_OK;
    }
    lobe->share = (float)total;
    lobe->least_cosine = (float)cos(fmin(widest + bright->half, MOST_RADIUS)) - ROUNDING;
    return fill(lobe, bright, total, *out_n);
}

lf_status lf_sky_lobes_find(const lf_light *light, lf_sky_lobe out[LF_SKY_LOBES], int *out_n)
{
    bright_texels bright;
    lf_status status = find_bright(light, &bright);
    size_t texels = 0;
    memset(out, 0, LF_SKY_LOBES * sizeof *out);
    *out_n = 0;
    for (int i = 0; i < TRIES && bright.n > 0 && status == LF_OK && *out_n < LF_SKY_LOBES; i++) {
        status = find_lobe(&bright, &out[*out_n], &texels);
        *out_n += status == LF_OK && texels > 0;
    }
    lf_free(bright.of);
    if (status == LF_OK)
        return LF_OK;
    for (int i = 0; i < LF_SKY_LOBES; i++)
        lf_sky_lobe_finish(&out[i]);
    *out_n = 0;
    return status;
}

void lf_sky_lobe_finish(lf_sky_lobe *lobe)
{
    lf_free(lobe->texel);
    lf_free(lobe->cumulative);
    *lobe = (lf_sky_lobe){0};
}

/* Per unit solid angle in its texel i. */
static float pdf_of(const lf_sky_lobe *lobe, const lf_environment *e, int i)
{
    const int row = (int)(lobe->texel[i] / (uint32_t)e->width);
    return (float)((double)(lobe->cumulative[i + 1] - lobe->cumulative[i]) /
                   lf_environment_texel_angle(e, row));
}

lf_vec3 lf_sky_lobe_draw(const lf_sky_lobe *lobe, const lf_light *light, const float u[3],
                         float *out_pdf)
{
    float rest;
    const int i = lf_cdf_find(lobe->cumulative, lobe->n, u[2], &rest);
    *out_pdf = pdf_of(lobe, light->environment, i);
    return lf_environment_direction(light, lobe->texel[i], u[0], u[1]);
}

float lf_sky_lobe_pdf(const lf_sky_lobe *lobe, const lf_light *light, lf_vec3 wi)
{
    if (!lf_sky_lobe_near(lobe, wi))
        return 0.0f;
    const uint32_t texel = lf_environment_texel(light, wi);
    int first = 0, count = lobe->n;
    while (count > 1) {
        const int half = count / 2;
        const bool above = lobe->texel[first + half] <= texel;
        first = above ? first + half : first;
        count = above ? count - half : half;
    }
    return lobe->texel[first] == texel ? pdf_of(lobe, light->environment, first) : 0.0f;
}
