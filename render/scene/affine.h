/* 3x4 affine maps in double precision; private to render/. Row major, applied to column vectors: p'
 * = m[.][0..2] p + m[.][3]. */
#ifndef LF_RENDER_AFFINE_H
#define LF_RENDER_AFFINE_H

#include "render/scene/limits.h"

typedef struct lf_affine {
    double m[3][4];
} lf_affine;

static inline lf_affine lf_affine_identity(void)
{
    return (lf_affine){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

/* The map that applies b first, then a. */
static inline lf_affine lf_affine_compose(const lf_affine *a, const lf_affine *b)
{
    lf_affine out;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++)
            out.m[i][j] =
                a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] + a->m[i][2] * b->m[2][j];
        out.m[i][3] += a->m[i][3];
    }
    return out;
}

static inline void lf_affine_point(const lf_affine *a, const double p[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a->m[i][0] * p[0] + a->m[i][1] * p[1] + a->m[i][2] * p[2] + a->m[i][3];
}

static inline double lf_affine_determinant(const lf_affine *a)
{
    const double(*m)[4] = a->m;
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* Cofactors of the linear part: the inverse transpose times the determinant. */
static inline void lf_affine_cofactors(const lf_affine *a, double out[3][3])
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            out[i][j] = a->m[i1][j1] * a->m[i2][j2] - a->m[i1][j2] * a->m[i2][j1];
        }
    }
}

/* Maps outward normals to outward normals (not of unit length): the inverse transpose up to a
 * positive factor. */
static inline void lf_affine_normals(const lf_affine *a, double out[3][3])
{
    lf_affine_cofactors(a, out);
    for (int i = 0; i < 9 && lf_affine_determinant(a) < 0; i++)
        out[i / 3][i % 3] = -out[i / 3][i % 3];
}

/* false if a is singular: its determinant is 0, not finite, or smaller than rounding relative to
 * its columns, or its inverse has an entry beyond LF_MAX_INVERSE (the last column excepted). */
static inline bool lf_affine_invert(const lf_affine *a, lf_affine *out)
{
    double scale = 1.0;
    for (int j = 0; j < 3; j++)
        scale *= sqrt(a->m[0][j] * a->m[0][j] + a->m[1][j] * a->m[1][j] + a->m[2][j] * a->m[2][j]);
    double det = lf_affine_determinant(a);
    if (!isfinite(det) || !(fabs(det) > 1e-12 * scale))
        return false;
    double cofactors[3][3];
    lf_affine_cofactors(a, cofactors);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            out->m[i][j] = cofactors[j][i] / det;
            if (!(fabs(out->m[i][j]) <= LF_MAX_INVERSE))
                return false;
        }
        out->m[i][3] =
            -(out->m[i][0] * a->m[0][3] + out->m[i][1] * a->m[1][3] + out->m[i][2] * a->m[2][3]);
    }
    return true;
}

#endif
