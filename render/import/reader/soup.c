#include "render/import/reader/soup.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/sandbox/reader.h"
#include "render/import/reader/input.h"

static lf_status no_room(lf_error *err)
{
    return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
}

void lf_soup_finish(lf_soup *soup)
{
    free(soup->points);
    free(soup->normals);
    free(soup->corners);
    free(soup->normals_of);
    free(soup->uvs.values);
    free(soup->uvs.of);
    free(soup->colours.values);
    for (size_t i = 0; i < soup->n_maps; i++)
        lf_map_finish(&soup->maps[i]);
    free(soup->maps);
    free(soup->choices);
    free(soup->parts);
    for (size_t i = 0; i < soup->n_sources; i++)
        lf_free(soup->source[i].name);
    free(soup->source);
    lf_warnings_finish(&soup->warnings);
    *soup = (lf_soup){0};
}

void lf_leave_out(lf_left_out *list, const char *name, size_t n)
{
    char one[40];
    size_t length = 0, at = strlen(list->names);
    for (; length < n && length + 1 < sizeof one; length++)
        one[length] = name[length] >= ' ' && name[length] <= '~' ? name[length] : '?';
    one[length] = '\0';
    for (const char *found = list->names; length > 0 && (found = strstr(found, one)); found++)
        if ((found == list->names || found[-1] == ' ') &&
            (found[length] == ',' || found[length] == '\0'))
            return;
    /* keeps room for the final dots */
    if (length == 0 || at + 2 + length + sizeof ", ..." > sizeof list->names) {
        if (length > 0 && (at < 3 || strcmp(list->names + at - 3, "...") != 0))
            memcpy(list->names + at, at ? ", ..." : "...", at ? sizeof ", ..." : sizeof "...");
        return;
    }
    snprintf(list->names + at, sizeof list->names - at, "%s%s", at ? ", " : "", one);
}

void lf_left_out_warn(const lf_left_out *list, const char *what, lf_warnings *warnings)
{
    if (list->names[0])
        lf_warnings_add(warnings, LF_HERE, "%s: %s", what, list->names);
}

lf_status lf_soup_point(lf_soup *soup, const double at[3], lf_error *err)
{
    if (soup->n_points >= 3 * (size_t)LF_MAX_TRIANGLES)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "the file has more than %d points",
                            3 * LF_MAX_TRIANGLES);
    if (!lf_grow(&soup->points, &soup->points_room, soup->n_points + 1, 3 * sizeof *soup->points))
        return no_room(err);
    memcpy(soup->points + 3 * soup->n_points++, at, 3 * sizeof *at);
    return LF_OK;
}

lf_status lf_soup_normal(lf_soup *soup, const float normal[3], lf_error *err)
{
    if (soup->n_normals >= 3 * (size_t)LF_MAX_TRIANGLES)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "the file has more than %d normals",
                            3 * LF_MAX_TRIANGLES);
    if (!lf_grow(&soup->normals, &soup->normals_room, soup->n_normals + 1,
                 3 * sizeof *soup->normals))
        return no_room(err);
    memcpy(soup->normals + 3 * soup->n_normals++, normal, 3 * sizeof *normal);
    return LF_OK;
}

lf_status lf_soup_uv(lf_soup *soup, const double uv[2], lf_error *err)
{
    if (soup->uvs.n >= 3 * (size_t)LF_MAX_TRIANGLES)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE,
                            "the file has more than %d texture coordinates", 3 * LF_MAX_TRIANGLES);
    if (!lf_grow(&soup->uvs.values, &soup->uvs.room, soup->uvs.n + 1, 2 * sizeof *soup->uvs.values))
        return no_room(err);
    for (int i = 0; i < 2; i++)
        soup->uvs.values[2 * soup->uvs.n + (size_t)i] =
            fabs(uv[i]) <= (double)LF_MAX_UV ? (float)uv[i] : 0.0f;
    soup->uvs.n++;
    return LF_OK;
}

float lf_soup_light(double code)
{
    double c = code > 0 ? fmin(code, 1) : 0;
    return (float)(c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4));
}

