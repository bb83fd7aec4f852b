/* The schema and the parser say the same, and both like what is shipped. The validator here knows
 * the keywords that docs/scene.schema.json uses, and fails on any other. */
#include "tests/testing.h"

#include <dirent.h>
#include <regex.h>

#include "render/render.h"
#include "render/scene/scene.h"
#include "tests/scene_file.h"

static bool valid(const json_t *root, const json_t *schema, json_t *value);

static bool has_type(const char *type, const json_t *value)
{
    if (strcmp(type, "integer") == 0)
        return json_is_number(value) && json_number_value(value) == floor(json_number_value(value));
    return (strcmp(type, "object") == 0 && json_is_object(value)) ||
           (strcmp(type, "array") == 0 && json_is_array(value)) ||
           (strcmp(type, "string") == 0 && json_is_string(value)) ||
           (strcmp(type, "boolean") == 0 && json_is_boolean(value)) ||
           (strcmp(type, "number") == 0 && json_is_number(value));
}

static size_t count_valid(const json_t *root, const json_t *schemas, json_t *value)
{
    size_t n = 0, i;
    json_t *schema;
    json_array_foreach(schemas, i, schema)
    {
        n += valid(root, schema, value);
    }
    return n;
}

/* properties, additionalProperties, propertyNames, required, maxProperties. */
static bool valid_object(const json_t *root, const json_t *schema, json_t *value)
{
    const json_t *properties = json_object_get(schema, "properties"),
                 *names = json_object_get(schema, "propertyNames");
    const json_t *others = json_object_get(schema, "additionalProperties"),
                 *max = json_object_get(schema, "maxProperties");
    const char *key;
    json_t *member, *required;
    size_t i;
    json_object_foreach(value, key, member)
    {
        const json_t *own = json_object_get(properties, key);
        json_t *name = json_string(key);
        bool good = (!names || valid(root, names, name)) &&
                    (own ? valid(root, own, member) : !others || valid(root, others, member));
        json_decref(name);
        if (!good)
            return false;
    }
    json_array_foreach(json_object_get(schema, "required"), i, required)
    {
        if (!json_object_get(value, json_string_value(required)))
            return false;
    }
    return !max || json_object_size(value) <= (size_t)json_integer_value(max);
}

static bool valid_array(const json_t *root, const json_t *schema, json_t *value)
{
    const json_t *min = json_object_get(schema, "minItems"),
                 *max = json_object_get(schema, "maxItems");
    const json_t *items = json_object_get(schema, "items"),
                 *first = json_object_get(schema, "prefixItems");
    size_t i;
    json_t *item;
    json_array_foreach(value, i, item)
    {
        const json_t *own = json_array_get(first, i) ? json_array_get(first, i) : items;
        if (own && !valid(root, own, item))
            return false;
    }
    return (!min || json_array_size(value) >= (size_t)json_integer_value(min)) &&
           (!max || json_array_size(value) <= (size_t)json_integer_value(max));
}

static bool valid_string(const json_t *schema, const json_t *value)
{
    const json_t *min = json_object_get(schema, "minLength"),
                 *max = json_object_get(schema, "maxLength");
    const json_t *pattern = json_object_get(schema, "pattern");
    size_t n = json_string_length(value);
    if ((min && n < (size_t)json_integer_value(min)) ||
        (max && n > (size_t)json_integer_value(max)))
        return false;
    if (!pattern)
        return true;
    regex_t expression;
    assert_int_equal(regcomp(&expression, json_string_value(pattern), REG_EXTENDED | REG_NOSUB), 0);
    bool good = regexec(&expression, json_string_value(value), 0, NULL, 0) == 0;
    regfree(&expression);
    return good;
}

static bool valid_scalar(const json_t *schema, const json_t *value)
{
    const json_t *min = json_object_get(schema, "minimum"),
                 *max = json_object_get(schema, "maximum");
    const json_t *choices = json_object_get(schema, "enum"),
                 *constant = json_object_get(schema, "const");
    size_t i;
    json_t *choice;
    bool among = !choices;
    json_array_foreach(choices, i, choice)
    {
        among = among || json_equal(choice, value);
    }
    double v = json_number_value(value);
    return among && (!constant || json_equal(constant, value)) &&
           (!json_is_number(value) ||
            ((!min || v >= json_number_value(min)) && (!max || v <= json_number_value(max))));
}

