/* render: from a scene file to a film of N views.
 *
 * After lf_scene_load a scene is immutable and reference counted. A patched scene shares all
 * unchanged parts with the one before: moving the camera rebuilds no BVH and reloads no volume. A
 * renderer adds samples of one scene, seen by one rig, to a film. The film gives three estimates of
 * every view pixel.
 *
 * Coordinates: right-handed, y up, scene units. Angles are in degrees in scene files and in radians
 * after parsing. Colours are linear Rec. 709, radiance is in W m^-2 sr^-1. Views are numbered from
 * the leftmost camera. Rows count from the top. docs/developer/estimators.md holds the formulas.
 *
 * A whole image that improves with every round, rgb [row][view][column][3]
 * (tests/render/test_usage.c compiles and runs these lines):
 *
 *     lf_pool *pool = NULL;
 *     lf_scene *scene = NULL;
 *     lf_renderer *renderer = NULL;
 *     lf_status status = lf_pool_create(0, &pool);
 *     if (status == LF_OK)
 *         status = lf_scene_load(path, NULL, NULL, &scene, err);
 *     if (status == LF_OK) {
 *         lf_render_settings settings = {.camera = *lf_scene_camera(scene), .skip = LF_SKIP_ALL};
 *         settings.width = width;
 *         settings.height = height;
 *         settings.camera.n_views = n_views;
 *         status = lf_renderer_create(scene, &settings, pool, &renderer, err);
 *     }
 *     for (int i = 0; status == LF_OK && i < rounds; i++) {
 *         status = lf_renderer_passes(renderer, NULL, 4 * n_views, true, NULL, NULL, NULL);
 *         if (status == LF_OK)
 *             status = lf_renderer_resolve(renderer, LF_ESTIMATOR_MWIS, rgb, NULL);
 *         if (status == LF_OK)
 *             show(rgb, lf_renderer_error_bound(renderer, LF_ESTIMATOR_MWIS, 0.05, NULL));
 *     }
 *     lf_renderer_destroy(renderer);
 *     lf_scene_unref(scene);
 *     lf_pool_destroy(pool);
 */
#ifndef LF_RENDER_H
#define LF_RENDER_H

#include <jansson.h>

#include "base/file.h"
#include "base/image.h"
#include "base/param.h"
#include "base/thread.h"
#include "render/scene/handle.h"
#include "render/scene/traits.h"
#include "render/transport/sampler.h"

/* ------------------------------------------------------------------------------------- scene -- */

/* How to show a mesh or volume file that is given instead of a scene
 * (docs/reference/scene-format.md, "Files without a scene"). Zeroed: up axis of the file's kind,
 * its front towards the camera, on a ground, in a studio. */
typedef enum lf_up { LF_UP_OF_FILE, LF_UP_Y, LF_UP_Z } lf_up;
typedef struct lf_alone {
    bool bare;               /* no ground and no studio, in front of a dark backdrop */
    bool has_yaw, has_pitch; /* given by the user; then a camera in the file is not used */
    /* direction of the camera: degrees to the right of +z, and above the horizon */
    double yaw, pitch;
    lf_up up; /* the file's axis that points up */
} lf_alone;
/* Its options and scene keys. */
extern const lf_param lf_alone_params[];
/* What a file is that can be shown without a scene, by its ending: "model" or "volume"; NULL:
 * neither. */
const char *lf_alone_kind(const char *path);

/* Loads a scene file (JSON, at most 16 MiB) and the files that it includes. Paths in it are
 * relative to its folder and must be below roots (NULL or empty: anywhere). The scene's own folder
 * is always allowed, unless the roots are closed. previous (may be NULL): the new scene shares its
 * unchanged parts. previous is only read. On LF_OK the caller owns a reference to *out_scene.
 * Errors: LF_E_IO, LF_E_PATH, LF_E_NOMEM, LF_E_FORMAT with file, line and JSON pointer; *out_scene
 * is then untouched. Thread: any; may take seconds. */
LF_NODISCARD lf_status lf_scene_load(const char *path, const lf_roots *roots,
                                     const lf_scene *previous, lf_scene **out_scene, lf_error *err);

/* lf_scene_load with a merge patch applied to the file's document (NULL: none). `alone` says how to
 * show a file without a scene (NULL: zeroed). Lines in errors are lines of the file. */
LF_NODISCARD lf_status lf_scene_load_patched(const char *path, const lf_alone *alone,
                                             const json_t *patch, const lf_roots *roots,
                                             const lf_scene *previous, lf_scene **out_scene,
                                             lf_error *err);

/* lf_scene_load for a document in memory. Relative paths, also of includes, are relative to folder.
 * An empty folder is none: relative paths are then errors.
 * Errors use `where` as the document's name. The scene keeps a reference to doc and shares its
 * values: nobody may change them from now on. LF_E_NOMEM also if the document (with its includes
 * and patches) has more than 16 MiB in its shortest form. */
