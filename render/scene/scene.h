/* The committed scene as the integrators see it; private to render/. Everything is in scene-local
 * coordinates: world minus `origin` (double), so that a scene a million units away loses nothing.
 * The origin is the middle of the bounding box of volumes and meshes, rounded to multiples of the
 * power of two at or above the box's longest side: 0 for scenes about the world's origin, and
 * mostly unmoved when something in the scene moves. Immutable after commit; parts are reference
 * counted so that scenes share them. */
#ifndef LF_RENDER_SCENE_H
#define LF_RENDER_SCENE_H

#include <stdatomic.h>
#include <string.h>

#include "render/scene/affine.h"
#include "render/scene/embree.h"
#include "render/scene/grid.h"
#include "render/scene/handle.h"
#include "render/scene/principled.h"
#include "render/scene/shape.h"
#include "render/scene/texture.h"
#include "render/scene/traits.h"
#include "render/scene/vec.h"
#include "render/scene/warnings.h"

/* Of what a file holds: XXH3, 128 bits as hexadecimal digits. Taken once, when something is made of
 * the file. */
typedef struct lf_digest {
    char text[33];
} lf_digest;

/* ----------------------------------------------------------------------------------- volumes -- */

#define LF_BRICK 8 /* cells along a side of a brick */
/* values along a side: the cells' corners, so that one brick answers a trilinear look-up */
#define LF_BRICK_VALUES 9
#define LF_BRICK_REACH 2 /* voxels */
#define LF_BRICK_STRIDE (LF_BRICK_VALUES * LF_BRICK_VALUES * LF_BRICK_VALUES)

/* Values of one grid, shared between scenes. Voxel centre (i, j, k), i in [0, size), carries a
 * value; a cell (i, j, k) spans the voxel centres i and i + 1. Cells start at -1 (the value outside
 * is 0), so brick b covers cells [8 b - 1, 8 b + 7) of the local grid and its value v stands for
 * voxel 8 b - 1 + v. */
typedef struct lf_grid {
    atomic_int refs;
    int size[3];       /* x, y, z voxels of the active bounding box */
    int bricks[3];     /* bricks along x, y, z: ceil((size + 1) / 8) */
    uint32_t n_bricks; /* bricks stored, without the empty brick 0 */
    uint32_t *index;   /* [bz][by][bx] number of the brick; 0 = empty */
    /* [n_bricks + 1][9 z][9 y][9 x]; brick 0 is all zero; values are finite and >= 0 */
    float *values;
    /* The same in 16 bits, in place of values, which is then NULL (lf_short_value): floats of six
     * bits of exponent and ten of mantissa, without a sign, whose bits as a float's are times
     * short_scale. */
    uint16_t *shorts;
    float short_scale;
    /* [bz][by][bx] largest value a look-up inside the brick can return, the filter's footprint
     * included */
    float *brick_max;
    /* [bz][by][bx] largest voxel within LF_BRICK_REACH of the brick; 0: nothing is near */
    float *brick_near;
    float max_value;
    /* voxel index of this box -> the file's own world space (before the scene's transform) */
    double local_to_file[3][4];
    char *key;        /* file, grid, modification time: what sharing compares */
    lf_digest digest; /* of the file */
    /* names of the file's other grids, each with a newline behind it; NULL = none */
    char *others;
    lf_grid_odd odd;
} lf_grid;

/* The value that 16 bits stand for: exact, and 0 for 0. */
static inline float lf_short_value(uint16_t bits, float scale)
{
    uint32_t wide = (uint32_t)bits << 13;
    float value;
    memcpy(&value, &wide, sizeof value);
    return value * scale;
}

/* The value of one voxel: brick times LF_BRICK_STRIDE plus its place there. */
static inline float lf_grid_stored(const lf_grid *grid, size_t place)
{
    return grid->values ? grid->values[place]
                        : lf_short_value(grid->shorts[place], grid->short_scale);
}

/* What of a phase function is another lobe than Henyey and Greenstein's first one (phase.h). */
typedef struct lf_second_lobe {
    float share;    /* 0..1; 0: there is none */
    float g, alpha; /* Draine's; alpha 0: Henyey and Greenstein's, above 0: g is, too */
} lf_second_lobe;