static void assert_known_keywords(const json_t *schema)
{
    static const char *const known =
        " $schema title description unit deprecated default $defs type additionalProperties "
        "properties "
        "propertyNames "
        "maxProperties required $ref items prefixItems minItems maxItems minLength maxLength "
        "pattern minimum "
        "maximum enum const anyOf oneOf not ";
    const char *key;
    json_t *member;
    json_object_foreach((json_t *)(uintptr_t)schema, key, member)
    {
        char word[64];
        snprintf(word, sizeof word, " %s ", key);
        if (!strstr(known, word))
            fail_msg("the schema uses \"%s\", which this validator does not know", key);
    }
}

static bool valid(const json_t *root, const json_t *schema, json_t *value)
{
    if (json_is_boolean(schema))
        return json_is_true(schema);
    assert_true(json_is_object(schema));
    assert_known_keywords(schema);
    const json_t *type = json_object_get(schema, "type"), *ref = json_object_get(schema, "$ref");
    const json_t *any = json_object_get(schema, "anyOf"), *one = json_object_get(schema, "oneOf"),
                 *not = json_object_get(schema, "not");
    if (ref) {
        const char *name = json_string_value(ref) + strlen("#/$defs/");
        const json_t *target = json_object_get(json_object_get(root, "$defs"), name);
        if (!target)
            fail_msg("the schema refers to %s, which is not there", json_string_value(ref));
        if (!valid(root, target, value))
            return false;
    }
    return (!type || has_type(json_string_value(type), value)) &&
           (!any || count_valid(root, any, value) > 0) &&
           (!one || count_valid(root, one, value) == 1) && (!not || !valid(root, not, value)) &&
           valid_scalar(schema, value) &&
           (!json_is_object(value) || valid_object(root, schema, value)) &&
           (!json_is_array(value) || valid_array(root, schema, value)) &&
           (!json_is_string(value) || valid_string(schema, value));
}

static bool schema_accepts(json_t *doc)
{
    json_t *schema = lf_scene_schema();
    assert_non_null(schema);
    bool good = valid(schema, schema, doc);
    json_decref(schema);
    return good;
}

static lf_status parser_status(const json_t *doc, lf_error *err)
{
    lf_scene *scene = NULL;
    lf_status status = lf_scene_from_json(doc, "/nowhere", "test", NULL, NULL, &scene, err);
    lf_scene_unref(scene);
    return status;
}

