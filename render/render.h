/* render: from a scene file to a film of N views.
 *
 * A scene is loaded, committed and from then on immutable and reference counted; a new scene made
 * by a patch shares whatever did not change with the one before (moving the camera rebuilds no BVH
 * and reloads no volume). A renderer adds samples of one scene, seen by one rig, to a film; the
 * film answers with three estimates of every view pixel.
 *
 * Coordinates: right-handed, y up, scene units; angles in degrees in scene files and radians behind
 * the parser; colours linear Rec. 709, radiance in W m^-2 sr^-1. Views are numbered from the
 * leftmost camera. Rows count from the top. docs/developer/estimators.md holds the formulas.
 *
 * A whole picture, better with every round, rgb [row][view][column][3] (tests/render/test_usage.c
 * compiles and runs these lines):
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

/* How a file of a mesh or a volume is shown that stands in a scene's place
 * (docs/reference/scene-format.md, "Files without a scene"). Zeroed: turned as its kind is, its
 * front towards the eye, on a ground, in a studio. */
typedef enum lf_up { LF_UP_OF_FILE, LF_UP_Y, LF_UP_Z } lf_up;
typedef struct lf_alone {
    bool bare;               /* no ground, no studio: before a dark backdrop */
    bool has_yaw, has_pitch; /* they were given: a camera of the file is not used then */
    double yaw, pitch;       /* degrees by which the eye is to the right of +z, and above */
    lf_up up;                /* which axis of the file leads upwards */
} lf_alone;
/* Its options and keys. */
extern const lf_param lf_alone_params[];

/* Loads a scene file (JSON, at most 16 MiB) and those that it includes. Files it names are read
 * relative to its folder and under roots (NULL or empty = anywhere; the scene's own folder is
 * always allowed, but where the roots are closed). previous (may be NULL): parts of it that are
 * unchanged are shared. On LF_OK the caller owns a reference to *out_scene. Errors: LF_E_IO,
 * LF_E_PATH, LF_E_NOMEM, LF_E_FORMAT with file, line and JSON pointer; *out_scene untouched then.
 * Thread: any; may take seconds; does not touch previous but to read it.
 */
LF_NODISCARD lf_status lf_scene_load(const char *path, const lf_roots *roots,
                                     const lf_scene *previous, lf_scene **out_scene, lf_error *err);

/* The same, with a merge patch laid over what the file says (NULL: none), and of a file without a
 * scene as alone says (NULL: zeroed); lines in errors are those of the file. */
LF_NODISCARD lf_status lf_scene_load_patched(const char *path, const lf_alone *alone,
                                             const json_t *patch, const lf_roots *roots,
                                             const lf_scene *previous, lf_scene **out_scene,
                                             lf_error *err);

/* The same from a document in memory; folder is what relative paths are relative to. where names it
 * in errors. The scene keeps a reference to doc, and shares its values: nobody may change them from
 * now on. It may include files, relative to folder. A document of more than 16 MiB (in the shortest
 * way to write it), also of one that includes others or was patched, is LF_E_NOMEM. */
LF_NODISCARD lf_status lf_scene_from_json(const json_t *doc, const char *folder, const char *where,
                                          const lf_roots *roots, const lf_scene *previous,
                                          lf_scene **out_scene, lf_error *err);

/* JSON Merge Patch (RFC 7396) of a scene's document; former names of keys in the patch count as
 * their current names (docs/reference/scene-format.md). A new reference, NULL = out of memory. The
 * result shares with doc and patch what it takes from them: nobody may change their values from now
 * on. */
json_t *lf_json_merge_patch(const json_t *doc, const json_t *patch);
/* The same of an object in place, which is the caller's own (members that others hold, too, are
 * copied before they change). It shares values with the patch. false: out of memory, the object is
 * half patched. */
LF_NODISCARD bool lf_json_merge_into(json_t *target, const json_t *patch);

/* Whether what the scene says of another frame is right, and the volumes' files of it are there,
 * without reading them: LF_E_IO, LF_E_FORMAT with their place in the document. */
LF_NODISCARD lf_status lf_scene_check_frame(const lf_scene *scene, int frame, lf_error *err);
/* The box about the volumes and meshes of a scene without its grounds (name NULL), or about those
 * of this name, in world coordinates: least and greatest corner. Lights at a distance, skies and
 * what the camera does not see have none. false: nothing is there. */
