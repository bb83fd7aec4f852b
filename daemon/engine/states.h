/* states: the accumulations in the folder of --state, one file per picture:
 *
 *     film-SCENE-CAMERA-REST.lfstate
 *
 * Each part is a hash of eight hex digits (lf_state_id). SCENE covers what the scene shows, CAMERA
 * the rig. REST covers both together with render settings, size, seed and format version. A picture
 * that returns finds its own file. Saving never overwrites the file of another picture.
 *
 * After a save the least recently used files are removed until at most LF_STATES_MOST remain.
 * Together they take at most LF_STATES_BYTES, and at most half of the sum of their own bytes and
 * the free space of the file system. The file in use stays.
 *
 * No other files are touched, except "film.lfstate" of older versions. If it fits, it is resumed
 * and gets its new name.
 *
 * Threads: any; saving and restoring obey the renderer's rules. */
#ifndef LF_DAEMON_STATES_H
#define LF_DAEMON_STATES_H

#include "base/file.h"
#include "render/render.h"

#define LF_STATES_MOST 8
#define LF_STATES_BYTES ((uint64_t)8 << 30)
#define LF_STATES_ASIDE 8 /* files of one name that are put aside */

typedef struct lf_states lf_states;

/* The folder exists, and no other process keeps states in it. Removes remains of killed saves.
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_states_create(const char *folder, lf_states **out_states, lf_error *err);
/* Accepts NULL. */
void lf_states_destroy(lf_states *states);

/* Makes the renderer's picture the one in use. If its state exists, restores it into the renderer
 * and returns true.
 *
 * A damaged file is put aside as NAME.aside, NAME.aside.2, … and a line is logged. A file stays if
 * it cannot be read now, or if LF_STATES_ASIDE are put aside already. No state of this picture is
 * then saved until it could be restored.
 *
 * tells: if no state fits, also logs in what the newest one differs. */
bool lf_states_restore(lf_states *states, lf_renderer *renderer, bool tells);
/* Begins to write the state of the renderer's picture, which becomes the one in use. Errors of
 * lf_outfile_open; LF_E_STATE: the existing file must not be overwritten. */
LF_NODISCARD lf_status lf_states_begin(lf_states *states, const lf_renderer *renderer,
                                       lf_outfile *file, lf_error *err);
/* Removes files over the limits. */
void lf_states_trim(lf_states *states);

#endif