/* Volume space -> scene-local when the shutter opens and when it closes. In between every point of
 * the volume goes along a straight line. */
typedef struct lf_volume_motion {
    lf_affine open, close;
} lf_volume_motion;

#define LF_MAX_STEPS 64

/* A grid whose values flow while the shutter is open (grid_flow.h): what it is in the middle of
 * each of n equal parts of that time, of one size and one map. Shared as grids are. */
typedef struct lf_grid_steps {
    atomic_int refs;
    int n;
    lf_grid *grid[LF_MAX_STEPS]; /* [n] counted references; the same key for all */
    /* What of its contrast the grid loses, as values between voxels are interpolated once more: sum
     * f^2 / sum f of the grid that flows, less that of a step, in the mean over those that have
     * any. */
    float lost;
} lf_grid_steps;
lf_grid_steps *lf_grid_steps_ref(lf_grid_steps *steps);
/* Accepts NULL. */
void lf_grid_steps_unref(lf_grid_steps *steps);

typedef struct lf_volume {
    lf_volume_kind kind;
    lf_grid *grid; /* counted reference; NULL unless LF_VOLUME_GRID */
    lf_grid_steps
        *steps;   /* counted reference; NULL: its values do not flow. grid is of the middle */
    bool nearest; /* interpolation "nearest" */
    /* sigma_t per scene unit = sigma_scale * value (value is 1 inside a homogeneous shape) */
    float sigma_scale;
    float sigma_max; /* majorant of the whole volume */
    /* sigma_t of each channel over that of the largest, which is the one above; all 0: they are the
     * same (lf_volume_colour) */
    lf_vec3 colour;
    lf_vec3 albedo; /* single-scattering, 0..1 a channel … */
    /* … or a field of each channel with a grid and a place of its own, whose value stands where a
     * volume has sigma_t: [3], owned, as are their grids; NULL: none */
    struct lf_volume *albedo_fields;
    float g; /* Henyey-Greenstein, (-1, 1) */
    lf_second_lobe second;
    /* Scene-local point -> volume space (voxel index for grids: voxel centres at integers) and
     * back; rows of a 3x4 affine. */
    float to_volume[3][4], to_scene[3][4];
    lf_volume_motion *motion; /* owned; NULL: it stands still. The above are then of the opening */
    /* scene-local box outside of which sigma_t = 0 (filter footprint included), wherever it goes */
    lf_vec3 bounds_min, bounds_max;
    float voxel;      /* grids: the shortest edge of a voxel, scene units … */
    float slice_cell; /* … and what slices resolve of it (scene_commit.c) */
} lf_volume;

#define LF_EMISSION_STEPS 256

/* What a volume emits along a ray: radiance per scene unit, of the value of its field. */
typedef struct lf_volume_emission {
    int volume;      /* whose it is: index into scene->volumes */
    lf_vec3 colour;  /* of a field that is no temperature: times its value */
    float per_value; /* steps of the table per unit of value; 0: no temperature */
    float inverse;   /* 1 / the largest value */
    /* [LF_EMISSION_STEPS + 1] of a black body as hot as value i / per_value, over the fourth power
     * of that value times inverse */
    lf_vec3 table[LF_EMISSION_STEPS + 1];
} lf_volume_emission;

/* Volumes that emit, each by a field of its own beside their extinction, with its own grid and
 * place: its value stands where a volume has sigma_t (sigma_scale is 1). */
typedef struct lf_emissive_volumes {
    int n;
    lf_volume *field;
    lf_volume_emission *light; /* of field[i] */
} lf_emissive_volumes;

/* What of sigma_t is each channel's, 0..1. */
static inline lf_vec3 lf_volume_colour(const lf_volume *volume)
{
    return lf_max3(volume->colour) > 0.0f ? volume->colour : lf_v3(1.0f, 1.0f, 1.0f);
}

/* Makes a volume what it is, where it is, at a moment: 0 when the shutter opens and 1 when it
 * closes. A grid that flows is then borrowed from its steps. */
void lf_volume_move(lf_volume *volume, float time);
/* false where the way flattens it in between, or nearly so (a turn of about half a circle). */
bool lf_volume_motion_is_sound(const lf_volume_motion *motion);