LF_NODISCARD lf_status lf_scene_from_json(const json_t *doc, const char *folder, const char *where,
                                          const lf_roots *roots, const lf_scene *previous,
                                          lf_scene **out_scene, lf_error *err);

/* Parses the document in an open regular file, from its start, for lf_scene_from_json. The caller
 * owns a reference to *out_doc. Errors name `where`: LF_E_NOMEM (also more than 16 MiB), LF_E_IO,
 * LF_E_FORMAT with the line. May wait for a file system. */
LF_NODISCARD lf_status lf_scene_document_read(int fd, const char *where, json_t **out_doc,
                                              lf_error *err);

/* JSON Merge Patch (RFC 7396) of a scene's document. Former names of keys in the patch count as
 * their current names (docs/reference/scene-format.md, "The file"). Returns a new reference; NULL:
 * out of memory. The result shares values with doc and patch: nobody may change them from now on.
 */
json_t *lf_json_merge_patch(const json_t *doc, const json_t *patch);
/* lf_json_merge_patch in place, for an object that the caller owns. Members that have other owners
 * are copied before they change. The result shares values with patch. false: out of memory, the
 * object is half patched. */
LF_NODISCARD bool lf_json_merge_into(json_t *target, const json_t *patch);

/* Checks another frame of the scene without reading its volumes: its values are valid, and its
 * volume files exist. LF_E_IO, LF_E_FORMAT with their position in the document. */
LF_NODISCARD lf_status lf_scene_check_frame(const lf_scene *scene, int frame, lf_error *err);
/* The box around all volumes and meshes except grounds (name NULL), or around all of this name,
 * in world coordinates: minimum and maximum corner. Lights at a distance, skies and meshes that the
 * camera does not see are excluded. false: the box is empty. */
bool lf_scene_bounds(const lf_scene *scene, const char *name, double out_bounds[2][3]);
/* The meshes that lf_scene_bounds excludes as grounds: those that the scene marks, or else those
 * found by the rule in docs/reference/scene-format.md, "Framing". NULL after the last. The scene
 * owns the names. */
const char *lf_scene_ground(const lf_scene *scene, int index);
/* The JSON Schema of scene files (docs/scene.schema.json, compiled in); a new reference. */
json_t *lf_scene_schema(void);

/* ---------------------------------------------------------------------------------- renderer -- */

/* How to resolve a film to an image (docs/developer/estimators.md, "8. Three estimators"). */
typedef enum lf_estimator {
    /* B + q N/W or B + q N/W', per tile the one with the smaller variance; consistent; the default
     */
    LF_ESTIMATOR_MWIS,
    LF_ESTIMATOR_MIS, /* B + N/n; unbiased */
    /* regression on both controls, coefficients from the other half; unbiased for fixed budgets */
    LF_ESTIMATOR_CV,
} lf_estimator;

/* Names of an lf_estimator and an lf_sampler_kind, as on the command line; NULL after the last. */
const char *lf_estimator_name(int estimator);
const char *lf_sampler_name(int kind);

/* How paths are sampled and shared. */
typedef struct lf_integrator_entry {
    const char *name; /* as in --integrator */
    const char *what; /* one-line description */
    bool shares;      /* a path contributes to more view pixels than its own */
    unsigned takes;   /* which rows of lf_integrator_params it takes, one bit each */
    /* output files are denoised by default; false: it is a reference to compare with, or has no
     * reconstruction */
    bool reconstructs;
    bool takes_light_paths; /* lf_render_settings.light_paths */
    bool splits;            /* lf_render_settings.suffixes */
    bool remembers;         /* it has state besides its film: lf_renderer_passes_after refuses it */
    bool spreads;           /* paths of a row reach others: the film receives a pass as a whole */
    /* supported traits of a scene and its view; lf_renderer_create refuses others */
    lf_traits supports;
} lf_integrator_entry;

/* The first is the default; NULL after the last. */
const lf_integrator_entry *lf_integrator_at(int index);
/* The integrator of this name (NULL: the default); NULL: unknown name. */
const lf_integrator_entry *lf_integrator_named(const char *name);
/* Names of the reference integrators, if a program has added them (papers/papers.h); NULL after the
 * last. */
const char *lf_integrator_reference(int index);

/* Options of integrators: for each row of lf_integrator_params the index of one of its words, 0 the
 * first. given: the user set it. */
enum { LF_MAX_CHOICES = 4 };
typedef struct lf_choices {
    int of[LF_MAX_CHOICES];
    bool given[LF_MAX_CHOICES];
} lf_choices;
/* Options of all integrators as fields of lf_choices. `about` names the option in the error of an
 * integrator that does not take it. */
const lf_param *lf_integrator_params(void);
/* The first row whose choice was given, or differs from its first word, and which the integrator
 * does not take; NULL: none. */