bool lf_scene_bounds(const lf_scene *scene, const char *name, double out_bounds[2][3]);
/* The meshes that lf_scene_bounds leaves out as grounds: what the scene says, or else the rule of
 * docs/reference/scene-format.md, "Framing". NULL behind the last; the names belong to the scene.
 */
const char *lf_scene_ground(const lf_scene *scene, int index);
/* The JSON Schema of scene files (docs/scene.schema.json, compiled in); a new reference. */
json_t *lf_scene_schema(void);

/* ---------------------------------------------------------------------------------- renderer -- */

/* How to answer from a film (docs/developer/estimators.md, "8. Three estimators"). */
typedef enum lf_estimator {
    /* B + q N/W or B + q N/W', per tile the one of smaller variance; consistent; the default */
    LF_ESTIMATOR_MWIS,
    LF_ESTIMATOR_MIS, /* B + N/n; unbiased */
    /* regression on both controls, coefficients from the other half; unbiased for fixed budgets */
    LF_ESTIMATOR_CV,
} lf_estimator;

/* Names of an lf_estimator and an lf_sampler_kind, as on the command line; NULL behind the last. */
const char *lf_estimator_name(int estimator);
const char *lf_sampler_name(int kind);

/* How paths are made and shared. */
typedef struct lf_integrator_entry {
    const char *name; /* as in --integrator */
    const char *what; /* in a few words */
    bool shares;      /* a path serves more view pixels than its own */
    unsigned takes;   /* which rows of lf_integrator_params, a bit each */
    /* picture files show its reconstruction unless told otherwise; false: it is there to compare
     * with, or has none */
    bool reconstructs;
    bool remembers; /* more than its film: lf_renderer_passes_after does not take it */
    /* What a scene and its picture may have: others are refused (lf_renderer_create) */
    lf_traits supports;
} lf_integrator_entry;

/* The first is the default; NULL behind the last. */
const lf_integrator_entry *lf_integrator_at(int index);
/* The one of this name, NULL = the default. NULL: there is none. */
const lf_integrator_entry *lf_integrator_named(const char *name);
/* The reference modes, which are there where a program has them added (papers/papers.h); NULL
 * behind the last. */
const char *lf_integrator_reference(int index);

/* What integrators are told beside their names: of the words of each row of lf_integrator_params
 * one, 0 the first. given: somebody said so. */
enum { LF_MAX_CHOICES = 4 };
typedef struct lf_choices {
    int of[LF_MAX_CHOICES];
    bool given[LF_MAX_CHOICES];
} lf_choices;
/* Options of all integrators that are there, into an lf_choices; `about` is what an integrator that
 * does not take one "knows no" of. */
const lf_param *lf_integrator_params(void);
/* The row of a choice that was given, or is not its first, of which an integrator knows nothing;
 * NULL: there is none. */
const lf_param *lf_choices_unfit(const lf_choices *choices, const lf_integrator_entry *entry);
/* Leaves those out. */
void lf_choices_fit(lf_choices *choices, const lf_integrator_entry *entry);

/* What is left out where the scene or the view does not need it. One row of lf_skip_at each. */
typedef enum lf_skip {
    LF_SKIP_SURFACES = 1,
    LF_SKIP_BACKGROUND = 2,
    LF_SKIP_DELTA_LOBES = 4,
    LF_SKIP_VIEW_LOBES = 8,
    LF_SKIP_EMISSION = 16,
    LF_SKIP_KNOWN_LIGHT = 32,
    LF_SKIP_PATHS = 64,
    LF_SKIP_ALL = 127, /* what programs use */
} lf_skip;

typedef struct lf_skip_entry {
    const char *name; /* as in --skip */
    const char *what; /* when, and what is left out */
    unsigned bit;     /* 1 << its index */
    bool bitwise;     /* the picture is the same to the last bit without it; else to rounding */
} lf_skip_entry;

/* NULL behind the last. */
const lf_skip_entry *lf_skip_at(int index);

