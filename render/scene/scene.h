/* The committed scene as the integrators see it; private to render/. Everything is in scene-local
 * coordinates: world minus `origin` (double), so that a scene a million units from the world's
 * origin loses no precision. The origin is the middle of the bounding box of volumes and meshes,
 * rounded to multiples of the power of two at or above the box's longest side. It is 0 for scenes
 * around the world's origin, and rarely changes when an object moves. Immutable after commit; parts
 * are reference counted so that scenes share them. */
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

/* Hash of a file's content: XXH3, 128 bits as hexadecimal digits. Computed once, when the file is
 * loaded. */
typedef struct lf_digest {
    char text[33];
} lf_digest;

/* ----------------------------------------------------------------------------------- volumes -- */

#define LF_BRICK 8 /* cells along a side of a brick */
/* values along a side: the cells' corners, so that one brick answers a trilinear look-up */
#define LF_BRICK_VALUES 9
#define LF_BRICK_REACH 2 /* voxels */
#define LF_BRICK_STRIDE (LF_BRICK_VALUES * LF_BRICK_VALUES * LF_BRICK_VALUES)

/* Values of one grid, shared between scenes. Voxel centre (i, j, k), i in [0, size), has a value; a
 * cell (i, j, k) spans the voxel centres i and i + 1. Cells start at -1 (the value outside is 0).
 * So brick b covers cells [8 b - 1, 8 b + 7) of the local grid, and its value v is voxel 8 b - 1 +
 * v. */
typedef struct lf_grid {
    atomic_int refs;
    int size[3];       /* x, y, z voxels of the active bounding box */
    int bricks[3];     /* bricks along x, y, z: ceil((size + 1) / 8) */
    uint32_t n_bricks; /* bricks stored, without the empty brick 0 */
    uint32_t *index;   /* [bz][by][bx] number of the brick; 0 = empty */
    /* [n_bricks + 1][9 z][9 y][9 x]; brick 0 is all zero; values are finite and >= 0 */
    float *values;
    /* The values in 16 bits; values is then NULL (lf_short_value). These are floats without a sign,
     * with six bits of exponent and ten of mantissa. Decoded as float bits and multiplied by
     * short_scale they give the value. */
    uint16_t *shorts;
    float short_scale;
    /* [bz][by][bx] largest value that a look-up inside the brick can return, including the filter's
     * footprint */
    float *brick_max;
    /* [bz][by][bx] largest voxel within LF_BRICK_REACH of the brick; 0: all near voxels are 0 */
    float *brick_near;
    float max_value;
    /* voxel index of this box -> the file's own world space (before the scene's transform) */
    double local_to_file[3][4];
    char *key;        /* file, grid, modification time: identifies the grid for sharing */
    lf_digest digest; /* of the file */
    /* names of the file's other grids, each followed by a newline; NULL = none */
    char *others;
    lf_grid_odd odd;
} lf_grid;

/* Decodes a 16-bit value: exact, and 0 for 0. */
static inline float lf_short_value(uint16_t bits, float scale)
{
    uint32_t wide = (uint32_t)bits << 13;
    float value;
    memcpy(&value, &wide, sizeof value);
    return value * scale;
}

/* The value of one voxel; place: brick times LF_BRICK_STRIDE plus its position in the brick. */
static inline float lf_grid_stored(const lf_grid *grid, size_t place)
{
    return grid->values ? grid->values[place]
                        : lf_short_value(grid->shorts[place], grid->short_scale);
}

/* The second lobe of a phase function, besides the first Henyey-Greenstein lobe (phase.h). */
typedef struct lf_second_lobe {
    float share; /* 0..1; 0: no second lobe */
    /* Draine's parameters; alpha 0: Henyey-Greenstein; alpha above 0: g is above 0, too */
    float g, alpha;
} lf_second_lobe;

/* Volume space -> scene-local when the shutter opens and when it closes. Between, every point of
 * the volume moves along a straight line. */
typedef struct lf_volume_motion {
    lf_affine open, close;
} lf_volume_motion;

#define LF_MAX_STEPS 64

/* A grid that is advected while the shutter is open (grid_flow.h): the grid at the middle of each
 * of n equal parts of that time, all of one size and map. Shared as grids are. */
typedef struct lf_grid_steps {
    atomic_int refs;
    int n;
    lf_grid *grid[LF_MAX_STEPS]; /* [n] counted references; all have the same key */
    /* loss of contrast by interpolating once more between voxels: sum f^2 / sum f of the source
     * grid minus the same for a step, mean over the steps that are not empty */
    float lost;
} lf_grid_steps;
lf_grid_steps *lf_grid_steps_ref(lf_grid_steps *steps);
/* Accepts NULL. */
void lf_grid_steps_unref(lf_grid_steps *steps);

