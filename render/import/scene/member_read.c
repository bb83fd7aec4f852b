#include "render/import/scene/member_read.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "render/scene/vec_double.h"

#define LF_MAX_PATH 4095
#define MAX_NAMES 32 /* of keys, of endings */

/* ------------------------------------------------------------------------------------ values -- */

int lf_read_type(lf_reader *reader, const lf_node *node, const char *const types[], int fallback)
{
    if (reader->status == LF_OK && !json_is_object(node->value))
        lf_read_fail(reader, node, "expected an object");
    if (fallback < 0 && !lf_node_child(node, "type").value) {
        char list[256];
        lf_join_names(types, list, sizeof list);
        lf_read_fail(reader, node, "\"type\" is missing; expected one of %s", list);
    }
    return lf_read_choice(reader, node, "type", types, fallback < 0 ? 0 : fallback);
}

static void make_unit(lf_reader *reader, const lf_node *at, double direction[3])
{
    const double length = lf_length_double(direction);
    if (!(length > 0))
        lf_read_fail(reader, at, "the direction must not be zero");
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

bool lf_is_file_of(const char *file, const char *const endings[])
{
    bool is = false;
    for (int i = 0; endings[i] && !is; i++)
        is = strcasecmp(ending(file), endings[i]) == 0;
    return is;
}

void lf_read_relative(lf_reader *reader, const lf_node *node, const char *file)
{
    lf_read_fail(reader, node,
                 "%s: the scene was sent without a file, so its paths must be absolute", file);
}

const char *lf_read_file(lf_reader *reader, const lf_node *node, const char *key,
                         const char *const endings[])
{
    const char *file = lf_read_string(reader, node, key, NULL, LF_MAX_PATH);
    char list[128];
    if (!file)
        return NULL;
    lf_node at = lf_node_child(node, key);
    if (reader->has_no_folder && file[0] != '/') {
        lf_read_relative(reader, &at, file);
        return NULL;
    }
    if (lf_is_file_of(file, endings))
        return file;
    join_endings(endings, list, sizeof list);
    lf_read_fail(reader, &at, "%s: unknown kind of file; expected %s", file, list);
    return NULL;
}

static void read_numbers(lf_reader *reader, const lf_node *node, const lf_param *row,
                         double number[3])
{
    const lf_node at = lf_node_child(node, row->name);
    memcpy(number, row->point, sizeof row->point);
    if (row->type == LF_PARAM_COLOUR)
        lf_read_colour(reader, node, row->name, number, row->low, row->high);
    else
        lf_read_numbers(reader, node, row->name, 3, number, row->low, row->high);
    if (row->type == LF_PARAM_DIRECTION)
        make_unit(reader, &at, number);
}

static const char *read_file_name(lf_reader *reader, const lf_node *node, const lf_param *row)
{
    const char *endings[MAX_NAMES + 1] = {NULL};
    for (int i = 0; i < MAX_NAMES && (i == 0 || endings[i - 1]); i++)
        endings[i] = row->word_at(i);
    return lf_read_file(reader, node, row->name, endings);
}

/* Reads a key into a field of its row's type. */
static void read_field(lf_reader *reader, const lf_node *node, const lf_param *row, void *field)
{
    double *number = field;
    switch (row->type) {
    case LF_PARAM_NUMBER:
    case LF_PARAM_ANGLE:
        *number = lf_read_number(reader, node, row->name, row->initial, row->low, row->high);
        if (row->type == LF_PARAM_ANGLE)
            *number = LF_RADIANS(*number);
        break;
    case LF_PARAM_POINT:
    case LF_PARAM_COLOUR:
    case LF_PARAM_DIRECTION:
        read_numbers(reader, node, row, number);
        break;
    case LF_PARAM_WHOLE:
        *(int *)field =
            lf_read_int(reader, node, row->name, (int)row->initial, (int)row->low, (int)row->high);
        break;
    case LF_PARAM_SWITCH:
        *(bool *)field =
            row->words ? lf_read_choice(reader, node, row->name, row->words, (int)row->initial)
                       : lf_read_bool(reader, node, row->name, row->initial != 0.0);
        break;
    case LF_PARAM_WORD:
        *(int *)field = lf_read_choice(reader, node, row->name, row->words, (int)row->initial);
        break;
    case LF_PARAM_FILE:
        *(const char **)field = read_file_name(reader, node, row);
        break;
    default:
        assert(false && "no row of a scene file");
    }
}

void lf_read_value(lf_reader *reader, const lf_node *node, const lf_param *key, lf_value *out)
{
    *out = (lf_value){.given = lf_node_child(node, key->name).value};
    void *field = out->number;
    if (key->type == LF_PARAM_WORD)
        field = &out->word;
    else if (key->type == LF_PARAM_SWITCH)
        field = &out->on;
    else if (key->type == LF_PARAM_FILE)
        field = &out->text;
    read_field(reader, node, key, field);
}

/* ------------------------------------------------------------------------------------- forms -- */

bool lf_read_either(lf_reader *reader, const lf_node *node, const char *a, const char *b)
{
    bool has_a = lf_node_child(node, a).value, has_b = lf_node_child(node, b).value;
    if (reader->status == LF_OK && has_a == has_b)
        lf_read_fail(reader, node, "%s: \"%s\" or \"%s\"",
                     has_a ? "only one is allowed" : "one is missing", a, b);
    return has_a;
}

/* The first key of a form; NULL: keys have none. */
static const char *first_of(const lf_param keys[], int form)
{
    for (int i = 0; keys[i].name; i++)
        if (keys[i].form == form)
            return keys[i].name;
    return NULL;
}

/* Refuses keys that do not have this form; 0: neither. also: an additional key, or NULL. */
static void check_keys(lf_reader *reader, const lf_node *node, const char *also,
                       const lf_param keys[], int form)
{
    const char *names[MAX_NAMES + 1] = {also};
    int n = also ? 1 : 0;
    for (int i = 0; keys[i].name; i++) {
        assert(n < MAX_NAMES);
        if (form == 0 || keys[i].form == 0 || keys[i].form == form)
            names[n++] = keys[i].name;
    }
    names[n] = NULL;
    lf_read_object(reader, node, names);
}

void lf_read_values(lf_reader *reader, const lf_node *node, const lf_param keys[], lf_value out[])
{
    const char *first = first_of(keys, 1);
    check_keys(reader, node, "type", keys, 0);
    if (first)
        check_keys(reader, node, "type", keys,
                   lf_read_either(reader, node, first, first_of(keys, 2)) ? 1 : 2);
    for (int i = 0; keys[i].name; i++)
        lf_read_value(reader, node, &keys[i], &out[i]);
}

void lf_read_params(lf_reader *reader, const lf_node *node, const char *also,
                    const lf_param params[], void *object)
{
    check_keys(reader, node, also, params, 0);
    for (const lf_param *row = params; row->name; row++)
        read_field(reader, node, row, (char *)object + row->place);
}
