#include "quilt/chart/camera.h"

#include <math.h>
#include <string.h>

#define N_UNKNOWN 10 /* log focal, k1, three rotations, three shifts, growth of the tags */
#define N_TOLD 3     /* standard errors */
#define ITERATIONS 30
#define SD_FOCAL_UNKNOWN 0.6
#define SD_K1 0.03
#define SD_K1_FEW_TAGS 0.004
#define SD_DISTANCE 0.01
#define SD_GROWTH_MM 0.3
#define LEAST_SD_PX 0.1
#define TOGETHER 1.6
#define USUAL_FOCAL 0.75 /* of a photo's diagonal */

bool lf_chart_solve(int n, int m, double *a, double *b)
{
    for (int i = 0; i < n; i++) {
        int best = i;
        for (int r = i + 1; r < n; r++)
            if (fabs(a[r * n + i]) > fabs(a[best * n + i]))
                best = r;
        if (!(fabs(a[best * n + i]) > 1e-300))
            return false;
        for (int c = 0; c < n; c++) {
            const double swapped = a[i * n + c];
            a[i * n + c] = a[best * n + c];
            a[best * n + c] = swapped;
        }
        for (int c = 0; c < m; c++) {
            const double swapped = b[i * m + c];
            b[i * m + c] = b[best * m + c];
            b[best * m + c] = swapped;
        }
        for (int r = 0; r < n; r++) {
            const double factor = r == i ? 0.0 : a[r * n + i] / a[i * n + i];
            for (int c = i; c < n && factor != 0.0; c++)
                a[r * n + c] -= factor * a[i * n + c];
            for (int c = 0; c < m && factor != 0.0; c++)
                b[r * m + c] -= factor * b[i * m + c];
        }
    }
    for (int i = 0; i < n; i++)
        for (int c = 0; c < m; c++)
            b[i * m + c] /= a[i * n + i];
    return true;
}

/* -------------------------------------------------------------------------------- projection -- */

bool lf_chart_project(const lf_chart_camera *camera, double x, double y, double *out_px,
                      double *out_py)
{
    double v[3];
    for (int k = 0; k < 3; k++)
        v[k] = camera->turn[k][0] * x + camera->turn[k][1] * y + camera->move[k];
    if (!(v[2] > 1e-6))
        return false;
    const double u = v[0] / v[2], w = v[1] / v[2], bent = 1.0 + camera->k1 * (u * u + w * w);
    *out_px = camera->middle[0] + camera->focal * u * bent;
    *out_py = camera->middle[1] + camera->focal * w * bent;
    return true;
}

/* Rotates the camera further by the vector d. */
static void rotate(double turn[3][3], const double d[3])
{
    const double angle = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    double before[3][3], by[3][3];
    memcpy(before, turn, sizeof before);
    const double s = angle > 1e-12 ? sin(angle) / angle : 1.0,
                 c = angle > 1e-6 ? (1.0 - cos(angle)) / (angle * angle) : 0.5;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            by[i][j] = c * d[i] * d[j] + (i == j ? cos(angle) : 0.0);
    by[0][1] -= s * d[2], by[1][0] += s * d[2];
    by[0][2] += s * d[1], by[2][0] -= s * d[1];
    by[1][2] -= s * d[0], by[2][1] += s * d[0];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            turn[i][j] = 0.0;
            for (int k = 0; k < 3; k++)
                turn[i][j] += by[i][k] * before[k][j];
        }
}

static lf_chart_camera changed(const lf_chart_camera *camera, const double d[N_UNKNOWN])
{
    lf_chart_camera c = *camera;
    c.focal *= exp(d[0]);
    c.k1 += d[1];
    rotate(c.turn, d + 2);
    for (int k = 0; k < 3; k++)
        c.move[k] += d[5 + k];
    for (int k = 0; k < 2; k++)
        c.growth[k] += d[8 + k];
    for (int k = 0; k < 3; k++)
        c.eye[k] =
            -(c.turn[0][k] * c.move[0] + c.turn[1][k] * c.move[1] + c.turn[2][k] * c.move[2]);
    return c;
}

