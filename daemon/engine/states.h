/* states: the accumulations that a daemon keeps in the folder of --state, a file for each picture:
 *
 *     film-SCENE-CAMERA-REST.lfstate
 *
 * with eight hex digits each (lf_state_id): what the scene shows, the rig, and with these how it is
 * rendered, its size, the seed, the version of the format. A picture that comes back finds its own,
 * and nothing else is written over. After a save the least recently used go until there are at most
 * LF_STATES_MOST, of together at most LF_STATES_BYTES, or half of what the file system has left
 * beside them; the one in use stays. No other files are touched, but for "film.lfstate", which was
 * the one state there was: where it fits it is gone on with and gets its new name.
 *
 * Threads: any; saving and restoring as the renderer is used. */
#ifndef LF_DAEMON_STATES_H
#define LF_DAEMON_STATES_H

#include "base/file.h"
#include "render/render.h"

#define LF_STATES_MOST 8
#define LF_STATES_BYTES ((uint64_t)8 << 30)
#define LF_STATES_ASIDE 8 /* of one name that are put aside */

typedef struct lf_states lf_states;

/* Of a folder that is there, which nobody else keeps states in meanwhile; what killed saves have
 * left behind is removed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_states_create(const char *folder, lf_states **out_states, lf_error *err);
/* Accepts NULL. */
void lf_states_destroy(lf_states *states);

/* The renderer's picture is the one in use from now on; where its state is kept the renderer goes
 * on from it: true. One that is damaged is put aside with a word, as NAME.aside, NAME.aside.2, …;
 * one that cannot be read now, or where LF_STATES_ASIDE are put aside already, stays, and no state
 * of this picture is begun until it could be restored. tells: also says in what the newest one that
 * lies there differs, where there is none of this picture. */
bool lf_states_restore(lf_states *states, lf_renderer *renderer, bool tells);
/* Begins to write the state of the renderer's picture, which is the one in use from now on. Errors
 * as of lf_outfile_open; LF_E_STATE: the one that lies there is not to be written over. */
LF_NODISCARD lf_status lf_states_begin(lf_states *states, const lf_renderer *renderer,
                                       lf_outfile *file, lf_error *err);
/* Removes what is too much. */
void lf_states_trim(lf_states *states);

#endif