lf_status lf_soup_colour(lf_soup *soup, const float rgba[4], lf_error *err)
{
    if (!lf_grow(&soup->colours.values, &soup->colours.room, soup->colours.n + 1,
                 4 * sizeof *soup->colours.values))
        return no_room(err);
    for (int i = 0; i < 4; i++)
        soup->colours.values[4 * soup->colours.n + (size_t)i] =
            rgba[i] > 0.0f ? fminf(rgba[i], 1.0f) : 0.0f;
    soup->colours.n++;
    return LF_OK;
}

/* choices are allocated when one of them is not 0 */
static bool put_choice(lf_soup *soup, unsigned choice)
{
    bool first = !soup->choices;
    if (first && choice == 0)
        return true;
    if (!lf_grow(&soup->choices, &soup->choices_room, soup->n_triangles + 1, sizeof(uint16_t)))
        return false;
    for (size_t i = 0; i < soup->n_triangles && first; i++)
        soup->choices[i] = 0;
    soup->choices[soup->n_triangles] = (uint16_t)choice;
    return true;
}

/* Numbers of texture coordinates are there once a triangle has some. */
static bool put_uvs(lf_soup *soup, const uint32_t *uvs)
{
    size_t at = 3 * soup->n_triangles;
    bool first = !soup->uvs.of;
    if (first && !uvs)
        return true;
    if (!lf_grow(&soup->uvs.of, &soup->uvs.of_room, at + 3, sizeof *uvs))
        return false;
    for (size_t i = first ? 0 : at; i < at + 3; i++)
        soup->uvs.of[i] = LF_NO_UV;
    if (uvs)
        memcpy(soup->uvs.of + at, uvs, 3 * sizeof *uvs);
    return true;
}

lf_status lf_soup_triangle(lf_soup *soup, const lf_soup_face *face, lf_error *err)
{
    size_t at = 3 * soup->n_triangles;
    if (soup->n_triangles >= LF_MAX_TRIANGLES)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "the file has more than %d triangles",
                            LF_MAX_TRIANGLES);
    if (!lf_grow(&soup->corners, &soup->corners_room, at + 3, sizeof *soup->corners) ||
        (face->normals &&
         !lf_grow(&soup->normals_of, &soup->normals_of_room, at + 3, sizeof *soup->normals_of)) ||
        !put_uvs(soup, face->uvs) || !put_choice(soup, face->choice))
        return no_room(err);
    memcpy(soup->corners + at, face->corners, 3 * sizeof *face->corners);
    if (face->normals)
        memcpy(soup->normals_of + at, face->normals, 3 * sizeof *face->normals);
    soup->n_triangles++;
    return LF_OK;
}

lf_status lf_soup_part(lf_soup *soup, lf_error *err)
{
    if (soup->n_parts > 0 && soup->parts[soup->n_parts - 1] == soup->n_triangles)
        return LF_OK;
    if (!lf_grow(&soup->parts, &soup->parts_room, soup->n_parts + 1, sizeof *soup->parts))
        return no_room(err);
    soup->parts[soup->n_parts++] = (uint32_t)soup->n_triangles;
    return LF_OK;
}

lf_status lf_soup_map(lf_soup *soup, lf_map map, lf_error *err)
{
    size_t at = soup->n_maps;
    while (at > 0 &&
           !(soup->maps[at - 1].source == map.source && soup->maps[at - 1].use == map.use))
        at--;
    if (at > 0) {
        lf_map_finish(&soup->maps[at - 1]);
        soup->maps[at - 1] = map;
        return LF_OK;
    }
    if (!lf_grow(&soup->maps, &soup->maps_room, soup->n_maps + 1, sizeof map)) {
        lf_map_finish(&map);
        return no_room(err);
    }
    soup->maps[soup->n_maps++] = map;
    return LF_OK;
}

lf_status lf_soup_say(lf_soup *soup, lf_source_material source, lf_error *err)
{
    lf_status status = LF_OK;
    if (soup->n_sources >= LF_MAX_MATERIALS)
        status = lf_error_set(err, LF_E_FORMAT, LF_HERE, "the file has more than %d materials",
                              LF_MAX_MATERIALS);
    else if (!source.name ||
             !lf_grow(&soup->source, &soup->source_room, soup->n_sources + 1, sizeof source))
        status = no_room(err);
    if (status == LF_OK)
        soup->source[soup->n_sources++] = source;
    else
        lf_free(source.name);
    return status;
}