typedef struct lf_render_settings {
    lf_camera camera;  /* the rig, after --preset, --panel and --views had their say */
    int width, height; /* pixels of a view */
    /* left, top, right, bottom of what the view pixels tile, in units of the camera's window with
     * its top left corner at 0,0 and bottom right at 1,1; all zero = 0,0,1,1. Prints and bleed go
     * beyond */
    double window[4];
    const char *integrator; /* a name of the table; NULL = "mvpt" */
    lf_sampler_kind sampler;
    uint64_t seed;
    int max_depth;      /* longest path in vertices after the camera; 0 = the scene's own limit */
    unsigned skip;      /* of lf_skip: what is left out where it is not needed */
    bool features;      /* the film keeps what the reconstruction needs: 16 bytes a view pixel */
    lf_choices choices; /* LF_E_ARG: one that the integrator does not take */
} lf_render_settings;

/* ----------------------------------------------------------------------------------- framing -- */

/* How deep the picture is, of the boxes of meshes and volumes as far as the middle of the rig sees
 * them through the window; grounds that the scene says to be such go on to the horizon and do not
 * count. A step is how far a thing jumps from one view to the next beside the
 * window, in pixels of a view: between cameras b apart a point at distance Z along the view axis
 * moves by b (1 - D/Z), D the window's distance. Positive behind the window, negative before it;
 * -INFINITY where things begin at the cameras. What is finer than its step is not seen once but
 * several times. docs/reference/scene-format.md, "Depth". */
typedef struct lf_depth {
    double nearest, farthest; /* Z, scene units */
    double nearest_step, farthest_step;
    /* Z between which steps stay within the limit: what a panel shows sharply, as far as its views
     * go. INFINITY: it has no end there. */
    double sharp_from, sharp_to;
    /* Steps beyond it (4 % of the window, at least 4 pixels) show as edges beside edges, and are
     * what programs warn of. exceeded: there are such, and no view_blur that makes them smooth. */
    double limit;
    bool exceeded;
} lf_depth;

/* false: there is one view, or nothing in it; views have windows of their own; or the settings are
 * out of range. */
bool lf_scene_depth(const lf_scene *scene, const lf_render_settings *settings, lf_depth *out);

/* Whether the box of at least one volume or mesh that is no ground lies in a view of the rig; true,
 * too, where there is no such box, and of rigs with several windows (tracks, lists of cameras), of
 * which nothing is known. False: the picture shows nothing but grounds and backdrop. */
bool lf_scene_is_seen(const lf_scene *scene, const lf_render_settings *settings);

/* What framing fills of the window unless somebody says otherwise. */
#define LF_CAMERA_FILL 0.9

/* Where to put the camera of settings so that the box of lf_scene_bounds is in the middle of the
 * window, looked at from the same side as now, and in all views fills at most the share `fill`
 * (above 0, at most 1) of it across and up: as near as that allows. A camera that would stand
 * beneath a ground looks level instead. steps > 0: no nearer than where no part of the box has a
 * step beyond that, which makes it smaller in the window. LF_E_ARG: nothing is there, or fill or
 * steps are out of range; errors of the rig. */
LF_NODISCARD lf_status lf_camera_fit(const lf_scene *scene, const lf_render_settings *settings,
                                     const char *name, double fill, double steps,
                                     double out_target[3], double out_position[3], lf_error *err);

typedef struct lf_renderer lf_renderer;

/* A renderer with an empty film. Keeps a reference to scene; pool is borrowed and must outlive it.
 * LF_E_ARG for settings out of range (err says which), LF_E_NOMEM. Memory: 40 to 64 bytes a view
 * pixel (film.h), 32 more where cameras are listed one by one, and 12 for every triangle and row
 * that can meet it: with a wide lens those are many rows (section.h). */
LF_NODISCARD lf_status lf_renderer_create(lf_scene *scene, const lf_render_settings *settings,
                                          lf_pool *pool, lf_renderer **out_renderer, lf_error *err);
/* Accepts NULL. */
void lf_renderer_destroy(lf_renderer *renderer);

/* Starts over with another scene or camera, keeping the film's memory when the shapes agree:
 * nothing of the old picture remains. On failure the renderer is as before. */
LF_NODISCARD lf_status lf_renderer_restart(lf_renderer *renderer, lf_scene *scene,
                                           const lf_render_settings *settings, lf_error *err);

/* Called on the worker that has just finished a visit of a row: resolve it here, while it is in the
 * cache. */
