/* A camera that goes round its target. Thread: any. */
#ifndef LF_DAEMON_ORBIT_H
#define LF_DAEMON_ORBIT_H

#include "render/render.h"

/* The position that an orbit moves a camera to (and the focus distance that belongs to it): turned
 * by yaw degrees about the up vector (to the right for positive), raised by pitch degrees (stopping
 * 1 degree before the poles), distance divided by zoom. */
void lf_orbit_camera(const lf_camera *camera, double yaw, double pitch, double zoom,
                     double out_position[3]);

#endif