/* Both accept. Files need not be there: what the parser then says is LF_E_IO, not LF_E_FORMAT. */
static const char *const good[] = {
    "{'frame': 3, 'camera': {'position': {'keys': [[1, [0, 0, 4]], [2.5, [0, 1, 4]]]}, "
    "'fov_y': {'keys': [[1, 10], [9, 20]], 'interpolation': 'smooth'}}}",
    "{'film': {'exposure': {'keys': [[1, 0]], 'interpolation': 'step'}}, "
    "'backdrop': {'top': {'keys': [[1, 0]]}}}",
    "{'backdrop': {'keys': [[1, [0, 1, 0]]]}, 'meshes': {'m': {'shape': 'cube', "
    "'transform': {'rotate': {'keys': [[1, [0, 0, 0]], [48, [0, 360, 0]]]}, "
    "'scale': {'keys': [[1, 1]]}}}}}",
    "{'volumes': {'v': {'shape': 'box', 'g': {'keys': [[1, 0.5]]}, "
    "'emission': {'keys': [[1, 1]]}}}, 'materials': {'m': {'roughness': {'keys': [[0, 1]]}}}}",
    "{'lights': {'a': {'type': 'spot', 'angle': {'keys': [[1, 9]]}, "
    "'intensity': {'keys': [[1, 9]]}, 'direction': {'keys': [[1, [0, 0, 1]]]}}}}",
    "{'rate': 29.97, 'meshes': {'m': {'file': 'a.glb', 'animation': {'clip': 'walk', "
    "'speed': -0.5, 'offset': 1.5, 'loop': false}}}}",
    "{'meshes': {'m': {'file': 'a.GLTF', 'animation': {'clip': 2}}}}",
    "{'meshes': {'m': {'file': 'a.glb', 'variant': 'night'}}}",
    "{'materials': {'m': {'type': 'principled', 'ior': 1e6}}}",
    "{'meshes': {'m': {'file': 'a.glb'}}, 'camera': {'from': {'mesh': 'm', 'camera': 'eye', "
    "'distance': 2}, 'cone': 30}}",
    "{'meshes': {'m': {'file': 'a.glb'}}, 'camera': {'from': {'mesh': 'm', 'camera': 3}}}",
    "{'meshes': {'m': {'file': 'a.glb', 'lights': 683}, 'n': {'file': 'a.glb', 'lights': false}}}",
    "{}",
    "{'quiltd': 1, 'comment': 'c', '$schema': 's'}",
    "{'quiltd': 1.0, 'camera': {'views': 45.0}}",
    "{'camera': {'fov_y': 0.1, 'aspect': 20, 'cone': 0, 'placement': 'inclusive', 'views': 1, "
    "'lens_radius': 1}}",
    "{'camera': {'view_blur': 1.5}}",
    "{'camera': {'depthiness': 0}}",
    "{'camera': {'depthiness': 2}}",
    "{'volumes': {'v': {'file': 'a.vdb', 'grid': 'd', 'scale': 0, 'interpolation': 'nearest', "
    "'g': -0.999}}}",
    "{'volumes': {'v': {'file': 'a.VDB'}}}",
    "{'volumes': {'v': {'array': 'a'}}}",
    "{'volumes': {'v': {'array': 'a', 'emission': {}}}}",
    "{'volumes': {'v': {'array': 'a', 'emission': {'array': 'b', 'scale': 2, 'colour': [1, 0, 0], "
    "'temperature_scale': {'keys': [[1, 1], [9, 2]]}}}}}",
    "{'meshes': {'m': {'arrays': {'positions': 'p', 'triangles': 't'}}}}",
    "{'meshes': {'m': {'arrays': {'positions': 'p', 'triangles': 't', 'normals': 'n', 'uvs': 'u'}, "
    "'normals': 'smooth', 'units': 'mm', 'catcher': true, 'transform': {'scale': 2}}}}",
    "{'volumes': {'v': {'array': 'a', 'spacing': [1, 0.5, 1e9], 'scale': 2, 'sigma_t': 1, "
    "'precision': 'half', 'interpolation': 'nearest', 'droplets': 9, 'transform': {'scale': 2}}}}",
    "{'volumes': {'v': {'array': 'a', 'spacing': {'keys': [[1, 1], [9, 2]]}, 'albedo': 0.5}}}",
    "{'volumes': {'v': {'file': 'a.vdb', 'emission': {}}}}",
    "{'volumes': {'v': {'file': 'a.vdb', 'emission': {'grid': 'heat', 'scale': 1e9, "
    "'colour': [1, 0.5, 0], 'kelvin': 1000000}}}}",
    "{'volumes': {'v': {'shape': 'box', 'density': 0, 'emission': [1, 0, 1e9]}}}",
    "{'volumes': {'v': {'shape': 'box', 'emission': 2}}}",
    "{'frame': 12, 'volumes': {'v': {'file': 'a_%04d.vdb'}}}",
    "{'frame': 0, 'volumes': {'v': {'file': 'a%d.vdb', 'sequence': {'first': 101, 'step': 0.5}}}}",
    "{'volumes': {'v': {'shape': 'sphere', 'density': 2, 'albedo': [0, 1, 0.5], 'transform': {}}}}",
    "{'volumes': {'v': {'shape': 'box', 'transform': {'scale': [1, 2, -3], 'rotate': [1, 2, 3], "
    "'translate': [1, 2, 3]}}}}",
    "{'volumes': {'v': {'shape': 'box', 'transform': {'matrix': [2,0,0,0, 0,2,0,0, 0,0,2,0, "
    "0,0,0,1]}}}}",
    "{'meshes': {'m': {'file': 'a.glb', 'normals': 'smooth'}}}",
    "{'meshes': {'m': {'shape': 'cube', 'material': 'a'}}, "
    "'materials': {'a': {'type': 'plastic', 'ior': 3}}}",
    "{'materials': {'a': {'type': 'conductor', 'metal': 'silver', 'roughness': 0.2}}}",
    "{'materials': {'a': {'type': 'conductor', 'eta': [0.2, 0.9, 1.1], 'k': 3}}}",
    "{'materials': {'a': {'emission': [1e9, 0, 0], 'roughness': 1}}}",
    "{'materials': {'a': {'albedo': {'file': 'a.PNG', 'scale': [1, 0.5, 0], 'wrap': 'mirror', "
    "'interpolation': 'nearest', 'transform': {'offset': [0.5, -2], 'rotate': 30, 'scale': 4}}, "
    "'alpha': 0.5, 'alpha_cutoff': 0.25}}}",
    "{'materials': {'a': {'type': 'principled', 'roughness': {'file': 'r.jpg', "
    "'scale': {'keys': [[1, 1]]}}, 'metallic': {'file': 'm.jpeg'}, "
    "'emission': {'file': 'e.webp', 'scale': 1e9}, 'normal': {'file': 'n.png', 'scale': -2, "
    "'transform': {'scale': [1, -1]}}}}}",
    "{'materials': {'a': {'type': 'conductor', 'metal': 'gold', 'roughness': {'file': 'r.png'}}}}",
    "{'meshes': {'m': {'file': 'a.glb', 'materials': {'Skin': 'a'}}}, 'materials': {'a': {}}}",
    "{'lights': {'l': {'type': 'environment', 'file': 'a.exr', 'scale': [1, 2, 3], "
    "'rotate': -10}}}",
    "{'lights': {'l': {'type': 'environment', 'radiance': 0}}}",
    "{'lights': {'l': {'type': 'distant', 'direction': [0, 0, 1], 'irradiance': [1, 2, 3], "
    "'angle': 0.5}}}",
    "{'lights': {'l': {'type': 'sky', 'elevation': 0, 'azimuth': -90, 'turbidity': 10, "
    "'sun': false, 'ground': [0, 0.5, 1], 'scale': 0.01, 'visible': false}}}",
    "{'lights': {'l': {'type': 'point'}}}",
    "{'lights': {'l': {'type': 'spot', 'direction': [1, 0, 0], 'angle': 180, 'blend': 0}}}",
    "{'lights': {'l': {'type': 'environment', 'radiance': 1, 'visible': false}, "
    "'m': {'type': 'distant', 'visible': true}}}",
    "{'lights': {'l': {'type': 'rectangle', 'radiance': 1, 'width': 2, 'height': 1e-9, "
    "'rotate': 30, 'direction': [1, 0, 0], 'visible': false}}}",
    "{'lights': {'l': {'type': 'rectangle', 'power': [1, 2, 3]}}}",
    "{'lights': {'l': {'type': 'disk', 'power': 5, 'radius': 2}}}",
    "{'lights': {'l': {'type': 'disk', 'radiance': 5, 'position': [1, 2, 3]}}}",
    "{'lights': {'l': {'type': 'sphere', 'power': 5, 'visible': true}}}",
    "{'lights': {'l': {'type': 'sphere', 'radiance': 5}}}",
    "{'meshes': {'m': {'shape': 'disk', 'catcher': true}}}",
    "{'meshes': {'m': {'shape': 'disk', 'catcher': 'reflection'}}}",
    "{'units': 'in', 'meshes': {'m': {'file': 'a.stl', 'units': 'mm'}}, "
    "'volumes': {'v': {'file': 'a.vdb', 'units': 'km'}}}",
    "{'include': 'other.json'}",
    "{'include': ['other.json', '../b.json'], 'lights': {}}",
    "{'include': []}",
    "{'backdrop': 0.5}",
    "{'backdrop': [0, 1, 1e9]}",
    "{'backdrop': {}}",
    "{'backdrop': {'top': 1, 'bottom': [1, 2, 3]}}",
    "{'film': {'exposure': 32, 'tonemap': 'filmic'}, 'render': {'max_depth': 65536}}",
};