typedef struct lf_volume {
    lf_volume_kind kind;
    lf_grid *grid; /* counted reference; NULL unless LF_VOLUME_GRID */
    lf_grid_steps
        *steps;   /* counted reference; NULL: the grid is not advected. grid is the middle step */
    bool nearest; /* interpolation "nearest" */
    /* sigma_t per scene unit = sigma_scale * value (value is 1 inside a homogeneous shape) */
    float sigma_scale;
    float sigma_max; /* majorant of the whole volume */
    /* sigma_t of each channel over the largest, which is the one above; all 0: the channels are
     * equal (lf_volume_colour) */
    lf_vec3 colour;
    lf_vec3 albedo; /* single-scattering, 0..1 per channel … */
    /* … or a field per channel, with its own grid and transform, whose value replaces sigma_t: [3],
     * owned, as are their grids; NULL: none */
    struct lf_volume *albedo_fields;
    float g; /* Henyey-Greenstein, (-1, 1) */
    lf_second_lobe second;
    /* Scene-local point -> volume space (for grids voxel indices: voxel centres at integers) and
     * back; rows of a 3x4 affine map. */
    float to_volume[3][4], to_scene[3][4];
    /* owned; NULL: static. The maps above are then those at shutter open */
    lf_volume_motion *motion;
    /* scene-local box outside of which sigma_t = 0 (including the filter's footprint), over the
     * whole motion */
    lf_vec3 bounds_min, bounds_max;
    float voxel;      /* grids: the shortest edge of a voxel, scene units … */
    float slice_cell; /* … and the cell size that slices resolve (scene_commit.c) */
} lf_volume;

#define LF_EMISSION_STEPS 256

/* The emission of a volume along a ray: radiance per scene unit, as a function of its field's
 * value. */
typedef struct lf_volume_emission {
    int volume;      /* index into scene->volumes */
    lf_vec3 colour;  /* factor of the value, if the field is not a temperature */
    float per_value; /* steps of the table per unit of value; 0: the field is not a temperature */
    float inverse;   /* 1 / the largest value */
    /* [LF_EMISSION_STEPS + 1] black-body radiance at temperature value i / per_value, divided by
     * the fourth power of that value times inverse */
    lf_vec3 table[LF_EMISSION_STEPS + 1];
} lf_volume_emission;

/* Emissive volumes. Each has a field of its own besides its extinction, with its own grid and
 * transform. The field's value takes the role of sigma_t (sigma_scale is 1). */
typedef struct lf_emissive_volumes {
    int n;
    lf_volume *field;
    lf_volume_emission *light; /* of field[i] */
} lf_emissive_volumes;

/* sigma_t per channel over the largest, 0..1. */
static inline lf_vec3 lf_volume_colour(const lf_volume *volume)
{
    return lf_max3(volume->colour) > 0.0f ? volume->colour : lf_v3(1.0f, 1.0f, 1.0f);
}

/* Interpolates a volume to a shutter time: 0 when the shutter opens, 1 when it closes. An advected
 * grid is then borrowed from its steps. */
void lf_volume_move(lf_volume *volume, float time);
/* false if the motion makes the volume singular in between, or nearly so (a rotation of about half
 * a circle). */
bool lf_volume_motion_is_sound(const lf_volume_motion *motion);

/* sigma_t of the largest channel at a scene-local point, filter applied, 0 outside. */
float lf_volume_sigma_t(const lf_volume *volume, lf_vec3 p);
/* Single-scattering albedo at a scene-local point; the first function is for albedo from grids. */
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

/* Coverage mode of a surface (alphaMode, glTF 2.0, section 3.9.4). */
typedef enum lf_cover { LF_COVER_OPAQUE, LF_COVER_MASK, LF_COVER_BLEND, LF_COVERS } lf_cover;

#define LF_GLASS_NODES 32

/* A texture image of the scene file's materials, ready for look-ups; shared between scenes while
 * its files stay the same (render/import/scene/scene_pictures.h). */
typedef struct lf_scene_picture {
    atomic_int refs;
    char *key;           /* of its files and of their processing */
    lf_digest digest[2]; /* of the files of its two parts; "" = none */
    lf_texels texels;
    lf_pyramid pyramid;
} lf_scene_picture;

/* Accepts NULL. */
void lf_scene_picture_unref(lf_scene_picture *picture);

