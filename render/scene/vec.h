/* Vectors of three floats; private to render/. Everything is static inline and without branches. */
#ifndef LF_RENDER_VEC_H
#define LF_RENDER_VEC_H

#include <math.h>

#define LF_PI 3.14159265358979323846f
#define LF_INV_PI 0.31830988618379067154f
#define LF_INV_4PI 0.07957747154594766788f

/* One instruction each (fminf and fmaxf are calls because of NaN). Returns b if either is NaN. */
static inline float lf_min(float a, float b)
{
    return a < b ? a : b;
}
static inline float lf_max(float a, float b)
{
    return a > b ? a : b;
}

static inline float lf_lerp(float a, float b, float f)
{
    return a + f * (b - a);
}

typedef struct lf_vec3 {
    float x, y, z;
} lf_vec3;

static inline lf_vec3 lf_v3(float x, float y, float z)
{
    return (lf_vec3){x, y, z};
}
static inline lf_vec3 lf_add(lf_vec3 a, lf_vec3 b)
{
    return lf_v3(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline lf_vec3 lf_sub(lf_vec3 a, lf_vec3 b)
{
    return lf_v3(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline lf_vec3 lf_mul(lf_vec3 a, lf_vec3 b)
{
    return lf_v3(a.x * b.x, a.y * b.y, a.z * b.z);
}
static inline lf_vec3 lf_scale(lf_vec3 a, float s)
{
    return lf_v3(a.x * s, a.y * s, a.z * s);
}
/* a + s b */
static inline lf_vec3 lf_madd(lf_vec3 a, float s, lf_vec3 b)
{
    return lf_v3(a.x + s * b.x, a.y + s * b.y, a.z + s * b.z);
}
static inline float lf_dot(lf_vec3 a, lf_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline lf_vec3 lf_cross(lf_vec3 a, lf_vec3 b)
{
    return lf_v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline float lf_length(lf_vec3 a)
{
    return sqrtf(lf_dot(a, a));
}
static inline lf_vec3 lf_normalize(lf_vec3 a)
{
    return lf_scale(a, 1.0f / lf_length(a));
}
static inline float lf_max3(lf_vec3 a)
{
    return lf_max(a.x, lf_max(a.y, a.z));
}
static inline float lf_mean3(lf_vec3 a)
{
    return (a.x + a.y + a.z) * (1.0f / 3.0f);
}

/* The mirror direction of wo; both point away from the surface with normal n. In double, rounded
 * once: direction-dependent rounding would visibly distort the reflection of the smallest suns. */
static inline lf_vec3 lf_reflect(lf_vec3 wo, lf_vec3 n)
{
    double k = 2.0 * ((double)wo.x * (double)n.x + (double)wo.y * (double)n.y +
                      (double)wo.z * (double)n.z);
    return lf_v3((float)(k * (double)n.x - (double)wo.x), (float)(k * (double)n.y - (double)wo.y),
                 (float)(k * (double)n.z - (double)wo.z));
}

/* Two unit vectors that form a right-handed orthonormal frame (t, b, n) with the unit vector n
 * (Duff et al. 2017, JCGT 6(1)). */
static inline void lf_tangents(lf_vec3 n, lf_vec3 *t, lf_vec3 *b)
{
    float sign = copysignf(1.0f, n.z);
    float a = -1.0f / (sign + n.z);
    float c = n.x * n.y * a;
    *t = lf_v3(1.0f + sign * n.x * n.x * a, sign * c, -sign * n.x);
    *b = lf_v3(c, sign + n.y * n.y * a, -n.y);
}

/* From coordinates in the frame (t, b, n) to a vector. */
static inline lf_vec3 lf_from_frame(lf_vec3 t, lf_vec3 b, lf_vec3 n, lf_vec3 v)
{
    return lf_v3(t.x * v.x + b.x * v.y + n.x * v.z, t.y * v.x + b.y * v.y + n.y * v.z,
                 t.z * v.x + b.z * v.y + n.z * v.z);
}

/* The inverse: a vector's coordinates in the frame. */
static inline lf_vec3 lf_to_frame(lf_vec3 t, lf_vec3 b, lf_vec3 n, lf_vec3 v)
{
    return lf_v3(lf_dot(t, v), lf_dot(b, v), lf_dot(n, v));
}

#endif
