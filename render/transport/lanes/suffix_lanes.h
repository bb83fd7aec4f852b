/* The algorithm of suffix.h over the lanes of the including file (suffix_*.c): a state machine in
 * which each lane is a path. A lane steps from brick to brick, looks up the grid at a tentative
 * collision, or is shaded (scatters, ends, starts the next job). The operation that most lanes wait
 * for is done for all of them at once. Each lane has its own random numbers and sums, so results do
 * not depend on the other lanes.
 *
 * `has` is the scene's, a constant in the inlined code: code for one scene contains nothing for
 * features that the scene lacks. */
#ifndef LF_RENDER_SUFFIX_LANES_H
#define LF_RENDER_SUFFIX_LANES_H

#include "render/transport/lanes/lanes.h"
#include "render/transport/lanes/suffix_sky_lanes.h"
#include "render/transport/lanes/suffix_surface_lanes.h"

/* Number of waiting lanes that is enough for an operation. */
enum { ENOUGH = LF_WIDTH / 2 };
/* Groups of lanes that alternate. While one waits for its gathers, or after a mispredicted branch,
 * the other continues (1.2 times as fast; three or four are no better). */
enum { TEAMS = 2 };

/* -------------------------------------------------------------------------- through the grid -- */

/* Rays through the bricks (track.c's lf_walk). */
typedef struct walk {
    lanes q[3], d[3]; /* volume space: q + t d */
    lanes t, end, edge;
    lanes depth;    /* remaining optical distance to the next tentative collision */
    lanes majorant; /* of the current brick, which ends at `edge` */
    lanes next[3], across[3];
    lanes corner[3], step[3]; /* of the current brick, voxels */
    lanes_int brick, stride[3];
} walk;

/* The operation that each lane waits for; idle lanes have no job left. */
typedef struct turns {
    mask step, look, shade, idle;
} turns;

typedef enum turn { STEP, LOOK, SHADE, END } turn;

LF_INLINE turn choose_turn(const turns *w)
{
    int steps = count_of(w->step), looks = count_of(w->look),
        shades = count_of(without(w->shade, w->idle));
    if (steps >= ENOUGH || (steps > 0 && steps >= looks && shades < ENOUGH))
        return STEP;
    if (looks > 0 && (looks >= ENOUGH || shades < ENOUGH))
        return LOOK;
    return shades > 0 ? SHADE : END;
}

/* Enters the brick along one axis. */
LF_INLINE void enter_axis(walk *k, const lf_lane_scene *scene, int i, mask m, lanes d, lanes *end)
{
    const int32_t strides[3] = {1, scene->field->framed[0],
                                scene->field->framed[0] * scene->field->framed[1]};
    lanes inverse = inverse_of(d);
    mask up = is_less(all(0.0f), inverse);
    *end = least(*end, (choose(up, all(scene->size[i]), all(-1.0f)) - k->q[i]) * inverse);
    lanes last = all((float)(scene->field->framed[i] - 3));
    lanes at = least(most((k->q[i] + 1.0f) * (1.0f / LF_BRICK), all(0.0f)), last);
    lanes_int brick = to_int(at);
    lanes corner = to_float(brick * LF_BRICK - 1);
    lanes face = corner + choose(up, all(LF_BRICK), all(0.0f));
    k->d[i] = choose(m, d, k->d[i]);
    k->next[i] = choose(m, (face - k->q[i]) * inverse, k->next[i]);
    k->across[i] = choose(m, magnitude(inverse) * (float)LF_BRICK, k->across[i]);
    k->corner[i] = choose(m, corner, k->corner[i]);
    k->step[i] = choose(m, choose(up, all(LF_BRICK), all(-LF_BRICK)), k->step[i]);
    k->stride[i] =
        choose_int(m, choose_int(up, all_int(strides[i]), all_int(-strides[i])), k->stride[i]);
    k->brick = choose_int(m, (brick + 1) * strides[i] + (i > 0 ? k->brick : all_int(0)), k->brick);
}

LF_INLINE lanes nearest_edge(const walk *k)
{
    return least(least(k->next[0], k->next[1]), least(k->next[2], k->end));
}