const lf_param *lf_choices_unfit(const lf_choices *choices, const lf_integrator_entry *entry);
/* Resets the choices that the integrator does not take. */
void lf_choices_fit(lf_choices *choices, const lf_integrator_entry *entry);

/* Optimisations that the scene or the view allows; lf_skip_at has one row for each. */
typedef enum lf_skip {
    LF_SKIP_SURFACES = 1,
    LF_SKIP_BACKGROUND = 2,
    LF_SKIP_DELTA_LOBES = 4,
    LF_SKIP_VIEW_LOBES = 8,
    LF_SKIP_EMISSION = 16,
    LF_SKIP_KNOWN_LIGHT = 32,
    LF_SKIP_PATHS = 64,
    LF_SKIP_ALL = 127, /* the programs' default */
} lf_skip;

typedef struct lf_skip_entry {
    const char *name; /* as in --skip */
    const char *what; /* condition, and what is omitted */
    unsigned bit;     /* 1 << its index */
    /* the image is bitwise the same without it; false: the same except for rounding */
    bool bitwise;
} lf_skip_entry;

/* NULL after the last. */
const lf_skip_entry *lf_skip_at(int index);

typedef struct lf_render_settings {
    lf_camera camera;  /* the rig, after --preset, --panel and --views were applied */
    int width, height; /* pixels of a view */
    /* left, top, right, bottom of the area that the view pixels tile, in units of the camera's
     * window: top left 0,0, bottom right 1,1. All zero: 0,0,1,1. Prints and bleed extend beyond the
     * window */
    double window[4];
    const char *integrator; /* name in the table; NULL: "mvpt" */
    lf_sampler_kind sampler;
    uint64_t seed;
    int max_depth;      /* longest path in vertices after the camera; 0: the scene's limit */
    unsigned skip;      /* bits of lf_skip: the optimisations to use */
    bool features;      /* the film keeps the data for reconstruction: 16 bytes per view pixel */
    lf_choices choices; /* LF_E_ARG if the integrator does not take one that was given */
    /* Light paths for each pass over all rows, in scenes and with integrators that take them;
     * LF_LIGHT_PATHS_AUTO: a number that suits the scene; 0: none
     * (docs/developer/estimators/light-paths.md) */
    int light_paths;
    /* Paths after each point of a diffuse surface that a camera sees: 1, 2, 4 or 8; 0: 1.
     * LF_SUFFIXES_AUTO: as the variance in the scene suggests. In scenes and with integrators that
     * support it (docs/developer/estimators/splitting.md) */
    int suffixes;
    /* If suffixes is above 1: whether they share one light sample, and whether roulette begins
     * below throughput 1. LF_SUFFIXES_AUTO finds both itself */
    bool one_light, early_roulette;
} lf_render_settings;
enum { LF_LIGHT_PATHS_AUTO = -1, LF_LIGHT_PATHS_MOST = 1 << 24 };
enum { LF_SUFFIXES_AUTO = -1, LF_SUFFIXES_MOST = 8 };

/* ----------------------------------------------------------------------------------- framing -- */

/* The depth of the image: from the boxes of meshes and volumes, cut to what the middle camera of
 * the rig sees through the window. Grounds that the scene marks extend to the horizon and do not
 * count. A step is the shift of an object from one view to the next, relative to the window, in
 * view pixels. For cameras b apart, a point at distance Z along the view axis shifts by b (1 -
 * D/Z), D the window's distance. Steps are positive behind the window and negative in front of it;
 * -INFINITY if an object begins at the cameras. Detail finer than its step appears several times.
 * docs/reference/scene-format.md, "Depth". */
typedef struct lf_depth {
    double nearest, farthest; /* Z, scene units */
    double nearest_step, farthest_step;
    /* Z range in which steps stay within the limit: what a panel shows sharply, as far as its views
     * decide. INFINITY: no far end. */
    double sharp_from, sharp_to;
    /* Steps beyond the limit (4 % of the window, at least 4 pixels) show as double edges; programs
     * warn of them. exceeded: the scene has such steps, and view_blur does not smooth them. */
    double limit;
    bool exceeded;
} lf_depth;

/* false: there is one view, or it is empty; or views have windows of their own; or the settings are
 * out of range. */
bool lf_scene_depth(const lf_scene *scene, const lf_render_settings *settings, lf_depth *out);

/* Whether at least one box of a volume, or of a mesh that is not a ground, lies in a view of the
 * rig. Also true if there is no such box, and for rigs with several windows (tracks, lists of
 * cameras), where this is unknown. false: the image shows only grounds and backdrop. */
bool lf_scene_is_seen(const lf_scene *scene, const lf_render_settings *settings);

/* Default share of the window that framing fills. */
#define LF_CAMERA_FILL 0.9

