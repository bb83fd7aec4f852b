#include "render/rows/equiangular_row.h"

/* Points per base sample that can meet a medium or mesh. */
#define SHARE 0.25f

static void init_plane(lf_equiangular_plane *out, const lf_equiangular_light *equiangular,
                       const lf_rig *rig, const lf_row_plane *plane, float my2)
{
    lf_vec3 d = lf_sub(equiangular->middle, rig->eye);
    float y = lf_dot(d, rig->up) - plane->ly, z = lf_dot(d, rig->forward),
          above = y - plane->my * z, least = 1e-6f * equiangular->reach;
    out->x = lf_dot(d, rig->right);
    out->z = (z + plane->my * y) / my2;
    out->e2 = above * above / my2 + equiangular->radius * equiangular->radius + least * least;
    out->reach2 = equiangular->reach * equiangular->reach;
    out->log_range = log1pf(out->reach2 / out->e2);
}

void lf_equiangular_row_init(lf_equiangular_row *row, const lf_scene *scene, const lf_rig *rig,
                             const lf_row_plane *plane, const lf_media *media, float base,
                             float targets)
{
    row->n = base > 0.0f ? scene->equiangular.n : 0;
    row->my2 = 1.0f + plane->my * plane->my;
    row->rig = rig;
    row->g = 0.0f;
    for (int i = 0; i < media->n_here; i++) {
        const lf_volume *volume = &scene->volumes[media->item[media->here[i]].volume];
        const lf_second_lobe *second = &volume->second;
        row->g = fabsf(volume->g) > fabsf(row->g) ? volume->g : row->g;
        if (second->share > 0.0f && fabsf(second->g) > fabsf(row->g))
            row->g = second->g;
    }
    for (int i = 0; i < row->n; i++) {
        lf_equiangular_plane *p = &row->plane[i];
        init_plane(p, &scene->equiangular.item[i], rig, plane, row->my2);
        p->points = SHARE * base * scene->equiangular.item[i].share;
        p->density = p->points * sqrtf(row->my2) / (targets * LF_PI * p->log_range);
    }
}

/* The direction from a light's foot in which a view sees most light, (x, true depth in the plane);
 * arbitrary if the foot is at the camera. */
static void axis_of(const lf_equiangular_row *row, const lf_equiangular_plane *p, int view,
                    float *out_x, float *out_z)
{
    float x = p->x - row->rig->b[view], z = p->z * sqrtf(row->my2), distance = sqrtf(x * x + z * z);
    float over = distance > 0.0f ? copysignf(1.0f / distance, -row->g) : 0.0f;
    *out_x = x * over;
    *out_z = distance > 0.0f ? z * over : 1.0f;
}

void lf_equiangular_row_draw(const lf_equiangular_row *row, int equiangular, int view,
                             const float u[3], float *out_x, float *out_z)
{
    const lf_equiangular_plane *p = &row->plane[equiangular];
    float rho = sqrtf(p->e2 * expm1f(u[0] * p->log_range)), cosine = cosf(2.0f * LF_PI * u[1]),
          sine = sinf(2.0f * LF_PI * u[1]);
    if (row->g != 0.0f && u[2] < 0.5f) {
        float a = fabsf(row->g), t = (1.0f - a) / (1.0f + a) * tanf(LF_PI * (u[1] - 0.5f)), x, z;
        float c = (1.0f - t * t) / (1.0f + t * t), s = 2.0f * t / (1.0f + t * t);
        axis_of(row, p, view, &x, &z);
        cosine = c * x - s * z;
        sine = c * z + s * x;
    }
    *out_x = p->x + rho * cosine;
    *out_z = p->z + rho * sine / sqrtf(row->my2);
}

/* The density of the angle relative to the uniform density; (x, z) is the unit vector from the
 * foot. */
static float angular(const lf_equiangular_row *row, const lf_equiangular_plane *p, int view,
                     float x, float z)
{
    float a = fabsf(row->g), sum = 0.0f, cauchy[LF_MAX_LANES];
    int first = view < 0 ? 0 : view, end = view < 0 ? row->rig->n_views : view + 1;
    if (row->g == 0.0f)
        return 1.0f;
    for (int k = first; k < end; k++) {
        float ax, az;
        axis_of(row, p, k, &ax, &az);
        cauchy[k] = (1.0f - a) * (1.0f + a) /
                    ((1.0f - a) * (1.0f - a) + a * ((x - ax) * (x - ax) + (z - az) * (z - az)));
    }
    for (int k = first; k < end; k++)
        sum += cauchy[k];
    return 0.5f + 0.5f * sum / (float)(end - first);
}

float lf_equiangular_row_ratio(const lf_equiangular_row *row, const lf_light *light, float x,
                               float z, int view, double density)
{
    if (light->equiangular == 0 || light->equiangular > row->n)
        return 0.0f;
    const lf_equiangular_plane *p = &row->plane[light->equiangular - 1];
    float dx = x - p->x, dz = sqrtf(row->my2) * (z - p->z), rho2 = dx * dx + dz * dz;
    if (rho2 > p->reach2)
        return 0.0f;
    float over = rho2 > 0.0f ? 1.0f / sqrtf(rho2) : 0.0f,
          points = p->density * angular(row, p, view, dx * over, dz * over);
    /* c_k D_k of one view is dx^-1 Z^-2 D times the density of its samples in (X, Z), but the
     * density of the points here is absolute. */
    float jacobian = row->rig->dx * z * z / row->rig->distance;
    return (float)((double)(points * jacobian / (rho2 + p->e2)) /
                   (density * (double)light->select));
}
