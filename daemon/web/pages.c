#include "daemon/web/pages.h"

#include <string.h>

#include "gen/web_pages.h"

#define HTML "text/html; charset=utf-8"
#define CSS "text/css; charset=utf-8"
#define JS "text/javascript; charset=utf-8"
#define JSON "application/schema+json"
#define SVG "image/svg+xml"

#define PAGE(path, type, name)                                                                     \
    {                                                                                              \
        path, type, lf_web_##name, sizeof lf_web_##name                                            \
    }
static const lf_page pages[] = {
    PAGE("/", HTML, index_html),
    PAGE("/style.css", CSS, style_css),
    PAGE("/icon.svg", SVG, icon_svg),
    PAGE("/camera.js", JS, camera_js),
    PAGE("/colour.js", JS, colour_js),
    PAGE("/dom.js", JS, dom_js),
    PAGE("/export_form.js", JS, export_form_js),
    PAGE("/exports.js", JS, exports_js),
    PAGE("/fields.js", JS, fields_js),
    PAGE("/files.js", JS, files_js),
    PAGE("/gestures.js", JS, gestures_js),
    PAGE("/health.js", JS, health_js),
    PAGE("/held.js", JS, held_js),
    PAGE("/history.js", JS, history_js),
    PAGE("/latest.js", JS, latest_js),
    PAGE("/lens.js", JS, lens_js),
    PAGE("/library.js", JS, library_js),
    PAGE("/main.js", JS, main_js),
    PAGE("/numbers.js", JS, numbers_js),
    PAGE("/patch.js", JS, patch_js),
    PAGE("/patiently.js", JS, patiently_js),
    PAGE("/picture.js", JS, picture_js),
    PAGE("/proof.js", JS, proof_js),
    PAGE("/remaining.js", JS, remaining_js),
    PAGE("/render.js", JS, render_js),
    PAGE("/rig.js", JS, rig_js),
    PAGE("/rpc.js", JS, rpc_js),
    PAGE("/scene.js", JS, scene_js),
    PAGE("/scene_tab.js", JS, scene_tab_js),
    PAGE("/schema.js", JS, schema_js),
    PAGE("/scrub.js", JS, scrub_js),
    PAGE("/shaders.js", JS, shaders_js),
    PAGE("/slideshow.js", JS, slideshow_js),
    PAGE("/stage.js", JS, stage_js),
    PAGE("/stereo.js", JS, stereo_js),
    PAGE("/store.js", JS, store_js),
    PAGE("/tabs.js", JS, tabs_js),
    PAGE("/tree.js", JS, tree_js),
    PAGE("/upload.js", JS, upload_js),
    PAGE("/view.js", JS, view_js),
    PAGE("/words.js", JS, words_js),
};

/* What scenes may be, for editors and checkers. */
static const lf_page schema = PAGE("/scene.schema.json", JSON, scene_schema_json);

enum { N_PAGES = sizeof pages / sizeof pages[0] };

const lf_page *lf_page_find(const char *path)
{
    for (int i = 0; i < N_PAGES; i++)
        if (strcmp(pages[i].path, path) == 0)
            return &pages[i];
    return strcmp(schema.path, path) == 0 ? &schema : NULL;
}

const lf_page *lf_page_at(int index)
{
    return index < N_PAGES ? &pages[index] : NULL;
}
