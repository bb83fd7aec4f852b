/* A sky image in lanes: sampling and look-up of light_environment.c, with its tables; private to
 * the suffix_*.c. */
#ifndef LF_RENDER_SKY_LANES_H
#define LF_RENDER_SKY_LANES_H

#include "render/transport/lanes/lane_scene.h"
#include "render/transport/lanes/lanes.h"

/* Coordinates in the image, in texels: column and row. */
LF_INLINE void texel_of(const lf_lane_picture *picture, const lanes w[3], lanes *x, lanes *y)
{
    const float(*m)[3] = picture->to_picture;
    lanes v[3];
    for (int i = 0; i < 3; i++)
        v[i] = m[i][0] * w[0] + m[i][1] * w[1] + m[i][2] * w[2];
    lanes turn = turn_of(magnitude(v[2]), v[0]);
    turn = choose(is_less(v[2], all(0.0f)), 1.0f - turn, turn);
    *x = turn * (float)picture->width;
    *y = turn_of(root(v[0] * v[0] + v[2] * v[2]), v[1]) * (2.0f * (float)picture->height);
}

/* lf_environment_escape: radiance along unit directions. Returns the pdf of draw_from_picture. */
LF_INLINE lanes picture_along(const lf_lane_picture *picture, const lanes w[3], lanes radiance[3])
{
    const lanes right = all((float)(picture->width - 1)),
                bottom = all((float)(picture->height - 1));
    lanes x, y;
    texel_of(picture, w, &x, &y);
    lanes_int texel = to_int(least(y, bottom)) * picture->width + to_int(least(x, right));
    x = x - 0.5f;
    x = choose(is_less(x, all(0.0f)), x + (float)picture->width, x);
    y = most(y - 0.5f, all(0.0f));
    lanes_int column = to_int(least(x, right)), row = to_int(least(y, bottom));
    lanes across = x - to_float(column), down = y - to_float(row);
    mask last = is_at_most(right, to_float(column)), lowest = is_at_most(bottom, to_float(row));
    lanes_int beside = choose_int(last, all_int(1 - picture->width), all_int(1)) * 3,
              below = choose_int(lowest, all_int(0), all_int(picture->width)) * 3,
              at = (row * picture->width + column) * 3;
    for (int i = 0; i < 3; i++) {
        const float *rgb = picture->rgb + i;
        lanes upper = between(gather(rgb, at), gather(rgb, at + beside), across),
              lower = between(gather(rgb, at + below), gather(rgb, at + below + beside), across);
        radiance[i] = most(between(upper, lower, down), all(0.0f)) * picture->factor[i];
    }
    return gather(picture->pdf, texel);
}

/* Groups of lanes that are drawn together, because a search waits for memory at each step. */
enum { LF_GROUPS = 4 };

/* lf_cdf_find among the n entries from cdf[first] on; u becomes the position within the entry. */
LF_INLINE void entries_of(const float *cdf, int n, lanes_int first[LF_GROUPS], lanes u[LF_GROUPS])
{
    for (int half; n > 1; n -= half) {
        half = n / 2;
        for (int g = 0; g < LF_GROUPS; g++) {
            mask above = is_at_most(gather(cdf, first[g] + half), u[g]);
            first[g] = choose_int(above, first[g] + half, first[g]);
        }
    }
    for (int g = 0; g < LF_GROUPS; g++) {
        lanes from = gather(cdf, first[g]), to = gather(cdf, first[g] + 1);
        u[g] = least((u[g] - from) / (to - from), all(0x1.fffffep-1f));
    }
}

/* sin^2 of half the angle between the pole and the edge of a row that is `rows` rows away from it.
 */
LF_INLINE lanes edge_of(const lf_lane_picture *picture, lanes rows)
{
    lanes s = sine_of_part(rows * (0.25f / (float)picture->height));
    return s * s;
}

/* Converts texel positions to scene directions. */
LF_INLINE void direction_of(const lf_lane_picture *picture, lanes_int row, lanes_int column,
                            lanes down, lanes across, lanes w[3])
{
    lanes y = to_float(row), other = (float)(picture->height - 1) - y, s, c;
    mask upper = is_less(2.0f * y, all((float)picture->height));
    lanes from_pole = choose(upper, y, other);
    lanes h = between(edge_of(picture, from_pole), edge_of(picture, from_pole + 1.0f), down);
    lanes sine = 2.0f * root(most(h * (1.0f - h), all(0.0f))), cosine = 1.0f - 2.0f * h;
    sine_cosine(
        least((to_float(column) + across) * (1.0f / (float)picture->width), all(0x1.fffffep-1f)),
        &s, &c);
    const lanes own[3] = {sine * c, choose(upper, cosine, -cosine), sine * s};
    const float(*m)[3] = picture->to_picture;
    for (int i = 0; i < 3; i++)
        w[i] = m[0][i] * own[0] + m[1][i] * own[1] + m[2][i] * own[2];
}

/* lf_environment_draw: directions from two numbers in [0, 1) each. */
LF_INLINE void draw_from_picture(const lf_lane_picture *picture, lanes u[LF_GROUPS],
                                 lanes v[LF_GROUPS], lanes w[LF_GROUPS][3])
{
    lanes_int row[LF_GROUPS], column[LF_GROUPS];
    for (int g = 0; g < LF_GROUPS; g++)
        row[g] = all_int(0);
    entries_of(picture->marginal, picture->height, row, u);
    for (int g = 0; g < LF_GROUPS; g++)
        column[g] = row[g] * (picture->width + 1);
    entries_of(picture->conditional, picture->width, column, v);
    for (int g = 0; g < LF_GROUPS; g++)
        direction_of(picture, row[g], column[g] - row[g] * (picture->width + 1), u[g], v[g], w[g]);
}

/* Unit directions uniform over the disk, in the scene, from two numbers in [0, 1). */
LF_INLINE void draw_from_disk(const lf_lane_scene *scene, lanes u, lanes v, lanes w[3])
{
    const lf_lane_disk *disk = &scene->disk;
    lanes versine = u * disk->versine, s, c;
    lanes sine = root(versine * (2.0f - versine)), cosine = 1.0f - versine;
    sine_cosine(v, &s, &c);
    for (int i = 0; i < 3; i++)
        w[i] = disk->side[0][i] * (sine * c) + disk->side[1][i] * (sine * s) +
               scene->toward[i] * cosine;
}

/* Fraction of the disk's radiance along unit directions. */
LF_INLINE lanes disk_along(const lf_lane_scene *scene, const lanes w[3])
{
    const float *n = scene->toward;
    const lanes d[3] = {w[0] - n[0], w[1] - n[1], w[2] - n[2]};
    const lanes x = d[1] * n[2] - d[2] * n[1], y = d[2] * n[0] - d[0] * n[2],
                z = d[0] * n[1] - d[1] * n[0];
    lanes cosine = w[0] * n[0] + w[1] * n[1] + w[2] * n[2],
          versine = (x * x + y * y + z * z) / (1.0f + most(cosine, all(0.0f)));
    lanes share = 0.5f + (scene->disk.versine - versine) * scene->disk.inverse_ramp;
    share = least(most(share, all(0.0f)), all(1.0f));
    return choose(is_less(all(0.0f), cosine), share, all(0.0f));
}

#endif
