/* What the pilots share, which run before the first pass: camera paths, and parts of the image;
 * private to render/rows/. */
#ifndef LF_RENDER_PILOT_PATH_H
#define LF_RENDER_PILOT_PATH_H

#include "render/plane/rig.h"
#include "render/transport/path/suffix_one.h"

/* Parts of the image, for which pilots estimate the brightness. */
enum {
    LF_PILOT_PART_ROWS = 8,
    LF_PILOT_PART_COLUMNS = 6,
    LF_PILOT_PARTS = LF_PILOT_PART_ROWS * LF_PILOT_PART_COLUMNS
};
static inline int lf_pilot_part(const lf_rig *rig, int row, int column)
{
    return row * LF_PILOT_PART_ROWS / rig->height * LF_PILOT_PART_COLUMNS +
           column * LF_PILOT_PART_COLUMNS / rig->width;
}

/* The sum of their light, and the number of samples; zeroed at first. */
typedef struct lf_pilot_light {
    double sum[LF_PILOT_PARTS], n[LF_PILOT_PARTS];
} lf_pilot_light;
static inline void lf_pilot_light_add(lf_pilot_light *light, int part, float mean)
{
    light->sum[part] += (double)mean;
    light->n[part] += 1.0;
}
/* 0 in a part without samples. */
static inline double lf_pilot_brightness(const lf_pilot_light *light, int part)
{
    return light->n[part] > 0.0 ? light->sum[part] / light->n[part] : 0.0;
}

/* The grid of a pilot's samples over the image. Each has one view. */
enum { LF_PILOT_ACROSS = 32, LF_PILOT_DOWN = 32 };
/* The view of a sample. Along each column and each row, all views come equally often; if they are
 * more than the samples there, none comes twice. */
int lf_pilot_view(int n_views, int column, int row);

/* The variance that two samples suggest, mean of the channels. */
static inline float lf_pilot_variance(lf_vec3 a, lf_vec3 b)
{
    const lf_vec3 d = lf_sub(a, b);
    return 0.5f * lf_mean3(lf_mul(d, d));
}

/* Traces the ray of a view's film point. out->w, and where the ray meets a surface with a lobe, the
 * pivot there. Sets the tracer's footprint. *out_light: what the camera sees there itself. false:
 * no pivot. Needs tracer->scene. */
bool lf_pilot_pivot(lf_tracer *tracer, const lf_rig *rig, int view, const float film[2],
                    lf_event *out, float *out_light);

/* Draws a suffix into a zeroed one; its direction is pending. */
void lf_pilot_suffix(lf_tracer *tracer, const lf_event *pivot, lf_sampler *sampler, lf_suffix *out);
/* Follows its direction. balance: its cosine is not read; NULL: alone. */
void lf_pilot_follow(lf_tracer *tracer, const lf_event *pivot, int max_depth,
                     const lf_light_balance *balance, lf_suffix *suffix);
/* Its radiance towards the camera; 0 if it is not finite. */
lf_vec3 lf_pilot_radiance(const lf_scene *scene, const lf_event *pivot, const lf_suffix *suffix);

#endif
