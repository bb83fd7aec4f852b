#include "render/import/scene/unused_grids.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

static bool is_named(const char *grid, const char *name, size_t length)
{
    if (!grid)
        return false;
    size_t n = strlen(grid);
    bool first = n + 3 == length && strncmp(name + n, "[0]", 3) == 0;
    return (n == length || first) && strncmp(grid, name, n) == 0;
}

/* Whether a name is one of several, one per line. */
static bool is_added(const char *names, const char *name, size_t length)
{
    for (const char *one = names; *one;) {
        char grid[LF_GRID_NAME_BYTES];
        size_t n = strcspn(one, "\n");
        snprintf(grid, sizeof grid, "%.*s", (int)n, one);
        if (is_named(grid, name, length))
            return true;
        one += n + (one[n] == '\n');
    }
    return false;
}

/* For a vector grid the name continues with the component: "Cd.x". */
static bool is_component(const char *component, const char *name, size_t length)
{
    char grid[LF_GRID_NAME_BYTES];
    size_t n = strlen(component);
    if (n < 2 || component[n - 2] != '.')
        return false;
    snprintf(grid, sizeof grid, "%.*s", (int)n - 2, component);
    return is_named(grid, name, length);
}

/* name: `length` bytes. A plain name means the first grid of that name. */
static bool is_used(const lf_scene_desc *desc, const char *file, const char *name, size_t length)
{
    for (int i = 0; i < desc->n_volumes; i++) {
        const lf_volume_desc *v = &desc->volumes[i];
        if (!v->file || strcmp(v->file, file) != 0)
            continue;
        bool used = is_added(v->grid, name, length) || is_named(v->emission_grid, name, length);
        for (int c = 0; c < 3; c++)
            used = used || is_named(v->albedo_grid[c], name, length) ||
                   is_component(v->albedo_grid[c], name, length) ||
                   is_named(v->velocity.grid[c], name, length) ||
                   is_component(v->velocity.grid[c], name, length);
        if (used)
            return true;
    }
    return false;
}

/* Common names of velocities: the name, or the name and a component. */
static bool is_velocity(const char *name, size_t length)
{
    static const char *const names[] = {"velocity", "vel", "v"};
    if (length > 2 && strchr("._", name[length - 2]) && strchr("xyzXYZ", name[length - 1]))
        length -= 2;
    for (int i = 0; i < 3; i++)
        if (strlen(names[i]) == length && strncasecmp(names[i], name, length) == 0)
            return true;
    return false;
}

/* Whether the shutter is open and none of a file's volumes has a velocity. */
static bool stands_still(const lf_scene_desc *desc, const char *file)
{
    bool flows = false;
    for (int i = 0; i < desc->n_volumes; i++) {
        const lf_volume_desc *v = &desc->volumes[i];
        flows = flows || (v->file && strcmp(v->file, file) == 0 && v->velocity.grid[0][0]);
    }
    return desc->camera.shutter > 0.0 && !flows;
}

void lf_warn_of_unused_grids(lf_warnings *warnings, const lf_scene_desc *desc, const lf_grid *grid,
                             const char *file)
{
    char unused[256] = "", still[256] = "";
    const bool is_still = stands_still(desc, file);
    for (const char *name = grid->others; name && *name; name = strchr(name, '\n') + 1) {
        size_t length = strcspn(name, "\n");
        bool blurs = is_still && is_velocity(name, length);
        char *list = blurs ? still : unused;
        size_t at = strlen(list);
        if (!is_used(desc, file, name, length))
            snprintf(list + at, sizeof unused - at, "%s%.*s", at ? ", " : "", (int)length, name);
    }
    if (still[0])
        lf_warnings_add(warnings, file,
                        "the shutter is open, but these velocity grids are not used: %s; set "
                        "\"velocity\" (see docs/reference/scene-format.md)",
                        still);
    if (unused[0])
        lf_warnings_add(warnings, file, "unused grids: %s", unused);
}

void lf_warn_of_odd_voxels(lf_warnings *warnings, const lf_grid *grid, const char *names,
                           const char *file)
{
    const lf_grid_odd *odd = &grid->odd;
    char list[LF_GRID_NAME_BYTES];
    snprintf(list, sizeof list, "%s", names);
    for (char *end = list; (end = strchr(end, '\n'));)
        *end = '+';
    if (odd->n_negative > 0)
        lf_warnings_add(warnings, file,
                        "grid %s: voxels below 0 (%.0f, down to %.3g) are read as 0", list,
                        odd->n_negative, odd->least);
    if (odd->n_not_finite > 0)
        lf_warnings_add(warnings, file, "grid %s: voxels that are not finite (%.0f) are read as 0",
                        list, odd->n_not_finite);
    if (odd->n_still > 0)
        lf_warnings_add(warnings, file,
                        "grid %s: velocities that are not finite (%.0f) are read as 0", list,
                        odd->n_still);
    if (odd->background != 0.0)
        lf_warnings_add(
            warnings, file,
            "grid %s: its background of %.3g is read as 0; the volume ends at its voxels", list,
            odd->background);
}
