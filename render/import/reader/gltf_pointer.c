/* KHR_animation_pointer: channels whose targets are JSON pointers (RFC 6901) of the glTF 2.0 Asset
 * Object Model. What one comes to replaces what the document says there, so that whoever reads the
 * document sees a still file. docs/reference/formats/gltf-pointers.md lists all of them. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/sandbox/reader.h"
#include "render/import/reader/gltf_animation.h"
#include "render/import/reader/gltf_primitive.h"
#include "render/import/reader/gltf_sampler.h"

/* Bytes of a pointer that names anything, and of one of its names. */
#define MOST_POINTER 256
#define MOST_NAME 64

typedef enum kind {
    NUMBERS,  /* one, or a vector */
    TURN,     /* a unit quaternion */
    SWITCH,   /* true or false */
    WEIGHTS,  /* of all morph targets */
    WEIGHT,   /* of one */
    NO_MATTER /* nothing of a picture */
} kind;

typedef struct property {
    const char *pointer; /* {}: a number */
    kind kind;
    unsigned components;
} property;

#define LIGHT "/extensions/KHR_lights_punctual/lights/{}/"
#define EXTENSION(name) "/materials/{}/extensions/KHR_materials_" name "/"

static const property properties[] = {
    {"/cameras/{}/orthographic/zfar", NO_MATTER, 1},
    {"/cameras/{}/orthographic/znear", NO_MATTER, 1},
    {"/cameras/{}/perspective/yfov", NUMBERS, 1},
    {"/cameras/{}/perspective/zfar", NO_MATTER, 1},
    {"/cameras/{}/perspective/znear", NO_MATTER, 1},
    {"/materials/{}/alphaCutoff", NUMBERS, 1},
    {"/materials/{}/emissiveFactor", NUMBERS, 3},
    {"/materials/{}/normalTexture/scale", NUMBERS, 1},
    {"/materials/{}/pbrMetallicRoughness/baseColorFactor", NUMBERS, 4},
    {"/materials/{}/pbrMetallicRoughness/metallicFactor", NUMBERS, 1},
    {"/materials/{}/pbrMetallicRoughness/roughnessFactor", NUMBERS, 1},
    {"/meshes/{}/weights", WEIGHTS, 1},
    {"/meshes/{}/weights/{}", WEIGHT, 1},
    {"/nodes/{}/translation", NUMBERS, 3},
    {"/nodes/{}/rotation", TURN, 4},
    {"/nodes/{}/scale", NUMBERS, 3},
    {"/nodes/{}/weights", WEIGHTS, 1},
    {"/nodes/{}/weights/{}", WEIGHT, 1},
    {"/nodes/{}/extensions/KHR_node_hoverability/hoverable", NO_MATTER, 1},
    {"/nodes/{}/extensions/KHR_node_selectability/selectable", NO_MATTER, 1},
    {"/nodes/{}/extensions/KHR_node_visibility/visible", SWITCH, 1},
    {LIGHT "color", NUMBERS, 3},
    {LIGHT "intensity", NUMBERS, 1},
    {LIGHT "range", NO_MATTER, 1},
    {LIGHT "spot/innerConeAngle", NUMBERS, 1},
    {LIGHT "spot/outerConeAngle", NUMBERS, 1},
    {EXTENSION("anisotropy") "anisotropyStrength", NUMBERS, 1},
    {EXTENSION("anisotropy") "anisotropyRotation", NUMBERS, 1},
    {EXTENSION("clearcoat") "clearcoatFactor", NUMBERS, 1},
    {EXTENSION("clearcoat") "clearcoatRoughnessFactor", NUMBERS, 1},
    {EXTENSION("clearcoat") "clearcoatNormalTexture/scale", NUMBERS, 1},
    {EXTENSION("emissive_strength") "emissiveStrength", NUMBERS, 1},
    {EXTENSION("ior") "ior", NUMBERS, 1},
    {EXTENSION("sheen") "sheenColorFactor", NUMBERS, 3},
    {EXTENSION("sheen") "sheenRoughnessFactor", NUMBERS, 1},
    {EXTENSION("specular") "specularFactor", NUMBERS, 1},
    {EXTENSION("specular") "specularColorFactor", NUMBERS, 3},
    {EXTENSION("transmission") "transmissionFactor", NUMBERS, 1},
    {EXTENSION("volume") "thicknessFactor", NUMBERS, 1},
    {EXTENSION("volume") "attenuationDistance", NUMBERS, 1},
    {EXTENSION("volume") "attenuationColor", NUMBERS, 3},
};

