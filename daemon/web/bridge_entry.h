/* bridge_entry: an entry of a playlist as programs of Bridge describe it, and as quiltd's
 * playlist.set takes it. Pure functions. Thread: any. */
#ifndef LF_DAEMON_WEB_BRIDGE_ENTRY_H
#define LF_DAEMON_WEB_BRIDGE_ENTRY_H

#include <jansson.h>

#include "base/status.h"

/* Reads a number, a boolean, or a text that is one of both. False: it is something else. */
bool lf_bridge_number(const json_t *value, double *out);
/* The same, without digits behind the point. */
bool lf_bridge_whole(const json_t *value, int *out);

/* Merges the parameters of a request into `said`, what was said of an entry before (an empty object
 * at first), and makes quiltd's entry of all of it:
 *
 * - uri: an absolute path, or file:// with it; the bytes behind % are decoded
 * - durationMS: seconds, left out if it is 0
 * - isRGBD 0: cols, rows and aspect become quilt and aspect; view_count or viewCount is cols x
 *   rows; rgbd_in is off, except if isRGBD is not said
 * - isRGBD 1: depth_loc 0 top, 1 bottom, 2 right, 3 left becomes rgbd_in; depth_inversion,
 *   chroma_depth, depthiness (1.5 as in Bridge), depth_cutoff; cols, rows and view_count are
 *   meaningless there
 * - focus, zoom, crop_pos_x, crop_pos_y become focus, zoom, crop_x, crop_y
 *
 * Numbers may be texts. Other parameters are ignored; ranges are for quiltd to check. Both results
 * are new references. LF_E_ARG: a parameter is missing or has another type, or quiltd cannot read
 * from such a place; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_bridge_entry_make(json_t *said, const json_t *body, json_t **out_said,
                                            json_t **out_entry, lf_error *err);
/* The keys of an entry that another one has not, or with other values; a new reference. NULL: out
 * of memory. */
json_t *lf_bridge_entry_changes(json_t *entry, const json_t *before);

#endif
