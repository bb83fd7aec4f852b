/* A parsed scene file, before its files are loaded; private to render/. Angles are in radians,
 * lengths and directions as in the file (world coordinates). Strings are borrowed from the JSON
 * document. docs/reference/scene-format.md is the manual. */
#ifndef LF_RENDER_SCENE_PARSE_H
#define LF_RENDER_SCENE_PARSE_H

#include "render/import/scene/clip.h"
#include "render/import/scene/frame_file.h"
#include "render/import/scene/json_reader.h"
#include "render/import/scene/mesh_shape.h"
#include "render/scene/affine.h"
#include "render/scene/scene.h"
#include "render/scene/warnings.h"
#include "render/transport/light/light_kind.h"

#define LF_MAX_MESHES 1024
#define LF_MAX_MATERIALS 4096
#define LF_MAX_LIGHTS 256
#define LF_MAX_NAME 128
/* room for a name of up to 256 bytes, a component suffix and a zero */
#define LF_GRID_NAME_BYTES 260
#define LF_MAX_SUMMED 4

/* The velocity grids of a volume's file. */
typedef struct lf_velocity_desc {
    char grid[3][LF_GRID_NAME_BYTES]; /* of each component; "" = none */
    double scale;
    bool per_frame; /* not per second */
    bool of_voxels; /* in voxels of the velocities' own grid, not in the file's units */
    int steps;      /* number of shutter times */
} lf_velocity_desc;

typedef struct lf_volume_desc {
    const char *name;
    lf_volume_kind kind;
    /* Only for LF_VOLUME_GRID, like the next: the grids that are added, separated by newlines. */
    char grid[LF_MAX_SUMMED * LF_GRID_NAME_BYTES];
    char *file; /* at the frame; released by lf_scene_desc_finish; NULL: a shape or an array */
    const char *array;          /* passed in memory; NULL: none */
    const char *emission_array; /* likewise, of an emissive volume with an array */
    lf_frame_of frame;
    bool absent; /* there is no file for the frame: the volume is empty */
    bool nearest;
    bool half;        /* grids are rounded to 16 bits (lf_grid_shorten) */
    double scale;     /* sigma_t per scene unit and unit of value … */
    double colour[3]; /* … times this factor per channel */
    double albedo[3], g;
    lf_second_lobe second;
    double droplets; /* micrometres, replaces g and the second lobe; 0: not given */
    /* or grids of the file, one per channel: "" = none */
    char albedo_grid[3][LF_GRID_NAME_BYTES];
    /* Emission, radiance per scene unit; only if is_emissive. For grids per unit of the value of
     * emission_grid or, if temperature_scale > 0, as a black body of that many kelvin per unit. */
    bool is_emissive;
    const char *emission_grid;
    double emissive[3], temperature_scale;
    lf_velocity_desc velocity;
    lf_affine transform;
} lf_volume_desc;

typedef enum lf_normals { LF_NORMALS_FILE, LF_NORMALS_SMOOTH, LF_NORMALS_FLAT } lf_normals;

/* Instances of a mesh: each a map applied after its transform. */
typedef struct lf_instances_desc {
    const char *file; /* of instances, or NULL */
    int n;            /* number of instances in the scene itself */
    lf_affine *map;   /* [n] released by lf_scene_desc_finish */
} lf_instances_desc;

static inline bool lf_instances_are_given(const lf_instances_desc *places)
{
    return places->file || places->n > 0;
}

/* An image that a material names. */
typedef struct lf_picture_desc {
    const char *file;   /* NULL: none */
    lf_texture texture; /* its mapping */
} lf_picture_desc;

/* The images of a material: two parts for each slot (lf_picture_keys). */
typedef struct lf_pictures_desc {
    lf_picture_desc slot[LF_OWN_SLOTS][2];
} lf_pictures_desc;

/* Vertex data that the scene's own materials need, in addition to the data for the mesh's file. */
typedef struct lf_mesh_wants {
    bool uvs, tangents;
} lf_mesh_wants;

/* A material of the scene that replaces one of a mesh's file. */
typedef struct lf_override {
    const char *name; /* in the file */
    int material;     /* index into materials */
} lf_override;