/* Camera position and target that frame the box of lf_scene_bounds. The box is in the middle of the
 * window, seen from the same side as now. In every view it fills at most the share `fill` (0 < fill
 * <= 1) of the width and height; the camera is as near as that allows. A camera that would be below
 * a ground looks horizontally instead. steps > 0: the camera stays so far away that no part of the
 * box has a greater depth step; the box is then smaller in the window. Tracks and grids keep their
 * size. LF_E_ARG: the box is empty, or fill or steps are out of range, or cameras have windows of
 * their own; also errors of the rig. */
LF_NODISCARD lf_status lf_camera_fit(const lf_scene *scene, const lf_render_settings *settings,
                                     const char *name, double fill, double steps,
                                     double out_target[3], double out_position[3], lf_error *err);

typedef struct lf_renderer lf_renderer;

/* Creates a renderer with an empty film. It keeps a reference to scene; pool is borrowed and must
 * outlive it. LF_E_ARG: settings out of range (err says which); LF_E_NOMEM. Memory: 40 to 64 bytes
 * per view pixel (film.h); 32 more for cameras listed one by one; 12 for every pair of a triangle
 * and a row that can meet it, which are many rows with a wide lens (section.h). */
LF_NODISCARD lf_status lf_renderer_create(lf_scene *scene, const lf_render_settings *settings,
                                          lf_pool *pool, lf_renderer **out_renderer, lf_error *err);
/* Accepts NULL. */
void lf_renderer_destroy(lf_renderer *renderer);
/* Releases what has been rendered, most of the memory. Counts and fits stay. Afterwards only
 * lf_renderer_stats, lf_renderer_settings, lf_renderer_scene, restart and destroy may be called. */
void lf_renderer_release(lf_renderer *renderer);

/* Starts again with another scene or camera. The film is empty; its memory is kept if the shapes
 * agree. On failure the renderer is as before. */
LF_NODISCARD lf_status lf_renderer_restart(lf_renderer *renderer, lf_scene *scene,
                                           const lf_render_settings *settings, lf_error *err);

/* Called on the worker that has just finished a visit of a row, so that it can be resolved while it
 * is in the cache. */
typedef void (*lf_row_fn)(void *context, int row, int worker);

/* The part of the image that passes render: rows first_row, first_row + row_step, … below end_row,
 * with one of 2^32 random streams of the seed. All zero: all rows, stream 0. Rows are independent:
 * a film merged from parts with different rows (film_merge.h) is bitwise the film of one
 * renderer after the same calls. Streams of one row add up to the same sums except for rounding.
 *
 * There are three exceptions. Cameras listed one by one share paths among the rows of a
 * pass: other parts give other bytes, and the film receives a pass when all of it is done, after
 * row_done. Holes are filled from the samples of all streams of a row. Adaptive integrators (amvpt)
 * read all rows before they distribute samples. */
typedef struct lf_part {
    int first_row, end_row; /* end_row 0: to the last row */
    int row_step;           /* 0 means 1 */
    uint32_t stream;
} lf_part;

/* One pass over a part (NULL: all rows). Each visited row receives `subsets` passes at once (1 <=
 * subsets <= n_views); n_views passes are one native sample per view pixel. The passes of a visit
 * share one row offset, one slice of the volumes and one estimate of B and q. Successive visits of
 * a row alternate between the film's two halves. row_done may be NULL. The same seed and sequence
 * of calls give the same film for any number of threads. Allocates only in the first pass of a
 * second stream.
 *
 * LF_E_CANCELLED: rows that had not started are not visited; within 20 ms, a row in progress is
 * restored to its state before this visit. LF_E_NOMEM; LF_E_STATE: the film already has 65536 other
 * streams. LF_E_ARG: rows or subsets out of range. */
LF_NODISCARD lf_status lf_renderer_pass(lf_renderer *renderer, const lf_part *part, int subsets,
                                        lf_row_fn row_done, void *context, const lf_cancel *cancel);

/* Like lf_renderer_pass, for the live image: after its visit, a row receives native samples in
 * holes (LF_PIXEL_HOLE). If hole_reach is 0, all holes are filled. If it is above 0, as many as a
 * coarse frame needs: afterwards no hole is farther than hole_reach columns from a filled pixel of
 * its view and row. If it is below 0, none. These samples do not count as passes.
 *
 * The estimator mwis stays consistent. The others, mis and cv, are too bright in those pixels, by a
 * share that vanishes with further passes (docs/developer/estimators.md, "8. Three estimators").
 * For fixed budgets use lf_renderer_passes, which never fills holes. */
LF_NODISCARD lf_status lf_renderer_pass_filling(lf_renderer *renderer, const lf_part *part,
                                                int subsets, int hole_reach, lf_row_fn row_done,
                                                void *context, const lf_cancel *cancel);

/* One quick pass for a coarse frame. B and q are computed in every fourth column. Between them,
 * they are interpolated in views without an edge there. The next other visit of the row replaces
 * these values completely. hole_reach as in lf_renderer_pass_filling. */
