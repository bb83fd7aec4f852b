#include "render/transport/lanes/lane_scene.h"

#include <string.h>

#include "base/alloc.h"
#include "render/scene/look_up.h"
#include "render/transport/light/light_types.h"
#include "render/transport/path/sunlight_media.h"
#include "render/transport/path/track.h"

/* Nodes of the control along the longest side: one per two voxels, within bounds. */
enum { LEAST_NODES = 16, MOST_NODES = 160 };

/* 1 GiB, in addition to the grid itself if that is in float. */
#define MOST_VALUES (UINT64_C(1) << 29)

/* For a sky image: indices have 32 bits. */
#define MOST_TEXELS (UINT64_C(1) << 29)

/* --------------------------------------------------------------------------------- the scene -- */

/* Maximum number of mean free paths along the longest edge of a voxel. Above, the rounding to 16
 * bits in a brick could absorb more than 1/256 of the light (the same limit applies to grids that
 * are in 16 bits already). */
#define MOST_DEPTH 64.0f

static float deepest_voxel(const lf_volume *v)
{
    float longest = 0.0f;
    for (int i = 0; i < 3; i++)
        longest = lf_max(longest,
                         lf_length(lf_v3(v->to_scene[0][i], v->to_scene[1][i], v->to_scene[2][i])));
    return longest * v->sigma_max;
}

/* For one grid. */
static bool serves_volume(const lf_volume *v)
{
    uint64_t framed = 1;
    for (int i = 0; i < 3; i++)
        framed *= (uint64_t)v->grid->bricks[i] + 2;
    return v->sigma_max > 0.0f && deepest_voxel(v) <= MOST_DEPTH && framed < INT32_MAX &&
           (uint64_t)v->grid->n_bricks * LF_BRICK_STRIDE < MOST_VALUES;
}

static bool has_picture(const lf_light *light)
{
    return light->environment;
}

/* The image, whether it is sampled or constant, or the sampled light besides it; NULL: none. */
static bool counts(const lf_light *light, bool picture)
{
    return has_picture(light) == picture && (picture || light->select > 0.0f);
}

static const lf_light *light_of_lanes(const lf_scene *scene, bool picture)
{
    for (int i = 0; i < scene->n_lights; i++)
        if (counts(&scene->lights[i], picture))
            return &scene->lights[i];
    return NULL;
}

static bool serves_picture(const lf_environment *picture)
{
    return (uint64_t)picture->width * (uint64_t)picture->height < MOST_TEXELS;
}

/* For lights at infinity. */
static bool serves_lights(const lf_scene *scene)
{
    int drawn[2] = {0, 0};
    for (int i = 0; i < scene->n_lights; i++) {
        const lf_light *l = &scene->lights[i];
        if (l->environment && !serves_picture(l->environment))
            return false;
        drawn[has_picture(l)] += counts(l, has_picture(l));
    }
    return drawn[0] <= 1 && drawn[1] <= 1;
}

bool lf_lane_scene_serves(const lf_scene *scene)
{
    return !(scene->traits & ~LF_LANES_SUPPORT) && scene->n_volumes == 1 &&
           serves_volume(&scene->volumes[0]) && serves_lights(scene);
}

static void put(float out[3], lf_vec3 v)
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static lf_lane_picture picture_of(const lf_light *light)
{
    const lf_environment *e = light->environment;
    lf_lane_picture picture = {.rgb = e->rgb,
                               .pdf = e->pdf,
                               .marginal = e->marginal,
                               .conditional = e->conditional,
                               .width = e->width,
                               .height = e->height};
    memcpy(picture.to_picture, light->to_environment, sizeof picture.to_picture);
    put(picture.factor, light->radiance);
    return picture;
}

static lf_lane_disk disk_of(const lf_light *light)
{
    const lf_vec3 axis = lf_scale(light->direction, -1.0f);
    lf_lane_disk disk = {.versine = light->versine,
                         .solid_angle = 2.0f * LF_PI * light->versine,
                         .inverse_ramp = 0.5f / lf_disk_ramp(light)};
    lf_vec3 t, b;
    lf_tangents(axis, &t, &b);
    put(disk.side[0], t);
    put(disk.side[1], b);
    put(disk.radiance, light->radiance);
    return disk;
}

