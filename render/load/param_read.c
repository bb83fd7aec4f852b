#include "render/load/param_read.h"

#include <assert.h>
#include <string.h>

#include "render/scene/vec_double.h"

static void read_param(lf_reader *reader, const lf_node *node, const lf_param *row, void *object)
{
    char *field = (char *)object + row->place;
    switch (row->type) {
    case LF_PARAM_NUMBER:
    case LF_PARAM_ANGLE: {
        const double number =
            lf_read_number(reader, node, row->name, row->initial, row->low, row->high);
        *(double *)(void *)field = row->type == LF_PARAM_ANGLE ? LF_RADIANS(number) : number;
        break;
    }
    case LF_PARAM_POINT:
        memcpy(field, row->point, sizeof row->point);
        lf_read_numbers(reader, node, row->name, 3, (double *)(void *)field, row->low, row->high);
        break;
    case LF_PARAM_WHOLE:
        *(int *)(void *)field =
            lf_read_int(reader, node, row->name, (int)row->initial, (int)row->low, (int)row->high);
        break;
    case LF_PARAM_SWITCH:
    case LF_PARAM_WORD: {
        const int word = lf_read_choice(reader, node, row->name, row->words, (int)row->initial);
        if (row->type == LF_PARAM_WORD)
            *(int *)(void *)field = word;
        else
            *(bool *)(void *)field = word == 1;
        break;
    }
    default:
        assert(!"a text in a scene file");
    }
}

void lf_read_params(lf_reader *reader, const lf_node *node, const lf_param params[], void *object)
{
    const char *keys[LF_MAX_PARAMS + 1];
    int n = 0;
    for (const lf_param *row = params; row->name; row++) {
        assert(n < LF_MAX_PARAMS);
        keys[n++] = row->name;
    }
    keys[n] = NULL;
    lf_read_object(reader, node, keys);
    for (const lf_param *row = params; row->name; row++)
        read_param(reader, node, row, object);
}