LF_NODISCARD lf_status lf_renderer_pass_coarse(lf_renderer *renderer, const lf_part *part,
                                               int hole_reach, lf_row_fn row_done, void *context,
                                               const lf_cancel *cancel);

/* Gives rows without visits temporary B, q and features, as in a coarse pass but without paths, so
 * that a fit also has an answer for these rows. Pixels between two rows that differ little are
 * excluded, because lf_fill serves them better. These are not visits: they are not counted or
 * saved, and the first visit replaces them. Scenes with lights in media or with emissive alpha
 * surfaces get none, because only paths find that light. Uses the pool; thread as for passes.
 * LF_E_STATE: no features; LF_E_CANCELLED: only some rows have them. */
LF_NODISCARD lf_status lf_renderer_pass_fans(lf_renderer *renderer, const lf_cancel *cancel);
bool lf_renderer_visited(const lf_renderer *renderer, int row);

/* Draws native samples for all remaining holes in a part's rows, on planes of its stream's visits.
 * This completes a consistent estimate (mwis) of a small budget. Not for mis and cv, whose answer
 * in a hole, B + N/n, is the unbiased one. */
LF_NODISCARD lf_status lf_renderer_fill_holes(lf_renderer *renderer, const lf_part *part,
                                              const lf_cancel *cancel);

/* Called on the worker that has just added `passes` passes to a row; worker 0 is the thread that
 * called lf_renderer_passes. */
typedef void (*lf_passes_fn)(void *context, int passes, int worker);

/* Adds exactly n_passes passes to every row of a part (NULL: all rows); one pass is width x height
 * base paths. They are split evenly between the halves, in visits that grow to whole cycles of
 * n_views passes: the offline schedule. For 45 views, --spp S is 45 S passes. If split is true, a
 * single pass puts one half of its columns into each half of the film (for cross-fitting). */
LF_NODISCARD lf_status lf_renderer_passes(lf_renderer *renderer, const lf_part *part,
                                          int64_t n_passes, bool split, lf_passes_fn row_done,
                                          void *context, const lf_cancel *cancel);

/* The visits of a row that n_passes passes make in an empty film, two whole cycles a call. */
int64_t lf_renderer_visits(const lf_renderer *renderer, int64_t n_passes);

/* What calls of lf_renderer_passes for one part have added to an empty film. Zeroed: none. */
typedef struct lf_asked {
    double given[2]; /* passes of each half */
    uint32_t visits[2];
} lf_asked;

/* lf_renderer_passes for a film that was restored, or that a cancelled call left incomplete. Rows
 * that already had a visit do not get it again; row_done is called for them, too. part (NULL: all
 * rows) is the same in all calls. *at: input, the passes requested before; on success, increased by
 * this call. Repeating the same calls from a zeroed *at, and then others, gives the film of one
 * uninterrupted run. LF_E_STATE: no such calls lead to this film, or the integrator has state
 * besides the film. LF_E_ARG: rows out of range. */
LF_NODISCARD lf_status lf_renderer_passes_after(lf_renderer *renderer, const lf_part *part,
                                                lf_asked *at, int64_t n_passes, bool split,
                                                lf_passes_fn row_done, void *context,
                                                const lf_cancel *cancel);
/* Whether the film holds exactly the passes of *at in the rows of the part, of its stream, and
 * nothing else. */
bool lf_renderer_is_at(const lf_renderer *renderer, const lf_part *part, const lf_asked *at);
/* Whether the integrator in use has no state besides its film. */
bool lf_renderer_is_its_film(const lf_renderer *renderer);
/* Whether a film receives nothing of a pass before its end, so that a cancelled pass is lost. */
bool lf_renderer_spreads(const lf_renderer *renderer);

/* Per-pixel flags of a resolved row. */
/* scattering is possible here but no path found any yet (W = 0): the value is a substitute */
#define LF_PIXEL_HOLE 1u
#define LF_PIXEL_SETTLED 2u /* q = W = 0: no scattering was found here so far */
#define LF_PIXEL_UNSEEN 4u  /* the row has no visit */

/* The estimate of one row of all views. out [n_views][width][3], flags [n_views][width] (may be
 * NULL). Holes get the row's own MIS estimate (B + N/n) and the flag LF_PIXEL_HOLE. LF_E_STATE: the
 * row has no visit (out black, flags LF_PIXEL_UNSEEN). Thread: any; different rows at once, because
 * each call stores the row's holes and error estimate for lf_renderer_stats. Not while the row is
 * being visited. */
lf_status lf_renderer_resolve_row(const lf_renderer *renderer, lf_estimator estimator, int row,
                                  float *out, uint8_t *flags);

/* All rows into out [row][view][column][3] on the renderer's pool. */
LF_NODISCARD lf_status lf_renderer_resolve(const lf_renderer *renderer, lf_estimator estimator,
                                           float *out, uint8_t *flags);

