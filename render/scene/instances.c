#include "render/scene/instances.h"

#include "base/alloc.h"
#include "render/scene/embree_commit.h"
#include "render/scene/ray.h"
#include "render/scene/vec_double.h"

lf_affine lf_instance_map(const lf_instances *instances, uint32_t place)
{
    lf_affine out;
    for (int i = 0; i < 12; i++)
        out.m[i / 4][i % 4] = (double)instances->map[place][i / 4][i % 4];
    return out;
}

/* ------------------------------------------------------------------------------------- boxes -- */

static void put_point(const double p[3], lf_box *box)
{
    box->min = lf_v3(lf_min(box->min.x, nextafterf((float)p[0], -INFINITY)),
                     lf_min(box->min.y, nextafterf((float)p[1], -INFINITY)),
                     lf_min(box->min.z, nextafterf((float)p[2], -INFINITY)));
    box->max = lf_v3(lf_max(box->max.x, nextafterf((float)p[0], INFINITY)),
                     lf_max(box->max.y, nextafterf((float)p[1], INFINITY)),
                     lf_max(box->max.z, nextafterf((float)p[2], INFINITY)));
}

static lf_box nothing(void)
{
    return (lf_box){lf_v3(INFINITY, INFINITY, INFINITY), lf_v3(-INFINITY, -INFINITY, -INFINITY)};
}

/* A box that contains the mesh transformed by a map. */
static lf_box mapped(const lf_affine *map, const lf_box *own)
{
    lf_box out = nothing();
    for (int corner = 0; corner < 8; corner++) {
        const double p[3] = {(double)(corner & 1 ? own->max.x : own->min.x),
                             (double)(corner & 2 ? own->max.y : own->min.y),
                             (double)(corner & 4 ? own->max.z : own->min.z)};
        double q[3];
        lf_affine_point(map, p, q);
        put_point(q, &out);
    }
    return out;
}

static lf_box box_of_triangle(const lf_mesh *mesh, uint32_t triangle)
{
    lf_box out = nothing();
    for (int i = 0; i < 3; i++) {
        lf_vec3 v = lf_mesh_vertex(mesh, mesh->triangles[3 * (size_t)triangle + (size_t)i]);
        out.min = lf_v3(lf_min(out.min.x, v.x), lf_min(out.min.y, v.y), lf_min(out.min.z, v.z));
        out.max = lf_v3(lf_max(out.max.x, v.x), lf_max(out.max.y, v.y), lf_max(out.max.z, v.z));
    }
    return out;
}

/* The effect of a map on lengths: bounds of its largest and smallest singular value. */
static void lengths_of(const lf_affine *map, float *out_most, float *out_least)
{
    double most = 0.0, inverse = 0.0;
    lf_affine back;
    bool turns = lf_affine_invert(map, &back);
    for (int i = 0; i < 9; i++) {
        most += map->m[i / 3][i % 3] * map->m[i / 3][i % 3];
        inverse += turns ? back.m[i / 3][i % 3] * back.m[i / 3][i % 3] : 0.0;
    }
    *out_most = (float)sqrt(most);
    *out_least = inverse > 0.0 ? (float)(1.0 / sqrt(inverse)) : 0.0f;
}

static lf_status build_triangles(lf_instanced_part *part, const lf_mesh *mesh, lf_box *own)
{
    lf_box *boxes = lf_calloc(part->n, sizeof *boxes);
    *own = nothing();
    for (uint32_t i = 0; boxes && i < part->n; i++) {
        const uint32_t triangle = part->first + i;
        boxes[i] = box_of_triangle(mesh, triangle);
        for (int c = 0; c < 3; c++) {
            lf_vec3 v = lf_mesh_vertex(mesh, mesh->triangles[3 * (size_t)triangle + (size_t)c]);
            const double p[3] = {(double)v.x, (double)v.y, (double)v.z};
            part->radius = fmax(part->radius, lf_length_double(p));
            put_point(p, own);
        }
    }
    part->radius *= 1.0 + 1e-6;
    lf_status status = boxes ? lf_box_tree_init(&part->triangles, boxes, part->n) : LF_E_NOMEM;
    lf_free(boxes);
    return status;
}