/* Starts rays from q along the scene's unit vector w in the lanes of m. */
LF_INLINE void begin_walk(walk *k, const lf_lane_scene *scene, mask m, const lanes w[3],
                          lanes_random *random)
{
    lanes end = all(INFINITY);
    for (int i = 0; i < 3; i++)
        enter_axis(k, scene, i, m, along_axis(scene, i, w), &end);
    k->t = choose(m, all(0.0f), k->t);
    k->end = choose(m, end, k->end);
    k->edge = choose(m, most(all(0.0f), nearest_edge(k)), k->edge);
    k->majorant = gather(scene->field->majorant, k->brick);
    k->depth = choose(m, draw_exponential(random, m), k->depth);
}

/* One step of the waiting lanes: to a tentative collision, to the next brick, or out. */
LF_INLINE void step(walk *k, const lf_lane_scene *scene, turns *w)
{
    lanes room = k->majorant * (k->edge - k->t);
    mask hit = both(w->step, is_less(k->depth, room)), on = without(w->step, hit);
    k->t = choose(hit, k->t + k->depth / k->majorant, choose(on, k->edge, k->t));
    k->depth = choose(on, k->depth - room, k->depth);
    mask out = both(on, is_at_most(k->end, k->edge));
    on = without(on, out);
    for (int i = 0; i < 3; i++) {
        mask m = both(on, is_at_most(k->next[i], k->edge));
        k->brick = choose_int(m, k->brick + k->stride[i], k->brick);
        k->corner[i] = choose(m, k->corner[i] + k->step[i], k->corner[i]);
        k->next[i] = choose(m, k->next[i] + k->across[i], k->next[i]);
    }
    k->edge = most(k->t, nearest_edge(k));
    k->majorant = gather(scene->field->majorant, k->brick);
    w->look = either(w->look, hit);
    w->shade = either(w->shade, out);
    w->step = on;
}

/* Decodes two neighbouring 16-bit values and interpolates between them. */
typedef lanes between_fn(lanes_int pair, lanes f);

/* Interpolates four neighbouring pairs in a box of nodes. */
LF_INLINE lanes look_up_box(const uint16_t *values, lanes_int at, int row, int layer,
                            const lanes part[3], between_fn pair)
{
    lanes a = pair(gather_pairs(values, at), part[0]),
          b = pair(gather_pairs(values, at + row), part[0]),
          c = pair(gather_pairs(values, at + layer), part[0]),
          d = pair(gather_pairs(values, at + (layer + row)), part[0]);
    return between(between(a, b, part[1]), between(c, d, part[1]), part[2]);
}

/* sigma_t over the brick's majorant at the rays' positions. */
LF_INLINE lanes look_up(const walk *k, const lf_lane_scene *scene)
{
    lanes part[3];
    lanes_int cell[3];
    for (int i = 0; i < 3; i++) {
        lanes x = k->q[i] + k->t * k->d[i] - k->corner[i];
        x = least(most(x, all(0.0f)), all(LF_BRICK));
        cell[i] = to_int(least(x, all(LF_BRICK - 1)));
        part[i] = x - to_float(cell[i]);
    }
    const int row = LF_BRICK_VALUES, layer = row * row;
    lanes_int at =
        gather_int(scene->field->first, k->brick) + cell[2] * layer + cell[1] * row + cell[0];
    if (scene->field->values)
        return look_up_box(scene->field->values, at, row, layer, part, between_pair) *
               (1.0f / 65535.0f);
    /* divided while the values are being loaded */
    return look_up_box(scene->field->shorts, at, row, layer, part, between_shorts) *
           (scene->field->scale / k->majorant);
}

/* The control at points of volume space. */
LF_INLINE lanes control_at(const lf_lane_field *field, const lanes q[3])
{
    lanes part[3];
    lanes_int node[3];
    for (int i = 0; i < 3; i++) {
        const float *row = field->to_nodes[i];
        lanes x = row[0] * q[0] + row[1] * q[1] + row[2] * q[2] + row[3],
              last = all((float)(field->nodes[i] - 1));
        x = least(most(x, all(0.0f)), last);
        node[i] = to_int(least(x, last - 1.0f));
        part[i] = x - to_float(node[i]);
    }
    const int along = field->nodes[2], layer = along * field->nodes[0];
    const lanes order[3] = {part[2], part[0], part[1]};
    return look_up_box(field->left, node[1] * layer + node[0] * along + node[2], along, layer,
                       order, between_pair) *
           (1.0f / 65535.0f);
}