typedef void (*lf_row_fn)(void *context, int row, int worker);

/* What of the picture passes go to: rows first_row, first_row + row_step, … below end_row, by one
 * of 2^32 streams of random numbers of the seed. All zero: the whole, by stream 0. Rows do not know
 * of each other: a film gathered from parts of other rows (lf_renderer_add) has the bytes that one
 * renderer makes of the same calls. Streams of one row add up to the same numbers but for rounding.
 * Cameras listed one by one share across the rows of a pass, which makes its bytes: other parts
 * make others, and the film has a pass when all of it is done, behind row_done. Holes are filled by
 * what all of a row's streams have found, and integrators that send samples where the error is
 * (amvpt) look at all rows before they do. */
typedef struct lf_part {
    int first_row, end_row; /* end_row 0 = to the last row */
    int row_step;           /* 0 = 1 */
    uint32_t stream;
} lf_part;

/* One pass over a part (NULL: the whole). Each visited row gets `subsets` passes at once, out of
 * the n_views that make one native sample a view pixel (1 <= subsets <= n_views): they share one
 * row offset, one slice of the volumes and one refresh of B and q. Successive visits of a row
 * alternate between the film's two halves. row_done may be NULL. LF_E_CANCELLED: rows not started
 * have been left out; a row in progress is left within 20 ms as it was before this visit. Same seed
 * and same sequence of calls give the same film for any number of threads. Allocates nothing but
 * for the first pass of a second stream (LF_E_NOMEM; LF_E_STATE: the film has 65536 of others).
 * LF_E_ARG: rows or subsets out of range. */
LF_NODISCARD lf_status lf_renderer_pass(lf_renderer *renderer, const lf_part *part, int subsets,
                                        lf_row_fn row_done, void *context, const lf_cancel *cancel);

/* The same for the live picture: behind its visit a row gets native samples for holes
 * (LF_PIXEL_HOLE), with hole_reach 0 for all of them, else for so many that none is farther than
 * hole_reach columns from a pixel of its view and row that has something, which is what a coarse
 * frame needs; hole_reach < 0 is lf_renderer_pass. They do not count as passes. mwis stays
 * consistent; mis and cv are too bright in those pixels by a share that vanishes with further
 * passes (docs/developer/estimators.md, "8. Three estimators"): fixed budgets use
 * lf_renderer_passes, which never does this. */
LF_NODISCARD lf_status lf_renderer_pass_filling(lf_renderer *renderer, const lf_part *part,
                                                int subsets, int hole_reach, lf_row_fn row_done,
                                                void *context, const lf_cancel *cancel);

/* One pass for a coarse frame, which is there soon: B and q are those of every fourth column, and
 * interpolated in views that have no edge between two of these, until the row is visited otherwise:
 * then nothing of them is left in the film. hole_reach as in lf_renderer_pass_filling. */
LF_NODISCARD lf_status lf_renderer_pass_coarse(lf_renderer *renderer, const lf_part *part,
                                               int hole_reach, lf_row_fn row_done, void *context,
                                               const lf_cancel *cancel);

/* Gives rows that nothing has visited B, q and features for the time being, those of a coarse pass
 * and no paths: so a fit of the rows that were visited has an answer for these, too, but for pixels
 * that lie between two rows which change little: these are best filled (lf_fill). They are no
 * visits: nothing else knows of them, none is saved, and nothing of them is left behind the first
 * visit. Scenes with lights in media or veils that glow, which paths alone find, have none. On the
 * pool, the thread of passes. LF_E_STATE: no features; LF_E_CANCELLED: some rows have theirs. */
LF_NODISCARD lf_status lf_renderer_pass_fans(lf_renderer *renderer, const lf_cancel *cancel);
bool lf_renderer_visited(const lf_renderer *renderer, int row);

/* Native samples for all holes that are left in a part's rows, on planes of its stream's visits,
 * and nothing else: what a consistent answer (mwis) of a small budget lacks. Not for mis and cv,
 * whose answer in a hole, B + N/n, is the unbiased one.
 */
LF_NODISCARD lf_status lf_renderer_fill_holes(lf_renderer *renderer, const lf_part *part,
                                              const lf_cancel *cancel);

/* Called on the worker that has just given a row so many more passes; worker 0 is the thread that
 * called lf_renderer_passes. */
