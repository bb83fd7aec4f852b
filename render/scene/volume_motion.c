#include "render/scene/scene.h"

static lf_affine map_at(const lf_volume_motion *motion, double time)
{
    lf_affine map;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            map.m[i][j] =
                motion->open.m[i][j] + time * (motion->close.m[i][j] - motion->open.m[i][j]);
    return map;
}

bool lf_volume_motion_is_sound(const lf_volume_motion *motion)
{
    enum { STEPS = 64 };
    const double least = 1e-3, ends[2] = {lf_affine_determinant(&motion->open),
                                          lf_affine_determinant(&motion->close)};
    bool sound = true;
    for (int i = 0; i <= STEPS; i++) {
        lf_affine map = map_at(motion, (double)i / STEPS), inverse;
        sound = sound && lf_affine_invert(&map, &inverse) &&
                copysign(1.0, ends[0]) * lf_affine_determinant(&map) >=
                    least * fmin(fabs(ends[0]), fabs(ends[1]));
    }
    return sound;
}

void lf_volume_move(lf_volume *volume, float time)
{
    const lf_grid_steps *steps = volume->steps;
    if (steps) {
        int step = (int)(time * (float)steps->n);
        volume->grid = steps->grid[step < steps->n ? step : steps->n - 1];
    }
    if (!volume->motion)
        return;
    lf_affine map = map_at(volume->motion, (double)time), inverse = map;
    (void)lf_affine_invert(&map, &inverse); /* valid motions have an inverse */
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            volume->to_scene[i][j] = (float)map.m[i][j];
            volume->to_volume[i][j] = (float)inverse.m[i][j];
        }
}