/* sigma_t at a scene-local point, filter applied, 0 outside: of the largest channel. */
float lf_volume_sigma_t(const lf_volume *volume, lf_vec3 p);
/* Single-scattering albedo at a scene-local point; the first where grids say it. */
lf_vec3 lf_volume_albedo_of_fields(const lf_volume *volume, lf_vec3 p);
static inline lf_vec3 lf_volume_albedo(const lf_volume *volume, lf_vec3 p)
{
    return volume->albedo_fields ? lf_volume_albedo_of_fields(volume, p) : volume->albedo;
}
/* The value of a grid at volume-space coordinates: trilinear (voxel centres at integers), 0
 * outside. */
float lf_grid_linear(const lf_grid *grid, float x, float y, float z);
float lf_grid_nearest(const lf_grid *grid, float x, float y, float z);

/* -------------------------------------------------------------------------- surfaces, meshes -- */

#define LF_LOSS_TERMS 9

/* How much of a surface is there (glTF 2.0, section 3.9.4). */
typedef enum lf_cover { LF_COVER_OPAQUE, LF_COVER_MASK, LF_COVER_BLEND, LF_COVERS } lf_cover;

#define LF_GLASS_NODES 32

/* A picture that materials of the scene file name, ready to be looked up; shared between scenes
 * while its files stay the same (render/import/scene/scene_pictures.h). */
typedef struct lf_scene_picture {
    atomic_int refs;
    char *key;           /* of its files and of what was made of them */
    lf_digest digest[2]; /* of the files of its two parts; "" = there is none */
    lf_texels texels;
    lf_pyramid pyramid;
} lf_scene_picture;

/* Accepts NULL. */
void lf_scene_picture_unref(lf_scene_picture *picture);

/* Slots that materials of the scene file may fill: LF_SLOT_BASE to LF_SLOT_EMISSION. */
#define LF_OWN_SLOTS 4

/* What such a material looks at. */
typedef struct lf_own_textures {
    lf_textures textures;
    lf_scene_picture *picture[LF_OWN_SLOTS]; /* counted references; NULL: the slot has none */
} lf_own_textures;

/* What is made of a surface that light goes through. */
typedef struct lf_glass {
    /* Made by lf_material_prepare: the lobe through it is no delta. */
    bool is_rough;
    /* Smooth clear sheets, and nothing else: what goes straight through is a matter of how much of
     * them is met (surface_glass.h). */
    bool is_thin;
    bool is_inside; /* of a hit's own: met from within a solid (track.c) */
    /* Of a hit's own: between two media. ior, at least 1, is the one index over the other, and
     * is_inside says that the path comes from the greater (lf_glass_part). */
    bool is_parting;
    float kept[2][LF_GLASS_NODES]; /* E of rough glass, from outside and from within */
} lf_glass;

/* Grooves of a rough layered surface where it was hit (surface_texture.c): its lobe is wider along
 * them than across. Elsewhere 0, and the lobe is round. */
typedef struct lf_anisotropy {
    float alpha[2]; /* along and across */
    float along[2]; /* the direction in the frame that lf_tangents makes of ns */
} lf_anisotropy;

/* Of a principled surface: what its metal and its clear coat lose (lf_loss), the mean of what its
 * dielectric lobe leaves to what is below, of what its metal reflects, lf_loss_rest and
 * lf_loss_smooth. */
typedef struct lf_layer_energy {
    float metal_loss[LF_LOSS_TERMS], coat_loss[LF_LOSS_TERMS], mean_loss, mean_fresnel, rest,
        smooth_ior, smooth_scale;
} lf_layer_energy;

typedef enum lf_tint {
    LF_TINT_ALBEDO,
    LF_TINT_ALL,
    LF_TINT_NOTHING
} lf_tint; /* all: emission, too */

