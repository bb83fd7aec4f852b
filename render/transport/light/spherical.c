#include "render/transport/light/spherical.h"

#include "render/scene/vec_double.h"

bool lf_spherical_init(lf_spherical *s, lf_vec3 p, lf_vec3 a, lf_vec3 b, lf_vec3 c)
{
    const lf_vec3 corners[3] = {a, b, c};
    double length[3], farthest = 0.0,
                      coordinate = fabs((double)p.x) + fabs((double)p.y) + fabs((double)p.z), n[3];
    double to[3][3], ab[3], ac[3];
    for (int i = 0; i < 3; i++) {
        to[i][0] = (double)corners[i].x - (double)p.x;
        to[i][1] = (double)corners[i].y - (double)p.y;
        to[i][2] = (double)corners[i].z - (double)p.z;
        length[i] = lf_length_double(to[i]);
        farthest = fmax(farthest, length[i]);
        if (!(length[i] > 0.0))
            return false;
    }
    lf_sub_double(to[1], to[0], ab);
    lf_sub_double(to[2], to[0], ac);
    lf_cross_double(ab, ac, n);
    double volume = fabs(lf_dot_double(n, to[0])), twice_area = lf_length_double(n);
    if (!(volume > twice_area * fmax(1e-5 * farthest, 1e-6 * coordinate)))
        return false;
    double denominator =
        length[0] * length[1] * length[2] + lf_dot_double(to[0], to[1]) * length[2] +
        lf_dot_double(to[1], to[2]) * length[0] + lf_dot_double(to[2], to[0]) * length[1];
    s->solid_angle = 2.0 * atan2(volume, denominator);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            s->corner[i][j] = to[i][j] / length[i];
    return s->solid_angle > LF_SPHERICAL_MIN;
}

/* The unit vector of v's part across the unit vector n. */
static void across(const double v[3], const double n[3], double out[3])
{
    double along = lf_dot_double(v, n), length = 0.0;
    for (int i = 0; i < 3; i++)
        out[i] = v[i] - along * n[i];
    length = lf_length_double(out);
    for (int i = 0; i < 3; i++)
        out[i] /= length > 0.0 ? length : 1.0;
}

/* cosine a + sine b, of unit vectors across each other. */
static void turned(const double a[3], const double b[3], double cosine, double out[3])
{
    double sine = sqrt(fmax(0.0, 1.0 - cosine * cosine));
    for (int i = 0; i < 3; i++)
        out[i] = cosine * a[i] + sine * b[i];
}

void lf_spherical_draw(const lf_spherical *s, const float u[2], double out_w[3])
{
    const double *a = s->corner[0], *b = s->corner[1], *c = s->corner[2];
    double to_b[3], to_c[3], side[3], part[3], toward[3];
    across(b, a, to_b);
    across(c, a, to_c);
    lf_cross_double(to_b, to_c, side);
    double cosine = lf_dot_double(to_b, to_c), sine = lf_length_double(side),
           alpha = atan2(sine, cosine);
    /* The third corner moves along the arc from a to c until the triangle has its share of the
     * solid angle. */
    double angle = (double)u[0] * s->solid_angle - alpha, sn = sin(angle), cs = cos(angle);
    double x = cs - cosine, y = sn + sine * lf_dot_double(a, b), q = (y * sn + x * cs) * sine;
    double along = q != 0.0 ? ((y * cs - x * sn) * cosine - y) / q : 1.0;
    turned(a, to_c, fmin(fmax(along, -1.0), 1.0), part);
    across(part, b, toward);
    turned(b, toward, 1.0 - (double)u[1] * (1.0 - lf_dot_double(part, b)), out_w);
}