typedef void (*lf_passes_fn)(void *context, int passes, int worker);

/* Adds exactly n_passes passes (one pass = one view's worth of base paths: width x height of them)
 * to every row of a part (NULL: the whole), split evenly between the halves, in visits that grow to
 * whole cycles of n_views passes: the offline schedule. 45 views:
 * --spp S is 45 S passes. A single pass with cross-fitting in mind (split) puts one half of its
 * columns into each half. */
LF_NODISCARD lf_status lf_renderer_passes(lf_renderer *renderer, const lf_part *part,
                                          int64_t n_passes, bool split, lf_passes_fn row_done,
                                          void *context, const lf_cancel *cancel);

/* What lf_renderer_passes has given a film that was empty before, by calls of it for all rows.
 * Zeroed: nothing. */
typedef struct lf_asked {
    double given[2]; /* passes of each half */
    uint32_t visits[2];
} lf_asked;

/* lf_renderer_passes for a film that was restored, or is there of a call that was cancelled: rows
 * that had a visit already do not get it again, but row_done hears of them, too. *at: what was
 * asked for before, and with success what was asked for now, too. The same calls as before from a
 * zeroed *at on, and then others, leave the film that they would have left at once.
 * LF_E_STATE: no such calls have left this film, or the integrator remembers more than it. */
LF_NODISCARD lf_status lf_renderer_passes_after(lf_renderer *renderer, lf_asked *at,
                                                int64_t n_passes, bool split, lf_passes_fn row_done,
                                                void *context, const lf_cancel *cancel);
/* Whether that is all that the film holds. */
bool lf_renderer_is_at(const lf_renderer *renderer, const lf_asked *at);
/* Whether the integrator in use remembers nothing beside its film. */
bool lf_renderer_is_its_film(const lf_renderer *renderer);

/* Per-pixel flags of a resolved row. */
/* scattering is possible here but nothing was found yet (W = 0): out is a stand-in */
#define LF_PIXEL_HOLE 1u
#define LF_PIXEL_SETTLED 2u /* q = W = 0: nothing that scatters has been met here so far */
#define LF_PIXEL_UNSEEN 4u  /* the row was never visited */

/* The estimate of one row of all views. out [n_views][width][3], flags [n_views][width] (may be
 * NULL); holes are returned as the row's own estimate from MIS (B + N/n) and flagged. LF_E_STATE
 * when the row was never visited (out black, flags LF_PIXEL_UNSEEN). Thread: any, for different
 * rows at once (each call leaves the row's holes and error estimate for lf_renderer_stats); not
 * while the row is being visited. */
lf_status lf_renderer_resolve_row(const lf_renderer *renderer, lf_estimator estimator, int row,
                                  float *out, uint8_t *flags);

/* All rows into out [row][view][column][3] on the renderer's pool. */
LF_NODISCARD lf_status lf_renderer_resolve(const lf_renderer *renderer, lf_estimator estimator,
                                           float *out, uint8_t *flags);

/* The reconstructed picture (docs/developer/reconstruction.md): of a film with settings.features. A
 * fit takes what the film holds now, for rows that are resolved from then on, also while further
 * passes add to them: to be made again when n has grown by a third or so. On the pool, the thread
 * of passes; not while a pass is under way. LF_E_STATE: no features. LF_E_NOMEM; LF_E_CANCELLED:
 * within 20 ms; there is no fit then. */
LF_NODISCARD lf_status lf_renderer_fit(lf_renderer *renderer, const lf_cancel *cancel);
/* Whether the next fit begins with what the last one knew before the renderer was restarted with
 * the same scene (the camera has moved): until one of a film with all rows visited was made, in
 * which nothing is left of it. */
bool lf_renderer_follows(const lf_renderer *renderer);
/* A row of it, as lf_renderer_resolve_row; LF_E_STATE also where there is no fit: out is untouched.
 */
lf_status lf_renderer_show_row(const lf_renderer *renderer, int row, float *out);
/* Of the pixels of a row [view][column]: LF_PIXEL_UNSEEN where that has no answer, else 0. */
void lf_renderer_show_flags(const lf_renderer *renderer, int row, uint8_t *flags);
/* All rows, by a fit made now. */
LF_NODISCARD lf_status lf_renderer_show(lf_renderer *renderer, float *out, const lf_cancel *cancel);