/* Both refuse. */
static const char *const wrong[] = {
    "[]",
    "{'quiltd': 2}",
    "{'quiltd': '1'}",
    "{'Camera': {}}",
    "{'comment': 1}",
    "{'comment': ''}",
    "{'camera': []}",
    "{'camera': null}",
    "{'camera': {'views': 0}}",
    "{'materials': {'a': {'type': 'conductor', 'metal': 'silver', 'albedo': 0.2}}}",
    "{'materials': {'a': {'type': 'conductor', 'metal': 'silver', 'eta': 1, 'k': 1}}}",
    "{'materials': {'a': {'type': 'conductor', 'eta': 1}}}",
    "{'materials': {'a': {'type': 'plastic', 'metal': 'silver'}}}",
    "{'materials': {'a': {'type': 'conductor', 'eta': 1, 'k': 21}}}",
    "{'materials': {'a': {'albedo': {}}}}",
    "{'materials': {'a': {'albedo': {'file': 'a.exr'}}}}",
    "{'materials': {'a': {'albedo': {'file': 'a.png', 'scale': 2}}}}",
    "{'materials': {'a': {'albedo': {'file': 'a.png', 'wrap': 'border'}}}}",
    "{'materials': {'a': {'albedo': {'file': 'a.png', 'transform': {'scale': [1]}}}}}",
    "{'materials': {'a': {'albedo': {'file': 'a.png', 'transform': {'rotate': [1, 2, 3]}}}}}",
    "{'materials': {'a': {'normal': 1}}}",
    "{'materials': {'a': {'alpha': 1.5}}}",
    "{'meshes': {'m': {'file': 'a.glb', 'materials': {'Skin': 1}}}}",
    "{'meshes': {'m': {'shape': 'quad', 'materials': {}}}}",
    "{'camera': {'views': 1.5}}",
    "{'camera': {'fov': 14}}",
    "{'camera': {'fov_y': 161}}",
    "{'camera': {'aspect': 0}}",
    "{'camera': {'cone': -1}}",
    "{'camera': {'placement': 'other'}}",
    "{'camera': {'target': [1, 2]}}",
    "{'camera': {'target': [1, 2, '3']}}",
    "{'camera': {'target': 1}}",
    "{'camera': {'focus_distance': 0}}",
    "{'volumes': {'v': 1}}",
    "{'volumes': {'': {'shape': 'box'}}}",
    "{'volumes': {'v': {}}}",
    "{'volumes': {'v': {'array': 'a', 'shape': 'box'}}}",
    "{'volumes': {'v': {'array': ''}}}",
    "{'volumes': {'v': {'array': 1}}}",
    "{'volumes': {'v': {'array': 'a', 'spacing': 0}}}",
    "{'volumes': {'v': {'array': 'a', 'spacing': [1, 1]}}}",
    "{'volumes': {'v': {'array': 'a', 'emission': {'grid': 'heat'}}}}",
    "{'volumes': {'v': {'array': 'a', 'emission': {'array': ''}}}}",
    "{'volumes': {'v': {'array': 'a', 'emission': 1}}}",
    "{'volumes': {'v': {'file': 'a.vdb', 'emission': {'array': 'a'}}}}",
    "{'meshes': {'m': {'arrays': {'positions': 'p'}}}}",
    "{'meshes': {'m': {'arrays': {'triangles': 't'}}}}",
    "{'meshes': {'m': {'arrays': {'positions': 'p', 'triangles': 't', 'colours': 'c'}}}}",
    "{'meshes': {'m': {'arrays': {'positions': '', 'triangles': 't'}}}}",
    "{'meshes': {'m': {'arrays': {'positions': 1, 'triangles': 't'}}}}",
    "{'meshes': {'m': {'arrays': ['p', 't']}}}",
    "{'meshes': {'m': {'arrays': {'positions': 'p', 'triangles': 't'}, 'shape': 'cube'}}}",
    "{'meshes': {'m': {'arrays': {'positions': 'p', 'triangles': 't'}, 'file': 'a.ply'}}}",
    "{'meshes': {'m': {'arrays': {'positions': 'p', 'triangles': 't'}, 'lights': true}}}",
    "{'meshes': {'m': {'arrays': {'positions': 'p', 'triangles': 't'}, 'variant': 'a'}}}",
    "{'meshes': {'m': {'arrays': {'positions': 'p', 'triangles': 't'}, 'materials': {'a': 'b'}}}}",
    "{'meshes': {'m': {'arrays': {'positions': 'p', 'triangles': 't'}, 'animation': {}}}}",
    "{'volumes': {'v': {'array': 'a', 'grid': 'density'}}}",
    "{'volumes': {'v': {'array': 'a', 'albedo': {'grid': 'Cd'}}}}",
    "{'volumes': {'v': {'shape': 'box', 'spacing': 1}}}",
    "{'volumes': {'v': {'file': 'a.vdb', 'shape': 'box'}}}",
    "{'volumes': {'v': {'file': 'a.vdb', 'density': 1}}}",
    "{'volumes': {'v': {'file': 'a.txt'}}}",
    "{'volumes': {'v': {'file': 'a.vdb', 'emission': 1}}}",
    "{'volumes': {'v': {'file': 'a.vdb', 'emission': {'grid': ''}}}}",
    "{'volumes': {'v': {'file': 'a.vdb', 'emission': {'scale': -1}}}}",
    "{'volumes': {'v': {'file': 'a.vdb', 'emission': {'colour': [1, 2]}}}}",
    "{'volumes': {'v': {'file': 'a.vdb', 'emission': {'kelvin': 2e6}}}}",
    /* former names next to current ones */
    "{'fps': 24, 'rate': 24}",
    "{'volumes': {'v': {'file': 'a.vdb', 'emission': {'kelvin': 1, 'temperature_scale': 1}}}}",
    "{'volumes': {'v': {'file': 'a.vdb', 'emission': {'temperature': 1}}}}",
    "{'volumes': {'v': {'shape': 'box', 'emission': {}}}}",
    "{'volumes': {'v': {'shape': 'box', 'emission': -1}}}",
    "{'volumes': {'v': {'shape': 'box', 'emission': {'colour': 1}}}}",
    "{'frame': -1}",
    "{'frame': 1.5}",
    "{'volumes': {'v': {'file': 'a%d.vdb', 'sequence': {'rate': 24}}}}",
    "{'volumes': {'v': {'file': 'a%d.vdb', 'sequence': {'first': -1}}}}",
    "{'volumes': {'v': {'shape': 'box', 'sequence': {}}}}",
    "{'volumes': {'v': {'shape': 'box', 'grid': 'density'}}}",
    "{'volumes': {'v': {'shape': 'cone'}}}",
    "{'volumes': {'v': {'shape': 'box', 'g': 1}}}",
    "{'volumes': {'v': {'shape': 'box', 'albedo': 1.01}}}",
    "{'volumes': {'v': {'shape': 'box', 'albedo': [1, 1]}}}",
    "{'volumes': {'v': {'shape': 'box', 'transform': {'rotate': 30}}}}",
    "{'volumes': {'v': {'shape': 'box', 'transform': {'scale': [1, 1]}}}}",
    "{'volumes': {'v': {'shape': 'box', 'transform': {'matrix': [1, 2, 3]}}}}",
    "{'volumes': {'v': {'shape': 'box', 'transform': {'matrix': [1,0,0,0, 0,1,0,0, 0,0,1,0, "
    "0,0,0,1], 'scale': 1}}}}",
    "{'meshes': {'m': {}}}",
    "{'meshes': {'m': {'file': 'a.obj', 'shape': 'quad'}}}",
    "{'meshes': {'m': {'file': 'a.dae'}}}",
    "{'meshes': {'m': {'shape': 'quad', 'flip': true}}}",
    "{'meshes': {'m': {'shape': 'quad', 'material': 3}}}",
    "{'meshes': {'m': {'shape': 'quad', 'catcher': 1}}}",
    "{'meshes': {'m': {'shape': 'quad', 'catcher': 'shadow'}}}",
    "{'materials': {'m': {'type': 'glass'}}}",
    "{'materials': {'m': {'ior': 0.9}}}",
    "{'materials': {'m': {'emission': -1}}}",
    "{'lights': {'l': {}}}",
    "{'lights': {'l': {'type': 'mesh'}}}",
    "{'lights': {'l': {'type': 'environment'}}}",
    "{'lights': {'l': {'type': 'environment', 'radiance': 1, 'scale': 1}}}",
    "{'lights': {'l': {'type': 'environment', 'file': 'a.exr', 'radiance': 1}}}",
    "{'lights': {'l': {'type': 'distant', 'angle': 91}}}",
    "{'lights': {'l': {'type': 'sky', 'elevation': 91}}}",
    "{'lights': {'l': {'type': 'sky', 'ground': 2}}}",
    "{'lights': {'l': {'type': 'sky', 'file': 'a.exr'}}}",
    "{'lights': {'l': {'type': 'spot', 'angle': 0}}}",
    "{'lights': {'l': {'type': 'distant', 'position': [0, 0, 0]}}}",
    "{'lights': {'l': {'type': 'point', 'intensity': [1, 2, 3, 4]}}}",
    "{'lights': {'l': {'type': 'environment', 'radiance': 1, 'visible': 1}}}",
    "{'lights': {'l': {'type': 'point', 'visible': false}}}",
    "{'lights': {'l': {'type': 'rectangle'}}}",
    "{'lights': {'l': {'type': 'rectangle', 'radiance': 1, 'power': 1}}}",
    "{'lights': {'l': {'type': 'rectangle', 'radiance': 1, 'width': 0}}}",
    "{'lights': {'l': {'type': 'disk', 'radiance': 1, 'width': 1}}}",
    "{'lights': {'l': {'type': 'sphere', 'radiance': 1, 'direction': [0, 1, 0]}}}",
    "{'lights': {'l': {'type': 'sphere', 'power': -1}}}",
    "{'units': 'inch'}",
    "{'units': 1}",
    "{'meshes': {'m': {'file': 'a.stl', 'units': 'parsec'}}}",
    "{'meshes': {'m': {'shape': 'cube', 'units': 'mm'}}}",
    "{'volumes': {'v': {'shape': 'box', 'units': 'mm'}}}",
    "{'include': 1}",
    "{'include': ''}",
    "{'include': ['']}",
    "{'include': {'file': 'a.json'}}",
    "{'backdrop': -1}",
    "{'backdrop': 'white'}",
    "{'backdrop': [1, 2]}",
    "{'backdrop': {'middle': 1}}",
    "{'backdrop': {'top': true}}",
    "{'film': {'tonemap': 'linear'}}",
    "{'film': {'exposure': 33}}",
    "{'camera': {'view_blur': 8.5}}",
    "{'camera': {'depthiness': 2.5}}",
    "{'camera': {'depthiness': -1}}",
    "{'render': {'max_depth': 1.5}}",
    "{'render': {'depth': 1}}",
    "{'camera': {'fov_y': {'keys': []}}}",
    "{'camera': {'fov_y': {'keys': [[1]]}}}",
    "{'camera': {'fov_y': {'keys': [[-1, 9]]}}}",
    "{'camera': {'fov_y': {'keys': [[1, '9']]}}}",
    "{'camera': {'fov_y': {'interpolation': 'step'}}}",
    "{'camera': {'fov_y': {'keys': [[1, 9]], 'interpolation': 'cubic'}}}",
    "{'camera': {'fov_y': {'keys': [[1, 9]], 'from': 1}}}",
    "{'camera': {'aspect': {'keys': [[1, 1]]}}}",
    "{'camera': {'views': {'keys': [[1, 9]]}}}",
    "{'frame': {'keys': [[1, 9]]}}",
    "{'render': {'max_depth': {'keys': [[1, 9]]}}}",
    "{'rate': 0}",
    "{'meshes': {'m': {'file': 'a.glb', 'animation': {'clip': ''}}}}",
    "{'meshes': {'m': {'file': 'a.glb', 'animation': {'clip': -1}}}}",
    "{'meshes': {'m': {'file': 'a.glb', 'variant': ''}}}",
    "{'meshes': {'m': {'shape': 'cube', 'variant': 'night'}}}",
    "{'materials': {'m': {'type': 'principled', 'ior': 1.1e6}}}",
    "{'meshes': {'m': {'file': 'a.glb', 'lights': -1}}}",
    "{'camera': {'from': {'camera': 3}}}",
    "{'camera': {'from': 'm'}}",
    "{'camera': {'from': {'mesh': 'm', 'camera': -1}}}",
    "{'camera': {'from': {'mesh': 'm', 'distance': 0}}}",
    "{'meshes': {'m': {'file': 'a.glb', 'lights': 'yes'}}}",
    "{'meshes': {'m': {'file': 'a.glb', 'lights': {'keys': [[1, 1]]}}}}",
    "{'meshes': {'m': {'shape': 'cube', 'lights': true}}}",
    "{'meshes': {'m': {'file': 'a.glb', 'animation': {'speed': 1001}}}}",
    "{'meshes': {'m': {'file': 'a.glb', 'animation': {'loop': 1}}}}",
    "{'meshes': {'m': {'file': 'a.glb', 'animation': 'walk'}}}",
};