/* Slots that materials of the scene file may fill: LF_SLOT_BASE to LF_SLOT_EMISSION. */
#define LF_OWN_SLOTS 4

/* The textures of a material in the scene file. */
typedef struct lf_own_textures {
    lf_textures textures;
    lf_scene_picture *picture[LF_OWN_SLOTS]; /* counted references; NULL: empty slot */
} lf_own_textures;

/* Properties of a surface that transmits light. */
typedef struct lf_glass {
    /* Set by lf_material_prepare: the transmission lobe is not a delta lobe. */
    bool is_rough;
    /* Thin glass: a smooth clear sheet without other lobes. It transmits rays like an alpha surface
     * (surface_glass.h). */
    bool is_thin;
    bool is_inside; /* of a hit only: met from inside a solid (track.c) */
    /* Of a hit only: a boundary between two media. ior, at least 1, is the ratio of the indices.
     * is_inside: the path comes from the medium with the greater index (lf_glass_part). */
    bool is_parting;
    float kept[2][LF_GLASS_NODES]; /* E of rough glass, from outside and from inside */
} lf_glass;

/* Anisotropy of a rough layered surface at a hit (surface_texture.c): the lobe is wider along the
 * grooves than across. 0: the lobe is isotropic. */
typedef struct lf_anisotropy {
    float alpha[2]; /* along and across */
    float along[2]; /* the direction in the frame of ns by lf_tangents */
} lf_anisotropy;

/* Energy terms of a principled surface: the losses of its metal and its clear coat (lf_loss), the
 * mean transmission of its dielectric lobe to the layer below, the mean reflectance of its metal,
 * lf_loss_rest and lf_loss_smooth. */
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
    const struct lf_surface_kind *kind; /* surface.h; interprets the scalars */
    LF_PRINCIPLED_MEMBERS;
    lf_tint tint; /* which colours the vertex colours multiply */
    /* emits from the front only, the side from which corners run counter-clockwise */
    bool one_sided;
    bool is_solid;  /* the side behind is another medium of index ior; false: a sheet */
    lf_cover cover; /* how alpha and the alpha of its texture are used */
    /* complex index eta + i k of each channel; eta.x = 0: none, use albedo */
    lf_vec3 eta, k;
    const lf_textures *textures; /* borrowed from geometry or scene; NULL: none */
    /* of a hit only, if it differs from the base's normal: as lf_anisotropy.along */
    lf_vec3 coat_normal;
    lf_glass glass;
    lf_anisotropy anisotropic;
    /* Computed from the above by lf_material_prepare (surface.h). */
    bool has_lobe;             /* has a lobe that is not a delta lobe */
    bool has_delta;            /* has a delta lobe of nonzero reflectance */
    float loss[LF_LOSS_TERMS]; /* of a rough lobe: lf_loss */
    lf_vec3 rest;              /* multiple-scattering compensation: surface_energy.c */
    lf_layer_energy energy;    /* of a principled surface */
} lf_material;
/* Whether it has delta lobes for which its pixels draw more native samples. Not thin glass: its
 * reflection is weak, and every ray that reaches it adds it. */
static inline bool lf_has_mirror(const lf_material *m)
{
    return m->has_delta && !m->glass.is_thin;
}

/* Whether it transmits through a lobe that is not a delta lobe. */
static inline bool lf_has_far_lobe(const lf_material *m)
{
    return m->glass.is_rough || m->subsurface > 0.0f;
}

/* Whether its lobes differ between inside and outside. */
static inline bool lf_is_sided(const lf_material *m)
{
    return (m->is_solid && m->glass.is_rough) || m->subsurface > 0.0f;
}

/* Of a hit only: subsurface that is left from inside; its lobe does not depend on the incident
 * direction. */
static inline bool lf_is_way_out(const lf_material *m)
{
    return m->glass.is_inside && m->subsurface > 0.0f;
}

/* Whether rays end on the surface at random, and views see through it. */
static inline bool lf_is_alpha_surface(const lf_material *m)
{
    return m->cover != LF_COVER_OPAQUE || m->glass.is_thin;
}
#define LF_ALPHA_MIN 1e-3f
/* Its root plus a margin: the lower limit for textures. */
#define LF_LEAST_ROUGHNESS 0.0317f

/* Scene-local; min > max if empty. */
typedef struct lf_box {
    lf_vec3 min, max;
} lf_box;

/* Vertex data at shutter close; lf_mesh has the same arrays for shutter open. Between, every vertex
 * moves along a straight line. vertices NULL: static, and the others are NULL. */