/* Textures that are read, and what may follow them. */
static const char *const textures[] = {
    "/materials/{}/emissiveTexture",
    "/materials/{}/normalTexture",
    "/materials/{}/pbrMetallicRoughness/baseColorTexture",
    "/materials/{}/pbrMetallicRoughness/metallicRoughnessTexture",
    EXTENSION("anisotropy") "anisotropyTexture",
    EXTENSION("clearcoat") "clearcoatTexture",
    EXTENSION("clearcoat") "clearcoatRoughnessTexture",
    EXTENSION("clearcoat") "clearcoatNormalTexture",
    EXTENSION("sheen") "sheenColorTexture",
    EXTENSION("sheen") "sheenRoughnessTexture",
    EXTENSION("specular") "specularTexture",
    EXTENSION("specular") "specularColorTexture",
    EXTENSION("transmission") "transmissionTexture",
};
#define TRANSFORM "/extensions/KHR_texture_transform/"
static const property transforms[] = {{TRANSFORM "offset", NUMBERS, 2},
                                      {TRANSFORM "rotation", NUMBERS, 1},
                                      {TRANSFORM "scale", NUMBERS, 2}};

static bool matches(const char *pattern, const char *pointer)
{
    while (*pattern) {
        size_t digits = strspn(pointer, "0123456789");
        if (strncmp(pattern, "{}", 2) != 0) {
            if (*pattern++ != *pointer++)
                return false;
            continue;
        }
        if (digits == 0 || (digits > 1 && *pointer == '0'))
            return false;
        pattern += 2;
        pointer += digits;
    }
    return !*pointer;
}

static const property *find_transform(const char *pointer)
{
    const char *rest = strstr(pointer, TRANSFORM);
    char texture[MOST_POINTER] = "";
    const property *found = NULL;
    bool known = false;
    if (!rest || (size_t)(rest - pointer) >= sizeof texture)
        return NULL;
    memcpy(texture, pointer, (size_t)(rest - pointer));
    for (size_t i = 0; i < sizeof textures / sizeof *textures; i++)
        known = known || matches(textures[i], texture);
    for (size_t i = 0; i < sizeof transforms / sizeof *transforms && known; i++)
        found = matches(transforms[i].pointer, rest) ? &transforms[i] : found;
    return found;
}

/* NULL: nobody reads it. */
static const property *find_property(const char *pointer)
{
    if (strlen(pointer) >= MOST_POINTER)
        return NULL;
    for (size_t i = 0; i < sizeof properties / sizeof *properties; i++)
        if (matches(properties[i].pointer, pointer))
            return &properties[i];
    return find_transform(pointer);
}

/* --------------------------------------------------------------------------- in the document -- */

static json_t *member(json_t *of, const char *name, size_t n)
{
    char copy[MOST_NAME] = "";
    uint64_t index;
    if (json_is_array(of))
        return lf_whole_read(name, &index) == name + n ? json_array_get(of, (size_t)index) : NULL;
    if (n >= sizeof copy)
        return NULL;
    memcpy(copy, name, n);
    return json_object_get(of, copy);
}

/* What has the last name of a pointer as a member. NULL: it is not there. */
static json_t *find_owner(json_t *at, const char *pointer, const char **out_key)
{
    const char *end;
    for (pointer++; (end = strchr(pointer, '/')); pointer = end + 1)
        at = member(at, pointer, (size_t)(end - pointer));
    *out_key = pointer;
    return at;
}

