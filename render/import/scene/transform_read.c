#include "render/import/scene/transform_read.h"

#include <string.h>

#include "base/alloc.h"
#include "render/import/scene/member_read.h"
#include "render/scene/vec_double.h"

/* Sine and cosine of an angle in degrees, exact at quarter turns. */
static void sincos_degrees(double degrees, double *s, double *c)
{
    double turned = remainder(degrees, 360.0);
    double quarter = nearbyint(turned / 90.0);
    double rest = LF_RADIANS(turned - 90.0 * quarter);
    double sine = sin(rest), cosine = cos(rest);
    switch ((int)quarter & 3) {
    case 0:
        *s = sine, *c = cosine;
        break;
    case 1:
        *s = cosine, *c = -sine;
        break;
    case 2:
        *s = -sine, *c = -cosine;
        break;
    default:
        *s = -cosine, *c = sine;
        break;
    }
}

static lf_affine rotation(int axis, double degrees)
{
    double s, c;
    sincos_degrees(degrees, &s, &c);
    int i = (axis + 1) % 3, j = (axis + 2) % 3;
    lf_affine a = lf_affine_identity();
    a.m[i][i] = c;
    a.m[i][j] = -s;
    a.m[j][i] = s;
    a.m[j][j] = c;
    return a;
}

static lf_affine parse_steps(lf_reader *reader, const lf_node *node)
{
    double scale[3] = {1, 1, 1}, rotate[3] = {0, 0, 0}, translate[3] = {0, 0, 0};
    lf_read_colour(reader, node, "scale", scale, -LF_MAX_COORDINATE, LF_MAX_COORDINATE);
    lf_read_numbers(reader, node, "rotate", 3, rotate, -3600, 3600);
    lf_read_numbers(reader, node, "translate", 3, translate, -LF_MAX_COORDINATE, LF_MAX_COORDINATE);
    lf_affine a = lf_affine_identity();
    for (int i = 0; i < 3; i++)
        a.m[i][i] = scale[i];
    for (int axis = 0; axis < 3; axis++) {
        lf_affine r = rotation(axis, rotate[axis]);
        a = lf_affine_compose(&r, &a);
    }
    for (int i = 0; i < 3; i++)
        a.m[i][3] = translate[i];
    return a;
}

static lf_affine parse_matrix(lf_reader *reader, const lf_node *node)
{
    lf_affine a = lf_affine_identity();
    lf_node matrix = lf_node_child(node, "matrix");
    if (json_object_size(node->value) != 1) {
        lf_read_fail(reader, &matrix,
                     "a matrix cannot be combined with scale, rotate or translate; remove them");
        return a;
    }
    if (!json_is_array(matrix.value) || json_array_size(matrix.value) != 16) {
        lf_read_fail(reader, &matrix, "expected 16 numbers: a 4x4 matrix, row by row");
        return a;
    }
    double m[16];
    if (!lf_read_numbers(reader, node, "matrix", 16, m, -LF_MAX_COORDINATE, LF_MAX_COORDINATE))
        return a;
    if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
        lf_read_fail(reader, &matrix,
                     "the last row must be 0 0 0 1: projections are not supported");
    memcpy(a.m, m, sizeof a.m);
    return a;
}

/* Reads a transform object. */
static lf_affine parse_map(lf_reader *reader, const lf_node *node)
{
    static const char *const keys[] = {"scale", "rotate", "translate", "matrix", NULL};
    if (!lf_read_object(reader, node, keys))
        return lf_affine_identity();
    return json_object_get(node->value, "matrix") ? parse_matrix(reader, node)
                                                  : parse_steps(reader, node);
}

void lf_refuse_flat(lf_reader *reader, const lf_node *node, const lf_affine *a)
{
    lf_affine inverse;
    if (reader->status == LF_OK && !lf_affine_invert(a, &inverse))
        lf_read_fail(reader, node,
                     "the transform is singular: its inverse does not exist or exceeds %g",
                     LF_MAX_INVERSE);
}

lf_affine lf_read_transform(lf_reader *reader, const lf_node *node)
{
    lf_node transform = lf_node_child(node, "transform");
    lf_affine a = parse_map(reader, &transform);
    lf_refuse_flat(reader, &transform, &a);
    return a;
}

/* --------------------------------------------------------------------------------- instances -- */

/* 12 or 16 numbers, row by row. */
static lf_affine parse_rows(lf_reader *reader, const lf_node *node)
{
    lf_affine a = lf_affine_identity();
    size_t n = json_array_size(node->value);
    double m[16] = {[15] = 1};
    if (n != 12 && n != 16) {
        lf_read_fail(reader, node,
                     "expected a transform, or 12 or 16 numbers: the rows of a matrix");
        return a;
    }
    for (size_t i = 0; i < n; i++) {
        const json_t *number = json_array_get(node->value, i);
        m[i] = json_number_value(number);
        if (!json_is_number(number) || !(fabs(m[i]) <= LF_MAX_COORDINATE)) {
            lf_node at = lf_node_item(node, i);
            lf_read_fail(reader, &at, "expected a number between %g and %g", -LF_MAX_COORDINATE,
                         LF_MAX_COORDINATE);
            return a;
        }
    }
    if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
        lf_read_fail(reader, node, "the last row must be 0 0 0 1: projections are not supported");
    memcpy(a.m, m, sizeof a.m);
    return a;
}

static void read_list(lf_reader *reader, const lf_node *list, lf_instances_desc *out)
{
    size_t n = json_array_size(list->value);
    if (n == 0) {
        lf_read_fail(reader, list, "the list is empty; remove \"instances\" to show the mesh once");
        return;
    }
    out->map = lf_calloc(n, sizeof *out->map);
    if (!out->map) {
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
        return;
    }
    for (size_t i = 0; i < n && reader->status == LF_OK; i++) {
        lf_node item = lf_node_item(list, i);
        out->map[i] =
            json_is_array(item.value) ? parse_rows(reader, &item) : parse_map(reader, &item);
        lf_refuse_flat(reader, &item, &out->map[i]);
    }
    out->n = (int)n;
}

void lf_read_instances(lf_reader *reader, const lf_node *node, lf_instances_desc *out)
{
    static const char *const endings[] = {"npy", "csv", NULL};
    lf_node list = lf_node_child(node, "instances");
    if (reader->status != LF_OK || !list.value)
        return;
    if (json_is_array(list.value))
        read_list(reader, &list, out);
    else
        out->file = lf_read_file(reader, node, "instances", endings);
}
