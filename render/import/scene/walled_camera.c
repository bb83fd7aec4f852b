#include "render/import/scene/walled_camera.h"

#include "render/import/scene/closed_mesh.h"
#include "render/scene/vec_double.h"
#include "render/transport/light/light_kind.h"
#include "render/transport/path/track.h"

/* A limit, because users wait for scenes to load: a million triangles took 0.17 s. */
enum { MOST_TRIANGLES = 1 << 18 };

static bool contains(const lf_box *box, lf_vec3 p)
{
    return p.x >= box->min.x && p.x <= box->max.x && p.y >= box->min.y && p.y <= box->max.y &&
           p.z >= box->min.z && p.z <= box->max.z;
}

static bool overlap(const lf_box *a, lf_vec3 min, lf_vec3 max)
{
    return a->min.x <= max.x && a->max.x >= min.x && a->min.y <= max.y && a->max.y >= min.y &&
           a->min.z <= max.z && a->max.z >= min.z;
}

static bool is_opaque(const lf_scene *scene, const lf_mesh *mesh)
{
    bool opaque = true;
    for (int i = 0; i < mesh->n_triangles && opaque; i++) {
        const lf_material *m = &scene->materials[lf_mesh_material(mesh, (uint32_t)i)];
        opaque =
            m->cover == LF_COVER_OPAQUE && !(m->transmission > 0.0f) && !(m->subsurface > 0.0f);
    }
    return opaque;
}

/* Whether anything in the box may emit; lights at a distance do not. */
static bool may_shine_in(const lf_scene *scene, const lf_box *box)
{
    bool found = false;
    for (int i = scene->n_lights_infinite; i < scene->n_lights && !found; i++) {
        const lf_light *light = &scene->lights[i];
        const lf_box *of = lf_light_has_faces(light) ? &scene->meshes[light->mesh].box : NULL;
        found =
            light->motion || (of ? overlap(box, of->min, of->max) : contains(box, light->position));
    }
    for (int i = 0; i < scene->emissive.n && !found; i++)
        found =
            overlap(box, scene->emissive.field[i].bounds_min, scene->emissive.field[i].bounds_max);
    return found;
}

/* The solid angle, with its sign, that a triangle takes up seen from p (van Oosterom and Strackee,
 * 1983). */
static double solid_angle(const lf_mesh *mesh, const uint32_t *triangle, const double p[3])
{
    double to[3][3], length[3], normal[3], below = 1;
    for (int k = 0; k < 3; k++) {
        const float *v = mesh->vertices + 3 * (size_t)triangle[k];
        for (int i = 0; i < 3; i++)
            to[k][i] = (double)v[i] - p[i];
        length[k] = lf_length_double(to[k]);
        below *= length[k];
    }
    for (int k = 0; k < 3; k++)
        below += lf_dot_double(to[k], to[(k + 1) % 3]) * length[(k + 2) % 3];
    lf_cross_double(to[1], to[2], normal);
    return 2 * atan2(lf_dot_double(to[0], normal), below);
}

/* How often a closed mesh winds around p: odd if every way out passes through it. */
static bool surrounds(const lf_mesh *mesh, const double p[3])
{
    double sum = 0;
    for (int i = 0; i < mesh->n_triangles; i++)
        sum += solid_angle(mesh, mesh->triangles + 3 * (size_t)i, p);
    double times = sum / (4 * M_PI);
    return fabs(times - round(times)) < 1e-3 && fmod(fabs(round(times)), 2) == 1;
}

/* A few rays, which show for most cameras that they are not enclosed. */
static bool sees_out(const lf_scene *scene, lf_vec3 p)
{
    lf_tracer tracer = {.scene = scene};
    lf_hit hit;
    bool met = true;
    for (int i = 0; i < 27 && met; i++) {
        const int x = i % 3 - 1, y = i / 3 % 3 - 1, z = i / 9 - 1;
        const lf_vec3 w = lf_v3((float)x, (float)y, (float)z);
        if (x != 0 || y != 0 || z != 0)
            met = lf_trace_next(&tracer, p, w, 0.0f, INFINITY, &hit);
    }
    return !met;
}

static bool walls_in(const lf_scene *scene, const lf_mesh *mesh, const double p[3])
{
    bool is_wall = !mesh->hidden && !mesh->instances && !mesh->close.vertices &&
                   mesh->n_triangles <= MOST_TRIANGLES && contains(&mesh->box, lf_to_vec3(p));
    return is_wall && is_opaque(scene, mesh) && !may_shine_in(scene, &mesh->box) &&
           surrounds(mesh, p) && lf_mesh_is_closed(mesh);
}

void lf_warn_of_walled_camera(const lf_scene *scene, const lf_scene_desc *desc,
                              lf_warnings *warnings)
{
    double p[3];
    lf_sub_double(scene->camera.position, scene->origin, p);
    if (scene->n_meshes == 0 || scene->camera.moves || scene->camera.list ||
        sees_out(scene, lf_to_vec3(p)))
        return;
    for (int i = 0; i < scene->n_meshes; i++)
        if (walls_in(scene, &scene->meshes[i], p)) {
            lf_warnings_add(
                warnings, scene->file.where,
                "the camera is inside the mesh \"%s\", where no light arrives; its view is black",
                desc->meshes[i].name);
            return;
        }
}
