/* docs/scene.schema.json, compiled in. */
#include "gen/scene_schema.h"
#include "render/render.h"

json_t *lf_scene_schema(void)
{
    return json_loadb((const char *)lf_scene_schema_bytes, sizeof lf_scene_schema_bytes - 1, 0,
                      NULL);
}
