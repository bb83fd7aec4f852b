/* Any text as a scene, and what is behind a zero byte as a patch of it: what it says is understood
 * within the limits of docs/reference/scene-format.md, or refused with a word and a line. No file
 * is read. */
#include "tests/fuzz/fuzz.h"

#include <math.h>
#include <string.h>

#include "render/import/scene/scene_parse.h"
#include "render/render.h"

static json_t *document(const char *text, size_t size)
{
    return json_loadb(text, size, JSON_REJECT_DUPLICATES, NULL);
}

static void check_counts(const lf_scene_desc *desc)
{
    lf_fuzz_require(desc->n_meshes >= 0 && desc->n_meshes <= LF_MAX_MESHES + LF_MAX_LIGHTS);
    lf_fuzz_require(desc->n_materials >= 0 &&
                    desc->n_materials <= LF_MAX_MATERIALS + LF_MAX_LIGHTS);
    lf_fuzz_require(desc->n_lights >= 0 && desc->n_lights <= LF_MAX_LIGHTS);
    lf_fuzz_require(desc->camera.n_views >= 1 && desc->camera.n_views <= LF_MAX_VIEWS);
    for (int i = 0; i < desc->n_meshes; i++) {
        const lf_mesh_desc *mesh = &desc->meshes[i];
        lf_fuzz_require(!mesh->shape != !mesh->file);
        lf_fuzz_require(mesh->material >= -1 && mesh->material < desc->n_materials);
    }
    for (int i = 0; i < desc->n_volumes; i++)
        lf_fuzz_require(isfinite(desc->volumes[i].scale) && desc->volumes[i].scale >= 0);
}

/* text: what doc was parsed from, NULL: of a patched one. */
static void understand(json_t *doc, const char *text, size_t size)
{
    lf_error err = {0};
    lf_reader reader = {"fuzz", text, size, LF_OK, &err, NULL, 0, false};
    lf_scene_desc desc = {0};
    const lf_node root = {NULL, NULL, 0, doc};
    lf_scene_parse(&reader, &root, &desc);
    if (reader.status == LF_OK) {
        check_counts(&desc);
    } else {
        lf_fuzz_require(err.what[0] != 0 && err.status == reader.status);
        lf_fuzz_require_text(err.what);
        lf_fuzz_require_text(err.pointer);
        lf_fuzz_require(!text || (err.line >= 1 && (size_t)err.line <= size + 1));
    }
    lf_scene_desc_finish(&desc);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const char *text = (const char *)data;
    const char *end = size > 0 ? memchr(text, 0, size) : NULL;
    size_t n = end ? (size_t)(end - text) : size;
    json_t *doc = document(text, n), *patch = end ? document(end + 1, size - n - 1) : NULL;
    if (doc)
        understand(doc, text, n);
    json_t *patched = doc && patch ? lf_json_merge_patch(doc, patch) : NULL;
    if (patched)
        understand(patched, NULL, 0);
    json_decref(patched);
    json_decref(patch);
    json_decref(doc);
    return 0;
}