static lf_status build_instances(lf_instances *instances, const lf_box *own, lf_box *all)
{
    lf_box *boxes = lf_calloc((size_t)instances->n, sizeof *boxes);
    *all = nothing();
    instances->least = INFINITY;
    for (int i = 0; boxes && i < instances->n; i++) {
        lf_affine map = lf_instance_map(instances, (uint32_t)i);
        const lf_instanced_part *part = lf_instanced_part_at(instances, (uint32_t)i);
        float most, least;
        boxes[i] = mapped(&map, &own[part - instances->parts]);
        const double ends[2][3] = {
            {(double)boxes[i].min.x, (double)boxes[i].min.y, (double)boxes[i].min.z},
            {(double)boxes[i].max.x, (double)boxes[i].max.y, (double)boxes[i].max.z}};
        put_point(ends[0], all);
        put_point(ends[1], all);
        lengths_of(&map, &most, &least);
        instances->most = lf_max(instances->most, most);
        instances->least = lf_min(instances->least, least);
        instances->reach = lf_max(instances->reach, most * (float)part->radius);
    }
    lf_status status =
        boxes ? lf_box_tree_init(&instances->boxes, boxes, (uint32_t)instances->n) : LF_E_NOMEM;
    lf_free(boxes);
    return status;
}

/* ------------------------------------------------------------------------------------ Embree -- */