/* -------------------------------------------------------------------------------------- jobs -- */

/* Gives the next jobs to the lanes of `free`; returns the lanes that got one. The others become
 * idle. */
LF_INLINE mask fetch(mask free, int n, int *next, lanes_int *job, turns *w)
{
    unsigned got = 0;
    for (unsigned b = bits_of(free); b && *next < n; b &= b - 1) {
        int k = __builtin_ctz(b);
        (*job)[k] = (*next)++;
        got |= 1u << k;
    }
    w->idle = either(w->idle, without(free, mask_of(got)));
    return mask_of(got);
}

/* ------------------------------------------------------------------------------- shadow rays -- */

/* Ratio tracking of the shadow rays, with roulette below 1/10, as in track.c. */
typedef struct shadow {
    walk k;
    lanes left;
    lanes_int job;
    lanes_random random;
    turns w;
    mask fresh; /* lanes that have not had a job yet */
} shadow;

LF_INLINE void ratio(shadow *s, const lf_lane_scene *scene)
{
    const mask m = s->w.look;
    lanes left = s->left * most(all(0.0f), 1.0f - look_up(&s->k, scene));
    mask low = both(m, is_less(left, all(0.1f))), ended = mask_of(0);
    if (bits_of(low)) {
        ended = both(low, is_at_most(all(0.5f), draw_unit(&s->random, low)));
        left = choose(low, left * 2.0f, left);
        left = choose(ended, all(0.0f), left);
    }
    s->left = choose(m, left, s->left);
    s->k.depth = choose(m, draw_exponential(&s->random, m), s->k.depth);
    s->w.shade = either(s->w.shade, ended);
    s->w.step = either(s->w.step, without(m, ended));
    s->w.look = mask_of(0);
}

LF_INLINE void next_shadow_rays(shadow *s, const lf_lane_scene *scene, lf_lane_memory *memory,
                                int *next, unsigned has)
{
    lanes toward[3] = {all(scene->toward[0]), all(scene->toward[1]), all(scene->toward[2])};
    const int words = (int)(sizeof *memory->shadow_ray / sizeof(float));
    mask ended = without(s->w.shade, s->w.idle);
    for (unsigned b = bits_of(without(ended, s->fresh)); b; b &= b - 1) {
        int k = __builtin_ctz(b);
        memory->left[s->job[k]] = s->left[k];
    }
    mask m = fetch(ended, memory->n, next, &s->job, &s->w);
    s->fresh = without(s->fresh, m);
    lanes_int at = s->job * words;
    for (int i = 0; i < 3; i++)
        s->k.q[i] = choose(m, gather(memory->shadow_ray->q + i, at), s->k.q[i]);
    for (int i = 0; i < 3 && has & LF_LANE_SKY; i++)
        toward[i] = gather(memory->w[i], s->job);
    begin_random(&s->random, m, (lanes_bits)gather_int(&memory->shadow_ray->random[0], at),
                 (lanes_bits)gather_int(&memory->shadow_ray->random[1], at));
    s->left = choose(m, all(1.0f), s->left);
    begin_walk(&s->k, scene, m, toward, &s->random);
    s->w.step = either(s->w.step, m);
    s->w.shade = s->w.idle;
}

