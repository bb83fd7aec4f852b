/* --hologram: a sequence of rows of cameras whose pictures form a plate. Functions do nothing for
 * other outputs, unless stated. Thread: the main thread, as the rendering's. */
#ifndef LF_DAEMON_RENDERING_PLATE_H
#define LF_DAEMON_RENDERING_PLATE_H

#include "daemon/tools/plan_division.h"
#include "daemon/tools/rendering.h"

/* The steps of lf_rendering_open. Once the scene is loaded: without --camera-rows, the sequence is
 * all rows of its cameras. */
LF_NODISCARD lf_status lf_rendering_plate_open(lf_rendering *r, lf_error *err);
/* Once the camera is placed: gives it the rig of the preset. LF_E_ARG. */
LF_NODISCARD lf_status lf_rendering_plate_rig(lf_rendering *r, lf_error *err);
/* At the end: the plate, a warning of its depth, and, unless it is only planned, the file that says
 * what its rows are. LF_E_ARG; LF_E_EXISTS: the folder has rows of another plate. */
LF_NODISCARD lf_status lf_rendering_plate_begin(lf_rendering *r, lf_error *err);

/* For a plate only: the number of files of this run, which are those of its rows or, without
 * --camera-rows, those of the plate and the manifest. The i-th name; caller frees; NULL = out of
 * memory. */
int lf_rendering_plate_files(const lf_rendering *r);
char *lf_rendering_plate_file(const lf_rendering *r, int i);
/* True if all files of a row are there, or the finished plate is. */
bool lf_rendering_plate_has(const lf_rendering *r, int row);
/* Writes the files of the current row. */
LF_NODISCARD lf_status lf_rendering_plate_write(const lf_rendering *r,
                                                const lf_output_request *request,
                                                const lf_output_source *source, lf_error *err);
/* After the last row: without --camera-rows, writes what needs all rows, and the manifest. */
LF_NODISCARD lf_status lf_rendering_plate_finish(lf_rendering *r, lf_error *err);
/* For a plate only, for plans: bytes of all files of the planned rows, uncompressed; and what
 * lf_rendering_plate_finish costs, besides the program and the scene. */
double lf_rendering_plate_bytes(const lf_rendering *r);
lf_plan_cost lf_rendering_plate_cost(const lf_rendering *r);
/* Releases r->sequence.plate. */
void lf_rendering_plate_close(lf_rendering *r);

#endif
