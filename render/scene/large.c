#include "render/scene/large.h"

#include "base/alloc.h"
#include "render/scene/instances.h"
#include "render/scene/vec_double.h"

/* ----------------------------------------------------------------------------------- picking -- */

/* Embree's error may be as large as this share of the scene's detail. */
#define ERROR_SHARE 1e-3f

static lf_vec3 corner_of(const lf_mesh *mesh, int triangle, int i)
{
    return lf_mesh_vertex(mesh, mesh->triangles[3 * (size_t)triangle + (size_t)i]);
}

/* The longest side of a triangle's box; *out_area is twice its area. */
static float size_of(const lf_mesh *mesh, int triangle, float *out_area)
{
    lf_vec3 a = corner_of(mesh, triangle, 0), ab = lf_sub(corner_of(mesh, triangle, 1), a),
            ac = lf_sub(corner_of(mesh, triangle, 2), a);
    const float side[3][2] = {{ab.x, ac.x}, {ab.y, ac.y}, {ab.z, ac.z}};
    float size = 0.0f;
    for (int i = 0; i < 3; i++)
        size = lf_max(size, lf_max(0.0f, lf_max(side[i][0], side[i][1])) -
                                lf_min(0.0f, lf_min(side[i][0], side[i][1])));
    *out_area = lf_length(lf_cross(ab, ac));
    return size;
}

/* Maximum distance at which Embree may find a triangle in front of or behind its plane. Measured
 * over random triangles and rays, of all slants down to 1e-5: up to 3e-7 of a triangle's size. For
 * slivers, whose normal is rounded: 4e-8 over the ratio of area and size, at most its size. */
static float error_of(float size, float area)
{
    return area > 0.0f ? size * lf_min(5e-7f + 1e-7f * size * (size / area), 1.0f) : 0.0f;
}

/* The detail of a mesh: the power of two at or below the width (twice the area over the size) of
 * its median triangle; INFINITY without triangles. */
static float detail_of(const lf_mesh *mesh)
{
    enum { FIRST = -150, CLASSES = 300 }; /* all of single precision */
    int count[CLASSES] = {0}, n = 0;
    for (int i = 0; i < mesh->n_triangles; i++) {
        float area, size = size_of(mesh, i, &area);
        if (!(area > 0.0f))
            continue;
        count[ilogbf(area / size) - FIRST]++;
        n++;
    }
    for (int i = 0, below = 0; i < CLASSES && n > 0; i++) {
        below += count[i];
        if (2 * (int64_t)below >= n)
            return ldexpf(1.0f, i + FIRST);
    }
    return INFINITY;
}

/* The smallest scale factor of a mesh's instances. */
static float least_of(const lf_mesh *mesh)
{
    return mesh->instances ? mesh->instances->least : 1.0f;
}

static lf_large_triangle make(const lf_mesh *mesh, int mesh_number, int triangle)
{
    lf_large_triangle out = {.mesh = (uint32_t)mesh_number, .triangle = (uint32_t)triangle};
    double ab[3], ac[3];
    for (int i = 0; i < 3; i++) {
        lf_vec3 p = corner_of(mesh, triangle, i);
        out.corner[i][0] = (double)p.x;
        out.corner[i][1] = (double)p.y;
        out.corner[i][2] = (double)p.z;
    }
    lf_sub_double(out.corner[1], out.corner[0], ab);
    lf_sub_double(out.corner[2], out.corner[0], ac);
    lf_cross_double(ab, ac, out.normal);
    return out;
}

/* Counts the triangles with an error above the limit, and stores them in order if there is room. */
static uint32_t gather(const lf_mesh *meshes, int n_meshes, float limit, lf_large_triangle *out,
                       float *out_offset)
{
    uint32_t n = 0;
    *out_offset = 0.0f;
    for (int m = 0; m < n_meshes; m++) {
        for (int i = 0; i < meshes[m].n_triangles; i++) {
            float area, size = size_of(&meshes[m], i, &area), error = error_of(size, area);
            bool large = error > limit && !meshes[m].close.vertices && !meshes[m].instances;
            error *= meshes[m].instances ? meshes[m].instances->most : 1.0f;
            *out_offset = lf_max(*out_offset, large ? 1e-12f * size : error);
            if (!large)
                continue;
            if (out)
                out[n] = make(&meshes[m], m, i);
            n++;
        }
    }
    return n;
}

