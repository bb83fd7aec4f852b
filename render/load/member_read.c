#include "render/load/member_read.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "render/scene/vec_double.h"

#define LF_MAX_PATH 4095

/* ----------------------------------------------------------------------------------- values -- */

int lf_read_type(lf_reader *reader, const lf_node *node, const char *const types[], int fallback)
{
    if (reader->status == LF_OK && !json_is_object(node->value))
        lf_read_fail(reader, node, "expected an object");
    if (fallback < 0 && !lf_node_child(node, "type").value) {
        char list[256];
        lf_join_names(types, list, sizeof list);
        lf_read_fail(reader, node, "\"type\" is missing: one of %s", list);
    }
    return lf_read_choice(reader, node, "type", types, fallback < 0 ? 0 : fallback);
}

static void read_direction(lf_reader *reader, const lf_node *node, const lf_key *key,
                           double direction[3])
{
    lf_node at = lf_node_child(node, key->name);
    lf_read_numbers(reader, node, key->name, 3, direction, -LF_MAX_COORDINATE, LF_MAX_COORDINATE);
    double length = lf_length_double(direction);
    if (!(length > 0))
        lf_read_fail(reader, &at, "the direction has no length");
    for (int i = 0; i < 3 && length > 0; i++)
        direction[i] /= length;
}

/* "a", ".a or .b", ".a, .b or .c" */
static void join_endings(const char *const endings[], char *out, size_t size)
{
    out[0] = '\0';
    for (int i = 0; endings[i]; i++) {
        size_t at = strlen(out);
        snprintf(out + at, size - at, "%s.%s",
                 !i               ? ""
                 : endings[i + 1] ? ", "
                                  : " or ",
                 endings[i]);
    }
}

static const char *ending(const char *file)
{
    const char *slash = strrchr(file, '/');
    const char *dot = strrchr(slash ? slash : file, '.');
    return dot ? dot + 1 : "";
}

const char *lf_read_file(lf_reader *reader, const lf_node *node, const char *key,
                         const char *const endings[])
{
    const char *file = lf_read_string(reader, node, key, NULL, LF_MAX_PATH);
    char list[128];
    if (!file)
        return NULL;
    for (int i = 0; endings[i]; i++)
        if (strcasecmp(ending(file), endings[i]) == 0)
            return file;
    lf_node at = lf_node_child(node, key);
    join_endings(endings, list, sizeof list);
    lf_read_fail(reader, &at, "%s: unknown kind of file; expected %s", file, list);
    return NULL;
}

void lf_read_value(lf_reader *reader, const lf_node *node, const lf_key *key, lf_value *out)
{
    *out = (lf_value){.given = lf_node_child(node, key->name).value};
    memcpy(out->number, key->fallback, sizeof out->number);
    switch (key->type) {
    case LF_KEY_NUMBER:
    case LF_KEY_ANGLE:
        out->number[0] =
            lf_read_number(reader, node, key->name, key->fallback[0], key->lo, key->hi);
        if (key->type == LF_KEY_ANGLE)
            out->number[0] = LF_RADIANS(out->number[0]);
        break;
    case LF_KEY_COLOUR:
        lf_read_colour(reader, node, key->name, out->number, key->lo, key->hi);
        break;
    case LF_KEY_POINT:
        lf_read_numbers(reader, node, key->name, 3, out->number, -LF_MAX_COORDINATE,
                        LF_MAX_COORDINATE);
        break;
    case LF_KEY_DIRECTION:
        read_direction(reader, node, key, out->number);
        break;
    case LF_KEY_CHOICE:
        out->number[0] = lf_read_choice(reader, node, key->name, key->words, 0);
        break;
    case LF_KEY_FILE:
        out->text = lf_read_file(reader, node, key->name, key->words);
        break;
    }
}

/* ------------------------------------------------------------------------------------ forms -- */

bool lf_read_either(lf_reader *reader, const lf_node *node, const char *a, const char *b)
{
    bool has_a = lf_node_child(node, a).value, has_b = lf_node_child(node, b).value;
    if (reader->status == LF_OK && has_a == has_b)
        lf_read_fail(reader, node, "%s: \"%s\" or \"%s\"",
                     has_a ? "only one is allowed" : "one is missing", a, b);
    return has_a;
}

/* The first key of a form; NULL: keys have none. */
static const char *first_of(const lf_key keys[], int form)
{
    for (int i = 0; keys[i].name; i++)
        if (keys[i].form == form)
            return keys[i].name;
    return NULL;
}

/* Refuses keys that are not of this form; 0: of neither. */
static void check_keys(lf_reader *reader, const lf_node *node, const lf_key keys[], int form)
{
    const char *names[LF_MAX_KEYS + 2] = {"type"};
    int n = 1;
    for (int i = 0; keys[i].name; i++)
        if (form == 0 || keys[i].form == 0 || keys[i].form == form)
            names[n++] = keys[i].name;
    names[n] = NULL;
    lf_read_object(reader, node, names);
}

void lf_read_values(lf_reader *reader, const lf_node *node, const lf_key keys[], lf_value out[])
{
    const char *first = first_of(keys, 1);
    check_keys(reader, node, keys, 0);
    if (first)
        check_keys(reader, node, keys,
                   lf_read_either(reader, node, first, first_of(keys, 2)) ? 1 : 2);
    for (int i = 0; keys[i].name; i++)
        lf_read_value(reader, node, &keys[i], &out[i]);
}