static void schema_and_parser_accept_the_same_documents(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        json_t *doc = lf_test_json("document", good[i]);
        lf_error err;
        lf_status status = parser_status(doc, &err);
        if (!schema_accepts(doc))
            fail_msg("the schema refuses %s", good[i]);
        if (status != LF_OK && status != LF_E_IO)
            fail_msg("the parser refuses %s: %s: %s", good[i], err.pointer, err.what);
        json_decref(doc);
    }
}

static void schema_and_parser_refuse_the_same_documents(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        json_t *doc = lf_test_json("document", wrong[i]);
        lf_error err;
        if (schema_accepts(doc))
            fail_msg("the schema accepts %s", wrong[i]);
        if (parser_status(doc, &err) != LF_E_FORMAT)
            fail_msg("the parser accepts %s", wrong[i]);
        json_decref(doc);
    }
}

/* Keys that a section of the schema lists are keys that the parser knows: it complains about the
 * value, not the key. */
static void every_key_of_the_schema_is_known_to_the_parser(void **state)
{
    (void)state;
    json_t *schema = lf_scene_schema(), *member;
    const char *key;
    int n = 0;
    json_object_foreach(json_object_get(schema, "properties"), key, member)
    {
        json_t *doc = json_pack("{s:n}", key);
        lf_error err;
        lf_assert_status(parser_status(doc, &err), LF_E_FORMAT, &err);
        if (strstr(err.what, "unknown key"))
            fail_msg("%s: %s", key, err.what);
        json_decref(doc);
        n++;
    }
    assert_int_equal(n, 16); /* "rate", too, the former name of "fps" */
    json_decref(schema);
}