static json_t *mesh_of(lf_gltf *gltf, json_t *owner)
{
    if (json_object_get(owner, "primitives"))
        return owner;
    return json_array_get(json_object_get(gltf->json, "meshes"), lf_gltf_index(owner, "mesh"));
}

static size_t count_targets(json_t *mesh)
{
    json_t *primitives = json_object_get(mesh, "primitives");
    return json_array_size(json_object_get(json_array_get(primitives, 0), "targets"));
}

static lf_status no_memory(lf_error *err)
{
    return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
}

/* --------------------------------------------------------------------------------- its value -- */

/* What a property comes to: where its keys are, and in whose place. */
typedef struct place {
    lf_gltf *gltf;
    const property *property;
    lf_gltf_sampler sampler;
    lf_gltf_moment moment;
    json_t *owner;
    const char *key;
    size_t index; /* of a weight */
} place;

/* Vector number i of a key; as many components as the property has. */
static lf_status value_of(const place *p, size_t i, float out[4], lf_error *err)
{
    lf_gltf_sampler_value(&p->sampler, &p->moment, i, out);
    for (unsigned c = 0; c < p->property->components; c++)
        if (!isfinite(out[c]))
            return lf_error_set(err, LF_E_FORMAT, LF_HERE, "a value is not finite");
    return LF_OK;
}

/* value is the document's, or NULL where there was no memory. */
static lf_status put(const place *p, json_t *value, lf_error *err)
{
    return json_object_set_new(p->owner, p->key, value) == 0 ? LF_OK : no_memory(err);
}

static lf_status put_numbers(const place *p, lf_error *err)
{
    float v[4];
    lf_status status = value_of(p, 0, v, err);
    if (status != LF_OK)
        return status;
    if (p->property->components == 1)
        return put(p, json_real((double)v[0]), err);
    json_t *array = json_array();
    for (unsigned c = 0; c < p->property->components; c++)
        if (json_array_append_new(array, json_real((double)v[c])) != 0) {
            json_decref(array);
            return no_memory(err);
        }
    if (strncmp(p->property->pointer, "/nodes/", 7) == 0) /* it would count in place of them */
        json_object_del(p->owner, "matrix");
    return put(p, array, err);
}

static lf_status put_switch(const place *p, lf_error *err)
{
    float v[4];
    if (p->sampler.values.type != LF_GLTF_UINT8 || p->sampler.course != LF_GLTF_STEP)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "true and false must be unsigned bytes, and STEP");
    lf_status status = value_of(p, 0, v, err);
    return status == LF_OK ? put(p, json_boolean(v[0] != 0), err) : status;
}

static lf_status put_weights(const place *p, lf_error *err)
{
    const size_t n = p->sampler.each, n_targets = count_targets(mesh_of(p->gltf, p->owner));
    lf_status status = LF_OK;
    float v[4];
    if (n != n_targets)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "%zu weights for %zu morph targets", n,
                            n_targets);
    json_t *array = json_array();
    for (size_t i = 0; i < n && status == LF_OK; i++) {
        status = value_of(p, i, v, err);
        if (status == LF_OK && json_array_append_new(array, json_real((double)v[0])) != 0)
            status = no_memory(err);
    }
    if (status == LF_OK)
        return put(p, array, err);
    json_decref(array);
    return status;
}

/* The weights of a mesh, or of a node: those of its mesh where it says none; as many as there are
 * morph targets at least. Borrowed; NULL: no memory. */
static json_t *weights_of(const place *p)
{
    json_t *mesh = mesh_of(p->gltf, p->owner), *weights = json_object_get(p->owner, "weights"),
           *other = json_object_get(mesh, "weights");
    if (!json_is_array(weights)) {
        weights = json_is_array(other) ? json_copy(other) : json_array();
        if (json_object_set_new(p->owner, "weights", weights) != 0)
            return NULL;
    }
    while (json_array_size(weights) < count_targets(mesh) &&
           json_array_size(weights) < LF_GLTF_MOST_TARGETS)
        if (json_array_append_new(weights, json_real(0)) != 0)
            return NULL;
    return weights;
}