/* Sets memory->left of all shadow rays. */
LF_INLINE int64_t trace_shadow_rays(const lf_lane_scene *scene, lf_lane_memory *memory,
                                    unsigned has)
{
    const mask every = mask_of((1u << LF_WIDTH) - 1);
    shadow team[TEAMS];
    int64_t lookups = 0;
    int next = 0;
    for (int g = 0; g < TEAMS; g++)
        team[g] = (shadow){.w = {.shade = every}, .fresh = every};
    for (int ended = 0; ended < TEAMS;) {
        ended = 0;
        for (int g = 0; g < TEAMS; g++) {
            shadow *s = &team[g];
            switch (choose_turn(&s->w)) {
            case STEP:
                step(&s->k, scene, &s->w);
                break;
            case LOOK:
                lookups += count_of(s->w.look);
                ratio(s, scene);
                break;
            case SHADE:
                next_shadow_rays(s, scene, memory, &next, has);
                break;
            case END:
                ended++;
            }
        }
    }
    if (has & LF_LANE_SURFACES)
        pass_surfaces(scene, memory, has);
    return lookups;
}

/* Probability that a vertex traces its shadow ray, and the control there. share: how much of the
 * light the vertex scatters, 1 = isotropic with albedo 1. The probability is proportional to the
 * share of the estimate of T in the suffix's standard deviation. This is the root of T(1 - T), plus
 * the possible error of the control where it is 0 or 1, which is large at sharp edges. If the
 * probability is below 1, a ray then adds 2.1 at most, for any share. */
LF_INLINE lanes chance(const lf_lane_scene *scene, const lanes q[3], lanes share, lanes *expected)
{
    if (!scene->field->left) {
        *expected = all(0.0f);
        return all(1.0f);
    }
    lanes t = *expected = control_at(scene->field, q);
    return most(least(2.0f * share * root(t * (1.0f - t) + 0.06f), all(1.0f)), all(0.05f));
}

/* ------------------------------------------------------------------------------------- paths -- */

typedef struct path {
    walk k;
    lanes w[3], beta[3], radiance[3];
    lanes vertex; /* number of the last vertex; the pivot is 1 */
    lanes pdf;    /* of the direction from there; for images */
    lanes_int job;
    lanes_random random;
    turns t;
    mask collided; /* among lanes that wait for shading; the others have left the grid */
    mask fresh;    /* lanes that have not had a job yet */
} path;

LF_INLINE void look(path *p, const lf_lane_scene *scene)
{
    const mask m = p->t.look;
    lanes share = look_up(&p->k, scene);
    mask met = both(m, is_less(draw_unit(&p->random, m), share));
    p->k.depth = choose(m, draw_exponential(&p->random, m), p->k.depth);
    p->collided = either(p->collided, met);
    p->t.shade = either(p->t.shade, met);
    p->t.step = either(p->t.step, without(m, met));
    p->t.look = mask_of(0);
}

/* Stores paths of m that have left the scene, so that their light at infinity is looked up for many
 * at once. Light found directly from the pivot is the caller's. */
LF_INLINE void leave(const path *p, mask m, lf_lane_memory *memory)
{
    for (unsigned b = bits_of(both(m, is_less(all(1.0f), p->vertex))); b; b &= b - 1) {
        int k = __builtin_ctz(b);
        lf_lane_exit *way = &memory->exit[memory->n_unscattered++];
        for (int i = 0; i < 3; i++) {
            way->w[i] = p->w[i][k];
            way->beta[i] = p->beta[i][k];
        }
        way->pdf = p->pdf[k];
        way->job = p->job[k];
    }
}

/* Returns the lanes of m whose last segment met a surface. Their path ends there; the light from
 * the surface is computed one by one. */
LF_INLINE mask meet(path *p, const lf_lane_scene *scene, int max_depth, mask m,
                    const lf_lane_surfaces *surfaces)
{
    const lanes length = choose(p->collided, p->k.t, all(INFINITY));
    unsigned met = 0;
    m = both(m, may_meet(&scene->boxes, p->k.q, p->k.d, length));
    const lanes_bits low = draw(&p->random, m), high = draw(&p->random, m);
    for (unsigned b = bits_of(m); b; b &= b - 1) {
        const int k = __builtin_ctz(b);
        float found[3];
        lf_lane_segment segment = {.length = length[k],
                                   .depth = (int)p->vertex[k] + 1,
                                   .max_depth = max_depth,
                                   .random = {low[k], high[k]}};
        for (int i = 0; i < 3; i++) {
            segment.q[i] = p->k.q[i][k];
            segment.w[i] = p->w[i][k];
            segment.beta[i] = p->beta[i][k];
        }
        if (!surfaces->meet(surfaces->of, &segment, found))
            continue;
        met |= 1u << k;
        for (int i = 0; i < 3; i++)
            p->radiance[i][k] += found[i];
    }
    p->vertex = choose(mask_of(met), p->vertex + 1.0f, p->vertex);
    return mask_of(met);
}

