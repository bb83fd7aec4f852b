/* Orbits of a camera around its target. Thread: any. */
#ifndef LF_DAEMON_ORBIT_H
#define LF_DAEMON_ORBIT_H

#include "render/render.h"

/* Writes the camera's position after an orbit. The angle yaw, in degrees, turns about the up
 * vector; positive is to the right. The angle pitch, in degrees, raises the camera and stops 1
 * degree before the poles. The distance to the target is divided by zoom. */
void lf_orbit_camera(const lf_camera *camera, double yaw, double pitch, double zoom,
                     double out_position[3]);

#endif
