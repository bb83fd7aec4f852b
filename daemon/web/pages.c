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
    PAGE("/", HTML, index_html),      PAGE("/style.css", CSS, style_css),
    PAGE("/main.js", JS, main_js),    PAGE("/rpc.js", JS, rpc_js),
    PAGE("/view.js", JS, view_js),    PAGE("/camera.js", JS, camera_js),
    PAGE("/icon.svg", SVG, icon_svg),
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
