/* What docs/scene.schema.json says of kinds of things is what their own lists of keys say: names,
 * types, ranges, defaults. */
#include "tests/testing.h"

#include <ctype.h>

#include "render/import/scene/member_read.h"
#include "render/import/scene/mesh_shape.h"
#include "render/render.h"
#include "render/transport/light/light_kind.h"

static json_t *schema;

static bool is_keyed(const json_t *node)
{
    const char *ref = json_string_value(json_object_get(node, "$ref"));
    return ref && strcmp(ref, "#/$defs/keyed") == 0;
}

/* What a node refers to, and of a value or its keys the value. */
static const json_t *resolve(const json_t *node)
{
    const json_t *ref = json_object_get(node, "$ref"), *any = json_object_get(node, "anyOf");
    if (ref)
        return resolve(json_object_get(json_object_get(schema, "$defs"),
                                       json_string_value(ref) + strlen("#/$defs/")));
    return json_array_size(any) == 2 && is_keyed(json_array_get(any, 1)) ? json_array_get(any, 0)
                                                                         : node;
}

/* Whether a value may have keys. */
static bool may_have_keys(const json_t *node)
{
    const json_t *ref = json_object_get(node, "$ref"), *any = json_object_get(node, "anyOf");
    if (ref)
        return may_have_keys(json_object_get(json_object_get(schema, "$defs"),
                                             json_string_value(ref) + strlen("#/$defs/")));
    return is_keyed(json_array_get(any, json_array_size(any) - 1));
}

/* Of what a property says itself or what it refers to. */
static const json_t *member(const json_t *property, const char *name)
{
    const json_t *own = json_object_get(property, name), *ref = json_object_get(property, "$ref"),
                 *whole = ref ? json_object_get(json_object_get(schema, "$defs"),
                                                json_string_value(ref) + strlen("#/$defs/"))
                              : NULL;
    if (!own)
        own = json_object_get(resolve(property), name);
    return own ? own : json_object_get(whole, name);
}

static bool has_range(const json_t *node, double lo, double hi)
{
    const json_t *own = resolve(node);
    return json_number_value(json_object_get(own, "minimum")) == lo &&
           json_number_value(json_object_get(own, "maximum")) == hi &&
           json_object_get(own, "minimum") && json_object_get(own, "maximum");
}

static bool has_words(const json_t *list, const char *const words[])
{
    size_t n = 0;
    while (words[n] && n < json_array_size(list) &&
           strcmp(words[n], json_string_value(json_array_get(list, n))) == 0)
        n++;
    return !words[n] && n == json_array_size(list);
}

/* One number, or three, or keys. */
static bool is_colour(const json_t *property, const lf_param *key)
{
    const json_t *any = member(property, "anyOf"), *three = json_array_get(any, 1);
    return json_array_size(any) == 3 && has_range(json_array_get(any, 0), key->low, key->high) &&
           has_range(json_object_get(three, "items"), key->low, key->high) &&
           json_integer_value(json_object_get(three, "minItems")) == 3 &&
           json_integer_value(json_object_get(three, "maxItems")) == 3;
}

static bool agrees_in_type(const json_t *property, const lf_param *key)
{
    bool numbers = key->type == LF_PARAM_NUMBER || key->type == LF_PARAM_ANGLE ||
                   key->type == LF_PARAM_COLOUR || key->type == LF_PARAM_POINT ||
                   key->type == LF_PARAM_DIRECTION;
    if (may_have_keys(property) != numbers)
        return false;
    switch (key->type) {
    case LF_PARAM_NUMBER:
    case LF_PARAM_ANGLE:
        return strcmp(json_string_value(member(property, "type")), "number") == 0 &&
               has_range(property, key->low, key->high);
    case LF_PARAM_COLOUR:
        return is_colour(property, key);
    case LF_PARAM_POINT:
    case LF_PARAM_DIRECTION:
        return has_range(member(property, "items"), key->low, key->high) &&
               json_integer_value(member(property, "minItems")) == 3 &&
               json_integer_value(member(property, "maxItems")) == 3;
    case LF_PARAM_SWITCH:
        return !key->words && strcmp(json_string_value(member(property, "type")), "boolean") == 0;
    case LF_PARAM_WORD:
        return has_words(member(property, "enum"), key->words);
    case LF_PARAM_FILE:
        for (int i = 0; key->word_at(i); i++) {
            char letters[64] = "";
            for (const char *c = key->word_at(i); *c; c++)
                snprintf(letters + strlen(letters), sizeof letters - strlen(letters), "[%c%c]", *c,
                         toupper(*c));
            if (!strstr(json_string_value(member(property, "pattern")), letters))
                return false;
        }
        return true;
    default:
        return false;
    }
}