/* Fits the reconstruction, the denoised image (docs/developer/reconstruction.md), of a film with
 * settings.features. The fit uses the film's current sums. It serves rows that are resolved later,
 * also while further passes add to them. Repeat it when n has grown by about a third. Uses the
 * pool; thread as for passes; not during a pass. LF_E_STATE: no features. LF_E_NOMEM,
 * LF_E_CANCELLED (within 20 ms): then there is no fit. */
LF_NODISCARD lf_status lf_renderer_fit(lf_renderer *renderer, const lf_cancel *cancel);
/* Whether the next fit starts from the fit before the last restart with the same scene (the camera
 * moved). It does so until a fit of a film with all rows visited, which no longer depends on it. */
bool lf_renderer_follows(const lf_renderer *renderer);
/* A row of the reconstruction, as lf_renderer_resolve_row. LF_E_STATE also if there is no fit; out
 * is then untouched. */
lf_status lf_renderer_show_row(const lf_renderer *renderer, int row, float *out);
/* Flags of a row [view][column]: LF_PIXEL_UNSEEN where lf_renderer_show_row has no answer, else 0.
 */
void lf_renderer_show_flags(const lf_renderer *renderer, int row, uint8_t *flags);
/* All rows, after a new fit. */
LF_NODISCARD lf_status lf_renderer_show(lf_renderer *renderer, float *out, const lf_cancel *cancel);

/* Other data of view pixels besides colour (AOVs); lf_layer_at has one row for each. */
typedef enum lf_layer {
    /* distance along the view axis in scene units: D over the mean of D/Z over the pixel's rays
     * that scatter, or that meet a mirror or an area light (decided by one ray). 0 if no ray meets
     * any. Needs settings.features */
    LF_LAYER_DEPTH = 1,
    /* the share of rays that count for depth: q, or 1 for a mirror or an area light */
    LF_LAYER_COVERAGE = 2,
    /* mean over the surfaces that 8 pinhole rays meet, ignoring media: unit shading normal towards
     * the camera in world coordinates, and the material's albedo; 0 if no ray meets a surface */
    LF_LAYER_NORMAL = 4,
    LF_LAYER_ALBEDO = 8,
    /* of the estimate per channel, from the difference of the halves. Unbiased, but as noisy as one
     * squared sample. 0 unless both halves have visits */
    LF_LAYER_VARIANCE = 16,
    /* W/q: received samples, in units of native samples; the number of native samples if q is 0 */
    LF_LAYER_SAMPLES = 32,
    /* shadow alpha: the fraction of direct light at shadow catchers (meshes) that is blocked, times
     * the fraction of the pixel's rays that reach a catcher. Uses as many rays as native samples,
     * at least 8. Without volumes at most 1 - coverage */
    LF_LAYER_SHADOW = 64,
    /* radiance that reflection catchers send to the camera from objects (volumes, and meshes that
     * are not catchers), to be added to the background. Mean over the pixel's rays; 0 for rays that
     * reach no catcher. Uses as many rays as LF_LAYER_SHADOW. Each follows the mirror reflection
     * and samples one direction of the other lobes */
    LF_LAYER_REFLECTION = 128,
} lf_layer;

#define LF_MAX_LAYER_CHANNELS 16

typedef struct lf_layer_entry {
    const char *name; /* as in --aov */
    const char *what;
    unsigned bit; /* 1 << its index */
    int n_channels;
    const char *channels[3]; /* channel names in an EXR */
} lf_layer_entry;

/* NULL after the last. */
const lf_layer_entry *lf_layer_at(int index);
/* Number of channels of layers (bits of lf_layer). out_names (may be NULL) gets their names, in the
 * order of the table. */
int lf_layer_channels(unsigned layers, const char *out_names[LF_MAX_LAYER_CHANNELS]);
/* Computes these layers into out [row][view][column][channels], on the pool. A row without visits
 * has the depth and coverage of the nearest visited row, and 0 for variance and samples. So has a
 * pixel of which a provisional row knows nothing. A film without any visit gives 0. LF_E_STATE:
 * depth of a film without features. LF_E_CANCELLED. Thread and time as lf_renderer_resolve. */
LF_NODISCARD lf_status lf_renderer_layers(const lf_renderer *renderer, lf_estimator estimator,
                                          unsigned layers, float *out, const lf_cancel *cancel);
/* One row [view][column][channels]. Thread as lf_renderer_resolve_row. Layers that cost as much as
 * an image (normal, albedo, shadow) cost their share of it per row. */
LF_NODISCARD lf_status lf_renderer_layers_row(const lf_renderer *renderer, lf_estimator estimator,
                                              unsigned layers, int row, float *out);