/* Constant radiance of the skies without an image. */
static lf_vec3 even_sky(const lf_scene *scene)
{
    lf_vec3 sum = lf_v3(0.0f, 0.0f, 0.0f);
    float pdf;
    for (int i = 0; i < scene->n_lights; i++) {
        const lf_light *light = &scene->lights[i];
        if (!light->environment && !(light->versine > 0.0f))
            sum = lf_add(sum, light->kind->escape(light, lf_v3(0.0f, 1.0f, 0.0f), &pdf));
    }
    return sum;
}

static bool is_empty(const lf_box *box)
{
    return !(box->min.x <= box->max.x);
}

/* Extends the box min, max to a mesh, plus the error of rounded coordinates. */
static void grow(const lf_volume *volume, const lf_box *mesh, float min[3], float max[3])
{
    const float x[2] = {mesh->min.x, mesh->max.x}, y[2] = {mesh->min.y, mesh->max.y},
                z[2] = {mesh->min.z, mesh->max.z};
    for (int i = 0; i < 3; i++) {
        const float *row = volume->to_volume[i];
        for (int c = 0; c < 8; c++) {
            const float part[4] = {row[0] * x[c & 1], row[1] * y[c >> 1 & 1], row[2] * z[c >> 2],
                                   row[3]};
            const float at = part[0] + part[1] + part[2] + part[3],
                        off = 1e-5f *
                              (fabsf(part[0]) + fabsf(part[1]) + fabsf(part[2]) + fabsf(part[3]));
            min[i] = lf_min(min[i], at - off);
            max[i] = lf_max(max[i], at + off);
        }
    }
}

static void set_boxes(lf_lane_scene *lanes, const lf_scene *scene)
{
    lf_lane_boxes *boxes = &lanes->boxes;
    for (int b = 0; b < LF_LANE_BOXES; b++)
        for (int k = 0; k < 3; k++) {
            boxes->min[b][k] = INFINITY;
            boxes->max[b][k] = -INFINITY;
        }
    for (int i = 0; i < scene->n_meshes; i++) {
        if (is_empty(&scene->meshes[i].box))
            continue;
        if (boxes->n < LF_LANE_BOXES)
            boxes->n++;
        const int b = boxes->n - 1;
        grow(&scene->volumes[0], &scene->meshes[i].box, boxes->min[b], boxes->max[b]);
    }
    lanes->has |= boxes->n > 0 ? LF_LANE_SURFACES : 0;
}

static void set_colours(lf_lane_scene *lanes, const lf_scene *scene)
{
    const lf_volume *volume = &scene->volumes[0];
    const lf_light *light = light_of_lanes(scene, false), *sky = light_of_lanes(scene, true);
    for (int i = 0; i < 3; i++) {
        lanes->size[i] = (float)volume->grid->size[i];
        for (int k = 0; k < 4; k++)
            lanes->to_volume[i][k] = volume->to_volume[i][k];
    }
    lanes->g = volume->g;
    put(lanes->albedo, volume->albedo);
    put(lanes->sky, even_sky(scene));
    if (light) {
        put(lanes->toward, lf_scale(light->direction, -1.0f));
        put(lanes->irradiance, light->irradiance);
    }
    if (light && light->versine > 0.0f) {
        lanes->has |= LF_LANE_DISK;
        lanes->disk = disk_of(light);
    }
    if (sky) {
        lanes->has |= LF_LANE_PICTURE;
        lanes->picture = picture_of(sky);
    }
}

/* --------------------------------------------------------------------------------- the field -- */

typedef struct layers {
    lf_lane_field *field;
    const lf_volume *volume;
} layers;