typedef struct lf_mesh_close {
    const float *vertices, *normals, *tangents;
} lf_mesh_close;

/* Whether the scene marks a mesh as a ground, which a fit does not frame. */
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
    lf_box box;    /* of the triangles, over the whole motion */
    bool hidden;   /* camera rays pass through it */
    bool catcher;  /* hidden, and shows the shadows on it (catcher.h) */
    bool reflects; /* a catcher that also shows reflections */
    bool lamp;     /* made from one of the scene's area lights */
    lf_ground_word ground;
    /* as in lf_mesh_data; each NULL if no material uses it */
    const float *uvs, *colours, *tangents;
    lf_mesh_close close;
    const struct lf_instances *instances; /* instanced (instances.h); NULL: a single mesh */
} lf_mesh;

static inline lf_vec3 lf_mesh_vertex(const lf_mesh *mesh, uint32_t vertex)
{
    const float *v = mesh->vertices + 3 * (size_t)vertex;
    return lf_v3(v[0], v[1], v[2]);
}

/* Index of a triangle's material in the scene. */
static inline uint16_t lf_mesh_material(const lf_mesh *mesh, uint32_t triangle)
{
    return mesh->triangle_material ? mesh->triangle_material[triangle] : mesh->material;
}

/* The point a + u (b - a) + v (c - a) of a triangle. Its distance from the plane is at most the
 * rounding of its own coordinates. */
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

/* A latitude-longitude image of radiance with its sampling tables; shared between scenes. Row 0
 * looks up (+y). Column 0 .. width-1 is phi from 0 to 2 pi, direction (sin(theta) cos(phi),
 * cos(theta), sin(theta) sin(phi)). */
typedef struct lf_environment {
    atomic_int refs;
    int width, height;
    float *rgb;         /* [height][width][3] */
    float *marginal;    /* [height + 1] cumulative over rows, 0..1 */
    float *conditional; /* [height][width + 1] cumulative along each row, 0..1 */
    float *pdf;         /* [height][width] per unit solid angle */
    float mean;         /* of the sampling weights of texels, over the sphere */
    float above_mean;   /* the sampling density: radiance above the mean, mean over the sphere */
    char *key;
    lf_digest digest;     /* of the file */
    lf_warnings warnings; /* features of the file that are not rendered */
} lf_environment;
/* Accepts NULL. */
void lf_environment_unref(lf_environment *environment);

typedef struct lf_light {
    const struct lf_light_kind *kind; /* light_kind.h; defines which of the fields below are used */
    /* probability that light sampling picks this light; 0 = never sampled (constant skies) */
    float select;
    /* sum of select up to and including this light; 1 from the last light with select > 0 on */
    float cumulative;
    /* radiance of rays that hit the light; multiplied by the environment's image */
    lf_vec3 radiance;
    lf_environment *environment; /* counted reference; NULL = constant */
    float to_environment[3][3];  /* scene direction -> the image's frame */
    lf_vec3 direction;           /* unit, in which light travels */
    lf_vec3 irradiance;          /* on a plane across direction */
    float versine;               /* 1 - cos of half the angle around direction */
    lf_vec3 position, intensity; /* scene-local, W sr^-1 */
    bool hidden;                 /* invisible to the camera only */
    /* Data of single kinds, one struct each. */
    union {
        struct {
            float inner; /* the versine at which the falloff to the rim begins */
        } spot;
    } own;
    int mesh;               /* index into scene->meshes */
    uint16_t mesh_material; /* the emitting material (triangles of it only) */
    int n_triangles;        /* emitting triangles … */
    uint32_t *triangle;     /* … their numbers */
    /* [n_triangles + 1] cumulative area, 0..1, in double: float steps would show in small triangles
     */
    double *area_cdf;
    float area; /* total */
    /* its emission is textured: radiance is the mean, area_cdf is weighted by emission */
    bool has_picture;
    bool one_sided; /* emits only from the front of its triangles */
    /* for one-sided lights with many triangles, else NULL (light_tree.h) */
    struct lf_light_node *tree;
    int equiangular; /* lights at a distance: 1 + index in scene->equiangular; 0 = none */
    struct lf_light_motion *motion; /* its motion (light_kind.h); NULL: static */
} lf_light;

/* The light of camera rays that meet nothing, replacing the lights at infinity: radiance at the
 * upper and lower edge of the window, linear in the height between them. */
typedef struct lf_backdrop {
    bool given;
    lf_vec3 top, bottom;
} lf_backdrop;

