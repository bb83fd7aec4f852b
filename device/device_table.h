/* The kinds of devices, and what they share. Private to device/. */
#ifndef LF_DEVICE_TABLE_H
#define LF_DEVICE_TABLE_H

#include "device/device.h"

extern const lf_device_ops lf_none_ops;
extern const lf_device_ops lf_sim_ops;
extern const lf_device_ops lf_drm_ops;
extern const lf_device_ops lf_window_ops;
extern const lf_device_ops lf_usb_ops;

/* The kinds in the order in which "auto" searches for panels, ended by NULL. */
extern const lf_device_ops *const lf_device_table[];

/* lf_device_find over a table (ended by NULL). */
LF_NODISCARD lf_status lf_device_find_in(const lf_device_ops *const table[], const char *first,
                                         const lf_calibration *calibration, lf_device **out_device,
                                         lf_error *err);

/* Checks the arguments of lf_device_ops.push for a panel of width x height pixels; false =
 * LF_E_ARG. */
bool lf_device_push_fits(int width, int height, const lf_image8 *frame, const lf_rect *rects,
                         int n);

/* Copies text for an lf_device_info field. Control characters and bytes that are not UTF-8 become
 * '?'. Text that does not fit is cut between characters. */
void lf_device_text(char *out, size_t size, const char *text);

/* The text of an error for a problem field: its place in a file, if any, and what is wrong;
 * sanitised and cut. */
void lf_device_problem(char *out, size_t size, const lf_error *why);

#endif