/* Counts the throughput of the paths of m, which end here. */
LF_INLINE void cut_off(const path *p, mask m, lf_lane_memory *memory)
{
    const lanes largest = most(p->beta[0], most(p->beta[1], p->beta[2]));
    for (unsigned b = bits_of(m); b; b &= b - 1)
        memory->cut += (double)largest[__builtin_ctz(b)];
}

/* Moves collided lanes to their vertex and adds the sky to lanes that left. Returns the lanes whose
 * path has ended. */
LF_INLINE mask arrive(path *p, const lf_lane_scene *scene, int max_depth, mask shaded,
                      lf_lane_memory *memory, unsigned has)
{
    mask met = mask_of(0);
    if (has & LF_LANE_SURFACES)
        met = meet(p, scene, max_depth, without(shaded, p->fresh), &memory->surfaces);
    mask vertex = without(both(shaded, p->collided), met),
         left = without(shaded, either(either(vertex, met), p->fresh));
    lanes seen = choose(left, all(1.0f), all(0.0f));
    if (has & LF_LANE_SKY)
        leave(p, left, memory);
    for (int i = 0; i < 3; i++) {
        if (!(has & LF_LANE_SKY))
            p->radiance[i] = p->radiance[i] + p->beta[i] * (scene->sky[i] * seen);
        p->k.q[i] = choose(vertex, p->k.q[i] + p->k.t * p->k.d[i], p->k.q[i]);
    }
    p->vertex = choose(vertex, p->vertex + 1.0f, p->vertex);
    p->collided = without(p->collided, shaded);
    mask deep = both(vertex, is_less(all((float)max_depth), p->vertex));
    if (bits_of(deep))
        cut_off(p, deep, memory);
    return either(without(shaded, vertex), deep);
}

/* lf_path_survives for the lanes of m; returns the lanes that do not survive. */
LF_INLINE mask roulette(path *p, mask m)
{
    lanes largest = most(p->beta[0], most(p->beta[1], p->beta[2]));
    mask weak = both(m, is_less(largest, all(0.25f)));
    if (!bits_of(weak))
        return weak;
    mask ended = both(weak, is_at_most(largest, draw_unit(&p->random, weak) * 0.25f));
    lanes up = choose(without(weak, ended), 0.25f / largest, all(1.0f));
    for (int i = 0; i < 3; i++)
        p->beta[i] = p->beta[i] * up;
    return ended;
}

/* Stores the results of ended paths and starts others in their lanes, which are returned. */
LF_INLINE mask next_paths(path *p, const lf_lane_paths *paths, mask ended, int *next, unsigned has)
{
    for (unsigned b = bits_of(without(ended, p->fresh)); b; b &= b - 1) {
        int k = __builtin_ctz(b);
        for (int i = 0; i < 3; i++)
            paths->radiance[i][p->job[k]] = p->radiance[i][k];
        if (has & LF_LANE_SKY)
            paths->escaped[p->job[k]] = p->vertex[k] > 1.0f ? 0.0f : 1.0f;
    }
    mask m = fetch(ended, paths->n, next, &p->job, &p->t);
    p->fresh = without(p->fresh, m);
    for (int i = 0; i < 3; i++) {
        p->k.q[i] = choose(m, gather(paths->q[i], p->job), p->k.q[i]);
        p->w[i] = choose(m, gather(paths->w[i], p->job), p->w[i]);
        p->beta[i] = choose(m, all(1.0f), p->beta[i]);
        p->radiance[i] = choose(m, all(0.0f), p->radiance[i]);
    }
    p->vertex = choose(m, all(1.0f), p->vertex);
    begin_random(&p->random, m, (lanes_bits)gather_int(paths->random[0], p->job),
                 (lanes_bits)gather_int(paths->random[1], p->job));
    return m;
}

