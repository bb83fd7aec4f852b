#include "render/import/scene/keyframes.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "render/import/scene/frame_file.h"

enum { MOST_NUMBERS = 16 }; /* of a value: a matrix has them */

typedef struct walker {
    lf_reader *reader;
    double frame;
    bool keyed; /* a value had keys */
} walker;

/* A value of the document: n 0 = a single number. */
typedef struct numbers {
    size_t n;
    double x[MOST_NUMBERS];
} numbers;

static json_t *no_memory(const walker *w)
{
    if (w->reader->status == LF_OK)
        w->reader->status =
            lf_error_set(w->reader->err, LF_E_NOMEM, w->reader->where, "out of memory");
    return NULL;
}

/* Objects may have this name, too; their value is an object, not an array. */
static bool has_keys(const json_t *value)
{
    return json_is_array(json_object_get(value, "keys"));
}

static void read_numbers(lf_reader *reader, const lf_node *node, numbers *out)
{
    bool good = json_is_number(node->value);
    *out = (numbers){.x = {json_number_value(node->value)}};
    if (json_is_array(node->value)) {
        out->n = json_array_size(node->value);
        good = out->n > 0 && out->n <= MOST_NUMBERS;
        for (size_t i = 0; i < out->n && good; i++) {
            out->x[i] = json_number_value(json_array_get(node->value, i));
            good = json_is_number(json_array_get(node->value, i));
        }
    }
    if (!good)
        lf_read_fail(reader, node, "expected a number, or an array of up to %d numbers",
                     MOST_NUMBERS);
}

/* One key: its frame and value. */
static double read_key(lf_reader *reader, const lf_node *keys, size_t i, numbers *out)
{
    const lf_node key = lf_node_item(keys, i);
    if (!json_is_array(key.value) || json_array_size(key.value) != 2) {
        lf_read_fail(reader, &key, "expected a key: [frame, value]");
        return 0;
    }
    const lf_node at = lf_node_item(&key, 0), value = lf_node_item(&key, 1);
    double frame = json_number_value(at.value);
    if (!json_is_number(at.value) || !(frame >= 0 && frame <= LF_MAX_FRAME))
        lf_read_fail(reader, &at, "expected a frame: 0 to %d", LF_MAX_FRAME);
    read_numbers(reader, &value, out);
    return frame;
}

/* The keys on both sides of a frame, and the position between them, 0 to 1. All keys are checked,
 * so that an error is reported in every frame. */
static double find_keys(const walker *w, const lf_node *keys, numbers *before, numbers *behind)
{
    double frame = 0, from = 0, to = INFINITY;
    for (size_t i = 0; i < json_array_size(keys->value) && w->reader->status == LF_OK; i++) {
        const lf_node key = lf_node_item(keys, i);
        double last = frame;
        numbers value;
        frame = read_key(w->reader, keys, i, &value);
        if (i > 0 && !(frame > last))
            lf_read_fail(w->reader, &key,
                         "keyframes must be in ascending frame order, one per frame");
        if (i > 0 && value.n != before->n)
            lf_read_fail(w->reader, &key, "expected as many numbers as in the first key");
        if (i == 0 || frame <= w->frame) {
            *before = *behind = value;
            from = frame;
        } else if (to > frame) {
            *behind = value;
            to = frame;
        }
    }
    return isfinite(to) && w->frame > from ? (w->frame - from) / (to - from) : 0;
}

static json_t *json_of(const walker *w, const numbers *value)
{
    if (value->n == 0)
        return json_real(value->x[0]);
    json_t *array = json_array();
    for (size_t i = 0; i < value->n; i++)
        if (json_array_append_new(array, json_real(value->x[i])) != 0) {
            json_decref(array);
            return no_memory(w);
        }
    return array;
}

/* The value at node in the walker's frame. */
static json_t *value_at(const walker *w, const lf_node *node)
{
    static const char *const members[] = {"keys", "interpolation", NULL};
    static const char *const kinds[] = {"linear", "smooth", "step", NULL};
    const lf_node keys = lf_node_child(node, "keys");
    numbers a = {0}, b = {0};
    lf_read_object(w->reader, node, members);
    if (json_array_size(keys.value) == 0)
        lf_read_fail(w->reader, &keys, "expected at least one key");
    int kind = lf_read_choice(w->reader, node, "interpolation", kinds, 0);
    double t = find_keys(w, &keys, &a, &b);
    if (w->reader->status != LF_OK)
        return NULL;
    t = kind == 2 ? 0 : kind == 1 ? t * t * (3 - 2 * t) : t;
    for (size_t i = 0; i < MOST_NUMBERS && t > 0; i++)
        a.x[i] += t * (b.x[i] - a.x[i]);
    return json_of(w, &a);
}