/* Composites catchers into an image [row][view][column][3] of lf_renderer_resolve: subtracts the
 * backdrop light that their shadows block (LF_LAYER_SHADOW) and adds their reflections
 * (LF_LAYER_REFLECTION). The image is unchanged unless the scene has a catcher and a backdrop. Uses
 * the pool. LF_E_CANCELLED. */
LF_NODISCARD lf_status lf_renderer_catch(const lf_renderer *renderer, float *picture,
                                         const lf_cancel *cancel);

/* The same during rendering: sums that grow with the film, row by row. Each sample of a light
 * serves all views that see its point, each sample of a reflection only its own. 29 bytes per view
 * pixel, and 28 more if a catcher reflects. */
typedef struct lf_caught lf_caught;
/* Prepares empty sums for the renderer's current film; renderer is borrowed. Call it again after
 * each lf_renderer_restart; memory of the same shape is kept. *caught is NULL at first. It becomes
 * NULL if the scene has no catcher or no backdrop, and on LF_E_NOMEM. */
LF_NODISCARD lf_status lf_caught_begin(lf_caught **caught, const lf_renderer *renderer);
/* Accepts NULL. */
void lf_caught_destroy(lf_caught *caught);
/* Adds samples to a row until it has as many as its film (shadows alone: 4096). The first call adds
 * at most 8, each later call one per view pixel. Any thread; different rows at once. */
void lf_caught_add(lf_caught *caught, int row);
/* Light samples per pixel of the row: 0 = none yet. */
int lf_caught_samples(const lf_caught *caught, int row);
/* Whether a row has enough samples to count as converged: 64 light samples and, if a catcher
 * reflects, 16 reflection samples per view pixel. */
bool lf_caught_settled(const lf_caught *caught, int row);
/* Smooths the current sums. Shadows: means over up to 7x7 pixels of similar depth and, from 32
 * samples on, similar shadow; over one pixel at 4096 samples. Reflections with 4 or more samples of
 * their own: means over pixels with as many that differ by no more than noise, so that reflections
 * of sharp objects stay sharp; over one pixel at 4096 samples. Reflections with 2 or 3 samples use
 * one pixel to each side, with 1 sample two, without samples three. Uses the pool; not while
 * samples are added. LF_E_CANCELLED: some rows stay as they were. */
LF_NODISCARD lf_status lf_caught_smooth(lf_caught *caught, const lf_cancel *cancel);
/* lf_renderer_catch for one row [view][column][3]. smooth: use the last smoothed sums if the row
 * has them. A row without samples is unchanged. */
void lf_caught_take(const lf_caught *caught, int row, bool smooth, float *picture);
/* lf_renderer_catch with smoothed sums of as many samples as the film has, for a denoised image.
 * Rows without samples are composited as by lf_renderer_catch. LF_E_NOMEM, LF_E_CANCELLED: some
 * rows of the image may be done. */
LF_NODISCARD lf_status lf_renderer_catch_smoothly(const lf_renderer *renderer, float *picture,
                                                  const lf_cancel *cancel);

/* Counters since the last restart; counters that do not apply are negative (JSON null). */
typedef struct lf_render_stats {
    int64_t base_paths;    /* native samples drawn */
    int64_t contributions; /* additions to a view pixel */
    /* surface rays, including shadow rays; -1 without meshes */
    int64_t rays_traced;
    /* density look-ups, including slices and tracking; -1 without volumes */
    int64_t volume_lookups;
    /* contributions that were NaN or infinite or, for cameras listed one by one, too large for
     * their sums: must be 0 */
    int64_t nonfinite_dropped;
    int64_t suffixes; /* paths that were continued after a first scattering */
    /* paths that max_depth ended, each weighted by its fraction of the light there */
    double suffixes_cut;
    /* CPU seconds of the process in which passes traced light paths. A pass over some rows traces
     * all paths, as a pass over all rows does. */
    double light_path_cpu;
    int max_depth; /* in vertices after the camera */
    /* pivots that the row's section hides from their own base view (V_i forced to 1); -1 without
     * meshes */
    int64_t base_hidden;
    /* view pixels that the last resolve flagged LF_PIXEL_HOLE; 0 before the first resolve */
    int64_t holes;
    int64_t film_bytes;        /* of the sums once all rows have visits, unpacked */
    double passes;             /* mean over rows, in passes */
    double native_spp_mean;    /* n, mean over view pixels */
    double effective_spp_mean; /* contributions per view pixel */
    /* mean over view pixels, epsilon 1e-2, from the two halves; < 0: unknown yet */
    double rel_mse_estimate;
} lf_render_stats;

/* An upper bound, at confidence 1 - alpha (0 < alpha <= 0.5), of the relMSE of the current image:
 * the mean over view pixels and channels of (x - I)^2 / (I^2 + 1e-2), x the answer of
 * lf_renderer_resolve and I the true value. Computed from the halves, row by row. *out_estimate
 * (may be NULL) gets the estimate of the relMSE. Negative if a row lacks a visit of either half, if
 * the error is zero and rows have had few visits, if the image is not finite, or without memory.
 * Takes about as long as two resolves, on the pool; same thread as lf_renderer_resolve.
 * docs/developer/estimators.md, "10. The error estimate". */