/* height: 0 at the window's upper edge, 1 at the lower one. */
static inline lf_vec3 lf_backdrop_at(const lf_backdrop *backdrop, float height)
{
    return lf_madd(backdrop->top, height, lf_sub(backdrop->bottom, backdrop->top));
}

/* Releases the light's data and zeroes it. Accepts a zeroed struct. */
void lf_light_finish(lf_light *light);

/* An equiangular light: a light in or near media (equiangular.h). */
typedef struct lf_equiangular_light {
    int light;
    lf_vec3 middle;
    float radius; /* from its middle; 0 for points */
    float reach;  /* distance from its middle to the farthest point of the volumes */
    float share;  /* its pick probability over the sum of all equiangular lights */
} lf_equiangular_light;
#define LF_MAX_EQUIANGULAR 64

/* All of them. */
typedef struct lf_equiangular_lights {
    int n;
    lf_equiangular_light item[LF_MAX_EQUIANGULAR];
    lf_box media; /* of all volumes */
} lf_equiangular_lights;

/* ------------------------------------------------------------------------------------- scene -- */

/* A document of at least this size uses a hundred megabytes. When it is freed, the memory must be
 * returned to the system explicitly. */
#define LF_SCENE_LARGE_BYTES ((size_t)1 << 20)

/* The source of the scene. */
typedef struct lf_scene_file {
    char *folder, *where;
    json_t *included; /* names of merged files (scene_include.h) */
    /* the scene's json at its frame, without keys (keyframes.h) */
    json_t *still;
    size_t bytes; /* of the document (lf_json_least_bytes) */
    int frame;
    double rate;           /* frames per second */
    bool has_frames;       /* the frames differ */
    lf_view_camera *views; /* the camera's list; NULL: none */
    json_t *placing;       /* lf_place_grounds' patch; NULL: the document gives all positions */
} lf_scene_file;

/* Two coplanar triangles of different glass solids. */
typedef struct lf_touching {
    int mesh;
    uint32_t triangle;
    int other;
    uint32_t other_triangle;
} lf_touching;

/* Glass solids inside glass solids (nest.h); all zero if there are none. Owned. */
typedef struct lf_nesting {
    /* [n_meshes][n_materials]: number of the solid of such triangles; -1: of no solid, or of one
     * whose faces are met as if in air */
    int16_t *solids;
    /* [n_touching] coplanar triangles of its solids, by mesh and triangle; each pair in both orders
     */
    lf_touching *touching;
    int n_touching;
} lf_nesting;

struct lf_scene {
    atomic_int refs;
    json_t *json;
    json_t *subject; /* the parts of the document that define a film (scene_subject.h) */
    lf_scene_file file;
    double origin[3]; /* world = local + origin */
    lf_camera camera; /* world coordinates */
    lf_film_settings film;
    int max_depth; /* path vertices; 0 = LF_DEFAULT_MAX_DEPTH */

    int n_volumes, n_meshes, n_materials, n_lights;
    lf_volume *volumes;
    lf_emissive_volumes emissive; /* their emission */
    lf_mesh *meshes;              /* indexed by Embree's geomID */
    lf_material *materials;       /* materials of files, then of the scene, then of area lights */
    /* after lf_lights_commit in the order of their kinds: lights at infinity first */
    lf_light *lights;
    int n_lights_infinite; /* set by lf_lights_commit */
    lf_backdrop backdrop;
    lf_equiangular_lights equiangular; /* lights in or near media */
    RTCScene embree; /* NULL without meshes (then no Embree device exists either) */
    float offset;    /* lf_geometry.offset; 0 without meshes */
    /* owner of the meshes' arrays and of embree, shared between scenes; NULL without meshes */
    struct lf_geometry *geometry;
    lf_box bounds; /* of volumes and meshes */

    lf_warnings warnings; /* of its parts and of the whole */

    /* Integrators are specialised by these. */
    lf_traits traits;
    lf_nesting nested;
    /* [n_own_textures] owned: textures of the scene file's materials, in its order */
    lf_own_textures *own_textures;
    int n_own_textures;
};
#define LF_DEFAULT_MAX_DEPTH 1024

/* Whether it has at least one of these traits. */
static inline bool lf_has(const lf_scene *scene, lf_traits any)
{
    return scene->traits & any;
}

/* Path vertices: `wanted`; if 0 the scene's value; if 0 the default. */
static inline int lf_max_depth(const lf_scene *scene, int wanted)
{
    int own = scene->max_depth > 0 ? scene->max_depth : LF_DEFAULT_MAX_DEPTH;
    return wanted > 0 ? wanted : own;
}

#define LF_MAX_VOLUMES 16

#endif