/* What is known of view pixels besides their colour: a row of lf_layer_at each. */
typedef enum lf_layer {
    /* D over the mean of D/Z where rays through the pixel scatter, or meet a mirror or lamp (told
     * by one ray), which is its place for the eye: scene units along the view axis; 0 where nothing
     * is met. Of films with settings.features. */
    LF_LAYER_DEPTH = 1,
    LF_LAYER_COVERAGE = 2, /* the share of rays that do: q, or 1 before a mirror or lamp */
    /* Of the surfaces that 8 rays of a pinhole camera meet, whatever media stand before them:
     * shading normals towards the camera, their mean made unit, in world coordinates, and the mean
     * of what materials call albedo; 0 where none meets any. */
    LF_LAYER_NORMAL = 4,
    LF_LAYER_ALBEDO = 8,
    /* Of the estimate in each channel, from the difference of the halves: right on average, and by
     * itself as uncertain as one square is. 0 unless both have been visited. */
    LF_LAYER_VARIANCE = 16,
    LF_LAYER_SAMPLES = 32, /* W/q: what was found, in native samples; their number where q is 0 */
    /* The share of the light of lights that is missing at catchers (meshes) for what stands before
     * it, times the share of a pixel's rays that comes to one: what is missing of what is seen
     * behind it. By as many rays as there are native samples, at least 8; without volumes no more
     * than coverage leaves. */
    LF_LAYER_SHADOW = 64,
    /* What catchers that reflect send to the camera of things (meshes that are no catchers,
     * volumes), to be added to what is seen through them: radiance, the mean over a pixel's rays, 0
     * of those that come to none. By as many rays; each follows what a mirror would show, and draws
     * one direction of what is not mirrored. */
    LF_LAYER_REFLECTION = 128,
} lf_layer;

#define LF_MAX_LAYER_CHANNELS 16

typedef struct lf_layer_entry {
    const char *name; /* as in --aov */
    const char *what;
    unsigned bit; /* 1 << its index */
    int n_channels;
    const char *channels[3]; /* their names in an EXR */
} lf_layer_entry;

/* NULL behind the last. */
const lf_layer_entry *lf_layer_at(int index);
/* How many channels layers (bits of lf_layer) have; their names, in the order of the table, into
 * out_names (may be NULL). */
int lf_layer_channels(unsigned layers, const char *out_names[LF_MAX_LAYER_CHANNELS]);
/* out [row][view][column][channels] of these layers, on the pool. Rows that were never visited have
 * the depth and coverage of the nearest one that was, and 0 for variance and samples; a film
 * without any visit is 0. LF_E_STATE: depth of a film without features. LF_E_CANCELLED. Thread and
 * time as lf_renderer_resolve. */
LF_NODISCARD lf_status lf_renderer_layers(const lf_renderer *renderer, lf_estimator estimator,
                                          unsigned layers, float *out, const lf_cancel *cancel);
/* One row [view][column][channels]. Thread as lf_renderer_resolve_row; layers that take a picture's
 * time (normal, albedo, shadow) take their share of it. */
LF_NODISCARD lf_status lf_renderer_layers_row(const lf_renderer *renderer, lf_estimator estimator,
                                              unsigned layers, int row, float *out);
/* Takes from a picture, [row][view][column][3] as lf_renderer_resolve makes it, what the shadows of
 * catchers (LF_LAYER_SHADOW) take from the backdrop, and adds what they reflect
 * (LF_LAYER_REFLECTION); it stays as it is where the scene has not catcher and backdrop. On the
 * pool. LF_E_CANCELLED. */
LF_NODISCARD lf_status lf_renderer_catch(const lf_renderer *renderer, float *picture,
                                         const lf_cancel *cancel);

/* The same while a picture is rendered: sums that grow with the film, row by row, each sample of
 * lights in all views that see its point, of reflections in its own. 29 bytes a view pixel, and 28
 * more where a catcher reflects. */
typedef struct lf_caught lf_caught;
/* For the film that renderer (borrowed) has now: again after each lf_renderer_restart; sums are
 * empty then, memory of the same shape is kept. *caught begins as NULL, and is NULL where the scene
 * has no catcher or no backdrop. LF_E_NOMEM: NULL, too. */
