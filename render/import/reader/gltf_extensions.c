#include "render/import/reader/gltf_extensions.h"

#include <stdio.h>
#include <string.h>

#include "base/sandbox/reader.h"

enum { MOST = 64, DEEPEST = 64 };

/* Names of the elements of the document's arrays. */
static const struct {
    const char *array, *one, *many;
} things[] = {{"accessors", "accessor", "accessors"},
              {"animations", "animation", "animations"},
              {"buffers", "buffer", "buffers"},
              {"bufferViews", "buffer view", "buffer views"},
              {"cameras", "camera", "cameras"},
              {"images", "image", "images"},
              {"materials", "material", "materials"},
              {"meshes", "mesh", "meshes"},
              {"nodes", "node", "nodes"},
              {"samplers", "sampler", "samplers"},
              {"scenes", "scene", "scenes"},
              {"skins", "skin", "skins"},
              {"textures", "texture", "textures"}};
enum { THINGS = sizeof things / sizeof *things };

typedef struct unknown {
    const char *name; /* the document's */
    size_t n[THINGS]; /* elements that have it, directly or in a child */
    const json_t *last;
} unknown;

typedef struct search {
    size_t n;
    bool has_more; /* than are kept */
    unknown found[MOST];
} search;

/* NULL: it is known, or there are too many. */
static unknown *find(search *s, const char *name)
{
    if (lf_gltf_knows(name))
        return NULL;
    for (size_t i = 0; i < s->n; i++)
        if (strcmp(s->found[i].name, name) == 0)
            return &s->found[i];
    s->has_more = s->has_more || s->n == MOST;
    if (s->n == MOST)
        return NULL;
    s->found[s->n] = (unknown){.name = name};
    return &s->found[s->n++];
}

/* Searches an element at any depth; its extras are skipped. */
static void look(search *s, int thing, const json_t *element, json_t *json, int depth)
{
    const char *key;
    json_t *value;
    size_t i;
    if (depth > DEEPEST)
        return;
    json_array_foreach(json, i, value) look(s, thing, element, value, depth + 1);
    json_object_foreach(json_object_get(json, "extensions"), key, value)
    {
        unknown *u = find(s, key);
        if (u && u->last != element)
            u->n[thing]++;
        if (u)
            u->last = element;
    }
    json_object_foreach(json, key, value)
    {
        if (strcmp(key, "extras") != 0 && (json_is_object(value) || json_is_array(value)))
            look(s, thing, element, value, depth + 1);
    }
}

static void warn_of(const unknown *u, lf_warnings *warnings)
{
    char users[256] = "";
    size_t at = 0;
    for (int i = 0; i < THINGS && at < sizeof users; i++)
        if (u->n[i] > 0)
            at +=
                (size_t)snprintf(users + at, sizeof users - at, "%s%zu %s", at > 0 ? ", " : " of ",
                                 u->n[i], u->n[i] == 1 ? things[i].one : things[i].many);
    lf_warnings_add(warnings, LF_HERE, "the extension %.80s%s is not supported; it is left out",
                    u->name, users);
}

void lf_gltf_warn_of_extensions(const lf_gltf *gltf, lf_warnings *warnings)
{
    search s = {0};
    size_t i;
    json_t *value;
    const char *key;
    json_array_foreach(json_object_get(gltf->json, "extensionsUsed"), i, value)
    {
        if (json_is_string(value))
            (void)find(&s, json_string_value(value));
    }
    json_object_foreach(json_object_get(gltf->json, "extensions"), key, value)(void) find(&s, key);
    for (int thing = 0; thing < THINGS; thing++)
        json_array_foreach(json_object_get(gltf->json, things[thing].array), i, value)
            look(&s, thing, value, value, 0);
    for (size_t k = 0; k < s.n; k++)
        warn_of(&s.found[k], warnings);
    if (s.has_more)
        lf_warnings_add(warnings, LF_HERE,
                        "more than %d extensions are not supported; the others are left out, too",
                        MOST);
}