typedef struct lf_material {
    const struct lf_surface_kind *kind; /* surface.h; says what it makes of the scalars */
    LF_PRINCIPLED_MEMBERS;
    lf_tint tint;   /* what colours of vertices multiply */
    bool one_sided; /* emission leaves the front alone, where corners run counter-clockwise */
    bool is_solid;  /* what is behind is another medium of index ior; else a sheet */
    lf_cover cover; /* what becomes of alpha and of the alpha of its texture */
    /* complex index eta + i k of each channel; eta.x = 0: none, albedo says it all */
    lf_vec3 eta, k;
    const lf_textures *textures; /* borrowed from geometry or scene; NULL: none */
    lf_vec3 coat_normal;         /* of a hit's own, where it is not the base's: as brush.along */
    lf_glass glass;
    lf_anisotropy anisotropic;
    /* Made of the above by lf_material_prepare (surface.h). */
    bool has_lobe;             /* any that is not delta */
    bool has_delta;            /* one of nonzero reflectance */
    float loss[LF_LOSS_TERMS]; /* of a rough lobe: lf_loss */
    lf_vec3 rest;              /* what becomes of it: surface_energy.c */
    lf_layer_energy energy;    /* of a principled surface */
} lf_material;
/* Whether it has delta lobes that its pixels take more native samples for. What a pane reflects is
 * little, and every ray that reaches it brings it. */
static inline bool lf_has_mirror(const lf_material *m)
{
    return m->has_delta && !m->glass.is_thin;
}

/* Whether a lobe that is no delta leads through it. */
static inline bool lf_has_far_lobe(const lf_material *m)
{
    return m->glass.is_rough || m->subsurface > 0.0f;
}

/* Whether its lobes are others from within than from outside. */
static inline bool lf_is_sided(const lf_material *m)
{
    return (m->is_solid && m->glass.is_rough) || m->subsurface > 0.0f;
}

/* Of a hit's own: flesh that is met from within, whose lobe does not depend on where from. */
static inline bool lf_is_way_out(const lf_material *m)
{
    return m->glass.is_inside && m->subsurface > 0.0f;
}

/* What rays meet by chance, and views see through. */
static inline bool lf_is_alpha_surface(const lf_material *m)
{
    return m->cover != LF_COVER_OPAQUE || m->glass.is_thin;
}
#define LF_ALPHA_MIN 1e-3f
/* Its root and a little more: what textures cannot go below. */
#define LF_LEAST_ROUGHNESS 0.0317f

/* Scene-local; min > max when there is nothing. */
typedef struct lf_box {
    lf_vec3 min, max;
} lf_box;

/* Where a mesh is when the shutter closes: arrays as lf_mesh has them for its opening. In between
 * every vertex goes along a straight line. vertices NULL: it stands still, the others are NULL. */
typedef struct lf_mesh_close {
    const float *vertices, *normals, *tangents;
} lf_mesh_close;

/* What the scene says of whether a mesh is a ground, which a fit does not frame. */
typedef enum lf_ground_word { LF_GROUND_GUESSED, LF_GROUND_SAID, LF_GROUND_DENIED } lf_ground_word;

typedef struct lf_mesh {
    unsigned geom_id; /* Embree geometry */
    int n_vertices, n_triangles;
    /* [n_vertices][3] scene-local (padded by one float for Embree) */
    const float *vertices;
    const uint32_t *triangles; /* [n_triangles][3] */
    const float *normals;      /* [n_vertices][3] unit, or NULL: flat shading */
    /* [n_triangles] index into scene->materials, or NULL: `material` for all */
    const uint16_t *triangle_material;
    uint16_t material;
    lf_box box;    /* of the triangles, wherever they go */
    bool hidden;   /* rays of the camera pass through it */
    bool catcher;  /* hidden, but for what it gets of shadows (catcher.h) */
    bool reflects; /* a catcher that also tells what it reflects */
    bool lamp;     /* made of one of the scene's lights */
    lf_ground_word ground;
    /* lf_mesh_data's, each NULL where no material wants it */
    const float *uvs, *colours, *tangents;
    lf_mesh_close close;
    const struct lf_instances
        *instances; /* many places (instances.h); NULL: where its vertices are */
} lf_mesh;

static inline lf_vec3 lf_mesh_vertex(const lf_mesh *mesh, uint32_t vertex)
{
    const float *v = mesh->vertices + 3 * (size_t)vertex;
    return lf_v3(v[0], v[1], v[2]);
}

/* The material of a triangle, in the scene. */
static inline uint16_t lf_mesh_material(const lf_mesh *mesh, uint32_t triangle)
{
    return mesh->triangle_material ? mesh->triangle_material[triangle] : mesh->material;
}

