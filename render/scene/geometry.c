#include "render/scene/geometry.h"

#include "base/alloc.h"
#include "render/scene/instances.h"

/* ThreadSanitizer cannot see how TBB hands work from thread to thread: under it Embree builds on
 * the calling thread. */
#ifdef __SANITIZE_THREAD__
#define DEVICE_CONFIG "threads=1"
#else
#define DEVICE_CONFIG NULL
#endif

static lf_status start(lf_geometry *geometry, lf_error *err)
{
    geometry->device = rtcNewDevice(DEVICE_CONFIG);
    if (geometry->device)
        geometry->embree = rtcNewScene(geometry->device);
    if (!geometry->embree)
        return lf_error_set(err, LF_E_NOMEM, "meshes", "Embree cannot start (error %d)",
                            (int)rtcGetDeviceError(geometry->device));
    rtcSetSceneFlags(geometry->embree, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(geometry->embree, RTC_BUILD_QUALITY_HIGH);
    return LF_OK;
}

lf_status lf_geometry_create(int most_meshes, const double origin[3], json_t *key,
                             lf_geometry **out, lf_error *err)
{
    const size_t n = (size_t)most_meshes;
    lf_geometry *geometry = lf_calloc(1, sizeof *geometry);
    if (!geometry)
        return lf_error_set(err, LF_E_NOMEM, "meshes", "out of memory");
    atomic_init(&geometry->refs, 1);
    geometry->key = json_incref(key);
    memcpy(geometry->origin, origin, sizeof geometry->origin);
    geometry->meshes = lf_calloc(n, sizeof *geometry->meshes);
    geometry->motions = lf_calloc(n, sizeof *geometry->motions);
    geometry->lights = lf_calloc(n, sizeof *geometry->lights);
    geometry->cameras = lf_calloc(n, sizeof *geometry->cameras);
    lf_status status =
        geometry->meshes && geometry->motions && geometry->lights && geometry->cameras
            ? start(geometry, err)
            : lf_error_set(err, LF_E_NOMEM, "meshes", "out of memory");
    if (status != LF_OK)
        lf_geometry_unref(geometry);
    else
        *out = geometry;
    return status;
}

lf_geometry *lf_geometry_ref(lf_geometry *geometry)
{
    atomic_fetch_add_explicit(&geometry->refs, 1, memory_order_relaxed);
    return geometry;
}

const char *lf_geometry_file(const lf_geometry *geometry, int mesh)
{
    int i = 0;
    while (i < geometry->n_files && geometry->files[i].mesh != mesh)
        i++;
    return i < geometry->n_files ? geometry->files[i].path : "";
}

void lf_geometry_unref(lf_geometry *geometry)
{
    /* Acquire-release: the thread that frees must see what the other owners did before they
     * released. */
    if (!geometry || atomic_fetch_sub_explicit(&geometry->refs, 1, memory_order_acq_rel) != 1)
        return;
    if (geometry->embree)
        rtcReleaseScene(geometry->embree);
    for (int i = 0; i < geometry->n_meshes; i++) {
        lf_free((void *)(uintptr_t)geometry->meshes[i].vertices);
        lf_free((void *)(uintptr_t)geometry->meshes[i].triangles);
        lf_free((void *)(uintptr_t)geometry->meshes[i].normals);
        lf_free((void *)(uintptr_t)geometry->meshes[i].triangle_material);
        lf_free((void *)(uintptr_t)geometry->meshes[i].uvs);
        lf_free((void *)(uintptr_t)geometry->meshes[i].colours);
        lf_free((void *)(uintptr_t)geometry->meshes[i].tangents);
        lf_free((void *)(uintptr_t)geometry->meshes[i].close.vertices);
        lf_free((void *)(uintptr_t)geometry->meshes[i].close.normals);
        lf_free((void *)(uintptr_t)geometry->meshes[i].close.tangents);
        lf_instances_destroy((lf_instances *)(uintptr_t)geometry->meshes[i].instances);
    }
    for (int i = 0; geometry->lights && i < geometry->n_meshes; i++) {
        lf_free(geometry->lights[i].open);
        lf_free(geometry->lights[i].close);
    }
    for (int i = 0; geometry->cameras && i < geometry->n_meshes; i++) {
        lf_free(geometry->cameras[i].open);
        lf_free(geometry->cameras[i].close);
    }
    if (geometry->device)
        rtcReleaseDevice(geometry->device);
    for (int i = 0; i < geometry->n_files; i++)
        lf_free(geometry->files[i].path);
    lf_free(geometry->files);
    lf_free(geometry->large.triangles);
    lf_free(geometry->meshes);
    lf_free(geometry->motions);
    lf_free(geometry->lights);
    lf_free(geometry->cameras);
    lf_free(geometry->materials);
    lf_free(geometry->first_material);
    lf_free(geometry->material_names);
    lf_free(geometry->textures);
    for (int i = 0; i < geometry->n_pyramids; i++)
        lf_pyramid_finish(&geometry->pyramids[i]);
    for (int i = 0; i < geometry->n_pictures; i++)
        lf_free(geometry->pictures[i].rgba);
    lf_free(geometry->pyramids);
    lf_free(geometry->pictures);
    lf_warnings_finish(&geometry->warnings);
    json_decref(geometry->key);
    lf_free(geometry);
}