static bool agrees_in_default(const json_t *property, const lf_param *key)
{
    const json_t *value = member(property, "default");
    if (key->type == LF_PARAM_NUMBER || key->type == LF_PARAM_ANGLE)
        return json_is_number(value) && json_number_value(value) == key->initial;
    if (key->type == LF_PARAM_WORD)
        return !value || strcmp(json_string_value(value), key->words[(size_t)key->initial]) == 0;
    if (key->type == LF_PARAM_SWITCH)
        return json_is_boolean(value) && json_is_true(value) == (key->initial != 0.0);
    if (key->type == LF_PARAM_COLOUR && json_is_number(value))
        return json_number_value(value) == key->point[0];
    for (int i = 0; i < 3; i++)
        if (json_number_value(json_array_get(value, (size_t)i)) != key->point[i])
            return false;
    return json_array_size(value) == 3;
}

static bool is_required(const json_t *variant, const char *name)
{
    size_t i;
    json_t *word;
    json_array_foreach(json_object_get(variant, "required"), i, word)
    {
        if (strcmp(json_string_value(word), name) == 0)
            return true;
    }
    return false;
}

/* One form of a kind, and what the schema says of it. */
static void compare(const char *kind, const lf_param keys[], int form, const json_t *variant)
{
    const json_t *properties = json_object_get(variant, "properties");
    size_t n = 1; /* "type" */
    bool first = form > 0;
    for (int i = 0; keys[i].name; i++) {
        const json_t *property = json_object_get(properties, keys[i].name);
        if (keys[i].form > 0 && keys[i].form != form)
            continue;
        n++;
        if (!property)
            fail_msg("%s: the schema has no \"%s\"", kind, keys[i].name);
        if (!agrees_in_type(property, &keys[i]))
            fail_msg("%s: the schema says another type or range of \"%s\"", kind, keys[i].name);
        bool needed = first && keys[i].form == form;
        first = first && !needed;
        if (is_required(variant, keys[i].name) != needed)
            fail_msg("%s: the schema says wrongly whether \"%s\" must be there", kind,
                     keys[i].name);
        if (!needed && !agrees_in_default(property, &keys[i]))
            fail_msg("%s: the schema says another default of \"%s\"", kind, keys[i].name);
    }
    if (json_object_size(properties) != n)
        fail_msg("%s: the schema has %zu keys, the kind %zu", kind, json_object_size(properties),
                 n);
}

/* The schema's n-th variant of a type; NULL: it has fewer. */
static const json_t *variant_of(const char *thing, const char *kind, int n)
{
    const json_t *all =
        json_object_get(json_object_get(json_object_get(schema, "$defs"), thing), "anyOf");
    size_t i;
    json_t *variant;
    json_array_foreach(all, i, variant)
    {
        const json_t *type = json_object_get(json_object_get(variant, "properties"), "type");
        if (strcmp(json_string_value(json_object_get(type, "const")), kind) == 0 && n-- == 0)
            return variant;
    }
    return NULL;
}

static bool has_forms(const lf_param keys[])
{
    bool found = false;
    for (int i = 0; keys[i].name; i++)
        found = found || keys[i].form > 0;
    return found;
}

static void the_schema_says_of_lights_what_their_kinds_say(void **state)
{
    (void)state;
    int n_variants = 0;
    for (int i = 0; lf_light_kinds[i]; i++) {
        const lf_light_kind *kind = lf_light_kinds[i];
        if (!kind->keys)
            continue;
        int n = has_forms(kind->keys) ? 2 : 1;
        for (int form = 0; form < n; form++) {
            const json_t *variant = variant_of("light", kind->name, form);
            if (!variant)
                fail_msg("the schema knows no light of type %s", kind->name);
            compare(kind->name, kind->keys, n == 2 ? form + 1 : 0, variant);
        }
        n_variants += n;
    }
    assert_int_equal(n_variants,
                     json_array_size(json_object_get(
                         json_object_get(json_object_get(schema, "$defs"), "light"), "anyOf")));
}

static const json_t *materials(void)
{
    return json_object_get(json_object_get(json_object_get(schema, "$defs"), "material"), "anyOf");
}