static lf_status put_weight(const place *p, lf_error *err)
{
    json_t *weights = weights_of(p);
    float v[4];
    if (!weights)
        return no_memory(err);
    if (p->index >= json_array_size(weights))
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "the file has no such morph target");
    lf_status status = value_of(p, 0, v, err);
    if (status != LF_OK)
        return status;
    return json_array_set_new(weights, p->index, json_real((double)v[0])) == 0 ? LF_OK
                                                                               : no_memory(err);
}

static lf_status put_value(const place *p, lf_error *err)
{
    const lf_gltf_sampler *s = &p->sampler;
    const size_t each = p->property->kind == WEIGHTS ? s->each : 1,
                 n = each * s->times.count * (s->course == LF_GLTF_CUBIC ? 3 : 1);
    if (s->values.count != n)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "%zu values for %zu moments",
                            s->values.count, s->times.count);
    switch (p->property->kind) {
    case WEIGHTS:
        return put_weights(p, err);
    case WEIGHT:
        return put_weight(p, err);
    case SWITCH:
        return put_switch(p, err);
    default:
        return put_numbers(p, err);
    }
}

/* ---------------------------------------------------------------------------------- channels -- */

typedef struct following {
    lf_gltf *gltf;
    const lf_gltf_playing *playing;
    json_t *seen; /* the names of what channels move */
    size_t n_left, n_odd;
    char first[MOST_POINTER], why[160]; /* of the first that is left out … */
    char odd[MOST_NAME];                /* … and the first odd interpolation */
} following;

static void leave_out(following *f, const char *name, const char *why)
{
    if (f->n_left++ > 0)
        return;
    lf_gltf_line(name, f->first, sizeof f->first);
    lf_gltf_line(why, f->why, sizeof f->why);
}

/* Writes what one pointer's channel comes to. LF_E_NOMEM; others: it is left out. */
static lf_status follow(following *f, const json_t *channel, const char *pointer, lf_error *err)
{
    const json_t *sampled = lf_gltf_element(f->playing->animation, "samplers",
                                            lf_gltf_whole(channel, "sampler", LF_GLTF_NONE));
    place p = {.gltf = f->gltf, .property = find_property(pointer)};
    char copy[MOST_POINTER];
    if (!p.property)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "quiltd does not read this property");
    if (p.property->kind == NO_MATTER)
        return LF_OK;
    memcpy(copy, pointer, strlen(pointer) + 1);
    if (p.property->kind == WEIGHT) {
        char *last = strrchr(copy, '/');
        uint64_t index = UINT64_MAX;
        (void)lf_whole_is(last + 1, &index);
        p.index = (size_t)index;
        *last = '\0';
    }
    p.owner = find_owner(f->gltf->json, copy, &p.key);
    if (!json_is_object(p.owner))
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "the file has nothing of that name");
    lf_status status =
        lf_gltf_sampler_open(f->gltf, sampled, p.property->components, &p.sampler, err);
    if (status != LF_OK)
        return status;
    p.sampler.turns = p.property->kind == TURN;
    p.moment = lf_gltf_sampler_moment(&p.sampler, f->playing->time);
    return put_value(&p, err);
}

/* Why lf_gltf_animate has no use of a channel; NULL: it has. */
static const char *problem_of(const following *f, const json_t *target)
{
    static const char *const paths[] = {"translation", "rotation", "scale", "weights"};
    const uint64_t number = lf_gltf_whole(target, "node", LF_GLTF_NONE);
    const json_t *node = lf_gltf_element(f->gltf->json, "nodes", number);
    int known = 0;
    while (known < 4 && strcmp(lf_gltf_text(target, "path"), paths[known]) != 0)
        known++;
    if (known == 4)
        return "quiltd does not read this property";
    if (!node)
        return json_object_get(target, "node") ? "the file has no such node" : "it names no node";
    return known == 3 && !json_object_get(node, "mesh") ? "the node has no mesh" : NULL;
}