/* Members that cannot have keys. */
static bool is_fixed(const char *member)
{
    static const char *const fixed[] = {"views",     "aspect",  "sequence",
                                        "animation", "shutter", "shutter_open",
                                        "lights",    "from",    NULL};
    for (int i = 0; fixed[i]; i++)
        if (strcmp(member, fixed[i]) == 0)
            return true;
    return false;
}

/* Stores now (a new reference) under key in a copy of doc, which is made for the first change and
 * shares all other values. */
static void put(const walker *w, const json_t *doc, json_t **copy, const char *key, json_t *now)
{
    if (!*copy)
        *copy = json_copy((json_t *)(uintptr_t)doc);
    if (json_object_set_new(*copy, key, now) != 0)
        no_memory(w);
}

/* The value at node in the walker's frame: a new reference, to the value itself if it has no keys.
 * names: its members are objects by name. */
static json_t *in_frame(walker *w, const lf_node *node, bool names)
{
    json_t *copy = NULL, *value;
    const char *key;
    json_object_foreach(node->value, key, value)
    {
        const lf_node child = lf_node_child(node, key);
        if (w->reader->status != LF_OK || !json_is_object(value) || (!names && is_fixed(key)))
            continue;
        w->keyed = w->keyed || has_keys(value);
        json_t *now = has_keys(value) ? value_at(w, &child) : in_frame(w, &child, false);
        if (now == value)
            json_decref(now);
        else
            put(w, node->value, &copy, key, now);
    }
    return copy ? copy : json_incref(node->value);
}

/* The document in the walker's frame: a new reference, to the same document if it has no keys.
 * NULL: see reader->status. */
static json_t *scene_in_frame(walker *w, const lf_node *root)
{
    static const struct {
        const char *name;
        bool names;
    } sections[] = {{"camera", false}, {"film", false},     {"volumes", true},
                    {"meshes", true},  {"materials", true}, {"lights", true}};
    const lf_node backdrop = lf_node_child(root, "backdrop");
    json_t *copy = NULL;
    for (size_t i = 0; i < sizeof sections / sizeof *sections; i++) {
        const lf_node section = lf_node_child(root, sections[i].name);
        json_t *now = section.value ? in_frame(w, &section, sections[i].names) : NULL;
        if (now == section.value)
            json_decref(now);
        else
            put(w, root->value, &copy, sections[i].name, now);
    }
    bool keyed = has_keys(backdrop.value);
    w->keyed = w->keyed || keyed;
    if (json_is_object(backdrop.value)) {
        json_t *now = keyed ? value_at(w, &backdrop) : in_frame(w, &backdrop, false);
        if (now == backdrop.value)
            json_decref(now);
        else
            put(w, root->value, &copy, "backdrop", now);
    }
    if (w->reader->status == LF_OK)
        return copy ? copy : json_incref(root->value);
    json_decref(copy);
    return NULL;
}

/* The document's frame number. */
static double frame_of(const lf_node *root)
{
    const json_t *said = json_object_get(root->value, "frame");
    return json_is_number(said) ? json_number_value(said) : 1;
}

json_t *lf_keyframes_beside(lf_reader *reader, const lf_node *root, double frames)
{
    walker w = {reader, frame_of(root) + frames, false};
    return scene_in_frame(&w, root);
}

json_t *lf_keyframes_still(lf_reader *reader, const lf_node *root, int frame, bool *out_keyed)
{
    walker w = {reader, frame >= 0 ? frame : frame_of(root), false};
    json_t *still = scene_in_frame(&w, root);
    *out_keyed = w.keyed;
    if (!still || frame < 0)
        return still;
    json_t *copy = json_copy(still);
    json_decref(still);
    if (json_object_set_new(copy, "frame", json_integer(frame)) == 0)
        return copy;
    json_decref(copy);
    return no_memory(&w);
}
