#include "render/import/scene/camera_frame.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/nearest.h"
#include "render/import/scene/camera_parse.h"
#include "render/scene/geometry.h"
#include "render/scene/vec_double.h"

/* ------------------------------------------------------------------------------- which it is -- */

/* The number of the mesh that the framing names; below 0: an error. */
static int find_mesh(lf_reader *reader, const lf_node *from, const lf_scene_desc *desc)
{
    const lf_node at = lf_node_child(from, "mesh");
    const char *names[LF_MAX_MESHES + 1];
    int n = 0;
    for (int i = 0; i < desc->n_meshes; i++) {
        const lf_mesh_desc *mesh = &desc->meshes[i];
        if (mesh->lamp)
            continue;
        if (strcmp(mesh->name, desc->framing.mesh) == 0)
            return i;
        names[n++] = mesh->name;
    }
    names[n] = NULL;
    const char *meant = lf_nearest_name(desc->framing.mesh, names);
    lf_read_fail(reader, &at, "no mesh \"%s\"%s%s%s", desc->framing.mesh,
                 meant ? "; did you mean \"" : " in meshes", meant ? meant : "",
                 meant ? "\"?" : "");
    return -1;
}

static bool is_meant(const lf_framing *framing, const lf_file_camera *camera)
{
    if (framing->name)
        return strcmp(camera->name, framing->name) == 0 ||
               strcmp(camera->node_name, framing->name) == 0;
    return framing->number < 0 || framing->number == camera->number;
}

/* 0 "Camera", 1 "Camera_Orientation": numbers of all, and names of those that have some. */
static void list_cameras(const lf_file_cameras *cameras, char *out, size_t size)
{
    size_t n = 0;
    out[0] = '\0';
    for (int i = 0; i < cameras->n && n < size; i++) {
        const lf_file_camera *camera = &cameras->open[i];
        const char *name = camera->name[0] ? camera->name : camera->node_name;
        int added = snprintf(out + n, size - n, *name ? "%s%d \"%s\"" : "%s%d", i > 0 ? ", " : "",
                             camera->number, name);
        n += added > 0 ? (size_t)added : 0;
    }
}

static void refuse(lf_reader *reader, const lf_node *from, const lf_framing *framing,
                   const lf_file_cameras *cameras)
{
    const lf_node at = lf_node_child(from, "camera");
    char said[LF_MAX_NAME + 3] = "", list[512];
    if (framing->name)
        snprintf(said, sizeof said, "\"%s\"", framing->name);
    else if (framing->number >= 0)
        snprintf(said, sizeof said, "%d", framing->number);
    list_cameras(cameras, list, sizeof list);
    if (cameras->n == 0)
        lf_read_fail(reader, from, "the file of mesh \"%s\" has no camera", framing->mesh);
    else
        lf_read_fail(reader, &at, "no camera %s; expected one of %s", said, list);
}

/* Which of a mesh's cameras; below 0: an error. */
static int find_camera(lf_reader *reader, const lf_node *from, const lf_framing *framing,
                       const lf_file_cameras *cameras)
{
    int i = 0;
    while (i < cameras->n && !is_meant(framing, &cameras->open[i]))
        i++;
    if (i == cameras->n) {
        refuse(reader, from, framing, cameras);
        return -1;
    }
    if (!cameras->open[i].parallel)
        return i;
    lf_read_fail(reader, from, "that camera is orthographic; choose a perspective camera");
    return -1;
}

/* ---------------------------------------------------------------------------------- position -- */

/* The middle of what of the scene's box lies before the camera, along its axis. */
static double middle_depth(const lf_scene *scene, const lf_file_camera *camera)
{
    const lf_vec3 *ends[] = {&scene->bounds.min, &scene->bounds.max};
    double nearest = INFINITY, farthest = -INFINITY;
    for (int corner = 0; corner < 8; corner++) {
        double p[3] = {(double)ends[corner & 1]->x, (double)ends[corner >> 1 & 1]->y,
                       (double)ends[corner >> 2]->z},
               depth = 0;
        for (int i = 0; i < 3; i++)
            depth += (p[i] + scene->origin[i] - camera->position[i]) * camera->look[i];
        nearest = fmin(nearest, depth);
        farthest = fmax(farthest, depth);
    }
    double middle = 0.5 * (fmax(nearest, 0) + farthest);
    return middle > 0 && isfinite(middle) ? middle : 1;
}

