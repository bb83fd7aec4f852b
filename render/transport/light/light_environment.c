/* A sky image, looked up bilinearly and sampled by a table that is constant over each texel. A
 * texel's weight is the mean of the bilinear image over it (weights 1 6 1 each way) minus the mean
 * of the whole image. Directions from scattering find the remaining light, and the balance
 * heuristic of both is right for any weights (Karlik, Sik, Vevoda, Skrivan and Krivanek, "MIS
 * Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling", 2019). */
#include <string.h>

#include "base/alloc.h"
#include "base/image_io.h"
#include "render/scene/vec_double.h"
#include "render/transport/light/light_types.h"
#include "render/transport/light/sky_lobe.h"

/* Share of the rows, and of the texels of a row, that is drawn uniformly. It keeps every cumulative
 * step above the resolution of the random numbers next to a sun, for images of up to 65536 texels a
 * side. */
#define EVEN_SHARE (1.0 / 64.0)

static float texel_mean(const lf_environment *e, int x, int y)
{
    const float *t = e->rgb + 3 * ((size_t)y * (size_t)e->width + (size_t)x);
    return (lf_max(t[0], 0.0f) + lf_max(t[1], 0.0f) + lf_max(t[2], 0.0f)) * (1.0f / 3.0f);
}

static double texel_weight(const lf_environment *e, int x, int y)
{
    static const double tent[3] = {0.125, 0.75, 0.125};
    double sum = 0.0;
    for (int j = -1; j <= 1; j++) {
        int row = y + j < 0 ? 0 : y + j >= e->height ? e->height - 1 : y + j;
        for (int i = -1; i <= 1; i++)
            sum += tent[j + 1] * tent[i + 1] *
                   (double)texel_mean(e, (x + i + e->width) % e->width, row);
    }
    return sum;
}

/* sin^2(theta / 2) at the upper and lower edge of a row counted from the nearer pole: differences
 * of these are solid angles over 4 pi, without the cancellation of 1 - cos. */
static void row_edges(const lf_environment *e, int row, float edges[2])
{
    for (int i = 0; i < 2; i++) {
        float s = sinf(0.5f * LF_PI * (float)(row + i) / (float)e->height);
        edges[i] = s * s;
    }
}

static int row_from_pole(const lf_environment *e, int row)
{
    return 2 * row < e->height ? row : e->height - 1 - row;
}

static double row_solid_angle(const lf_environment *e, int row)
{
    double a = sin(0.5 * (double)LF_PI * row / e->height),
           b = sin(0.5 * (double)LF_PI * (row + 1) / e->height);
    return 4.0 * (double)LF_PI * (b * b - a * a);
}

/* Turns n weights into cdf[0..n], 0 at the start and 1 from the last weight above 0 on; false when
 * all are 0. */
static bool make_cdf(const double *weight, int n, float *cdf)
{
    double total = 0.0, sum = 0.0;
    int lit = 0, last = 0;
    for (int i = 0; i < n; i++) {
        total += weight[i];
        lit += weight[i] > 0.0;
        last = weight[i] > 0.0 ? i : last;
    }
    cdf[0] = 0.0f;
    for (int i = 0; i < n; i++) {
        if (weight[i] > 0.0)
            sum += (1.0 - EVEN_SHARE) * weight[i] / total + EVEN_SHARE / lit;
        cdf[i + 1] = i >= last ? 1.0f : lf_min(lf_cumulative_round(sum), 1.0f);
    }
    return total > 0.0;
}

static void fill_pdf(lf_environment *e)
{
    for (int y = 0; y < e->height; y++) {
        const float *conditional = e->conditional + (size_t)y * ((size_t)e->width + 1);
        double k = (double)(e->marginal[y + 1] - e->marginal[y]) * e->width / row_solid_angle(e, y);
        for (int x = 0; x < e->width; x++)
            e->pdf[(size_t)y * (size_t)e->width + (size_t)x] =
                (float)(k * (double)(conditional[x + 1] - conditional[x]));
    }
}

/* Over all directions, of the weights of texels. */
static double picture_mean(const lf_environment *e)
{
    double mean = 0.0;
    for (int y = 0; y < e->height; y++) {
        double sum = 0.0;
        for (int x = 0; x < e->width; x++)
            sum += texel_weight(e, x, y);
        mean += sum / e->width * row_solid_angle(e, y) / (4.0 * (double)LF_PI);
    }
    return mean;
}

/* In a constant image only rounding exceeds the mean. */
#define ROUNDING 1e-6

