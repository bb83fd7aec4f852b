/* The participating media on one row's plane: interpolated grids as slices, voxels with edges and
 * homogeneous shapes exactly. Several media are independent processes: optical depths add up, and a
 * collision belongs to the medium in which it happened; private to render/.
 * docs/developer/estimators.md, "6. Optical depth to all views". */
#ifndef LF_RENDER_MEDIA_H
#define LF_RENDER_MEDIA_H

#include "render/plane/kernel.h"
#include "render/plane/voxels.h"
#include "render/transport/path/track.h"

typedef enum lf_medium_kind { LF_MEDIUM_BODY, LF_MEDIUM_SLICE, LF_MEDIUM_VOXELS } lf_medium_kind;

/* The volumes of a list that the rig's rays can meet: fixed for a scene and rig. */
typedef struct lf_media_frame {
    int n;
    struct {
        int volume; /* index into the list */
        lf_medium_kind kind;
        lf_slice_frame slice; /* LF_MEDIUM_SLICE */
    } item[LF_MAX_VOLUMES];
} lf_media_frame;

typedef struct lf_medium {
    int volume;
    lf_medium_kind kind;
    float colour[3];  /* lf_volume_colour */
    lf_slice slice;   /* LF_MEDIUM_SLICE: interpolated grids */
    lf_voxels voxels; /* LF_MEDIUM_VOXELS: grids that are not */
    lf_body body;     /* LF_MEDIUM_BODY: shapes */
} lf_medium;

/* One worker's media of the row in work. */
typedef struct lf_media {
    int n;                    /* media with memory */
    int n_here;               /* of them on this row's plane … */
    int here[LF_MAX_VOLUMES]; /* … these, in the scene's order */
    lf_medium item[LF_MAX_VOLUMES];
} lf_media;

/* Rays X(Z) = x0[k] + slope[k] Z of a row's plane, z_from < Z < z_end[k], in the order that
 * lf_kernels.march wants. */
typedef struct lf_rays {
    const lf_scene *scene;
    const lf_rig *rig;
    const lf_row_plane *plane;
    const lf_kernels *kernels;
    int n; /* a multiple of LF_LANES */
    const float *x0, *slope, *z_end;
    float z_from;  /* what lies before it is left out */
    bool channels; /* of each channel, not of the largest alone */
} lf_rays;

/* Of one of them, per unit of Z. */
static inline float lf_rays_length(const lf_rays *rays, int k)
{
    return sqrtf(1.0f + rays->plane->my * rays->plane->my + rays->slope[k] * rays->slope[k]);
}

/* A base ray in the row's plane. */
typedef struct lf_media_ray {
    float x0, slope, length; /* X(Z) = x0 + slope Z; scene units per unit of Z */
    float z_end;             /* INFINITY when no surface ends it */
} lf_media_ray;

typedef struct lf_collision {
    float z;             /* INFINITY: the ray goes through */
    int medium;          /* index into lf_media.item */
    float forced_weight; /* 1, or the probability q of any collision when it was forced */
} lf_collision;

/* volumes: the scene's, or what they emit (its flames), whose value is then what stands for sigma_t
 * here. rigs as in lf_slice_frame_init. */
void lf_media_frame_init(lf_media_frame *frame, const lf_volume *volumes, int n, const lf_rig *rigs,
                         int n_rigs);

/* media must be zeroed. LF_E_NOMEM; release with lf_media_finish, also after a failure. */
LF_NODISCARD lf_status lf_media_init(lf_media *media, const lf_media_frame *frame);
void lf_media_finish(lf_media *media);

/* A row's plane, as volumes are cut with it. */
typedef struct lf_media_plane {
    const lf_rig *rig;
    const lf_row_plane *plane;
    const lf_kernels *kernels;
    float phase[2]; /* in [0,1), moves the slices' samples and planes */
} lf_media_plane;

/* Cuts the volumes. Adds the look-ups made to *lookups. */
void lf_media_cut(lf_media *media, const lf_media_frame *frame, const lf_volume *volumes,
                  const lf_media_plane *at, int64_t *lookups);

/* The first collision of a base ray in the extinction of one channel (0 .. 2), u in [0,1) (further
 * numbers from the tracer). forced: with certainty where there is anything to collide with. */
lf_collision lf_media_collide(const lf_media *media, const lf_media_ray *ray, int channel, float u,
                              bool forced, lf_tracer *tracer);

/* Where rays collide first, if they do: mean and standard deviation of nearness (lf_nearness); the
 * probability is that of the depths. */
typedef struct lf_media_moments {
    float distance; /* D, and the lane of the first ray: to be set by who asks */
    int first;
    float met[LF_MAX_LANES]; /* about the probability */
    float nearness[LF_MAX_LANES], spread[LF_MAX_LANES];
} lf_media_moments;

/* lf_media_depths without a collision, the same tau to the bit, and the moments of rays of these
 * lengths per unit of Z, into out from lane out->first on. Exact but for exp in steps, the shapes'
 * own second order and media that reach into each other along a ray, which count as partly before
 * and partly behind. */
void lf_media_moments_of(const lf_media *media, const lf_rays *rays, const float *length,
                         float *tau, lf_media_moments *out);

/* Optical depths per unit of Z of rays from the cameras (z_from 0) through all media, of their
 * largest channels; with collided >= 0 also density[rays->n], up to a common factor the collision
 * density of that medium at z_end. */
void lf_media_depths(const lf_media *media, const lf_rays *rays, float *tau, int collided,
                     float *density);

/* The same for each channel, tau[c * rays->n + k], c = 0 .. 2; density is that of the medium's
 * largest channel. */
void lf_media_depths_of_channels(const lf_media *media, const lf_rays *rays, float *tau,
                                 int collided, float *density);

#endif
