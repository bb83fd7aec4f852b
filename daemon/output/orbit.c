#include "daemon/output/orbit.h"

#include <math.h>

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static bool normalize(double v[3])
{
    double length = sqrt(dot(v, v));
    for (int i = 0; i < 3 && length > 0; i++)
        v[i] /= length;
    return length > 0;
}

void lf_orbit_camera(const lf_camera *camera, double yaw, double pitch, double zoom,
                     double out_position[3])
{
    const double degree = acos(-1.0) / 180.0;
    const double limit = 89.0 * degree;
    double up[3] = {camera->up[0], camera->up[1], camera->up[2]};
    double arm[3], flat[3], side[3];
    for (int i = 0; i < 3; i++) {
        arm[i] = camera->position[i] - camera->target[i];
        out_position[i] = camera->position[i];
    }
    double distance = sqrt(dot(arm, arm));
    if (!normalize(up) || !normalize(arm))
        return;
    double height = dot(arm, up);
    for (int i = 0; i < 3; i++)
        flat[i] = arm[i] - height * up[i];
    if (!normalize(flat))
        return;
    side[0] = up[1] * flat[2] - up[2] * flat[1];
    side[1] = up[2] * flat[0] - up[0] * flat[2];
    side[2] = up[0] * flat[1] - up[1] * flat[0];
    double elevation = asin(fmin(1, fmax(-1, height)));
    /* A camera that starts nearer to a pole than the limit only may not go further. */
    double most = fmax(limit, fabs(elevation));
    elevation = fmin(most, fmax(-most, elevation + pitch * degree));
    for (int i = 0; i < 3; i++) {
        double direction =
            cos(elevation) * (cos(yaw * degree) * flat[i] + sin(yaw * degree) * side[i]) +
            sin(elevation) * up[i];
        out_position[i] = camera->target[i] + distance / zoom * direction;
    }
}