lf_status lf_environment_commit(lf_environment *e)
{
    size_t w = (size_t)e->width, h = (size_t)e->height, longer = w > h ? w : h;
    double *weight = lf_calloc(longer, sizeof *weight), *rows = lf_calloc(h, sizeof *rows),
           above = 0.0, whole = picture_mean(e), mean = whole * (1.0 + ROUNDING);
    if (!e->marginal)
        e->marginal = lf_calloc(h + 1, sizeof *e->marginal);
    if (!e->conditional)
        e->conditional = lf_calloc(h * (w + 1), sizeof *e->conditional);
    if (!e->pdf)
        e->pdf = lf_calloc(h * w, sizeof *e->pdf);
    bool ok = weight && rows && e->marginal && e->conditional && e->pdf;
    for (int y = 0; ok && y < e->height; y++) {
        double sum = 0.0, solid_angle = row_solid_angle(e, y);
        for (int x = 0; x < e->width; x++)
            sum += weight[x] = fmax(texel_weight(e, x, y) - mean, 0.0);
        make_cdf(weight, e->width, e->conditional + (size_t)y * (w + 1));
        rows[y] = sum * solid_angle;
        above += sum / e->width * solid_angle / (4.0 * (double)LF_PI);
    }
    if (ok && make_cdf(rows, e->height, e->marginal))
        fill_pdf(e);
    else if (ok)
        memset(e->pdf, 0, h * w * sizeof *e->pdf);
    e->mean = (float)whole;
    e->above_mean = (float)above;
    lf_free(weight);
    lf_free(rows);
    return ok ? LF_OK : LF_E_NOMEM;
}

/* Row and column of a direction in the image's frame, in texels. atan2 keeps its digits at the
 * poles, acos does not. */
static void direction_to_texel(const lf_environment *e, lf_vec3 w, float *x, float *y)
{
    float phi = atan2f(w.z, w.x);
    phi += phi < 0.0f ? 2.0f * LF_PI : 0.0f;
    *x = phi * (0.5f * LF_INV_PI) * (float)e->width;
    *y = atan2f(sqrtf(w.x * w.x + w.z * w.z), w.y) * LF_INV_PI * (float)e->height;
}

static lf_vec3 bilinear(const lf_environment *e, float x, float y)
{
    float fx = floorf(x - 0.5f), fy = floorf(y - 0.5f), ax = x - 0.5f - fx, ay = y - 0.5f - fy;
    int x0 = (int)fx, y0 = (int)fy, y1 = y0 + 1 < e->height ? y0 + 1 : e->height - 1;
    int x1 = x0 + 1 < e->width ? x0 + 1 : x0 + 1 - e->width;
    x0 = x0 < 0 ? x0 + e->width : x0 >= e->width ? x0 - e->width : x0;
    y0 = y0 < 0 ? 0 : y0 >= e->height ? e->height - 1 : y0;
    const float *upper = e->rgb + 3 * (size_t)y0 * (size_t)e->width,
                *lower = e->rgb + 3 * (size_t)y1 * (size_t)e->width;
    float c[3];
    for (int i = 0; i < 3; i++) {
        float a = upper[3 * x0 + i] + ax * (upper[3 * x1 + i] - upper[3 * x0 + i]);
        float b = lower[3 * x0 + i] + ax * (lower[3 * x1 + i] - lower[3 * x0 + i]);
        c[i] = lf_max(a + ay * (b - a), 0.0f);
    }
    return lf_v3(c[0], c[1], c[2]);
}

static lf_vec3 rotate(const float m[3][3], lf_vec3 w)
{
    return lf_v3(m[0][0] * w.x + m[0][1] * w.y + m[0][2] * w.z,
                 m[1][0] * w.x + m[1][1] * w.y + m[1][2] * w.z,
                 m[2][0] * w.x + m[2][1] * w.y + m[2][2] * w.z);
}

static lf_vec3 rotate_back(const float m[3][3], lf_vec3 w)
{
    return lf_v3(m[0][0] * w.x + m[1][0] * w.y + m[2][0] * w.z,
                 m[0][1] * w.x + m[1][1] * w.y + m[2][1] * w.z,
                 m[0][2] * w.x + m[1][2] * w.y + m[2][2] * w.z);
}

/* The texel of a direction, by rows; *x and *y as in direction_to_texel. */
static uint32_t texel_of(const lf_light *light, lf_vec3 w, float *x, float *y)
{
    const lf_environment *e = light->environment;
    direction_to_texel(e, rotate(light->to_environment, w), x, y);
    int column = (int)lf_min(*x, (float)(e->width - 1)),
        row = (int)lf_min(*y, (float)(e->height - 1));
    return (uint32_t)row * (uint32_t)e->width + (uint32_t)column;
}

uint32_t lf_environment_texel(const lf_light *light, lf_vec3 w)
{
    float x, y;
    return texel_of(light, w, &x, &y);
}

double lf_environment_texel_angle(const lf_environment *e, int row)
{
    return row_solid_angle(e, row) / e->width;
}

lf_vec3 lf_environment_escape(const lf_light *light, lf_vec3 w, float *out_pdf)
{
    const lf_environment *e = light->environment;
    float x, y;
    if (!e) {
        *out_pdf = 0.0f;
        return light->radiance;
    }
    *out_pdf = e->pdf[texel_of(light, w, &x, &y)];
    return lf_mul(light->radiance, bilinear(e, x, y));
}