/* Queues shadow rays from the vertices of m. Each adds weight times (transmittance - `expected`)
 * times each channel's light. */
LF_INLINE void shoot(path *p, mask m, const float light[3], lanes weight, lanes expected,
                     lf_lane_memory *memory)
{
    const lanes_bits low = draw(&p->random, m), high = draw(&p->random, m);
    for (unsigned b = bits_of(m); b; b &= b - 1) {
        int k = __builtin_ctz(b);
        lf_lane_shadow_ray *shadow_ray = &memory->shadow_ray[memory->n++];
        for (int i = 0; i < 3; i++) {
            shadow_ray->q[i] = p->k.q[i][k];
            shadow_ray->weight[i] = weight[k] * p->beta[i][k] * light[i];
        }
        shadow_ray->expected = expected[k];
        shadow_ray->random[0] = low[k];
        shadow_ray->random[1] = high[k];
        shadow_ray->job = p->job[k];
    }
}

/* Direction to the light from the vertices of m, in `out`. Returns its phase function; *weight: the
 * same with the MIS weight against scattering. */
LF_INLINE lanes towards_light(path *p, const lf_lane_scene *scene, mask m, lanes out[3],
                              lanes *weight, unsigned has)
{
    for (int i = 0; i < 3; i++)
        out[i] = all(scene->toward[i]);
    if (has & LF_LANE_DISK) {
        lanes u = draw_unit(&p->random, m);
        draw_from_disk(scene, u, draw_unit(&p->random, m), out);
    }
    lanes phase = *weight = phase_between(scene->g, p->w, out);
    if (has & LF_LANE_DISK)
        *weight = phase / (1.0f / scene->disk.solid_angle + phase);
    return phase;
}

/* Light sampling at the vertices of m: adds the control at once and, with some probability, queues
 * a shadow ray for its error. */
LF_INLINE void next_event(path *p, const lf_lane_scene *scene, mask m, lf_lane_memory *memory,
                          unsigned has)
{
    const float *sent = has & LF_LANE_DISK ? scene->disk.radiance : scene->irradiance;
    float light[3], mean = 0.0f;
    lanes carried = all(0.0f), expected, toward[3], weight;
    for (int i = 0; i < 3; i++) {
        light[i] = scene->albedo[i] * sent[i];
        mean += light[i];
        carried = carried + p->beta[i] * light[i];
    }
    if (!(mean > 0.0f) || !bits_of(m))
        return;
    lanes phase = towards_light(p, scene, m, toward, &weight, has);
    lanes share = carried * (1.0f / mean) * phase * (4.0f * LF_PI),
          probability = chance(scene, p->k.q, share, &expected);
    lanes known = choose(m, weight * expected, all(0.0f));
    for (int i = 0; i < 3; i++)
        p->radiance[i] = p->radiance[i] + p->beta[i] * light[i] * known;
    m = both(m, is_less(draw_unit(&p->random, m), probability));
    int n = memory->n;
    shoot(p, m, light, weight / probability, expected, memory);
    for (unsigned b = has & LF_LANE_SKY ? bits_of(m) : 0; b; b &= b - 1, n++) {
        int k = __builtin_ctz(b);
        memory->draws[n] = 0;
        for (int i = 0; i < 3; i++)
            memory->w[i][n] = toward[i][k];
    }
}

/* Light sampling of the image, with some probability; the direction is drawn later, for many at
 * once. */
LF_INLINE void next_picture(path *p, const lf_lane_scene *scene, mask m, lf_lane_memory *memory)
{
    int n = memory->n;
    m = both(m, is_less(draw_unit(&p->random, m), all(PICTURE_SHARE)));
    shoot(p, m, scene->albedo, all(1.0f), all(0.0f), memory);
    for (unsigned b = bits_of(m); b; b &= b - 1, n++) {
        int k = __builtin_ctz(b);
        memory->draws[n] = -1;
        for (int i = 0; i < 3; i++)
            memory->w[i][n] = p->w[i][k];
    }
}