static void pack_brick(lf_lane_field *field, const lf_volume *volume, size_t from, size_t to)
{
    const lf_grid *grid = volume->grid;
    const size_t first = (size_t)grid->index[from] * LF_BRICK_STRIDE;
    const float highest = grid->brick_max[from];
    field->majorant[to] = highest * volume->sigma_scale;
    field->first[to] = (int32_t)first;
    if (!field->values)
        return;
    for (int i = 0; i < LF_BRICK_STRIDE && highest > 0.0f; i++) {
        float share = lf_grid_stored(grid, first + (size_t)i) / highest;
        field->values[first + (size_t)i] = (uint16_t)(lf_min(share, 1.0f) * 65535.0f + 0.5f);
    }
}

static void pack_layer(void *context, int z, int worker)
{
    const layers *job = context;
    const lf_grid *grid = job->volume->grid;
    const size_t row = (size_t)job->field->framed[0], layer = row * (size_t)job->field->framed[1];
    (void)worker;
    for (int y = 0; y < grid->bricks[1]; y++)
        for (int x = 0; x < grid->bricks[0]; x++) {
            size_t from = lf_grid_brick(grid, x, y, z);
            size_t to = (size_t)(z + 1) * layer + (size_t)(y + 1) * row + (size_t)(x + 1);
            if (grid->index[from] != 0)
                pack_brick(job->field, job->volume, from, to);
        }
}

static lf_status pack(lf_lane_field *field, const lf_volume *volume, lf_pool *pool)
{
    const lf_grid *grid = volume->grid;
    layers job = {field, volume};
    size_t n = 1;
    for (int i = 0; i < 3; i++) {
        field->framed[i] = grid->bricks[i] + 2;
        n *= (size_t)field->framed[i];
    }
    field->majorant = lf_calloc(n, sizeof *field->majorant);
    field->first = lf_calloc(n, sizeof *field->first);
    field->shorts = grid->shorts;
    field->scale = grid->short_scale * volume->sigma_scale;
    if (!grid->shorts)
        field->values =
            lf_calloc(((size_t)grid->n_bricks + 1) * LF_BRICK_STRIDE, sizeof *field->values);
    if (!field->majorant || !field->first || !(field->values || field->shorts))
        return LF_E_NOMEM;
    return lf_pool_run(pool, grid->bricks[2], pack_layer, &job, NULL);
}

/* Volume-space point -> node. */
static void compose(const lf_sunlight_media *media, const lf_volume *volume, float out[3][4])
{
    for (int i = 0; i < 3; i++) {
        const float *row = media->to_nodes[i];
        for (int k = 0; k < 4; k++)
            out[i][k] = row[0] * volume->to_scene[0][k] + row[1] * volume->to_scene[1][k] +
                        row[2] * volume->to_scene[2][k] + (k == 3 ? row[3] : 0.0f);
    }
}

static int nodes_for(const lf_grid *grid)
{
    int longest = grid->size[0] > grid->size[1] ? grid->size[0] : grid->size[1];
    longest = longest > grid->size[2] ? longest : grid->size[2];
    return (int)lf_min(lf_max((float)longest / 2.0f, LEAST_NODES), MOST_NODES);
}

typedef struct shades {
    lf_lane_field *field;
    const lf_sunlight_media *media;
    const lf_lane_boxes *boxes;
    float toward[3]; /* volume space */
} shades;

/* Transmittance of meshes from p to the light. */
static float passed(const shades *job, lf_tracer *tracer, lf_vec3 p)
{
    const lf_volume *volume = &job->field->scene->volumes[0];
    for (int b = 0; b < job->boxes->n; b++) {
        float first = 0.0f, last = INFINITY;
        for (int i = 0; i < 3; i++) {
            const float *row = volume->to_volume[i], d = job->toward[i],
                        q = row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3],
                        inverse = 1.0f / (fabsf(d) < 1e-20f ? 1e-20f : d),
                        near = (job->boxes->min[b][i] - q) * inverse,
                        far = (job->boxes->max[b][i] - q) * inverse;
            first = lf_max(first, lf_min(near, far));
            last = lf_min(last, lf_max(near, far));
        }
        if (first <= last)
            return lf_trace_passed(tracer, p, job->media->toward, INFINITY);
    }
    return 1.0f;
}