/* Applies the schema to every scene of a folder of the source tree; the number of scenes. */
static int check_folder(const char *name)
{
    char folder[PATH_MAX];
    snprintf(folder, sizeof folder, "%s", lf_test_source(name));
    DIR *dir = opendir(folder);
    int n = 0;
    assert_non_null(dir);
    for (struct dirent *entry = readdir(dir); entry; entry = readdir(dir)) {
        const char *dot = strrchr(entry->d_name, '.');
        if (!dot || strcmp(dot, ".json") != 0)
            continue;
        json_error_t problem;
        json_t *doc =
            json_load_file(lf_test_path(folder, entry->d_name), JSON_REJECT_DUPLICATES, &problem);
        if (!doc)
            fail_msg("%s:%d: %s", entry->d_name, problem.line, problem.text);
        if (!schema_accepts(doc))
            fail_msg("%s does not follow the schema", entry->d_name);
        /* A negative control: the same scene with a slip does not. */
        json_object_set_new(json_object_get(doc, "camera"), "fov_z", json_integer(14));
        assert_false(schema_accepts(doc));
        json_decref(doc);
        n++;
    }
    closedir(dir);
    return n;
}

static void every_shipped_scene_follows_the_schema(void **state)
{
    (void)state;
    assert_true(check_folder("scenes") >= 4);
    assert_true(check_folder("scenes/bench") >= 11);
    assert_true(check_folder("bench/reference") >= 2);
    assert_true(check_folder("bench/textured") >= 5);
}

/* As some editors write it. */
static void a_mark_of_utf8_before_the_document_is_skipped(void **state)
{
    lf_error err;
    lf_scene *scene = NULL;
    const char *path = lf_test_write(*state, "marked.json",
                                     "\xef\xbb\xbf{ \"quiltd\": 1, \"camera\": { \"target\": "
                                     "[0,0,0], \"position\": [0,0,5] } }");
    lf_assert_ok(lf_scene_load(path, NULL, NULL, &scene, &err), &err);
    lf_scene_unref(scene);
    /* places in errors are those of the file */
    path = lf_test_write(*state, "marked.json", "\xef\xbb\xbf{\n\"quiltd\": 1,\n\"wings\": 2 }");
    lf_assert_status(lf_scene_load(path, NULL, NULL, &scene, &err), LF_E_FORMAT, &err);
    assert_int_equal(err.line, 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(schema_and_parser_accept_the_same_documents),
        cmocka_unit_test(schema_and_parser_refuse_the_same_documents),
        cmocka_unit_test(every_key_of_the_schema_is_known_to_the_parser),
        cmocka_unit_test(every_shipped_scene_follows_the_schema),
        lf_test_in_folder(a_mark_of_utf8_before_the_document_is_skipped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