static size_t n_materials(void)
{
    return json_array_size(materials());
}

/* Whether a variant of the schema's materials is for this kind. */
static bool is_for(const json_t *variant, const char *kind)
{
    const json_t *type = json_object_get(json_object_get(variant, "properties"), "type");
    const json_t *only = json_object_get(type, "const");
    size_t i;
    json_t *word;
    json_array_foreach(json_object_get(type, "enum"), i, word)
    {
        if (strcmp(json_string_value(word), kind) == 0)
            return true;
    }
    return only && strcmp(json_string_value(only), kind) == 0;
}

/* What a property is where no picture stands in its place. */
static const json_t *without_picture(const json_t *property)
{
    const json_t *any = json_object_get(property, "anyOf");
    const char *second = json_string_value(json_object_get(json_array_get(any, 1), "$ref"));
    return second && strcmp(second, "#/$defs/picture") == 0 ? json_array_get(any, 0) : property;
}

/* The schema has a key of other kinds too where its absence would be an error after a patch of the
 * type alone. */
static void the_schema_says_of_surfaces_what_their_kinds_say(void **state)
{
    (void)state;
    for (int i = 0; lf_surface_kinds[i]; i++)
        for (const lf_param *const *at = lf_surface_kinds[i]->keys; *at; at++) {
            const lf_param *key = *at;
            const char *kind = lf_surface_kinds[i]->name;
            int n = 0;
            for (size_t j = 0; j < n_materials(); j++) {
                const json_t *variant = json_array_get(materials(), j),
                             *property =
                                 json_object_get(json_object_get(variant, "properties"), key->name);
                if (!property || !is_for(variant, kind))
                    continue;
                n++;
                if (!agrees_in_type(without_picture(property), key))
                    fail_msg("%s: the schema says another type or range of \"%s\"", kind,
                             key->name);
                if (!key->exclusive && !agrees_in_default(property, key))
                    fail_msg("%s: the schema says another default of \"%s\"", kind, key->name);
            }
            if (n == 0)
                fail_msg("%s: the schema has no \"%s\"", kind, key->name);
        }
}

static bool some_kind_has(const char *name)
{
    static const char *const all_have[] = {"type", "emission", "alpha", "alpha_cutoff", "normal"};
    bool found = false;
    for (size_t i = 0; i < sizeof all_have / sizeof *all_have; i++)
        found = found || strcmp(name, all_have[i]) == 0;
    for (int i = 0; lf_surface_kinds[i]; i++)
        for (const lf_param *const *key = lf_surface_kinds[i]->keys; *key; key++)
            found = found || strcmp((*key)->name, name) == 0;
    return found;
}

static void the_schema_has_no_key_of_surfaces_that_no_kind_has(void **state)
{
    (void)state;
    const char *name;
    json_t *property;
    for (size_t i = 0; i < n_materials(); i++)
        json_object_foreach(json_object_get(json_array_get(materials(), i), "properties"), name,
                            property)
        {
            if (!some_kind_has(name))
                fail_msg("the schema has \"%s\" of materials, which nothing reads", name);
        }
}

static void the_schema_has_the_shapes_of_volumes_that_there_are(void **state)
{
    (void)state;
    const json_t *variants =
        json_object_get(json_object_get(json_object_get(schema, "$defs"), "volume"), "anyOf");
    const json_t *shape =
        json_object_get(json_object_get(json_array_get(variants, 1), "properties"), "shape");
    assert_true(has_words(json_object_get(shape, "enum"), lf_volume_shapes));
    assert_false(has_words(json_object_get(shape, "enum"), lf_volume_shapes + 1));
}

static void the_schema_has_the_shapes_of_meshes_that_there_are(void **state)
{
    (void)state;
    const char *names[LF_MAX_KINDS + 1] = {NULL};
    int n = 0;
    for (; lf_mesh_shapes[n]; n++) {
        assert_true(n < LF_MAX_KINDS && lf_mesh_shapes[n]->corner);
        names[n] = lf_mesh_shapes[n]->name;
    }
    const json_t *mesh = json_object_get(json_object_get(schema, "$defs"), "mesh"),
                 *shape = json_object_get(json_object_get(mesh, "properties"), "shape");
    assert_true(has_words(json_object_get(shape, "enum"), names));
    names[n - 1] = NULL;
    assert_false(has_words(json_object_get(shape, "enum"), names));
}