/* lf_phase_sample in the lanes of m, and the change of throughput. */
LF_INLINE void scatter(path *p, const lf_lane_scene *scene, mask m, unsigned has)
{
    const float a = fabsf(scene->g), b = 1.0f - a, side = copysignf(1.0f, scene->g);
    lanes u = draw_unit(&p->random, m), sine, cosine;
    lanes d = b + 2.0f * a * (1.0f - u), s = b * (1.0f + a) / d, versine = b * u * (s + b) / d;
    sine_cosine(draw_unit(&p->random, m), &sine, &cosine);
    lanes radius = root(most(versine * (2.0f - versine), all(0.0f)));
    lanes x = radius * cosine, y = radius * sine, z = 1.0f - versine;
    /* lf_tangents around the axis */
    lanes nx = p->w[0] * side, ny = p->w[1] * side, nz = p->w[2] * side;
    lanes sign = choose(is_less(nz, all(0.0f)), all(-1.0f), all(1.0f));
    lanes f = -1.0f / (sign + nz), c = nx * ny * f;
    const lanes turned[3] = {(1.0f + sign * nx * nx * f) * x + c * y + nx * z,
                             sign * c * x + (sign + ny * ny * f) * y + ny * z,
                             nz * z - sign * nx * x - ny * y};
    for (int i = 0; i < 3; i++) {
        p->w[i] = choose(m, turned[i], p->w[i]);
        p->beta[i] = choose(m, p->beta[i] * scene->albedo[i], p->beta[i]);
    }
    if (has & LF_LANE_SKY)
        p->pdf = choose(m, phase_at(scene->g, 2.0f * versine), p->pdf);
}

LF_INLINE void shade(path *p, const lf_lane_scene *scene, const lf_lane_paths *paths,
                     lf_lane_memory *memory, int *next, unsigned has)
{
    mask shaded = without(p->t.shade, p->t.idle),
         ended = arrive(p, scene, paths->max_depth, shaded, memory, has),
         vertex = without(shaded, ended);
    mask died = roulette(p, vertex), begun = mask_of(0);
    vertex = without(vertex, died);
    ended = either(ended, died);
    if (bits_of(ended))
        begun = next_paths(p, paths, ended, next, has);
    if (bits_of(vertex)) {
        next_event(p, scene, vertex, memory, has);
        if (has & LF_LANE_PICTURE)
            next_picture(p, scene, vertex, memory);
        scatter(p, scene, vertex, has);
    }
    mask on = either(vertex, begun);
    begin_walk(&p->k, scene, on, p->w, &p->random);
    p->t.step = either(p->t.step, on);
    p->t.shade = p->t.idle;
}

/* A vertex queues at most two shadow rays before the queue is checked, and `aim` fills up its last
 * groups. */
enum { FILL = LF_GROUPS * LF_WIDTH };
_Static_assert((LF_LANE_SHADOW_RAYS + LF_WIDTH + FILL - 1) / FILL * FILL <=
                   LF_LANE_SHADOW_RAYS + LF_LANE_MOST,
               "room for a turn's shots");

/* Traces the queued shadow rays and adds their results. */
LF_INLINE int64_t flush(const lf_lane_scene *scene, const lf_lane_paths *paths,
                        lf_lane_memory *memory, unsigned has)
{
    if (has & LF_LANE_PICTURE)
        aim(scene, memory);
    int64_t lookups = memory->n > 0 ? trace_shadow_rays(scene, memory, has) : 0;
    for (int k = 0; k < memory->n; k++) {
        const lf_lane_shadow_ray *shadow_ray = &memory->shadow_ray[k];
        for (int i = 0; i < 3; i++)
            paths->lit[i][shadow_ray->job] +=
                shadow_ray->weight[i] * (memory->left[k] - shadow_ray->expected);
    }
    memory->n = 0;
    if (has & LF_LANE_SKY)
        find(scene, paths, memory, has);
    return lookups;
}

