#include "render/bounds.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "render/render.h"

/* The rule of docs/reference/scene-format.md, "Framing". */
#define THIN (1.0 / 20.0)
#define MUCH_LARGER 4.0

/* ------------------------------------------------------------------------------------- boxes -- */

static const lf_box nowhere = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static bool is_there(const lf_box *box)
{
    return box->min.x <= box->max.x;
}

static void grow(lf_box *box, lf_vec3 min, lf_vec3 max)
{
    box->min =
        lf_v3(lf_min(box->min.x, min.x), lf_min(box->min.y, min.y), lf_min(box->min.z, min.z));
    box->max =
        lf_v3(lf_max(box->max.x, max.x), lf_max(box->max.y, max.y), lf_max(box->max.z, max.z));
}

static void grow_by_volume(const lf_volume *volume, lf_box *box)
{
    if (volume->sigma_max > 0.0f)
        grow(box, volume->bounds_min, volume->bounds_max);
}

/* Objects of the document, without area lights. */
static int count_said(const lf_scene *scene)
{
    return scene->n_volumes + (int)json_object_size(json_object_get(scene->json, "meshes"));
}

int lf_scene_things(const lf_scene *scene)
{
    return scene->n_volumes + scene->n_meshes;
}

bool lf_thing_box(const lf_scene *scene, int thing, lf_box *out)
{
    *out = nowhere;
    if (thing >= scene->n_volumes) {
        const lf_mesh *mesh = &scene->meshes[thing - scene->n_volumes];
        if (!mesh->hidden)
            *out = mesh->box;
        return is_there(out);
    }
    grow_by_volume(&scene->volumes[thing], out);
    for (int f = 0; f < scene->emissive.n; f++)
        if (scene->emissive.light[f].volume == thing)
            grow_by_volume(&scene->emissive.field[f], out);
    return is_there(out);
}

int lf_box_sides(const lf_box *box, double out[3])
{
    const lf_vec3 min = box->min, max = box->max;
    out[0] = (double)max.x - (double)min.x;
    out[1] = (double)max.y - (double)min.y;
    out[2] = (double)max.z - (double)min.z;
    int thin = out[1] <= out[0] ? 1 : 0;
    return out[2] < out[thin] ? 2 : thin;
}

/* ----------------------------------------------------------------------------------- grounds -- */

static bool is_flat(const lf_box *box)
{
    double side[3];
    const int thin = lf_box_sides(box, side);
    return side[thin] < THIN * fmax(side[0], fmax(side[1], side[2]));
}

static lf_ground_word word_of(const lf_scene *scene, int thing)
{
    return thing < scene->n_volumes ? LF_GROUND_DENIED
                                    : scene->meshes[thing - scene->n_volumes].ground;
}

/* The box that a flat mesh is compared with: of all objects that are not flat or, if there are
 * none, of all others. */
static lf_box rest_of(const lf_scene *scene, int flat)
{
    lf_box rest = nowhere, others = nowhere, box;
    for (int i = 0; i < count_said(scene); i++) {
        const lf_ground_word word = word_of(scene, i);
        if (i == flat || word == LF_GROUND_SAID || !lf_thing_box(scene, i, &box))
            continue;
        grow(&others, box.min, box.max);
        if (word == LF_GROUND_DENIED || !is_flat(&box))
            grow(&rest, box.min, box.max);
    }
    return is_there(&rest) ? rest : others;
}

static bool is_guessed(const lf_scene *scene, int thing, const lf_box *box)
{
    double side[3], other[3];
    const int thin = lf_box_sides(box, side), a = (thin + 1) % 3, b = (thin + 2) % 3;
    if (!is_flat(box))
        return false;
    const lf_box rest = rest_of(scene, thing);
    if (!is_there(&rest))
        return false;
    lf_box_sides(&rest, other);
    return side[a] * side[b] > MUCH_LARGER * other[a] * other[b];
}

bool lf_find_grounds(const lf_scene *scene, bool *out)
{
    int n_there = 0, n_left = 0;
    lf_box box;
    memset(out, 0, (size_t)lf_scene_things(scene) * sizeof *out);
    for (int i = 0; i < count_said(scene); i++) {
        if (!lf_thing_box(scene, i, &box))
            continue;
        const lf_ground_word word = word_of(scene, i);
        out[i] =
            word == LF_GROUND_SAID || (word == LF_GROUND_GUESSED && is_guessed(scene, i, &box));
        n_there++;
        n_left += out[i];
    }
    if (n_left < n_there)
        return n_left > 0;
    memset(out, 0, (size_t)lf_scene_things(scene) * sizeof *out);
    return false;
}

const char *lf_scene_ground(const lf_scene *scene, int index)
{
    bool *left_out = lf_calloc((size_t)lf_scene_things(scene) + 1, sizeof *left_out);
    const char *found = NULL, *key;
    json_t *value;
    int i = scene->n_volumes;
    if (left_out && lf_find_grounds(scene, left_out)) {
        json_object_foreach(json_object_get(scene->json, "meshes"), key, value)
        {
            if (left_out[i++] && index-- == 0)
                found = key;
        }
    }
    lf_free(left_out);
    return found;
}

/* ------------------------------------------------------------------------------------ bounds -- */

static void grow_bounds(const lf_scene *scene, int thing, double bounds[2][3])
{
    lf_box box;
    if (!lf_thing_box(scene, thing, &box))
        return;
    const float lo[3] = {box.min.x, box.min.y, box.min.z},
                hi[3] = {box.max.x, box.max.y, box.max.z};
    for (int i = 0; i < 3; i++) {
        bounds[0][i] = fmin(bounds[0][i], (double)lo[i] + scene->origin[i]);
        bounds[1][i] = fmax(bounds[1][i], (double)hi[i] + scene->origin[i]);
    }
}

/* name NULL: all except left_out, which may also be NULL. */
static void grow_by_section(const lf_scene *scene, const char *section, int first, const char *name,
                            const bool *left_out, double bounds[2][3])
{
    const char *key;
    json_t *value;
    json_object_foreach(json_object_get(scene->json, section), key, value)
    {
        const int thing = first++;
        if (name ? strcmp(key, name) == 0 : !(left_out && left_out[thing]))
            grow_bounds(scene, thing, bounds);
    }
}

bool lf_scene_bounds(const lf_scene *scene, const char *name, double out_bounds[2][3])
{
    double bounds[2][3];
    bool *left_out = lf_calloc((size_t)lf_scene_things(scene) + 1, sizeof *left_out);
    for (int i = 0; i < 3; i++) {
        bounds[0][i] = INFINITY;
        bounds[1][i] = -INFINITY;
    }
    if (left_out)
        (void)lf_find_grounds(scene, left_out);
    grow_by_section(scene, "volumes", 0, name, left_out, bounds);
    grow_by_section(scene, "meshes", scene->n_volumes, name, left_out, bounds);
    lf_free(left_out);
    if (!(bounds[0][0] <= bounds[1][0]))
        return false;
    memcpy(out_bounds, bounds, sizeof bounds);
    return true;
}
