/* Deferred work of suffixes in lanes, for full groups of lanes: shadow rays that draw from a sky
 * image, and paths that have left the scene; private to suffix_lanes.h. */
#ifndef LF_RENDER_SUFFIX_SKY_LANES_H
#define LF_RENDER_SUFFIX_SKY_LANES_H

#include "render/transport/lanes/sky_lanes.h"
#include "render/transport/lanes/suffix.h"

/* Probability that a vertex draws from the image. Both MIS strategies for its light use it. */
#define PICTURE_SHARE 0.5f

/* lf_phase_between directions, from the squared distance of their end points (g < 0: one direction
 * reversed). */
LF_INLINE lanes phase_at(float g, lanes square)
{
    const float a = fabsf(g), numerator = LF_INV_4PI * (1.0f - a) * (1.0f + a);
    lanes d = most((1.0f - a) * (1.0f - a) + a * square, all(1e-12f));
    return numerator / (d * root(d));
}

/* lf_phase_between the directions of travel and another direction. */
LF_INLINE lanes phase_between(float g, const lanes w[3], const lanes towards[3])
{
    const float sign = copysignf(1.0f, g);
    lanes square = all(0.0f);
    for (int i = 0; i < 3; i++) {
        lanes c = w[i] - sign * towards[i];
        square = square + c * c;
    }
    return phase_at(g, square);
}

/* MIS weights, against scattering, of a group of shadow rays that draw from the image towards w. */
LF_INLINE void aim_group(const lf_lane_scene *scene, lf_lane_memory *memory, int first,
                         const lanes w[3])
{
    const lanes_int draws = load_int(memory->draws + first);
    const lanes came[3] = {load(memory->w[0] + first), load(memory->w[1] + first),
                           load(memory->w[2] + first)};
    lanes radiance[3], pdf = picture_along(&scene->picture, w, radiance),
                       phase = phase_between(scene->g, came, w),
                       weight = phase / (PICTURE_SHARE * pdf + phase);
    weight = choose(is_less(all(0.0f), pdf), weight, all(0.0f));
    for (int k = 0; k < LF_WIDTH; k++)
        for (int i = 0; i < 3 && draws[k]; i++) {
            memory->shadow_ray[first + k].weight[i] *= weight[k] * (radiance[i][k] + scene->sky[i]);
            memory->w[i][first + k] = w[i][k];
        }
}

/* Draws directions from the image for the shadow rays that need one. */
LF_INLINE void aim(const lf_lane_scene *scene, lf_lane_memory *memory)
{
    const int words = (int)(sizeof *memory->shadow_ray / sizeof(float));
    const uint32_t *key = memory->shadow_ray->random;
    const mask every = mask_of((1u << LF_WIDTH) - 1);
    for (int first = 0; first < memory->n; first += LF_GROUPS * LF_WIDTH) {
        lanes u[LF_GROUPS], v[LF_GROUPS], w[LF_GROUPS][3];
        for (int g = 0; g < LF_GROUPS; g++) {
            const lanes_int at = (count_up() + (first + g * LF_WIDTH)) * words;
            lanes_random random = {0};
            begin_random(&random, every, ~(lanes_bits)gather_int(key, at),
                         (lanes_bits)gather_int(key + 1, at));
            u[g] = draw_unit(&random, every);
            v[g] = draw_unit(&random, every);
        }
        draw_from_picture(&scene->picture, u, v, w);
        for (int g = 0; g < LF_GROUPS; g++)
            aim_group(scene, memory, first + g * LF_WIDTH, w[g]);
    }
}

/* Light of escaping paths, weighted against light sampling; own is their pdf. */
LF_INLINE void find_group(const lf_lane_scene *scene, const lanes w[3], lanes own, lanes out[3],
                          unsigned has)
{
    lanes weight = all(1.0f), pdf;
    for (int i = 0; i < 3; i++)
        out[i] = all(0.0f);
    if (has & LF_LANE_PICTURE) {
        pdf = picture_along(&scene->picture, w, out);
        weight = own / (own + PICTURE_SHARE * pdf);
    }
    for (int i = 0; i < 3; i++)
        out[i] = (out[i] + scene->sky[i]) * weight;
    if (has & LF_LANE_DISK) {
        lanes share = disk_along(scene, w);
        pdf = share * (1.0f / scene->disk.solid_angle);
        share = share * own / (own + pdf);
        for (int i = 0; i < 3; i++)
            out[i] = out[i] + share * scene->disk.radiance[i];
    }
}

LF_INLINE void find(const lf_lane_scene *scene, const lf_lane_paths *paths, lf_lane_memory *memory,
                    unsigned has)
{
    const int words = (int)(sizeof *memory->exit / sizeof(float));
    for (int first = 0; first < memory->n_unscattered; first += LF_WIDTH) {
        const lf_lane_exit *way = memory->exit;
        const lanes_int at = (count_up() + first) * words;
        lanes w[3], found[3];
        for (int i = 0; i < 3; i++)
            w[i] = gather(way->w + i, at);
        find_group(scene, w, gather(&way->pdf, at), found, has);
        const int rest = memory->n_unscattered - first, n = rest < LF_WIDTH ? rest : LF_WIDTH;
        for (int k = 0; k < n; k++)
            for (int i = 0; i < 3; i++)
                paths->lit[i][way[first + k].job] += way[first + k].beta[i] * found[i][k];
    }
    memory->n_unscattered = 0;
}

#endif
