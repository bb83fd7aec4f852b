#include "render/scene/principled.h"

#include <string.h>

#include "render/scene/vec_double.h"

/* Rounding of a unit vector, with room. */
#define UNIT_SLACK 1e-3f

#define NUMBER(field, lowest, highest, usual, told)                                                \
    const lf_param lf_principled_##field = {.name = #field,                                        \
                                            .type = LF_PARAM_NUMBER,                               \
                                            .low = (lowest),                                       \
                                            .high = (highest),                                     \
                                            .initial = (usual),                                    \
                                            .help = (told),                                        \
                                            .place = offsetof(lf_principled, field)};
#define COLOUR(field, lowest, highest, usual, told)                                                \
    const lf_param lf_principled_##field = {.name = #field,                                        \
                                            .type = LF_PARAM_COLOUR,                               \
                                            .low = (lowest),                                       \
                                            .high = (highest),                                     \
                                            .point = {usual, usual, usual},                        \
                                            .help = (told),                                        \
                                            .place = offsetof(lf_principled, field)};
#define ANGLE(field, lowest, highest, usual, told)                                                 \
    const lf_param lf_principled_##field = {.name = #field,                                        \
                                            .type = LF_PARAM_ANGLE,                                \
                                            .low = (lowest),                                       \
                                            .high = (highest),                                     \
                                            .initial = (usual),                                    \
                                            .help = (told),                                        \
                                            .place = offsetof(lf_principled, field)};
LF_PRINCIPLED(NUMBER, COLOUR, ANGLE)

#define LIST(field, ...) &lf_principled_##field,
const lf_param *const lf_principled_rows[] = {LF_PRINCIPLED(LIST, LIST, LIST) NULL};

static void set(lf_principled *p, const lf_param *row, const double value[3])
{
    int n;
    float *field = lf_principled_at(p, row, &n);
    if (row->type == LF_PARAM_ANGLE) {
        field[0] = (float)cos(value[0]);
        field[1] = (float)sin(value[0]);
        return;
    }
    for (int i = 0; i < n; i++)
        field[i] = (float)value[i];
}

lf_principled lf_principled_usual(void)
{
    lf_principled p;
    for (const lf_param *const *row = lf_principled_rows; *row; row++)
        set(&p, *row, (*row)->type == LF_PARAM_COLOUR ? (*row)->point : &(*row)->initial);
    return p;
}

static bool is_sound(lf_principled *p, const lf_param *row)
{
    int n;
    const float *field = lf_principled_at(p, row, &n);
    bool sound = true;
    if (row->type == LF_PARAM_ANGLE)
        return fabsf(field[0] * field[0] + field[1] * field[1] - 1.0f) <= UNIT_SLACK;
    for (int i = 0; i < n; i++) /* no NaN is */
        sound = sound && field[i] >= (float)row->low && field[i] <= (float)row->high;
    return sound;
}

const lf_param *lf_principled_wrong(const lf_principled *p)
{
    lf_principled own = *p;
    const lf_param *const *row = lf_principled_rows;
    while (*row && is_sound(&own, *row))
        row++;
    return *row;
}

bool lf_principled_take(lf_principled *p, const lf_param *key, const lf_value *value)
{
    const lf_param *const *row = lf_principled_rows;
    while (*row && *row != key)
        row++;
    if (*row)
        set(p, key, value->number);
    return *row;
}