LF_NODISCARD lf_status lf_caught_begin(lf_caught **caught, const lf_renderer *renderer);
/* Accepts NULL. */
void lf_caught_destroy(lf_caught *caught);
/* Samples of a row until there are as many as its film has (of shadows alone 4096), but at most 8
 * in the first call and one of every view pixel in each later one. Any thread, rows at once, each
 * by one. */
void lf_caught_add(lf_caught *caught, int row);
/* Samples of lights behind a pixel of the row: 0 = none yet. */
int lf_caught_samples(const lf_caught *caught, int row);
/* Whether a row has enough to be called converged: 64 of them, and where a catcher reflects 16 of
 * the reflections of each view pixel. */
bool lf_caught_settled(const lf_caught *caught, int row);
/* Makes a smooth shade of what there is now, by means over up to 7x7 pixels as deep and, from
 * 32 samples on, as dark: over one where there are 4096 samples. Reflections of a view pixel with 4
 * samples of its own or more are averaged with those of as many that differ by no more than chance,
 * so that the image of a sharp thing stays sharp, and over one pixel where there are 4096; with 2
 * or 3 over a pixel to each side, with 1 over two and with none over three. On the pool;
 * not while rows are added to. LF_E_CANCELLED: some are as they were. */
LF_NODISCARD lf_status lf_caught_smooth(lf_caught *caught, const lf_cancel *cancel);
/* lf_renderer_catch of one row [view][column][3], smooth as it was made last, where it was; without
 * samples it stays as it is. */
void lf_caught_take(const lf_caught *caught, int row, bool smooth, float *picture);
/* lf_renderer_catch by such sums, of as many samples as the film has, made smooth: for a
 * reconstructed picture. Rows without samples get theirs as there. LF_E_NOMEM, LF_E_CANCELLED: of
 * the picture some rows may be done. */
LF_NODISCARD lf_status lf_renderer_catch_smoothly(const lf_renderer *renderer, float *picture,
                                                  const lf_cancel *cancel);

/* Counters since the last restart; what does not apply is negative (JSON null). */
typedef struct lf_render_stats {
    int64_t base_paths;    /* native samples drawn */
    int64_t contributions; /* additions to a view pixel */
    /* surface rays, light samples' occlusion rays included; -1 without meshes */
    int64_t rays_traced;
    /* density look-ups, slices and tracking included; -1 without volumes */
    int64_t volume_lookups;
    /* contributions that were NaN or infinite, or, of cameras listed one by one, too great for
     * their sums: must be 0 */
    int64_t nonfinite_dropped;
    int64_t suffixes;    /* paths that were followed behind a first scattering */
    double suffixes_cut; /* those that max_depth has ended, each as the part of its light there */
    int max_depth;       /* in vertices after the camera */
    /* pivots that the row's section hides from their own base (V_i forced to 1); -1 without meshes
     */
    int64_t base_hidden;
    /* view pixels flagged LF_PIXEL_HOLE by the estimator last resolved; 0 before the first resolve
     */
    int64_t holes;
    int64_t film_bytes;        /* memory of the sums once all rows were visited */
    double passes;             /* mean over rows, in passes */
    double native_spp_mean;    /* n, mean over view pixels */
    double effective_spp_mean; /* contributions a view pixel */
    /* mean over view pixels, epsilon 1e-2, from the two halves; < 0 = not known yet */
    double rel_mse_estimate;
} lf_render_stats;

/* An upper bound, at confidence 1 - alpha (0 < alpha <= 0.5), of the relMSE of this very picture:
 * of mean over view pixels and channels of (x - I)^2 / (I^2 + 1e-2), x what lf_renderer_resolve
 * answers now and I the truth. From the halves, row by row; *out_estimate (may be NULL) gets the
 * estimate of the same. Negative while a row has not been seen by both halves, while there is no
 * error at all and rows have had few visits, where the picture is not finite, or without memory.
 * Takes about as long as two resolves, on the pool; same thread as lf_renderer_resolve.
 * docs/developer/estimators.md, "10. The error estimate". */
/* What programs use: 95 %. */
#define LF_ERROR_ALPHA 0.05
double lf_renderer_error_bound(const lf_renderer *renderer, lf_estimator estimator, double alpha,
                               double *out_estimate);
