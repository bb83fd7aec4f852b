#include "render/cameras/pinhole.h"

#include "render/plane/rig.h"
#include "render/scene/vec_double.h"

static lf_vec3 scaled(const double a[3], double s)
{
    return lf_v3((float)(a[0] * s), (float)(a[1] * s), (float)(a[2] * s));
}

static lf_status aim(lf_pinhole *out, const lf_view_camera *from, const double origin[3],
                     int number, lf_error *err)
{
    double forward[3], right[3], up[3], eye[3];
    lf_sub_double(from->position, origin, eye);
    lf_sub_double(from->target, from->position, forward);
    lf_cross_double(forward, from->up, right);
    lf_cross_double(right, forward, up);
    const double ahead = lf_length_double(forward), across = lf_length_double(right);
    if (!(across > 1e-12 * ahead * lf_length_double(from->up)) ||
        !(from->fov_y > 0.0 && from->fov_y < 3.1))
        return lf_error_set(err, LF_E_ARG, "camera.views",
                            "camera %d is at its target, or up is parallel to its view direction, "
                            "or fov_y is not between 0 and 178 degrees",
                            number);
    out->eye = lf_to_vec3(eye);
    out->forward = scaled(forward, 1.0 / ahead);
    out->right = scaled(right, 1.0 / across);
    out->up = scaled(up, 1.0 / lf_length_double(up));
    out->focus = (float)ahead;
    return LF_OK;
}

lf_status lf_pinholes_init(lf_pinhole *out, const lf_render_settings *settings,
                           const double origin[3], lf_error *err)
{
    const lf_camera *c = &settings->camera;
    const double *w = settings->window;
    const bool whole = w[0] == 0.0 && w[1] == 0.0 && w[2] == 0.0 && w[3] == 0.0;
    const double left = whole ? 0.0 : w[0], top = whole ? 0.0 : w[1], right = whole ? 1.0 : w[2],
                 bottom = whole ? 1.0 : w[3];
    lf_status status = lf_rig_check_size(settings, err);
    if (status == LF_OK && !(right > left && bottom > top))
        status = lf_error_set(err, LF_E_ARG, "window", "must have a positive size");
    for (int k = 0; status == LF_OK && k < c->n_views; k++) {
        const double height = 2.0 * tan(0.5 * c->list[k].fov_y), width = height * c->aspect;
        status = aim(&out[k], &c->list[k], origin, k, err);
        out[k].x0 = (float)((left - 0.5) * width);
        out[k].dx = (float)((right - left) * width / settings->width);
        out[k].y0 = (float)((0.5 - top) * height);
        out[k].dy = (float)(-(bottom - top) * height / settings->height);
        out[k].tangent = (float)(0.5 * height);
        out[k].lens_radius = (float)c->lens_radius;
        if (c->focus_distance > 0.0)
            out[k].focus = (float)c->focus_distance;
    }
    return status;
}

void lf_pinhole_lens(const lf_pinhole *pinhole, const float u[2], float out_lens[2])
{
    const float r = pinhole->lens_radius * sqrtf(u[0]), angle = 2.0f * LF_PI * u[1];
    out_lens[0] = r * cosf(angle);
    out_lens[1] = r * sinf(angle);
}

lf_vec3 lf_pinhole_eye(const lf_pinhole *pinhole, const float lens[2])
{
    return lf_madd(lf_madd(pinhole->eye, lens[0], pinhole->right), lens[1], pinhole->up);
}

lf_vec3 lf_pinhole_ray(const lf_pinhole *pinhole, const float lens[2], float u, float v)
{
    return lf_normalize(
        lf_madd(lf_madd(pinhole->forward, pinhole->x0 + u * pinhole->dx - lens[0] / pinhole->focus,
                        pinhole->right),
                pinhole->y0 + v * pinhole->dy - lens[1] / pinhole->focus, pinhole->up));
}

bool lf_pinhole_see(const lf_pinhole *pinhole, const float lens[2], lf_vec3 p,
                    lf_pinhole_sight *out)
{
    out->eye = lf_pinhole_eye(pinhole, lens);
    const lf_vec3 d = lf_sub(p, out->eye);
    const float z = lf_dot(d, pinhole->forward), r = lf_length(d);
    if (!(z > 1e-6f * r))
        return false;
    out->u = (lf_dot(d, pinhole->right) / z + lens[0] / pinhole->focus - pinhole->x0) / pinhole->dx;
    out->v = (lf_dot(d, pinhole->up) / z + lens[1] / pinhole->focus - pinhole->y0) / pinhole->dy;
    out->distance = r;
    out->w = lf_scale(d, 1.0f / r);
    /* a pixel is |dx dy| cos^3 of solid angle, cos = z/r */
    const double cosine = (double)z / (double)r;
    out->area = fabs((double)pinhole->dx * (double)pinhole->dy) * cosine * cosine * cosine *
                (double)r * (double)r;
    return true;
}
