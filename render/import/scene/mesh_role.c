#include "render/import/scene/mesh_role.h"

#include <string.h>

#include "render/import/scene/mesh_shape.h"

/* A shadow catcher, or also a reflection catcher. */
static void parse_catcher(lf_reader *reader, const lf_node *node, lf_mesh_desc *mesh)
{
    const lf_node catcher = lf_node_child(node, "catcher");
    mesh->reflects = json_is_string(catcher.value) &&
                     strcmp(json_string_value(catcher.value), "reflection") == 0;
    if (catcher.value && !mesh->reflects && !json_is_boolean(catcher.value))
        lf_read_fail(reader, &catcher, "expected true, false or \"reflection\"");
    mesh->hidden = mesh->catcher = mesh->reflects || json_is_true(catcher.value);
}

void lf_mesh_role_parse(lf_reader *reader, const lf_node *node, lf_mesh_desc *mesh)
{
    parse_catcher(reader, node, mesh);
    if (!lf_node_child(node, "ground").value)
        return;
    const bool is_ground = lf_read_bool(reader, node, "ground", true);
    mesh->ground = is_ground ? LF_GROUND_SAID : LF_GROUND_DENIED;
    mesh->stands = is_ground && mesh->shape && !lf_node_child(node, "transform").value &&
                   !lf_node_child(node, "instances").value;
    if (mesh->stands && mesh->shape != &lf_mesh_quad && mesh->shape != &lf_mesh_disk)
        lf_read_fail(reader, node,
                     "a ground of this shape needs a \"transform\"; only a quad and a disk are "
                     "placed below the scene automatically");
}