/* ------------------------------------------------------------------------------- first guess -- */

/* The homography from mm to pixels about the photo's middle, by the direct linear transform with
 * its last element 1; lengths are scaled by `unit`. */
static bool homography(const lf_chart_corners *corners, const double middle[2], double unit,
                       double h[9])
{
    double a[64] = {0}, b[8] = {0};
    for (int i = 0; i < corners->n; i++) {
        const double x = corners->at[i][0], y = corners->at[i][1];
        for (int k = 0; k < 2; k++) {
            const double p = (corners->px[i][k] - middle[k]) / unit;
            const double row[8] = {k == 0 ? x : 0, k == 0 ? y : 0, k == 0 ? 1 : 0, k == 1 ? x : 0,
                                   k == 1 ? y : 0, k == 1 ? 1 : 0, -p * x,         -p * y};
            for (int r = 0; r < 8; r++) {
                b[r] += row[r] * p;
                for (int c = 0; c < 8; c++)
                    a[8 * r + c] += row[r] * row[c];
            }
        }
    }
    h[8] = 1.0;
    if (!lf_chart_solve(8, 1, a, b))
        return false;
    memcpy(h, b, sizeof b);
    return true;
}

/* The focal length for which both columns are at right angles and of one length; 0: not told. */
static double focal_of(const double h[9])
{
    const double a0 = h[0] * h[1] + h[3] * h[4], b0 = h[6] * h[7];
    const double a1 = h[0] * h[0] + h[3] * h[3] - h[1] * h[1] - h[4] * h[4],
                 b1 = h[6] * h[6] - h[7] * h[7];
    const double square = -(a0 * b0 + a1 * b1) / (b0 * b0 + b1 * b1);
    return square > 0.01 && square < 25.0 ? sqrt(square) : 0.0;
}

static bool first_guess(const lf_chart_corners *corners, double known_focal, double diagonal,
                        lf_chart_camera *out)
{
    double h[9], focal = known_focal / diagonal, c[3][3];
    if (!homography(corners, out->middle, diagonal, h))
        return false;
    if (!(focal > 0.0))
        focal = focal_of(h);
    if (!(focal > 0.0))
        focal = USUAL_FOCAL;
    out->focal = focal * diagonal;
    for (int k = 0; k < 3; k++) {
        c[k][0] = h[k] / focal;
        c[k][1] = h[3 + k] / focal;
        c[k][2] = h[6 + k];
    }
    const double scale = 2.0 / (sqrt(c[0][0] * c[0][0] + c[0][1] * c[0][1] + c[0][2] * c[0][2]) +
                                sqrt(c[1][0] * c[1][0] + c[1][1] * c[1][1] + c[1][2] * c[1][2]));
    double norm = 0.0, dot = 0.0;
    for (int k = 0; k < 3; k++)
        norm += c[0][k] * c[0][k];
    for (int k = 0; k < 3; k++)
        out->turn[k][0] = c[0][k] / sqrt(norm);
    for (int k = 0; k < 3; k++)
        dot += out->turn[k][0] * c[1][k];
    norm = 0.0;
    for (int k = 0; k < 3; k++) {
        out->turn[k][1] = c[1][k] - dot * out->turn[k][0];
        norm += out->turn[k][1] * out->turn[k][1];
    }
    for (int k = 0; k < 3; k++)
        out->turn[k][1] /= sqrt(norm);
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        out->turn[k][2] = out->turn[i][0] * out->turn[j][1] - out->turn[j][0] * out->turn[i][1];
        out->move[k] = c[2][k] * scale;
    }
    return isfinite(out->turn[2][2]) && isfinite(scale);
}

/* --------------------------------------------------------------------------------------- fit -- */

typedef struct problem {
    const lf_chart_corners *corners;
    double focal, sd_focal, sd_k1, distance;
    double sd_px;
} problem;

enum { MOST_RESIDUALS = 2 * LF_CHART_CORNERS + 5 };

