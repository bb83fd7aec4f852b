/* The participating media on one row's plane: interpolated grids as slices; voxels with edges and
 * homogeneous shapes exactly. Several media are independent processes: optical depths add up, and a
 * collision belongs to the medium in which it happened. Private to render/.
 * docs/developer/estimators.md, "6. Optical depth to all views". */
#ifndef LF_RENDER_MEDIA_H
#define LF_RENDER_MEDIA_H

#include "render/plane/kernel.h"
#include "render/plane/voxels.h"
#include "render/transport/path/track.h"

typedef enum lf_medium_kind { LF_MEDIUM_BODY, LF_MEDIUM_SLICE, LF_MEDIUM_VOXELS } lf_medium_kind;

/* The volumes of a list that the rig's rays can meet; constant for a scene and rig. */
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
    lf_voxels voxels; /* LF_MEDIUM_VOXELS: grids without interpolation */
    lf_body body;     /* LF_MEDIUM_BODY: shapes */
} lf_medium;

/* One worker's media of the current row. */
typedef struct lf_media {
    int n;                    /* media with memory */
    int n_here;               /* number of media on this row's plane */
    int here[LF_MAX_VOLUMES]; /* their indices, in the scene's order */
    lf_medium item[LF_MAX_VOLUMES];
} lf_media;

/* Rays X(Z) = x0[k] + slope[k] Z of a row's plane, z_from < Z < z_end[k], in the order that
 * lf_kernels.march requires. */
typedef struct lf_rays {
    const lf_scene *scene;
    const lf_rig *rig;
    const lf_row_plane *plane;
    const lf_kernels *kernels;
    int n; /* a multiple of LF_LANES */
    const float *x0, *slope, *z_end;
    float z_from;  /* nearer parts are ignored */
    bool channels; /* depths per channel, not only of the largest channel */
} lf_rays;

/* Length of ray k per unit of Z. */
static inline float lf_rays_length(const lf_rays *rays, int k)
{
    return sqrtf(1.0f + rays->plane->my * rays->plane->my + rays->slope[k] * rays->slope[k]);
}

/* A base ray in the row's plane. */
typedef struct lf_media_ray {
    float x0, slope, length; /* X(Z) = x0 + slope Z; length in scene units per unit of Z */
    float z_end;             /* INFINITY if no surface ends it */
} lf_media_ray;

typedef struct lf_collision {
    float z;             /* INFINITY: no collision */
    int medium;          /* index into lf_media.item */
    float forced_weight; /* 1, or the probability q of any collision if it was forced */
} lf_collision;

/* volumes: the scene's, or their emission, whose value then takes the role of sigma_t. rigs as in
 * lf_slice_frame_init. */
void lf_media_frame_init(lf_media_frame *frame, const lf_volume *volumes, int n, const lf_rig *rigs,
                         int n_rigs);

/* media must be zeroed. LF_E_NOMEM; release with lf_media_finish, also after a failure. */
LF_NODISCARD lf_status lf_media_init(lf_media *media, const lf_media_frame *frame);
void lf_media_finish(lf_media *media);

/* A row's plane with the parameters for cutting volumes. */
typedef struct lf_media_plane {
    const lf_rig *rig;
    const lf_row_plane *plane;
    const lf_kernels *kernels;
    float phase[2]; /* in [0,1), offsets of the slices' samples and planes */
} lf_media_plane;

/* Cuts the volumes. Adds the number of look-ups to *lookups. */
void lf_media_cut(lf_media *media, const lf_media_frame *frame, const lf_volume *volumes,
                  const lf_media_plane *at, int64_t *lookups);

/* The first collision of a base ray in the extinction of one channel (0 .. 2), u in [0,1) (further
 * numbers from the tracer). forced: the ray collides with certainty if its optical depth is above
 * 0. */
lf_collision lf_media_collide(const lf_media *media, const lf_media_ray *ray, int channel, float u,
                              bool forced, lf_tracer *tracer);

/* Mean and standard deviation of nearness (lf_nearness) at the first collision; its probability
 * follows from the depths. */
typedef struct lf_media_moments {
    float distance; /* D and the lane of the first ray; the caller sets both. */
    int first;
    float met[LF_MAX_LANES]; /* approximate probability */
    float nearness[LF_MAX_LANES], spread[LF_MAX_LANES];
} lf_media_moments;

/* lf_media_depths without a collision, with bitwise the same tau, and the moments of rays with
 * these lengths per unit of Z, into out from lane out->first on. Approximate in three respects: exp
 * in steps, the second order of shapes, and media that overlap along a ray. Of two such media, each
 * counts as partly in front of and partly behind the other. */
void lf_media_moments_of(const lf_media *media, const lf_rays *rays, const float *length,
                         float *tau, lf_media_moments *out);

/* Optical depths per unit of Z of rays from the cameras (z_from 0) through all media, in their
 * largest channels. If collided >= 0, also density[rays->n]: up to a common factor, the collision
 * density of that medium at z_end. */
void lf_media_depths(const lf_media *media, const lf_rays *rays, float *tau, int collided,
                     float *density);

/* lf_media_depths for each channel, tau[c * rays->n + k], c = 0 .. 2; density is of the medium's
 * largest channel. */
void lf_media_depths_of_channels(const lf_media *media, const lf_rays *rays, float *tau,
                                 int collided, float *density);

#endif