/* A direction in the scene; across, along: position in the texel. */
static lf_vec3 direction_at(const lf_light *light, int row, int column, float across, float along)
{
    const lf_environment *e = light->environment;
    float edges[2];
    int from_pole = row_from_pole(e, row);
    row_edges(e, from_pole, edges);
    float h = edges[0] + across * (edges[1] - edges[0]), sine = 2.0f * sqrtf(h * (1.0f - h)),
          cosine = 1.0f - 2.0f * h;
    float phi = 2.0f * LF_PI * ((float)column + along) / (float)e->width;
    return rotate_back(
        light->to_environment,
        lf_v3(sine * cosf(phi), from_pole == row ? cosine : -cosine, sine * sinf(phi)));
}

lf_vec3 lf_environment_direction(const lf_light *light, uint32_t texel, float across, float along)
{
    const uint32_t width = (uint32_t)light->environment->width;
    return direction_at(light, (int)(texel / width), (int)(texel % width), across, along);
}

bool lf_environment_draw(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place,
                         const float u[2], lf_light_sample *out)
{
    (void)scene, (void)p, (void)place;
    const lf_environment *e = light->environment;
    float along, across;
    int row = lf_cdf_find(e->marginal, e->height, u[0], &across);
    int column =
        lf_cdf_find(e->conditional + (size_t)row * ((size_t)e->width + 1), e->width, u[1], &along);
    out->wi = direction_at(light, row, column, across, along);
    return true;
}

double lf_environment_power(const lf_light *light, double radius)
{
    if (!light->environment)
        return 0.0;
    double pi = (double)LF_PI;
    return 4.0 * pi * pi * radius * radius * (double)light->environment->above_mean *
           (double)lf_mean3(light->radiance);
}

bool lf_environment_varies(const lf_light *light)
{
    return light->environment;
}

void lf_environment_turn(lf_light *light, double angle)
{
    double a = 0.5 * M_PI - angle, c = cos(a), s = sin(a);
    const double m[3][3] = {{c, 0, s}, {0, 1, 0}, {-s, 0, c}};
    for (int i = 0; i < 9; i++)
        light->to_environment[i / 3][i % 3] = (float)m[i / 3][i % 3];
}

/* ------------------------------------------------------------------------------- light paths -- */

static bool emit(const lf_scene *scene, const lf_light *light, const lf_emitter_square *square,
                 const float u[6], lf_emitted *out)
{
    (void)scene;
    float area, pdf, whole;
    const lf_vec3 at = lf_emitter_square_draw(square, u, &out->cell, &area),
                  wi = lf_sky_lobe_draw(square->lobe, light, u + 3, &pdf);
    if (!(pdf > 0.0f))
        return false;
    out->w = lf_scale(wi, -1.0f);
    out->p = lf_madd(at, 4.0f * square->half, wi);
    out->flux =
        lf_scale(lf_environment_escape(light, wi, &whole), area * lf_dot(wi, square->axis) / pdf);
    return true;
}

static float emit_density(const lf_scene *scene, const lf_light *light,
                          const lf_emitter_square *square, lf_vec3 p, const lf_light_end *end)
{
    (void)scene;
    const float pdf = lf_sky_lobe_pdf(square->lobe, light, end->wi);
    return pdf > 0.0f ? pdf * lf_emitter_square_density(square, p, end->wi) : 0.0f;
}

/* ---------------------------------------------------------------------------------- its keys -- */

enum { FILE_NAME, SCALE, ROTATE, RADIANCE, VISIBLE };

static const lf_param keys[] = {
    [FILE_NAME] = {.name = "file",
                   .type = LF_PARAM_FILE,
                   .form = 1,
                   .word_at = lf_image_float_ending},
    [SCALE] = {.name = "scale",
               .type = LF_PARAM_COLOUR,
               .form = 1,
               .high = LF_MAX_RADIANCE,
               .point = {1, 1, 1}},
    [ROTATE] = {.name = "rotate", .type = LF_PARAM_ANGLE, .form = 1, .low = -3600, .high = 3600},
    [RADIANCE] = {.name = "radiance", .type = LF_PARAM_COLOUR, .form = 2, .high = LF_MAX_RADIANCE},
    [VISIBLE] = LF_VISIBLE_KEY,
    {0},
};

static void read(const lf_value values[], const double origin[3], lf_light *light)
{
    (void)origin;
    light->radiance = lf_to_vec3(values[values[FILE_NAME].given ? SCALE : RADIANCE].number);
    light->hidden = !values[VISIBLE].on;
    lf_environment_turn(light, values[ROTATE].number[0]);
}

const lf_light_kind lf_light_environment = {
    .name = "environment",
    .keys = keys,
    .read = read,
    .draw = lf_environment_draw,
    .power = lf_environment_power,
    .escape = lf_environment_escape,
    .varies = lf_environment_varies,
    .emit = emit,
    .emit_density = emit_density,
};