/* What is left of each corner and of each thing that is known, in standard deviations. */
static int residuals(const problem *p, const lf_chart_camera *camera, double *out)
{
    int n = 0;
    for (int i = 0; i < p->corners->n; i++) {
        double px = 0.0, py = 0.0;
        const double *at = p->corners->at[i], *side = p->corners->side[i];
        if (!lf_chart_project(camera, at[0] + side[0] * camera->growth[0],
                              at[1] + side[1] * camera->growth[1], &px, &py))
            px = py = 1e6;
        out[n++] = (px - p->corners->px[i][0]) / p->sd_px;
        out[n++] = (py - p->corners->px[i][1]) / p->sd_px;
    }
    out[n++] = log(camera->focal / p->focal) / p->sd_focal;
    out[n++] = camera->k1 / p->sd_k1;
    for (int k = 0; k < 2; k++)
        out[n++] = camera->growth[k] / SD_GROWTH_MM;
    out[n++] =
        p->distance > 0.0 ? log(fmax(-camera->eye[2], 1e-3) / p->distance) / SD_DISTANCE : 0.0;
    return n;
}

static double sum_of_squares(const double *r, int n)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++)
        sum += r[i] * r[i];
    return sum;
}

static void differentiate(const problem *p, const lf_chart_camera *camera, int k, double *out)
{
    static const double steps[N_UNKNOWN] = {1e-5, 1e-5, 1e-6, 1e-6, 1e-6,
                                            1e-3, 1e-3, 1e-3, 1e-4, 1e-4};
    double up[MOST_RESIDUALS], d[N_UNKNOWN] = {0};
    d[k] = steps[k];
    lf_chart_camera moved = changed(camera, d);
    const int n = residuals(p, &moved, up);
    d[k] = -steps[k];
    moved = changed(camera, d);
    residuals(p, &moved, out);
    for (int i = 0; i < n; i++)
        out[i] = (up[i] - out[i]) / (2.0 * steps[k]);
}

/* Normal equations: a = J'J, b = -J'r. */
static void normal(const problem *p, const lf_chart_camera *camera, double *a, double *b)
{
    double r[MOST_RESIDUALS], j[N_UNKNOWN][MOST_RESIDUALS];
    const int n = residuals(p, camera, r);
    for (int k = 0; k < N_UNKNOWN; k++)
        differentiate(p, camera, k, j[k]);
    for (int k = 0; k < N_UNKNOWN; k++) {
        b[k] = 0.0;
        for (int i = 0; i < n; i++)
            b[k] -= j[k][i] * r[i];
        for (int l = 0; l < N_UNKNOWN; l++) {
            a[k * N_UNKNOWN + l] = 0.0;
            for (int i = 0; i < n; i++)
                a[k * N_UNKNOWN + l] += j[k][i] * j[l][i];
        }
    }
}

static void descend(const problem *p, lf_chart_camera *camera)
{
    double r[MOST_RESIDUALS], damping = 1e-3;
    int n = residuals(p, camera, r);
    double cost = sum_of_squares(r, n);
    for (int i = 0; i < ITERATIONS; i++) {
        double a[N_UNKNOWN * N_UNKNOWN], b[N_UNKNOWN];
        normal(p, camera, a, b);
        for (int k = 0; k < N_UNKNOWN; k++)
            a[k * (N_UNKNOWN + 1)] *= 1.0 + damping;
        if (!lf_chart_solve(N_UNKNOWN, 1, a, b))
            return;
        const lf_chart_camera next = changed(camera, b);
        n = residuals(p, &next, r);
        const double lower = sum_of_squares(r, n);
        if (!(lower < cost)) {
            damping *= 10.0;
            continue;
        }
        const bool ends = cost - lower < 1e-10 * cost;
        *camera = next;
        cost = lower;
        damping *= 0.2;
        if (ends)
            return;
    }
}

/* The turn of the chart's x axis about its normal from before to after, for small ones. */
static double roll_between(const lf_chart_camera *before, const lf_chart_camera *after)
{
    double sum = 0.0;
    for (int k = 0; k < 3; k++)
        sum += after->turn[k][0] * before->turn[k][1];
    return sum;
}