static void shade_layer(void *context, int y, int worker)
{
    const shades *job = context;
    const int *size = job->media->size;
    lf_tracer tracer = {.scene = job->media->scene};
    (void)worker;
    for (int x = 0; x < size[0]; x++)
        for (int z = 0; z < size[2]; z++) {
            const size_t at =
                ((size_t)y * (size_t)size[0] + (size_t)x) * (size_t)size[2] + (size_t)z;
            float left = expf(-job->media->depth[at]);
            if (left > 0x1p-17f)
                left *= passed(job, &tracer,
                               lf_sunlight_media_node(job->media, (const int[3]){x, y, z}));
            job->field->left[at] = (uint16_t)(left * 65535.0f + 0.5f);
        }
}

static lf_status make_control(lf_lane_field *field, const lf_lane_boxes *boxes,
                              const lf_light *light, lf_pool *pool)
{
    const lf_volume *volume = &field->scene->volumes[0];
    lf_sunlight_media media;
    lf_status status =
        lf_sunlight_media_init(&media, field->scene, lf_scale(light->direction, -1.0f),
                               nodes_for(volume->grid), pool, NULL);
    size_t n = (size_t)media.size[0] * (size_t)media.size[1] * (size_t)media.size[2];
    if (status != LF_OK || !media.depth || n >= INT32_MAX) {
        lf_sunlight_media_finish(&media);
        return status;
    }
    shades job = {field, &media, boxes, {0.0f}};
    for (int i = 0; i < 3; i++) {
        const float *row = volume->to_volume[i];
        job.toward[i] = lf_dot(lf_v3(row[0], row[1], row[2]), media.toward);
    }
    field->left = lf_calloc(n + 1, sizeof *field->left);
    status = field->left ? lf_pool_run(pool, media.size[1], shade_layer, &job, NULL) : LF_E_NOMEM;
    for (int i = 0; i < 3; i++)
        field->nodes[i] = media.size[i];
    compose(&media, volume, field->to_nodes);
    lf_sunlight_media_finish(&media);
    return status;
}

static void unref(lf_lane_field *field)
{
    if (!field || --field->refs > 0)
        return;
    lf_free(field->values);
    lf_free(field->majorant);
    lf_free(field->first);
    lf_free(field->left);
    lf_scene_unref(field->scene);
    lf_free(field);
}

static lf_status make_field(lf_scene *scene, const lf_lane_boxes *boxes, lf_pool *pool,
                            lf_lane_field **out)
{
    const lf_light *light = light_of_lanes(scene, false);
    lf_lane_field *field = lf_calloc(1, sizeof *field);
    if (!field)
        return LF_E_NOMEM;
    field->refs = 1;
    field->scene = lf_scene_ref(scene);
    lf_status status = pack(field, &scene->volumes[0], pool);
    if (status == LF_OK && light)
        status = make_control(field, boxes, light, pool);
    *out = field;
    return status;
}

static bool is_field_of(const lf_lane_field *field, const lf_scene *scene)
{
    const lf_volume *old = &field->scene->volumes[0], *is = &scene->volumes[0];
    const lf_light *before = light_of_lanes(field->scene, false),
                   *now = light_of_lanes(scene, false);
    if (before && now) {
        if (memcmp(&before->direction, &now->direction, sizeof now->direction) != 0)
            return false;
    } else if (before || now) {
        return false;
    }
    return old->grid == is->grid && old->sigma_scale == is->sigma_scale &&
           memcmp(old->to_volume, is->to_volume, sizeof is->to_volume) == 0 &&
           field->scene->geometry == scene->geometry;
}

lf_status lf_lane_scene_init(lf_lane_scene *out, lf_scene *scene, const lf_lane_scene *previous,
                             lf_pool *pool)
{
    *out = (lf_lane_scene){0};
    if (!lf_lane_scene_serves(scene))
        return LF_OK;
    set_colours(out, scene);
    set_boxes(out, scene);
    if (!previous || !previous->field || !is_field_of(previous->field, scene))
        return make_field(scene, &out->boxes, pool, &out->field);
    out->field = previous->field;
    out->field->refs++;
    return LF_OK;
}

void lf_lane_scene_finish(lf_lane_scene *lanes)
{
    unref(lanes->field);
    *lanes = (lf_lane_scene){0};
}
