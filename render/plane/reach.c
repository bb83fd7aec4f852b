#include "render/plane/reach.h"

#include "render/scene/geometry.h"

/* Range of film positions, in columns; a point at or behind the cameras covers all columns. */
typedef struct shadow {
    const lf_rig *rig;
    float lens_chord;
    bool everywhere;
    float lo[LF_MAX_LANES], hi[LF_MAX_LANES];
} shadow;

/* Adds the film positions of the point (x, z) of the row's plane in every view, over the whole
 * lens. */
static void add_point(shadow *s, float x, float z)
{
    const lf_rig *rig = s->rig;
    if (!(z > 1e-6f * rig->distance) || !(fabsf(x) < INFINITY)) {
        s->everywhere = true;
        return;
    }
    float per_pixel = 1.0f / rig->dx, scale = rig->distance / z;
    float blur = s->lens_chord > 0.0f ? s->lens_chord * rig->distance *
                                            fabsf(1.0f / rig->focus - 1.0f / z) * per_pixel
                                      : 0.0f;
    int lanes = (rig->n_views + LF_LANES - 1) / LF_LANES * LF_LANES;
    for (int k = 0; k < lanes; k++) {
        float u = (rig->skew[k] + scale * (x - rig->b[k]) - rig->x0) * per_pixel;
        s->lo[k] = lf_min(s->lo[k], u - blur);
        s->hi[k] = lf_max(s->hi[k], u + blur);
    }
}

static void add_slice(shadow *s, const lf_slice *slice)
{
    /* Between two planes a ray passes what lies on either, because it is straight. So the occupied
     * parts of planes are sufficient. */
    for (int i = slice->first; i <= slice->last; i++) {
        if (slice->spans[i].x_lo > slice->spans[i].x_hi)
            continue;
        float z = slice->z0 + (float)i * slice->dz;
        add_point(s, slice->spans[i].x_lo, z);
        add_point(s, slice->spans[i].x_hi, z);
    }
}

/* A convex box projects on no more than what its corners span. With a plane: only if the plane
 * meets it. */
static void add_box(shadow *s, lf_vec3 min, lf_vec3 max, const lf_row_plane *plane)
{
    const lf_rig *rig = s->rig;
    float x[8], z[8], above = -INFINITY, below = INFINITY, size = 0.0f;
    for (int corner = 0; corner < 8; corner++) {
        lf_vec3 p = lf_v3(corner & 1 ? max.x : min.x, corner & 2 ? max.y : min.y,
                          corner & 4 ? max.z : min.z);
        lf_vec3 d = lf_sub(p, rig->eye);
        x[corner] = lf_dot(d, rig->right);
        z[corner] = lf_dot(d, rig->forward);
        float y = lf_dot(d, rig->up), height = y - plane->ly - plane->my * z[corner];
        above = lf_max(above, height);
        below = lf_min(below, height);
        size = lf_max(size, fabsf(x[corner]) + fabsf(y) + fabsf(z[corner]));
    }
    if (above < -1e-5f * size || below > 1e-5f * size)
        return;
    for (int corner = 0; corner < 8; corner++)
        add_point(s, x[corner], z[corner]);
}

void lf_reach_whole(lf_reach *reach, const lf_rig *rig)
{
    for (int k = 0; k < LF_MAX_LANES; k++) {
        reach->first[k] = 0;
        reach->end[k] = k < rig->n_views ? rig->width : 0;
    }
    reach->any = true;
}

/* The columns of one view, widened by a pixel on either side for rounding. */
static void take_columns(lf_reach *reach, const shadow *s, int k)
{
    float width = (float)s->rig->width;
    reach->first[k] = (int)lf_min(lf_max(floorf(s->lo[k]) - 1.0f, 0.0f), width);
    reach->end[k] = (int)lf_min(lf_max(floorf(s->hi[k]) + 2.0f, 0.0f), width);
    reach->any = reach->any || reach->first[k] < reach->end[k];
}

static void add_media(shadow *s, const lf_media *media, const lf_volume *volumes,
                      const lf_row_plane *plane)
{
    for (int i = 0; i < media->n_here; i++) {
        const lf_medium *medium = &media->item[media->here[i]];
        const lf_volume *volume = &volumes[medium->volume];
        if (medium->kind == LF_MEDIUM_SLICE)
            add_slice(s, &medium->slice);
        else
            add_box(s, volume->bounds_min, volume->bounds_max, plane);
    }
}

void lf_reach_of(lf_reach *reach, const lf_scene *scene, const lf_rig *rig,
                 const lf_row_plane *plane, const lf_media *media, const lf_media *emissive)
{
    shadow s = {.rig = rig, .lens_chord = plane->lens_chord};
    for (int k = 0; k < LF_MAX_LANES; k++) {
        s.lo[k] = INFINITY;
        s.hi[k] = -INFINITY;
    }
    add_media(&s, media, scene->volumes, plane);
    add_media(&s, emissive, scene->emissive.field, plane);
    const lf_geometry *geometry = scene->geometry;
    if (geometry) {
        lf_vec3 bounds[2];
        for (int i = 0; i < 2; i++)
            bounds[i] = lf_v3((float)(geometry->bounds[i][0] - scene->origin[0]),
                              (float)(geometry->bounds[i][1] - scene->origin[1]),
                              (float)(geometry->bounds[i][2] - scene->origin[2]));
        add_box(&s, bounds[0], bounds[1], plane);
    }
    if (s.everywhere) {
        lf_reach_whole(reach, rig);
        return;
    }
    reach->any = false;
    for (int k = 0; k < LF_MAX_LANES; k++) {
        reach->first[k] = reach->end[k] = 0;
        if (k < rig->n_views && s.lo[k] <= s.hi[k])
            take_columns(reach, &s, k);
    }
}