/* The programs' alpha: 95 % confidence. */
#define LF_ERROR_ALPHA 0.05
double lf_renderer_error_bound(const lf_renderer *renderer, lf_estimator estimator, double alpha,
                               double *out_estimate);
/* lf_renderer_error_bound for the denoised image of the last fit: x is the answer of
 * lf_renderer_show_row, including the bias that it shares with its neighbours. Both numbers are
 * negative if there is no fit, if a row lacks a visit of either half, or if it was cancelled (NULL:
 * never). docs/developer/reconstruction.md, "The stated error". */
double lf_renderer_shown_error(const lf_renderer *renderer, double alpha, double *out_estimate,
                               const lf_cancel *cancel);

/* The share of scattered light that may be missing because paths end at max_depth. Exact if these
 * paths would have found as much light as the others. 0 without paths. */
static inline double lf_render_cut(const lf_render_stats *stats)
{
    return stats->suffixes > 0 ? stats->suffixes_cut / (double)stats->suffixes : 0.0;
}

/* Not during a pass or a resolve: it reads the workers' counters and the results of
 * lf_renderer_resolve_row. */
void lf_renderer_stats(const lf_renderer *renderer, lf_render_stats *out);
/* The optimisations used for this scene: {"volumes": "none in the scene", …}. A new reference. */
json_t *lf_renderer_skipped(const lf_renderer *renderer);
const lf_render_settings *lf_renderer_settings(const lf_renderer *renderer);
lf_scene *lf_renderer_scene(const lf_renderer *renderer);

/* Whether two scenes and settings differ only in display (film) and random numbers, so that one can
 * continue the accumulation of the other. Also false without memory. */
bool lf_same_picture(const lf_scene *a, const lf_render_settings *of_a, const lf_scene *b,
                     const lf_render_settings *of_b);
/* Hash of all that defines the image of these settings, except random numbers, as 64 hexadecimal
 * digits and a 0: what the scene shows, volume files, rig, and settings. LF_E_NOMEM. */
#define LF_PICTURE_HASH 65
LF_NODISCARD lf_status lf_picture_hash(const lf_scene *scene, const lf_render_settings *settings,
                                       char out[static LF_PICTURE_HASH]);
/* Save and restore the accumulation (kind "state": --state), in the format of film/film_file.h. A
 * state holds the sums, a hash of what they show (scene, volume files, rig and settings without the
 * seed), and which visits of which random streams are included. lf_renderer_save writes through
 * file, restore reads from fd. Restoring keeps samples of another seed and continues with its own.
 * Restoring errors: LF_E_STATE for another image or version, LF_E_FORMAT for a file that is
 * truncated or changed; the renderer is then as before. cancel (may be NULL) is checked once per
 * row: LF_E_CANCELLED, and the caller must abandon the file. */
LF_NODISCARD lf_status lf_renderer_save(const lf_renderer *renderer, lf_outfile *file,
                                        const lf_cancel *cancel, lf_error *err);
LF_NODISCARD lf_status lf_renderer_restore(lf_renderer *renderer, int fd, lf_error *err);
/* Identity of a state, for programs that keep several. Hashes are parts of SHA-256s. Two states
 * have the same `whole` if one can continue the other and they have the same seed. The other fields
 * show what differs. */
enum { LF_STATE_HASH = 4 };
typedef struct lf_state_id {
    uint8_t scene[LF_STATE_HASH], camera[LF_STATE_HASH], whole[LF_STATE_HASH];
    int n_views, width, height; /* of a view */
    uint64_t seed;
} lf_state_id;

/* The identity of a renderer's accumulation. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_renderer_state_id(const lf_renderer *renderer, lf_state_id *out);
/* Reads the identity from the start of a state file, except the hashes, which are 0. seed is the
 * seed of the first stream. LF_E_IO, LF_E_FORMAT, LF_E_STATE (another version). */
LF_NODISCARD lf_status lf_state_look(int fd, lf_state_id *out, lf_error *err);
/* Counts the rows with visits in a state file, from its start, without reading their sums. Errors
 * as of lf_state_look; also LF_E_NOMEM. */
LF_NODISCARD lf_status lf_state_rows(int fd, int *out_rows, lf_error *err);
/* Adds what another renderer has accumulated of the same views in another part of the shutter. Each
 * part counts with its share of the samples. from is unchanged; neither renderer may be rendering.
 * LF_E_STATE, with no change: their films store different data (other views, material kinds or
 * constant sky), or both have visits of the same half of a row by the same stream of one seed.
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_renderer_mix(lf_renderer *renderer, const lf_renderer *from,
                                       lf_error *err);

#endif