/* Committed scenes count on the order. */
static void lights_at_infinity_stand_first_in_the_table_and_faces_last(void **state)
{
    (void)state;
    int n = 0, n_infinite = 0;
    while (lf_light_kinds[n])
        n++;
    assert_true(n > 0 && n <= LF_MAX_KINDS);
    while (n_infinite < n && lf_light_kinds[n_infinite]->escape)
        n_infinite++;
    for (int i = 0; i < n; i++) {
        const lf_light_kind *kind = lf_light_kinds[i];
        int n_keys = 0;
        while (kind->keys && kind->keys[n_keys].name)
            n_keys++;
        assert_true(n_keys <= LF_MAX_KEYS);
        if (kind->shape) { /* a mesh light once the scene is parsed */
            assert_true(kind->make && n_keys > 0 && !kind->read && !kind->draw && i >= n_infinite);
            continue;
        }
        assert_true(kind->draw && kind->power && !kind->escape == (i >= n_infinite) &&
                    !kind->extent == (i < n_infinite));
        assert_true(!kind->hit_pdf == (i < n - 1) && !kind->keys == !kind->read);
    }
}

/* Of the surface that has most: none is cut off. */
static void an_unknown_key_is_told_all_that_there_are(void **state)
{
    (void)state;
    json_t *doc =
        json_pack("{s:{s:{s:s,s:i}}}", "materials", "m", "type", "principled", "zzzzzzzz", 1);
    lf_scene *scene = NULL;
    lf_error err = {0};
    assert_int_equal(lf_scene_from_json(doc, "/", "t", NULL, NULL, &scene, &err), LF_E_FORMAT);
    for (const lf_param *const *key = lf_surface_principled.keys; *key; key++)
        if (!strstr(err.what, (*key)->name))
            fail_msg("%s: %s", (*key)->name, err.what);
    assert_string_equal(err.what + strlen(err.what) - strlen(", normal"), ", normal");
    json_decref(doc);
}

/* Of a principled material that says nothing but this. */
static lf_principled said_alone(const lf_param *row, double value)
{
    json_t *doc =
        json_pack("{s:{s:{s:s,s:f}}}", "materials", "m", "type", "principled", row->name, value);
    lf_scene *scene = NULL;
    lf_error err = {0};
    lf_assert_ok(lf_scene_from_json(doc, "/", "t", NULL, NULL, &scene, &err), &err);
    lf_principled p = scene->materials[0].p;
    lf_scene_unref(scene);
    json_decref(doc);
    return p;
}

static void a_scene_says_every_scalar_and_no_other_with_it(void **state)
{
    (void)state;
    for (const lf_param *const *row = lf_principled_rows; *row; row++) {
        const bool turns = (*row)->type == LF_PARAM_ANGLE;
        const double value = turns ? 30 : (*row)->low + 0.125 * fmin((*row)->high - (*row)->low, 4);
        lf_principled want = lf_principled_usual(), p = said_alone(*row, value);
        int n;
        float *field = lf_principled_at(&want, *row, &n);
        for (int i = 0; i < n; i++)
            field[i] = turns ? (i == 0 ? sqrtf(0.75f) : 0.5f) : (float)value;
        for (size_t i = 0; i < LF_PRINCIPLED_FLOATS; i++)
            if (!(fabsf(((float *)&p)[i] - ((float *)&want)[i]) <= 1e-6f))
                fail_msg("%s: number %zu is %g", (*row)->name, i, (double)((float *)&p)[i]);
        assert_null(lf_principled_wrong(&p));
    }
}

static int load_schema(void **state)
{
    (void)state;
    schema = lf_scene_schema();
    return schema ? 0 : -1;
}

static int release_schema(void **state)
{
    (void)state;
    json_decref(schema);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_schema_says_of_lights_what_their_kinds_say),
        cmocka_unit_test(the_schema_says_of_surfaces_what_their_kinds_say),
        cmocka_unit_test(the_schema_has_no_key_of_surfaces_that_no_kind_has),
        cmocka_unit_test(the_schema_has_the_shapes_of_volumes_that_there_are),
        cmocka_unit_test(the_schema_has_the_shapes_of_meshes_that_there_are),
        cmocka_unit_test(an_unknown_key_is_told_all_that_there_are),
        cmocka_unit_test(a_scene_says_every_scalar_and_no_other_with_it),
        cmocka_unit_test(lights_at_infinity_stand_first_in_the_table_and_faces_last),
    };
    return cmocka_run_group_tests(tests, load_schema, release_schema);
}
