#include "daemon/output/made_with.h"

#include <stdio.h>
#include <string.h>

#include "daemon/output/output_internal.h"

/* In the order in which differences are told. */
static const char *const names[LF_MADE_WITH_KEYS] = {
    "quiltd.scene",   "quiltd.integrator", "quiltd.estimator",
    "quiltd.denoise", "quiltd.sampler",    "quiltd.budget",
    "quiltd.tonemap", "quiltd.exposure",   "quiltd.exposure_keys"};
enum { SCENE = 0, EXPOSURE = LF_MADE_WITH_KEYS - 2, EXPOSURE_KEYS };

void lf_made_with_read(const char *path, lf_made_with *out)
{
    *out = (lf_made_with){0};
    if (lf_png_texts(path, NULL, names, LF_MADE_WITH_KEYS, out->value, NULL) != LF_OK)
        *out = (lf_made_with){0};
}

static const char *without_folder(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

void lf_made_with_settings(const json_t *settings, lf_made_with *out)
{
    output_attributes attributes;
    *out = (lf_made_with){0};
    output_attributes_fill(&attributes, settings);
    for (int i = 0; i < attributes.n; i++)
        for (int k = 0; k < LF_MADE_WITH_KEYS; k++)
            if (strcmp(attributes.name[i], names[k]) == 0)
                snprintf(out->value[k], sizeof out->value[k], "%s", attributes.value[i]);
    /* whole, although attributes are cut */
    const char *scene = json_string_value(json_object_get(settings, "scene"));
    snprintf(out->value[SCENE], sizeof out->value[SCENE], "%s", scene ? without_folder(scene) : "");
}

/* "": not known, also if it may have been cut. */
static const char *told(const lf_made_with *of, int key)
{
    const char *value = of->value[key];
    if (strlen(value) == LF_PNG_TEXT - 1)
        return "";
    return key == SCENE ? without_folder(value) : value;
}

bool lf_made_with_differs(const lf_made_with *is, const lf_made_with *expected, char *words,
                          size_t size)
{
    const bool has_keys = is->value[EXPOSURE_KEYS][0] || expected->value[EXPOSURE_KEYS][0];
    const int n = has_keys ? EXPOSURE : EXPOSURE_KEYS;
    for (int k = 0; k < n; k++) {
        const char *a = told(is, k), *b = told(expected, k);
        if (a[0] == '\0' || b[0] == '\0' || strcmp(a, b) == 0)
            continue;
        snprintf(words, size, "%s %s, not %s", names[k] + strlen("quiltd."), a, b);
        return true;
    }
    return false;
}