static lf_status build_embree(lf_instanced_part *part, const lf_mesh *mesh, RTCDevice device)
{
    RTCGeometry shape = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    part->embree = rtcNewScene(device);
    if (!shape || !part->embree) {
        if (shape)
            rtcReleaseGeometry(shape);
        return LF_E_NOMEM;
    }
    rtcSetSharedGeometryBuffer(shape, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->vertices,
                               0, 3 * sizeof(float), (size_t)mesh->n_vertices);
    rtcSetSharedGeometryBuffer(shape, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh->triangles + 3 * (size_t)part->first, 0, 3 * sizeof(uint32_t),
                               part->n);
    rtcSetGeometryBuildQuality(shape, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(shape);
    rtcAttachGeometryByID(part->embree, shape, mesh->geom_id);
    rtcReleaseGeometry(shape);
    rtcSetSceneFlags(part->embree, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(part->embree, RTC_BUILD_QUALITY_HIGH);
    return lf_embree_commit(part->embree, device, NULL);
}

lf_status lf_instances_build(lf_instances *instances, lf_mesh *mesh, RTCDevice device)
{
    lf_box *own = lf_calloc((size_t)instances->n_parts, sizeof *own);
    lf_status status = own ? LF_OK : LF_E_NOMEM;
    for (int i = 0; i < instances->n_parts && status == LF_OK; i++) {
        status = build_triangles(&instances->parts[i], mesh, &own[i]);
        if (status == LF_OK)
            status = build_embree(&instances->parts[i], mesh, device);
    }
    if (status == LF_OK)
        status = build_instances(instances, own, &mesh->box);
    lf_free(own);
    return status;
}

void lf_instances_destroy(lf_instances *instances)
{
    if (!instances)
        return;
    for (int i = 0; instances->parts && i < instances->n_parts; i++) {
        if (instances->parts[i].embree)
            rtcReleaseScene(instances->parts[i].embree);
        lf_box_tree_finish(&instances->parts[i].triangles);
    }
    lf_box_tree_finish(&instances->boxes);
    lf_free(instances->parts);
    lf_free(instances->part_of);
    lf_free(instances->map);
    lf_free(instances);
}

static void bounds(const struct RTCBoundsFunctionArguments *args)
{
    const lf_mesh *mesh = args->geometryUserPtr;
    const lf_box *box = &mesh->instances->boxes.boxes[args->primID];
    *args->bounds_o = (struct RTCBounds){.lower_x = box->min.x,
                                         .lower_y = box->min.y,
                                         .lower_z = box->min.z,
                                         .upper_x = box->max.x,
                                         .upper_y = box->max.y,
                                         .upper_z = box->max.z};
}

/* A ray in the space of an instance: t of the outer ray is begin + t / speed. */
typedef struct brought {
    struct RTCRayHit own;
    double begin, speed;
} brought;

/* Transforms a ray to the space of an instance, starting where it comes near to the mesh. The start
 * depends only on the line, so that a ray that continues after a hit is rounded as before. Embree
 * accepts the ray for any map (limits.h). false: it does not come near. */
static bool bring(const lf_instances *instances, uint32_t place, const struct RTCRay *ray,
                  brought *out)
{
    const double from[3] = {(double)ray->org_x, (double)ray->org_y, (double)ray->org_z},
                 along[3] = {(double)ray->dir_x, (double)ray->dir_y, (double)ray->dir_z};
    lf_affine map = lf_instance_map(instances, place);
    const double radius = lf_instanced_part_at(instances, place)->radius;
    double o[3], w[3], back[3][3];
    lf_affine_cofactors(&map, back);
    double det = lf_dot_double(map.m[0], back[0]);
    for (int i = 0; i < 3; i++) {
        o[i] = w[i] = 0.0;
        for (int j = 0; j < 3; j++) {
            o[i] += back[j][i] * (from[j] - map.m[j][3]) / det;
            w[i] += back[j][i] * along[j] / det;
        }
    }
    double ww = lf_dot_double(w, w), ow = lf_dot_double(o, w),
           apart = lf_dot_double(o, o) - ow * ow / ww, half2 = radius * radius - apart;
    if (!(half2 >= -1e-6 * radius * radius))
        return false;
    const double half = 1.001 * sqrt(fmax(half2, 0.0) * ww), beside = 1e-3 * radius / sqrt(ww);
    if (!((-ow + half) / ww + beside >= 0.0)) /* the mesh lies behind the origin */
        return false;
    out->begin = fmax((-ow - half) / ww - beside, 0.0);
    out->speed =
        ww > LF_MAX_STRETCH * LF_MAX_STRETCH || ww < 1.0 / (LF_MAX_STRETCH * LF_MAX_STRETCH)
            ? sqrt(ww)
            : 1.0;
    struct RTCRay *own = &out->own.ray;
    *own = *ray;
    own->org_x = (float)(o[0] + out->begin * w[0]);
    own->org_y = (float)(o[1] + out->begin * w[1]);
    own->org_z = (float)(o[2] + out->begin * w[2]);
    own->dir_x = (float)(w[0] / out->speed);
    own->dir_y = (float)(w[1] / out->speed);
    own->dir_z = (float)(w[2] / out->speed);
    own->tnear = (float)fmax(((double)ray->tnear - out->begin) * out->speed, 0.0);
    own->tfar = (float)(((double)ray->tfar - out->begin) * out->speed);
    return own->tfar > own->tnear && lf_ray_is_sound(own);
}

/* Rays come one at a time (track.c). */
static void intersect(const struct RTCIntersectFunctionNArguments *args)
{
    const lf_mesh *mesh = args->geometryUserPtr;
    const lf_instances *instances = mesh->instances;
    struct RTCRayHit *rh = (struct RTCRayHit *)(void *)args->rayhit;
    const uint32_t place = instances->boxes.order[args->primID];
    brought at;
    if (!bring(instances, place, &rh->ray, &at))
        return;
    at.own.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    at.own.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    const lf_instanced_part *part = lf_instanced_part_at(instances, place);
    lf_embree_intersect(part->embree, &at.own);
    if (at.own.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return;
    /* never before the requested start, because rays continue after earlier hits */
    rh->ray.tfar = lf_max((float)(at.begin + (double)at.own.ray.tfar / at.speed), rh->ray.tnear);
    rh->hit.u = at.own.hit.u;
    rh->hit.v = at.own.hit.v;
    rh->hit.geomID = args->geomID;
    rh->hit.primID = part->first + at.own.hit.primID;
    rh->hit.instID[0] = place;
}

static void occluded(const struct RTCOccludedFunctionNArguments *args)
{
    const lf_instances *instances = ((const lf_mesh *)args->geometryUserPtr)->instances;
    struct RTCRay *ray = (struct RTCRay *)(void *)args->ray;
    const uint32_t place = instances->boxes.order[args->primID];
    brought at;
    if (!bring(instances, place, ray, &at))
        return;
    lf_embree_occluded(lf_instanced_part_at(instances, place)->embree, &at.own.ray);
    if (at.own.ray.tfar < 0.0f)
        ray->tfar = -INFINITY;
}

bool lf_instances_attach(const lf_mesh *mesh, RTCDevice device, RTCScene scene)
{
    RTCGeometry shape = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    if (!shape)
        return false;
    rtcSetGeometryUserPrimitiveCount(shape, (unsigned)mesh->instances->n);
    rtcSetGeometryUserData(shape, (void *)(uintptr_t)mesh);
    rtcSetGeometryBoundsFunction(shape, bounds, NULL);
    rtcSetGeometryIntersectFunction(shape, intersect);
    rtcSetGeometryOccludedFunction(shape, occluded);
    rtcCommitGeometry(shape);
    rtcAttachGeometryByID(scene, shape, mesh->geom_id);
    rtcReleaseGeometry(shape);
    return rtcGetDeviceError(device) == RTC_ERROR_NONE;
}
