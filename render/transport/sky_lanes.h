/* A picture of the sky in lanes: what light_environment.c draws and looks up for one direction,
 * from its tables; private to the suffix_*.c. */
#ifndef LF_RENDER_SKY_LANES_H
#define LF_RENDER_SKY_LANES_H

#include "render/transport/lane_scene.h"
#include "render/transport/lanes.h"

/* In the picture's frame, in texels: column and row. */
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

/* lf_environment_escape: radiance along unit directions; returns the pdf with which
 * draw_from_picture draws them. */
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

/* lf_cdf_find among the n entries from cdf[first] on; u becomes the place in the entry. */
LF_INLINE lanes_int entry_of(const float *cdf, lanes_int first, int n, lanes *u)
{
    for (int half; n > 1; n -= half) {
        half = n / 2;
        mask above = is_at_most(gather(cdf, first + half), *u);
        first = choose_int(above, first + half, first);
    }
    lanes from = gather(cdf, first), to = gather(cdf, first + 1);
    *u = least((*u - from) / (to - from), all(0x1.fffffep-1f));
    return first;
}

/* sin^2 of half the angle between the pole and the edge of a row that is so many away from it. */
LF_INLINE lanes edge_of(const lf_lane_picture *picture, lanes rows)
{
    lanes s = sine_of_part(rows * (0.25f / (float)picture->height));
    return s * s;
}

/* lf_environment_draw: a direction by two numbers in [0, 1). */
LF_INLINE void draw_from_picture(const lf_lane_picture *picture, lanes u, lanes v, lanes w[3])
{
    lanes_int row = entry_of(picture->marginal, all_int(0), picture->height, &u),
              line = row * (picture->width + 1),
              column = entry_of(picture->conditional, line, picture->width, &v) - line;
    lanes y = to_float(row), other = (float)(picture->height - 1) - y;
    mask upper = is_less(2.0f * y, all((float)picture->height));
    lanes from_pole = choose(upper, y, other);
    lanes h = between(edge_of(picture, from_pole), edge_of(picture, from_pole + 1.0f), u);
    lanes sine = 2.0f * root(most(h * (1.0f - h), all(0.0f))), cosine = 1.0f - 2.0f * h, s, c;
    sine_cosine(least((to_float(column) + v) * (1.0f / (float)picture->width), all(0x1.fffffep-1f)),
                &s, &c);
    const lanes own[3] = {sine * c, choose(upper, cosine, -cosine), sine * s};
    const float(*m)[3] = picture->to_picture;
    for (int i = 0; i < 3; i++)
        w[i] = m[0][i] * own[0] + m[1][i] * own[1] + m[2][i] * own[2];
}

#endif
