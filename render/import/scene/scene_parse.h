/* What a scene file says, before anything is loaded; private to render/. Angles are radians,
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
/* room for a name of up to 256 bytes, a component behind it and a zero */
#define LF_GRID_NAME_BYTES 260
#define LF_MAX_SUMMED 4

/* The grids of a volume's file that say how its values move. */
typedef struct lf_velocity_desc {
    char grid[3][LF_GRID_NAME_BYTES]; /* of each component; "" = none */
    double scale;
    bool per_frame; /* in place of seconds */
    bool of_voxels; /* of the velocities' own grid, in place of the file's lengths */
    int steps;      /* moments of the shutter */
} lf_velocity_desc;

typedef struct lf_volume_desc {
    const char *name;
    lf_volume_kind kind;
    /* LF_VOLUME_GRID only, as the next: the grids whose sum it is, each with a newline behind it
     * but the last */
    char grid[LF_MAX_SUMMED * LF_GRID_NAME_BYTES];
    char *file; /* of the frame; released by lf_scene_desc_finish */
    lf_frame_of frame;
    bool absent; /* there is no file for the frame: nothing is there */
    bool nearest;
    bool half;        /* grids are rounded to 16 bits (lf_grid_shorten) */
    double scale;     /* sigma_t per scene unit and unit of value … */
    double colour[3]; /* … times this: of each channel */
    double albedo[3], g;
    lf_second_lobe second;
    double droplets; /* micrometres, in place of g and the second lobe; 0: not given */
    /* or grids of the file, one a channel: "" = none */
    char albedo_grid[3][LF_GRID_NAME_BYTES];
    /* What it emits, radiance per scene unit: nothing, unless it is given; grids: per unit of the
     * value of emission_grid, or, temperature_scale > 0, as a black body of that many kelvin per
     * unit. */
    bool is_emissive;
    const char *emission_grid;
    double emissive[3], temperature_scale;
    lf_velocity_desc velocity;
    lf_affine transform;
} lf_volume_desc;

typedef enum lf_normals { LF_NORMALS_FILE, LF_NORMALS_SMOOTH, LF_NORMALS_FLAT } lf_normals;

/* Where a mesh stands that is given once for many places: each a map after its transform. */
typedef struct lf_instances_desc {
    const char *file; /* of them, or NULL */
    int n;            /* of those that the scene says itself */
    lf_affine *map;   /* [n] released by lf_scene_desc_finish */
} lf_instances_desc;

static inline bool lf_instances_are_given(const lf_instances_desc *places)
{
    return places->file || places->n > 0;
}

/* A picture that a material names. */
typedef struct lf_picture_desc {
    const char *file;   /* NULL: none */
    lf_texture texture; /* how it lies */
} lf_picture_desc;

/* Those of a material: of each slot two parts (lf_picture_keys). */
typedef struct lf_pictures_desc {
    lf_picture_desc slot[LF_OWN_SLOTS][2];
} lf_pictures_desc;

/* What the scene's own materials look at, besides what those of the mesh's file do. */
typedef struct lf_mesh_wants {
    bool uvs, tangents;
} lf_mesh_wants;

/* A material of the scene in place of one of a mesh's file. */
typedef struct lf_override {
    const char *name; /* in the file */
    int material;     /* index into materials */
} lf_override;

typedef struct lf_mesh_desc {
    const char *name;
    const lf_mesh_shape *shape; /* NULL: file */
    const char *file;           /* NULL: shape */
    int material;               /* index into materials; -1 = the file's own */
    lf_normals normals;
    lf_affine transform;
    lf_clip clip;        /* of a file */
    const char *variant; /* of a file: which look, by name; NULL: its own */
    double area; /* a shape's, to which it is scaled about its middle; 0 = what it comes to */
    /* how much the lights of a glTF file shine; below 0: where the scene has none of its own, 1 */
    double lights;
    bool lamp;   /* of a light that is faces: the name is the light's */
    bool hidden; /* from the camera */
    bool catcher;
    bool reflects; /* a catcher of what it reflects, too */
    lf_ground_word ground;
    bool stands; /* a ground that the scene places (placing.h) */
    bool emits;  /* some material of the scene that it has does */
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

/* A camera of a mesh's file, which the scene's is like where it says nothing else. */
typedef struct lf_framing {
    const char *mesh; /* its name; NULL: there is none */
    const char *name; /* of the camera or its node; NULL: by its number */
    int number;       /* of the file's cameras; below 0: the first that stands somewhere */
    double distance;  /* of the window; 0: the middle of what lies before it */
    bool own_position, own_target, own_up, own_fov; /* the scene says it */
} lf_framing;

typedef struct lf_scene_desc {
    int frame;
    double fps;
    double seconds;        /* of animations: 0 in frame 1 */
    double unit_mm;        /* what a scene unit is */
    lf_camera camera;      /* what lf_camera_frame makes of it where there is a framing */
    lf_view_camera *views; /* what camera.list is; NULL: it has none */
    lf_framing framing;
    lf_film_settings film;
    lf_backdrop backdrop;
    int max_depth; /* 0 = not stated */
    int n_volumes, n_meshes, n_materials, n_lights;
    lf_volume_desc *volumes;
    /* each behind those of the file: one for every light that is faces, which is no light then */
    lf_mesh_desc *meshes;
    lf_material *materials;
    lf_pictures_desc *pictures; /* [n_materials] theirs */
    lf_light_desc *lights;
    lf_warnings warnings; /* of what it says without effect */
} lf_scene_desc;

/* What files of meshes and of volumes end in, without the dot; NULL behind the last. */
extern const char *const lf_mesh_endings[], *const lf_volume_endings[];

/* What a scene says when its shutter opens, and when it closes: [2], the same where it has none. */
typedef const lf_scene_desc *const *lf_ends;

/* Fills *out from the root of a document; reader->status says how it went. Release with
 * lf_scene_desc_finish in any case. */
void lf_scene_parse(lf_reader *reader, const lf_node *root, lf_scene_desc *out);
/* The same so many frames behind the document's own, as far as animations of meshes are concerned
 * (keyframes.h makes documents of other moments). */
void lf_scene_parse_beside(lf_reader *reader, const lf_node *root, double frames,
                           lf_scene_desc *out);
void lf_scene_desc_finish(lf_scene_desc *desc);

#endif