/* Arrays of a mesh that a client passed in memory. */
typedef enum lf_mesh_array {
    LF_MESH_POSITIONS,
    LF_MESH_TRIANGLES,
    LF_MESH_NORMALS,
    LF_MESH_UVS,
    LF_MESH_N_ARRAYS
} lf_mesh_array;
extern const char *const lf_mesh_array_keys[]; /* keys in scenes; NULL after the last */

typedef struct lf_mesh_arrays {
    const char *name[LF_MESH_N_ARRAYS]; /* NULL: none; the first two are there */
} lf_mesh_arrays;

typedef struct lf_mesh_desc {
    const char *name;
    /* one of the three: a shape, a file, or arrays with positions */
    const lf_mesh_shape *shape;
    const char *file;
    lf_mesh_arrays arrays;
    int material; /* index into materials; -1 = the file's own */
    lf_normals normals;
    lf_affine transform;
    lf_clip clip;        /* animation of a file */
    const char *variant; /* of a file: name of a material variant; NULL: the default */
    double area; /* area of a shape, to which it is scaled about its middle; 0 = its natural area */
    /* factor of the lights of a glTF file; below 0: 1 if the scene has no lights of its own, else 0
     */
    double lights;
    bool lamp;   /* made from an area light: name is the light's */
    bool hidden; /* from the camera */
    bool catcher;
    bool reflects; /* also catches reflections */
    lf_ground_word ground;
    bool stands; /* a ground that is placed automatically (placing.h) */
    bool emits;  /* a material of the scene on it emits */
    int n_overrides;
    lf_override *overrides; /* [n_overrides] released by lf_scene_desc_finish */
    lf_mesh_wants wants;
    lf_instances_desc places;
} lf_mesh_desc;

typedef struct lf_light_desc {
    const char *name;
    const lf_light_kind *kind; /* one with keys */
    lf_value values[LF_MAX_KEYS];
} lf_light_desc;

/* A camera of a mesh's file that gives the defaults of the scene's camera. */
typedef struct lf_framing {
    const char *mesh; /* its name; NULL: none */
    const char *name; /* of the camera or its node; NULL: by number */
    int number;       /* of the file's cameras; below 0: the first with a node */
    double distance;  /* of the window; 0: the middle of the scene in front of it */
    bool own_position, own_target, own_up, own_fov; /* given by the scene */
} lf_framing;

typedef struct lf_scene_desc {
    int frame;
    double fps;            /* frames per second */
    double seconds;        /* time of animations: 0 in frame 1 */
    double unit_mm;        /* size of a scene unit */
    lf_camera camera;      /* with a framing, completed by lf_camera_frame */
    lf_view_camera *views; /* the camera's list; NULL: none */
    lf_framing framing;
    lf_film_settings film;
    lf_backdrop backdrop;
    int max_depth; /* 0 = not given */
    int n_volumes, n_meshes, n_materials, n_lights;
    lf_volume_desc *volumes;
    /* meshes of the file, followed by one for every area light, which is not in lights then */
    lf_mesh_desc *meshes;
    lf_material *materials;
    lf_pictures_desc *pictures; /* [n_materials] images of the materials */
    lf_light_desc *lights;
    lf_warnings warnings; /* about keys without effect */
} lf_scene_desc;

/* Endings of mesh and volume files, without the dot; NULL after the last. */
extern const char *const lf_mesh_endings[], *const lf_volume_endings[];

/* A scene when its shutter opens and when it closes: [2], the same pointer without a shutter. */
typedef const lf_scene_desc *const *lf_ends;

/* Fills *out from the root of a document; see reader->status for errors. Release with
 * lf_scene_desc_finish, also after a failure. */
void lf_scene_parse(lf_reader *reader, const lf_node *root, lf_scene_desc *out);
/* lf_scene_parse with animations of meshes `frames` frames after the document's own frame
 * (keyframes.h makes documents of other times). */
void lf_scene_parse_beside(lf_reader *reader, const lf_node *root, double frames,
                           lf_scene_desc *out);
void lf_scene_desc_finish(lf_scene_desc *desc);

#endif
