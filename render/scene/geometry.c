#include "render/scene/geometry.h"

#include "base/alloc.h"
#include "render/scene/placed.h"

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
    /* Acquire-release: whoever frees sees what the other owners did before they let go. */
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
        lf_placed_destroy((lf_placed *)(uintptr_t)geometry->meshes[i].placed);
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