static void name_target(const json_t *target, char *out, size_t size)
{
    const uint64_t number = lf_gltf_whole(target, "node", LF_GLTF_NONE);
    char path[64];
    lf_gltf_line(lf_gltf_text(target, "path"), path, sizeof path);
    if (number < LF_GLTF_NONE)
        snprintf(out, size, "/nodes/%llu/%s", (unsigned long long)number, path);
    else
        snprintf(out, size, "a channel of path \"%s\"", path);
}

/* Notes a name; *out_again: another channel had it. */
static lf_status note(following *f, const char *name, bool *out_again, lf_error *err)
{
    *out_again = json_object_get(f->seen, name);
    return json_object_set_new(f->seen, name, json_true()) == 0 ? LF_OK : no_memory(err);
}

static void look_at_sampler(following *f, const json_t *channel)
{
    const json_t *sampled = lf_gltf_element(f->playing->animation, "samplers",
                                            lf_gltf_whole(channel, "sampler", LF_GLTF_NONE));
    const char *source = lf_gltf_text(sampled, "interpolation");
    if (!*source || strcmp(source, "LINEAR") == 0 || strcmp(source, "STEP") == 0 ||
        strcmp(source, "CUBICSPLINE") == 0)
        return;
    if (f->n_odd++ == 0)
        lf_gltf_line(source, f->odd, sizeof f->odd);
}

static lf_status look_at(following *f, const json_t *channel, lf_error *err)
{
    json_t *target = json_object_get(channel, "target");
    const json_t *extension = lf_gltf_extension(target, "KHR_animation_pointer");
    const bool points = strcmp(lf_gltf_text(target, "path"), "pointer") == 0;
    const char *pointer = lf_gltf_text(extension, "pointer"), *name = pointer;
    char made[128];
    lf_error wrong = {0};
    bool again = false;
    if (!points || !*pointer) {
        name_target(target, made, sizeof made);
        name = made;
    }
    lf_status status = note(f, name, &again, err);
    if (status != LF_OK)
        return status;
    look_at_sampler(f, channel);
    const char *problem = !points             ? problem_of(f, target)
                          : pointer[0] != '/' ? "it has no pointer"
                                              : NULL;
    if (!problem && again) {
        problem = "another channel moves the same";
        if (!points && json_object_set_new(target, "path", json_string("")) != 0)
            return no_memory(err); /* lf_gltf_animate passes it by */
    }
    if (!problem && points && follow(f, channel, pointer, &wrong) != LF_OK)
        problem = wrong.what;
    if (wrong.status == LF_E_NOMEM)
        return no_memory(err);
    if (problem)
        leave_out(f, name, problem);
    return LF_OK;
}

static void warn(const following *f, lf_warnings *warnings)
{
    if (f->n_left == 1)
        lf_warnings_add(warnings, LF_HERE, "1 animation channel is left out, %s: %s", f->first,
                        f->why);
    else if (f->n_left > 1)
        lf_warnings_add(warnings, LF_HERE,
                        "%zu animation channels are left out, the first is %s: %s", f->n_left,
                        f->first, f->why);
    if (f->n_odd > 0)
        lf_warnings_add(warnings, LF_HERE,
                        "%zu animation channels have interpolations that are not known here, the "
                        "first is \"%s\": taken as LINEAR",
                        f->n_odd, f->odd);
}

lf_status lf_gltf_follow_pointers(lf_gltf *gltf, const lf_gltf_playing *playing,
                                  lf_warnings *warnings, lf_error *err)
{
    const json_t *channels = json_object_get(playing->animation, "channels");
    following f = {.gltf = gltf, .playing = playing, .seen = json_object()};
    lf_status status = LF_OK;
    for (size_t i = 0; i < json_array_size(channels) && status == LF_OK; i++)
        status = look_at(&f, json_array_get(channels, i), err);
    if (status == LF_OK)
        warn(&f, warnings);
    json_decref(f.seen);
    return status;
}