/* The point a + u (b - a) + v (c - a) of a triangle, off its plane by no more than the rounding of
 * the point's own coordinates. */
static inline lf_vec3 lf_mesh_point(const lf_mesh *mesh, uint32_t triangle, float u, float v)
{
    const uint32_t *corner = mesh->triangles + 3 * (size_t)triangle;
    const float *a = mesh->vertices + 3 * (size_t)corner[0],
                *b = mesh->vertices + 3 * (size_t)corner[1],
                *c = mesh->vertices + 3 * (size_t)corner[2];
    double p[3];
    for (int i = 0; i < 3; i++)
        p[i] = (double)a[i] + (double)u * ((double)b[i] - (double)a[i]) +
               (double)v * ((double)c[i] - (double)a[i]);
    return lf_v3((float)p[0], (float)p[1], (float)p[2]);
}

/* ------------------------------------------------------------------------------------ lights -- */

/* A latitude-longitude picture of radiance with its sampling tables; shared between scenes. Row 0
 * looks up (+y); column 0 .. width-1 runs phi from 0 to 2 pi, direction (sin(theta) cos(phi),
 * cos(theta), sin(theta) sin(phi)). */
typedef struct lf_environment {
    atomic_int refs;
    int width, height;
    float *rgb;         /* [height][width][3] */
    float *marginal;    /* [height + 1] cumulative over rows, 0..1 */
    float *conditional; /* [height][width + 1] cumulative along each row, 0..1 */
    float *pdf;         /* [height][width] per unit solid angle */
    float above_mean;   /* what is drawn from: radiance above the mean, mean over the sphere */
    char *key;
    lf_digest digest;     /* of the file */
    lf_warnings warnings; /* what the file says and the picture lacks */
} lf_environment;
/* Accepts NULL. */
void lf_environment_unref(lf_environment *environment);

typedef struct lf_light {
    const struct lf_light_kind *kind; /* light_kind.h; says which of the fields below it uses */
    /* probability that light sampling picks this light; 0 = never sampled (constant skies) */
    float select;
    /* sum of select up to and with this light; 1 from the last that can be picked on */
    float cumulative;
    lf_vec3 radiance;            /* what rays that meet it find; times the environment's picture */
    lf_environment *environment; /* counted reference; NULL = constant */
    float to_environment[3][3];  /* scene direction -> the picture's frame */
    lf_vec3 direction;           /* unit, in which light travels */
    lf_vec3 irradiance;          /* on a plane across direction */
    float versine;               /* 1 - cos of half the angle about direction */
    lf_vec3 position, intensity; /* scene-local, W sr^-1 */
    bool hidden;                 /* the camera does not see it; everything else does */
    /* What one kind alone keeps: a struct each. */
    union {
        struct {
            float inner; /* the versine at which the fall to the rim begins */
        } spot;
    } own;
    int mesh;               /* index into scene->meshes */
    uint16_t mesh_material; /* the emitting material (triangles of it only) */
    int n_triangles;        /* emitting triangles … */
    uint32_t *triangle;     /* … their numbers */
    /* [n_triangles + 1] cumulative area, 0..1: a float's steps would show in small triangles */
    double *area_cdf;
    float area;       /* total */
    bool has_picture; /* its emission is textured: radiance is the mean, area_cdf goes by it */
    bool one_sided;   /* shines to the front of its triangles alone */
    struct lf_light_node *tree; /* one-sided ones of many triangles; else NULL (light_tree.h) */
    int equiangular;            /* lights at a distance: 1 + its place in scene->glows; 0 = none */
    struct lf_light_motion *motion; /* where its numbers change (light_kind.h); NULL: they do not */
} lf_light;

/* What the camera sees where it meets nothing, in place of the lights at infinity: radiance at the
 * upper and lower edge of the window, linear in its height between them. */
typedef struct lf_backdrop {
    bool given;
    lf_vec3 top, bottom;
} lf_backdrop;

/* height: from the window's upper edge, 0, to the lower one, 1. */
static inline lf_vec3 lf_backdrop_at(const lf_backdrop *backdrop, float height)
{
    return lf_madd(backdrop->top, height, lf_sub(backdrop->bottom, backdrop->top));
}

/* Releases what the light owns; leaves it zeroed. Accepts one that is all zero. */
void lf_light_finish(lf_light *light);

