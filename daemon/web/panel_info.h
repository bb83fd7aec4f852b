/* panel_info: the panel as programs for Looking Glass know it, from what quiltd says. Pure
 * functions. Thread: any. */
#ifndef LF_DAEMON_WEB_PANEL_INFO_H
#define LF_DAEMON_WEB_PANEL_INFO_H

#include <jansson.h>

/* One device of the older protocol's `info`: {hwid, state, hardwareVersion, index, unityIndex,
 * joystickIndex, buttons, windowCoords: [x, y], calibration, defaultQuilt}.
 *
 * - calibration has configVersion, serial, and as {"value": NUMBER} pitch, slope, center, viewCone,
 *   DPI, screenW, screenH, invView, verticalAngle, flipImageX, flipImageY, flipSubp, fringe and
 *   CellPatternMode; subpixelCells if there are some. What quiltd does not know is 0: programs
 *   throw a panel away that lacks one of them.
 * - defaultQuilt has quiltX, quiltY, tileX, tileY and quiltAspect: the panel's own, or that of its
 *   model.
 * - hwid begins with LKG, and hardwareVersion is a word for the model, which follows from the
 *   serial number, or from the size in pixels.
 *
 * calibration: the result of quiltd's device.calibration; device: `device` of status. Both are
 * borrowed. NULL: one of them is missing, the device is not present, the calibration has no size,
 * or there is no memory. */
json_t *lf_panel_info(const json_t *calibration, const json_t *device);

#endif
