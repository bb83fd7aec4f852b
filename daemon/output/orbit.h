/* Orbits of a camera around its target. Thread: any. */
#ifndef LF_DAEMON_ORBIT_H
#define LF_DAEMON_ORBIT_H

#include "render/render.h"

/* Writes the camera's position after an orbit. yaw: degrees about the up vector, positive to the
 * right. pitch: degrees upwards; it stops 1 degree before the poles. zoom: divides the distance to
 * the target. */
void lf_orbit_camera(const lf_camera *camera, double yaw, double pitch, double zoom,
                     double out_position[3]);

#endif