/* A light in media (equiangular.h). */
typedef struct lf_equiangular_light {
    int light;
    lf_vec3 middle;
    float radius; /* how far the light reaches from its middle; 0 for points */
    float reach;  /* and how far the farthest point of the volumes is */
    float share;  /* of the light's probability to be picked in that of all glows */
} lf_equiangular_light;
#define LF_MAX_EQUIANGULAR 64

/* All of them. */
typedef struct lf_equiangular_lights {
    int n;
    lf_equiangular_light item[LF_MAX_EQUIANGULAR];
    lf_box media; /* of all volumes */
} lf_equiangular_lights;

/* ------------------------------------------------------------------------------------- scene -- */

/* A document of so many bytes or more takes a hundred megabytes when it is gone, unless they are
 * given back. */
#define LF_SCENE_LARGE_BYTES ((size_t)1 << 20)

/* Where it was read. */
typedef struct lf_scene_file {
    char *folder, *where;
    json_t *included; /* names of files that were merged into it (scene_include.h) */
    /* the scene's json as it is in its frame: without keys (keyframes.h) */
    json_t *still;
    size_t bytes; /* of the document (lf_json_least_bytes) */
    int frame;
    double rate;           /* frames a second */
    bool has_frames;       /* they differ */
    lf_view_camera *views; /* what the camera's list is; NULL: it has none */
    json_t *placing;       /* lf_place_grounds' patch; NULL: the document says where all stands */
} lf_scene_file;

/* Two triangles of different solids of glass that lie in one plane. */
typedef struct lf_touching {
    int mesh;
    uint32_t triangle;
    int other;
    uint32_t other_triangle;
} lf_touching;

/* Solid glass that stands in solid glass (nest.h); all zero where there is none. Owned. */
typedef struct lf_nesting {
    /* [n_meshes][n_materials]: which solid such triangles belong to; -1: they part glass from air,
     * or nothing from nothing */
    int16_t *solids;
    /* [n_touching] of its solids, by mesh and triangle; each pair both ways */
    lf_touching *touching;
    int n_touching;
} lf_nesting;

struct lf_scene {
    atomic_int refs;
    json_t *json;
    json_t *subject; /* the document as far as films are concerned (scene_subject.h) */
    lf_scene_file file;
    double origin[3]; /* world = local + origin */
    lf_camera camera; /* world coordinates */
    lf_film_settings film;
    int max_depth; /* path vertices; 0 = LF_DEFAULT_MAX_DEPTH */

    int n_volumes, n_meshes, n_materials, n_lights;
    lf_volume *volumes;
    lf_emissive_volumes emissive; /* what they emit */
    lf_mesh *meshes;              /* indexed by Embree's geomID */
    lf_material *materials; /* the files' own, then the scene's, then those of lights with faces */
    /* in the order of their kinds after lf_lights_commit: those at infinity first */
    lf_light *lights;
    int n_lights_infinite; /* set by lf_lights_commit */
    lf_backdrop backdrop;
    lf_equiangular_lights equiangular; /* lights in media */
    RTCScene embree; /* NULL without meshes (then no Embree device exists either) */
    float offset;    /* lf_geometry.offset; 0 without meshes */
    /* owner of the meshes' arrays and of embree, shared between scenes; NULL without meshes */
    struct lf_geometry *geometry;
    lf_box bounds; /* of volumes and meshes */

    lf_warnings warnings; /* of its parts and of the whole */

    /* What integrators are specialised by. */
    lf_traits traits;
    lf_nesting nested;
    /* [n_own_textures] owned: of the materials of the scene file, in its order */
    lf_own_textures *own_textures;
    int n_own_textures;
};
#define LF_DEFAULT_MAX_DEPTH 1024

/* Whether it has any of these traits. */
static inline bool lf_has(const lf_scene *scene, lf_traits any)
{
    return scene->traits & any;
}

/* Path vertices: what is wanted, else (0) what the scene says, else the default. */
static inline int lf_max_depth(const lf_scene *scene, int wanted)
{
    int own = scene->max_depth > 0 ? scene->max_depth : LF_DEFAULT_MAX_DEPTH;
    return wanted > 0 ? wanted : own;
}

#define LF_MAX_VOLUMES 16

#endif