lf_status lf_large_pick(const lf_mesh *meshes, int n_meshes, lf_large *out, float *out_offset)
{
    float detail = INFINITY;
    for (int m = 0; m < n_meshes; m++)
        detail = lf_min(detail, least_of(&meshes[m]) * detail_of(&meshes[m]));
    *out = (lf_large){.n = gather(meshes, n_meshes, ERROR_SHARE * detail, NULL, out_offset)};
    out->triangles = lf_calloc(out->n, sizeof *out->triangles);
    if (!out->triangles)
        return LF_E_NOMEM;
    gather(meshes, n_meshes, ERROR_SHARE * detail, out->triangles, out_offset);
    return LF_OK;
}

/* ----------------------------------------------------------------------------------- meeting -- */

/* Six times the signed volume that the ray and an edge span. */
static inline double side(const double a[3], const double b[3], const double w[3])
{
    double across[3];
    lf_cross_double(a, b, across);
    return lf_dot_double(w, across);
}

bool lf_large_meet(const lf_large_triangle *triangle, const double o[3], const double w[3],
                   double *out_t, double out_uv[2])
{
    double v[3][3];
    for (int i = 0; i < 3; i++)
        lf_sub_double(triangle->corner[i], o, v[i]);
    double height = lf_dot_double(triangle->normal, v[0]),
           along = lf_dot_double(triangle->normal, w);
    if (!(height * along > 0.0))
        return false;
    double c0 = side(v[1], v[2], w), c1 = side(v[2], v[0], w), c2 = side(v[0], v[1], w);
    if (!((c0 >= 0.0 && c1 >= 0.0 && c2 >= 0.0) || (c0 <= 0.0 && c1 <= 0.0 && c2 <= 0.0)))
        return false;
    *out_t = height / along;
    out_uv[0] = c1 / (c0 + c1 + c2);
    out_uv[1] = c2 / (c0 + c1 + c2);
    return true;
}

static bool meet(const struct RTCRay *ray, const lf_large_triangle *triangle, float *out_t,
                 double out_uv[2])
{
    const double o[3] = {(double)ray->org_x, (double)ray->org_y, (double)ray->org_z};
    const double w[3] = {(double)ray->dir_x, (double)ray->dir_y, (double)ray->dir_z};
    double t;
    if (!lf_large_meet(triangle, o, w, &t, out_uv))
        return false;
    *out_t = (float)t;
    return t > (double)ray->tnear && t < (double)ray->tfar;
}

static void bounds(const struct RTCBoundsFunctionArguments *args)
{
    const lf_large *large = args->geometryUserPtr;
    const lf_large_triangle *t = &large->triangles[args->primID];
    float box[2][3];
    for (int i = 0; i < 3; i++) {
        box[0][i] = (float)fmin(t->corner[0][i], fmin(t->corner[1][i], t->corner[2][i]));
        box[1][i] = (float)fmax(t->corner[0][i], fmax(t->corner[1][i], t->corner[2][i]));
    }
    *args->bounds_o = (struct RTCBounds){.lower_x = box[0][0],
                                         .lower_y = box[0][1],
                                         .lower_z = box[0][2],
                                         .upper_x = box[1][0],
                                         .upper_y = box[1][1],
                                         .upper_z = box[1][2]};
}

/* Rays come one at a time (track.c). */
static void intersect(const struct RTCIntersectFunctionNArguments *args)
{
    const lf_large *large = args->geometryUserPtr;
    struct RTCRayHit *rh = (struct RTCRayHit *)(void *)args->rayhit;
    float t;
    double uv[2];
    if (!meet(&rh->ray, &large->triangles[args->primID], &t, uv))
        return;
    rh->ray.tfar = t;
    rh->hit.u = (float)uv[0];
    rh->hit.v = (float)uv[1];
    rh->hit.geomID = args->geomID;
    rh->hit.primID = args->primID;
}

static void occluded(const struct RTCOccludedFunctionNArguments *args)
{
    const lf_large *large = args->geometryUserPtr;
    struct RTCRay *ray = (struct RTCRay *)(void *)args->ray;
    float t;
    double uv[2];
    if (meet(ray, &large->triangles[args->primID], &t, uv))
        ray->tfar = -INFINITY;
}

bool lf_large_attach(const lf_large *large, RTCDevice device, RTCScene scene, unsigned id)
{
    RTCGeometry shape = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    if (!shape)
        return false;
    rtcSetGeometryUserPrimitiveCount(shape, large->n);
    rtcSetGeometryUserData(shape, (void *)(uintptr_t)large);
    rtcSetGeometryBoundsFunction(shape, bounds, NULL);
    rtcSetGeometryIntersectFunction(shape, intersect);
    rtcSetGeometryOccludedFunction(shape, occluded);
    rtcCommitGeometry(shape);
    rtcAttachGeometryByID(scene, shape, id);
    rtcReleaseGeometry(shape);
    return rtcGetDeviceError(device) == RTC_ERROR_NONE;
}