/* The same of the reconstructed picture by the last fit: x what lf_renderer_show_row answers, with
 * the bias that it shares with its neighbours. Both are negative while there is no fit, or a row
 * has not been seen by both halves, or when it was cancelled (NULL: never).
 * docs/developer/reconstruction.md, "The stated error". */
double lf_renderer_shown_error(const lf_renderer *renderer, double alpha, double *out_estimate,
                               const lf_cancel *cancel);

/* The share of what is scattered that may be missing as paths end at max_depth: exact where these
 * would have found as much light as others. 0 without paths. */
static inline double lf_render_cut(const lf_render_stats *stats)
{
    return stats->suffixes > 0 ? stats->suffixes_cut / (double)stats->suffixes : 0.0;
}

/* Not while a pass or a resolve is under way: it reads what workers count and what resolving a row
 * leaves behind. */
void lf_renderer_stats(const lf_renderer *renderer, lf_render_stats *out);
/* {"volumes": "none in the scene", …}: what this scene did not need and was left out. A new
 * reference. */
json_t *lf_renderer_skipped(const lf_renderer *renderer);
const lf_render_settings *lf_renderer_settings(const lf_renderer *renderer);
lf_scene *lf_renderer_scene(const lf_renderer *renderer);

/* Whether an accumulation of one scene and settings may go on as that of the others: they differ in
 * nothing but how it is shown (film) and random numbers. false also when there is no memory. */
bool lf_same_picture(const lf_scene *a, const lf_render_settings *of_a, const lf_scene *b,
                     const lf_render_settings *of_b);
/* Saves and restores the accumulation (kind "state": --state), in the format of film/film_file.h:
 * the sums, what they are a picture of (scene, files of volumes, rig and settings, not the seed),
 * and which visits of which random streams are in them. Restoring gives LF_E_STATE for another
 * picture or version, LF_E_FORMAT for a file that was cut or changed, and then leaves the renderer
 * as it was; what was accumulated with another seed is kept, and gone on with by one's own.
 * Written through file; read from fd. cancel (may be NULL) is looked at once a row: LF_E_CANCELLED,
 * the file is to be abandoned. */
LF_NODISCARD lf_status lf_renderer_save(const lf_renderer *renderer, lf_outfile *file,
                                        const lf_cancel *cancel, lf_error *err);
LF_NODISCARD lf_status lf_renderer_restore(lf_renderer *renderer, int fd, lf_error *err);
/* What a state is of, to whoever keeps several. Hashes are parts of SHA-256s; two states have the
 * same `whole` when one can be gone on with as the other and they have the same seed; what differs
 * otherwise, the rest tells. */
enum { LF_STATE_HASH = 4 };
typedef struct lf_state_id {
    uint8_t scene[LF_STATE_HASH], camera[LF_STATE_HASH], whole[LF_STATE_HASH];
    int n_views, width, height; /* of a view */
    uint64_t seed;
} lf_state_id;

/* Of what a renderer accumulates. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_renderer_state_id(const lf_renderer *renderer, lf_state_id *out);
/* What the head of a state says, read from its start: all but the hashes, which are 0; the seed
 * that its first stream has. LF_E_IO, LF_E_FORMAT, LF_E_STATE (another version). */
LF_NODISCARD lf_status lf_state_look(int fd, lf_state_id *out, lf_error *err);
/* Adds what another renderer of the same picture has saved: rows that only one of them has are
 * taken as they are, of others sums are added, half by half. Errors as of restoring; LF_E_STATE too
 * where both have visited the same half of a row by the same stream. Which is added to which makes
 * no difference to a bit. Where sums are no floats they are rounded at random, without bias. */
LF_NODISCARD lf_status lf_renderer_add(lf_renderer *renderer, int fd, lf_error *err);
/* Adds what another renderer has accumulated of the same views at another time: a picture of a
 * shutter is that of its parts, each with its share of the samples. from stays as it is; neither
 * may be at work. LF_E_STATE, and nothing is changed: what their films keep differs (other views,
 * other kinds of materials, another even sky), or both have visited the same half of a row by the
 * same stream of one seed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_renderer_mix(lf_renderer *renderer, const lf_renderer *from,
                                       lf_error *err);

#endif