/* Standard errors of distance, direction and roll, by the inverse of the normal equations. */
static void estimate_errors(const problem *p, lf_chart_camera *camera)
{
    double a[N_UNKNOWN * N_UNKNOWN], b[N_UNKNOWN], inverse[N_UNKNOWN * N_UNKNOWN] = {0};
    double slope[N_TOLD][N_UNKNOWN], variance[N_TOLD] = {0};
    normal(p, camera, a, b);
    for (int k = 0; k < N_UNKNOWN; k++) {
        double d[N_UNKNOWN] = {0};
        d[k] = 1e-5;
        const lf_chart_camera moved = changed(camera, d);
        slope[0][k] = log(moved.eye[2] / camera->eye[2]) / 1e-5;
        slope[1][k] = (moved.eye[0] / moved.eye[2] - camera->eye[0] / camera->eye[2]) / 1e-5;
        slope[2][k] = roll_between(camera, &moved) / 1e-5;
        inverse[k * (N_UNKNOWN + 1)] = 1.0;
    }
    camera->sd_distance = camera->sd_aside = camera->sd_roll = INFINITY;
    if (!lf_chart_solve(N_UNKNOWN, N_UNKNOWN, a, inverse))
        return;
    for (int v = 0; v < N_TOLD; v++)
        for (int k = 0; k < N_UNKNOWN; k++)
            for (int l = 0; l < N_UNKNOWN; l++)
                variance[v] += slope[v][k] * inverse[k * N_UNKNOWN + l] * slope[v][l];
    camera->sd_distance = sqrt(fmax(variance[0], 0.0));
    camera->sd_aside = sqrt(fmax(variance[1], 0.0));
    camera->sd_roll = sqrt(fmax(variance[2], 0.0));
}

/* How exact the corners are, by what is left of them. Those of one tag are off together. */
static double noise_px(const problem *p, const lf_chart_camera *camera)
{
    double r[MOST_RESIDUALS];
    const int n = 2 * p->corners->n;
    residuals(p, camera, r);
    return fmax(TOGETHER * p->sd_px * sqrt(sum_of_squares(r, n) / (n - N_UNKNOWN)), LEAST_SD_PX);
}

lf_status lf_chart_camera_fit(const lf_chart_corners *corners, const lf_chart_hint *hint,
                              const char *where, lf_chart_camera *out, lf_error *err)
{
    const double diagonal = hypot(hint->width, hint->height);
    lf_chart_camera camera = {.middle = {0.5 * hint->width, 0.5 * hint->height}};
    static const double none[N_UNKNOWN];
    double r[MOST_RESIDUALS];
    problem p = {.corners = corners,
                 .focal = hint->focal > 0.0 ? hint->focal : USUAL_FOCAL * diagonal,
                 .sd_focal = hint->focal > 0.0 ? hint->sd_focal : SD_FOCAL_UNKNOWN,
                 .sd_k1 = corners->n_tags >= 6 ? SD_K1 : SD_K1_FEW_TAGS,
                 .distance = hint->distance,
                 .sd_px = fmax(0.5, 3e-4 * diagonal)};
    const bool begun = first_guess(corners, hint->focal, diagonal, &camera);
    if (begun) {
        camera = changed(&camera, none);
        descend(&p, &camera);
        p.sd_px = noise_px(&p, &camera);
        descend(&p, &camera);
        estimate_errors(&p, &camera);
    }
    residuals(&p, &camera, r);
    camera.rms_px = p.sd_px * sqrt(sum_of_squares(r, 2 * corners->n) / (2.0 * corners->n));
    if (!begun || !(camera.eye[2] < 0.0) || !(camera.rms_px < 0.01 * diagonal))
        return lf_error_set(err, LF_E_FORMAT, where,
                            "the marks do not lie as on a flat chart; lay the chart flat and take "
                            "the photo again");
    *out = camera;
    return LF_OK;
}