LF_INLINE int64_t trace_with(const lf_lane_scene *scene, const lf_lane_paths *paths,
                             lf_lane_memory *memory, unsigned has)
{
    const mask every = mask_of((1u << LF_WIDTH) - 1);
    path team[TEAMS];
    int64_t lookups = 0;
    int next = 0;
    for (int g = 0; g < TEAMS; g++)
        team[g] = (path){.t = {.shade = every}, .fresh = every};
    for (int i = 0; i < 3; i++)
        memset(paths->lit[i], 0, sizeof **paths->lit * (size_t)paths->n);
    memory->n = memory->n_unscattered = 0;
    for (int ended = 0; ended < TEAMS;) {
        ended = 0;
        for (int g = 0; g < TEAMS; g++) {
            path *p = &team[g];
            switch (choose_turn(&p->t)) {
            case STEP:
                step(&p->k, scene, &p->t);
                break;
            case LOOK:
                lookups += count_of(p->t.look);
                look(p, scene);
                break;
            case SHADE:
                shade(p, scene, paths, memory, &next, has);
                if (memory->n > LF_LANE_SHADOW_RAYS - LF_WIDTH ||
                    (has & LF_LANE_SKY && memory->n_unscattered > LF_LANE_SHADOW_RAYS - LF_WIDTH))
                    lookups += flush(scene, paths, memory, has);
                break;
            case END:
                ended++;
            }
        }
    }
    lookups += flush(scene, paths, memory, has);
    /* in that order, whenever the shadow rays were traced */
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < paths->n; k++)
            paths->radiance[i][k] += paths->lit[i][k];
    return lookups;
}

/* Copies for a constant sky, for a sky image, and for disk lights with either. All scenes with
 * surfaces share one copy that tests at run time, because rays dominate their cost. */
#define LF_TRACE(name, has)                                                                        \
    static int64_t trace_##name(const lf_lane_scene *scene, const lf_lane_paths *paths,            \
                                lf_lane_memory *memory)                                            \
    {                                                                                              \
        return trace_with(scene, paths, memory, has);                                              \
    }
LF_TRACE(even, 0)
LF_TRACE(picture, LF_LANE_PICTURE)
LF_TRACE(disk, LF_LANE_DISK | (scene->has & LF_LANE_PICTURE))
LF_TRACE(surfaces, scene->has)

static int64_t trace(const lf_lane_scene *scene, const lf_lane_paths *paths, lf_lane_memory *memory)
{
    return (scene->has & LF_LANE_SURFACES  ? trace_surfaces
            : scene->has & LF_LANE_DISK    ? trace_disk
            : scene->has & LF_LANE_PICTURE ? trace_picture
                                           : trace_even)(scene, paths, memory);
}

/* ------------------------------------------------------------------------------------ points -- */

LF_INLINE int64_t light_with(const lf_lane_scene *scene, const lf_lane_points *points,
                             lf_lane_memory *memory, unsigned has)
{
    const float *toward = scene->toward;
    int64_t lookups = 0;
    memset(points->left, 0, sizeof *points->left * (size_t)points->n);
    if (!(has & LF_LANE_SKY) && toward[0] == 0.0f && toward[1] == 0.0f && toward[2] == 0.0f)
        return 0; /* rays without a direction would not advance, some forever */
    for (int first = 0; first < points->n; first += LF_LANE_SHADOW_RAYS) {
        const int rest = points->n - first;
        memory->n = rest < LF_LANE_SHADOW_RAYS ? rest : LF_LANE_SHADOW_RAYS;
        for (int k = 0; k < memory->n; k++) {
            lf_lane_shadow_ray *shadow_ray = &memory->shadow_ray[k];
            for (int i = 0; i < 3; i++)
                shadow_ray->q[i] = points->q[i][first + k];
            for (int i = 0; i < 2; i++)
                shadow_ray->random[i] = points->random[i][first + k];
        }
        for (int i = 0; i < 3 && has & LF_LANE_SKY; i++)
            memcpy(memory->w[i], points->w[i] + first, sizeof(float) * (size_t)memory->n);
        lookups += trace_shadow_rays(scene, memory, has);
        memcpy(points->left + first, memory->left, sizeof *memory->left * (size_t)memory->n);
    }
    return lookups;
}

static int64_t light(const lf_lane_scene *scene, const lf_lane_points *points,
                     lf_lane_memory *memory)
{
    return scene->has ? light_with(scene, points, memory, scene->has)
                      : light_with(scene, points, memory, 0);
}

#endif