/* Fills in values that the document does not give. */
static void stand(const lf_framing *framing, const lf_file_camera *from, const lf_scene *scene,
                  lf_camera *camera)
{
    double distance = framing->distance > 0 ? framing->distance : middle_depth(scene, from);
    for (int i = 0; i < 3; i++) {
        if (!framing->own_position)
            camera->position[i] = from->position[i];
        if (!framing->own_target)
            camera->target[i] = from->position[i] + distance * from->look[i];
        if (!framing->own_up)
            camera->up[i] = from->up[i];
    }
    if (!framing->own_fov)
        camera->fov_y = from->fov_y;
}

static double between(double a, double b, double t)
{
    return a + t * (b - a);
}

/* The camera at the frame's own time, from both ends. */
static lf_file_camera moment_of(const lf_file_camera *open, const lf_file_camera *close,
                                const lf_camera *camera)
{
    double t = camera->shutter > 0 ? fmin(fmax(-camera->shutter_open / camera->shutter, 0), 1) : 0,
           look = 0, across = 0, along = 0;
    lf_file_camera now = *open;
    for (int i = 0; i < 3; i++) {
        now.position[i] = between(open->position[i], close->position[i], t);
        now.look[i] = between(open->look[i], close->look[i], t);
        now.up[i] = between(open->up[i], close->up[i], t);
    }
    now.fov_y = between(open->fov_y, close->fov_y, t);
    look = lf_length_double(now.look);
    for (int i = 0; i < 3; i++) {
        now.look[i] /= look;
        along += now.look[i] * now.up[i];
    }
    for (int i = 0; i < 3; i++)
        now.up[i] -= along * now.look[i];
    across = lf_length_double(now.up);
    return t > 0 && look > 1e-3 && across > 1e-3 ? now : *open;
}

/* Copies the list to the scene. */
static bool take_views(const lf_scene_desc *desc, lf_scene *scene)
{
    const size_t bytes = (size_t)desc->camera.n_views * sizeof *desc->views;
    if (!desc->camera.list)
        return true;
    scene->file.views = lf_calloc(1, bytes);
    if (scene->file.views)
        memcpy(scene->file.views, desc->views, bytes);
    scene->camera.list = scene->file.views;
    return scene->file.views;
}

void lf_camera_frame(lf_reader *reader, const lf_node *root, const lf_scene_desc *desc,
                     const lf_shutter *shutter, lf_scene *scene)
{
    const lf_node node = lf_node_child(root, "camera"), from = lf_node_child(&node, "from");
    lf_camera ends[2] = {shutter->desc[0]->camera, shutter->desc[1]->camera};
    scene->camera = desc->camera;
    if (!take_views(desc, scene)) {
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
        return;
    }
    if (desc->framing.mesh) {
        int mesh = find_mesh(reader, &from, desc), which = -1;
        const lf_file_cameras *cameras = mesh < 0 ? NULL : &scene->geometry->cameras[mesh];
        if (cameras)
            which = find_camera(reader, &from, &desc->framing, cameras);
        if (which < 0)
            return;
        const lf_file_camera *open = &cameras->open[which],
                             *close = cameras->close ? &cameras->close[which] : open,
                             now = moment_of(open, close, &desc->camera);
        stand(&desc->framing, &now, scene, &scene->camera);
        stand(&desc->framing, open, scene, &ends[0]);
        stand(&desc->framing, close, scene, &ends[1]);
        lf_camera_check(reader, root, &scene->camera);
        lf_camera_check(reader, root, &ends[0]);
        lf_camera_check(reader, root, &ends[1]);
    }
    lf_shutter_shift(ends, &scene->camera);
}

void lf_camera_frame_warn(const lf_scene_desc *desc, lf_scene *scene)
{
    const lf_geometry *geometry = scene->geometry;
    for (int i = 0; geometry && i < geometry->n_meshes && !desc->framing.mesh; i++)
        if (geometry->cameras[i].n > 0)
            lf_warnings_count(&scene->warnings, lf_geometry_file(geometry, i),
                              geometry->cameras[i].n,
                              "camera is not used because the scene has its own; to use it, set "
                              "\"from\" of the scene's camera",
                              "cameras are not used because the scene has its own; to use one, set "
                              "\"from\" of the scene's camera");
}
