#include "render/plane/correction.h"

bool lf_correction_needed(const lf_media *media)
{
    bool needed = false;
    for (int i = 0; i < media->n_here; i++)
        needed = needed || media->item[media->here[i]].kind == LF_MEDIUM_SLICE;
    return needed;
}

/* How dense the points are. */
typedef struct field {
    float dense; /* per unit of Z, in units of rough */
    float least; /* minimum, unless the medium is empty */
    float z_end; /* of the longest ray */
} field;

static int tile_of(const lf_slice *slice, float x)
{
    float cell = lf_min(lf_max((x - slice->x_min) * slice->inv_dx, 0.0f), (float)(slice->nx - 1));
    return (int)cell / slice->tile_cells_x;
}

/* The roughest tile that the fan meets between the planes around a depth, whose samples define the
 * slice there. */
static float roughest(const lf_slice *slice, const lf_rays *rays, int row, float z)
{
    int n = rays->n - 1;
    float z0 = z - slice->dz, z1 = z + slice->dz, most = 0.0f;
    float a = rays->x0[0] + rays->slope[0] * z0, b = rays->x0[0] + rays->slope[0] * z1;
    float c = rays->x0[n] + rays->slope[n] * z0, d = rays->x0[n] + rays->slope[n] * z1;
    int from = tile_of(slice, lf_min(lf_min(a, b), lf_min(c, d))),
        to = tile_of(slice, lf_max(lf_max(a, b), lf_max(c, d)));
    for (int tile = from; tile <= to; tile++)
        most = lf_max(most, slice->rough[row * slice->tiles_x + tile]);
    return most;
}

static float rate_of(const field *f, float rough)
{
    return rough > 0.0f ? lf_max(f->dense * rough, f->least) : 0.0f;
}

/* One Poisson process of depths for the whole fan, with the density for the roughest tile that it
 * meets at a depth. It is thinned from the density for the roughest tile of the row. */
static void multiply(const lf_slice *slice, const float colour[3], const lf_volume *volume,
                     const lf_rays *rays, const field *f, lf_tracer *tracer, float *factor)
{
    float depth = lf_rng_exponential(tracer), thickness = (float)slice->tile_cells_z * slice->dz;
    lf_probe probe = {
        .slice = slice, .volume = volume, .my2 = 1.0f + rays->plane->my * rays->plane->my};
    for (int row = 0; row < slice->tiles_z; row++) {
        float z = slice->z0 - slice->dz + (float)row * thickness,
              end = lf_min(z + thickness, f->z_end);
        z = lf_max(z, rays->z_from);
        if (!(z < end))
            continue;
        float most = rate_of(f, slice->roughest[row]), room;
        for (; depth < (room = most * (end - z)); depth = lf_rng_exponential(tracer)) {
            z += depth / most;
            float rate = rate_of(f, roughest(slice, rays, row, z));
            if (lf_rng_fine(tracer) * most >= rate)
                continue;
            probe.z = z;
            probe.line = lf_slice_line(volume, rays->rig, rays->plane, z);
            for (int c = 0; c < (rays->channels ? 3 : 1); c++) {
                probe.inverse = (rays->channels ? colour[c] : 1.0f) / rate;
                rays->kernels->compare(&probe, rays->n, rays->x0, rays->slope, rays->z_end,
                                       factor + c * rays->n);
            }
            tracer->lookups += rays->n;
        }
        depth -= room;
    }
}

/* Any density is unbiased. This limits the number of points: a collision close in front of one
 * camera is seen by the others almost along their line, through very many cells. */
static void bound(field *f, const lf_slice *slice)
{
    const float most_points = 1024.0f;
    float rough = 0.0f, end = slice->z0 + (float)slice->nz * slice->dz;
    for (int row = 0; row < slice->tiles_z; row++)
        rough = lf_max(rough, slice->roughest[row]);
    float points = f->dense * rough * lf_min(end, f->z_end);
    if (points > most_points)
        f->dense *= most_points / points;
}

/* If there are so many points that their product is not finite, the transmittance is 0. */
static void drop_nonfinite(lf_tracer *tracer, int n, float *factor)
{
    for (int k = 0; k < n; k++) {
        bool sound = isfinite(factor[k]);
        tracer->nonfinite += !sound;
        factor[k] = sound ? factor[k] : 0.0f;
    }
}

void lf_correction_transmittance(const lf_media *media, const lf_rays *rays, float dense,
                                 float least, lf_tracer *tracer, float *factor)
{
    float steepest = lf_max(fabsf(rays->slope[0]), fabsf(rays->slope[rays->n - 1])), z_end = 0.0f;
    float longest = sqrtf(1.0f + steepest * steepest + rays->plane->my * rays->plane->my);
    for (int k = 0; k < rays->n; k++)
        z_end = lf_max(z_end, rays->z_end[k]);
    for (int i = 0; i < media->n_here; i++) {
        const lf_medium *medium = &media->item[media->here[i]];
        if (medium->kind != LF_MEDIUM_SLICE)
            continue;
        float occupied = (float)(medium->slice.last - medium->slice.first + 2) * medium->slice.dz;
        /* Between planes a ray that crosses several cells is further from the grid than what
         * samples side by side show. */
        float cells = lf_max(1.0f, steepest * medium->slice.dz * medium->slice.inv_dx);
        field f = {dense * longest * cells * cells, least / occupied, z_end};
        bound(&f, &medium->slice);
        multiply(&medium->slice, medium->colour, &rays->scene->volumes[medium->volume], rays, &f,
                 tracer, factor);
        drop_nonfinite(tracer, rays->channels ? 3 * rays->n : rays->n, factor);
    }
}

float lf_correction_density(const lf_media *media, int medium, const lf_scene *scene, lf_vec3 p,
                            lf_tracer *tracer)
{
    tracer->lookups++;
    return lf_volume_sigma_t(&scene->volumes[media->item[medium].volume], p);
}
