/* Loops over views and segments, written once for all instruction sets, with 4 or 8 lanes. A group
 * of views has 8, as have a box and a leaf of a section. Each fan_*.c defines the width of lanes
 * and includes this file. */
#ifndef LF_RENDER_FAN_LANES_H
#define LF_RENDER_FAN_LANES_H

#include "render/plane/fan.h"
#include "render/transport/lanes/lanes.h"

enum { WIDE = LF_SECTION_WIDE };

LF_INLINE void store(float *to, lanes from)
{
    memcpy(to, &from, sizeof from);
}

/* ------------------------------------------------------------------------------------- views -- */

static void project(const lf_projection *of, int n, const lf_projected *out)
{
    const lf_rig *rig = of->rig;
    const float inverse_z = 1.0f / of->z, lens = of->lx * rig->distance / rig->focus,
                per_pixel = 1.0f / rig->dx, distance = rig->distance, u0 = rig->x0,
                width = (float)rig->width;
    const bool surface = of->surface;
    lanes_int number;
    for (int i = 0; i < LF_WIDTH; i++)
        number[i] = i;
    for (int k = 0; k < n; k += LF_WIDTH) {
        const lanes c = load(rig->b + k) + of->lx, dx = of->x - c, slope = dx * inverse_z;
        const lanes u = (load(rig->skew + k) + lens + distance * slope - u0) * per_pixel;
        const lanes h = surface ? (lanes)(-(of->nx * dx + of->nyz)) : root(dx * dx + of->yz2);
        const mask in_frame = both(both(is_at_most(all(0.0f), u), is_less(u, all(width))),
                                   (mask)(number < rig->n_views - k));
        const lanes_int column = to_int(choose(in_frame, u, all(0.0f)));
        store(out->x0 + k, c);
        store(out->slope + k, slope);
        store(out->z_end + k, all(of->z));
        memcpy(out->column + k, &column, sizeof column);
        store(out->h + k, choose(both(in_frame, is_less(all(0.0f), h)), h, all(0.0f)));
    }
}

/* In the fixed order lane 0..7 of running sums of 8. */
LF_INLINE float total_of(const lanes sum[LF_LANES / LF_WIDTH])
{
    float part[LF_LANES], total;
    for (int i = 0; i < LF_LANES / LF_WIDTH; i++)
        store(part + i * LF_WIDTH, sum[i]);
    total = part[0];
    for (int i = 1; i < LF_LANES; i++)
        total += part[i];
    return total;
}

static float densities(int n, const float *scale, float *d)
{
    lanes sum[LF_LANES / LF_WIDTH] = {{0.0f}};
    for (int k = 0; k < n; k += LF_LANES) {
        for (int i = 0; i < LF_LANES / LF_WIDTH; i++) {
            const lanes all_of = load(scale + k + i * LF_WIDTH),
                        here = choose(is_less(all(0.0f), all_of), all_of, all(0.0f));
            store(d + k + i * LF_WIDTH, here);
            sum[i] += here;
        }
    }
    return total_of(sum);
}

/* ------------------------------------------------------------------------------------- lobes -- */

static void cosines(const lf_fan_axis *axis, int n, const float *restrict slope,
                    float *restrict out)
{
    const lf_fan_axis of = *axis;
    for (int k = 0; k < n; k++)
        out[k] = (slope[k] * of.across + of.along) / sqrtf(of.my2 + slope[k] * slope[k]);
}

static void phases(float g, const float to[3], float my, int n, const float *restrict slope,
                   float *restrict out)
{
    const float a = fabsf(g), my2 = 1.0f + my * my,
                numerator = LF_INV_4PI * (1.0f - a) * (1.0f + a), tx = to[0], ty = to[1],
                tz = to[2];
    for (int k = 0; k < n; k++) {
        const float inverse = 1.0f / sqrtf(my2 + slope[k] * slope[k]);
        const float x = slope[k] * inverse - tx, y = my * inverse - ty, z = inverse - tz;
        const float d = lf_max((1.0f - a) * (1.0f - a) + a * (x * x + y * y + z * z), 1e-12f);
        out[k] = numerator / (d * sqrtf(d));
    }
}

static float pdf(int n, const float *strategy, const float *of)
{
    lanes sum[LF_LANES / LF_WIDTH] = {{0.0f}};
    for (int k = 0; k < n; k += LF_LANES)
        for (int i = 0; i < LF_LANES / LF_WIDTH; i++)
            sum[i] += load(strategy + k + i * LF_WIDTH) * load(of + k + i * LF_WIDTH);
    return total_of(sum);
}

static void collect(int n, const float *const density[3], const lf_fan_lobes *lobes,
                    lf_vec3 radiance, lf_sent *sent)
{
    const float channels[3] = {radiance.x, radiance.y, radiance.z};
    for (int c = 0; c < 3; c++) {
        const float *restrict d = density[c], *restrict f = lobes->f[c];
        float *restrict out = sent->n[c];
        const float channel = channels[c];
        for (int k = 0; k < n; k++)
            out[k] += d[k] * f[k] * channel;
    }
}

static void collect_shares(int n, const float *restrict density, const lf_fan_share *share,
                           lf_sent *sent)
{
    const float drawn = share->drawn, blind = share->blind;
    const float *restrict lobe = share->lobe, *restrict z = share->z;
    float *restrict out = sent->w2;
    for (int k = 0; k < n && lobe; k++)
        out[k] += density[k] * (z && !(z[k] > LF_MIN_COS) ? blind : drawn * lobe[k]);
    for (int k = 0; k < n && !lobe; k++)
        out[k] += density[k] * (z && !(z[k] > LF_MIN_COS) ? blind : 0.0f);
}

/* ------------------------------------------------------------------------------ hidden views -- */

/* Uses the same roundings as segments_before, and rounding is monotonic. So a box spans at least
 * its segments, and no ray slips through between two segments that share an end. */
LF_INLINE unsigned boxes_before(const lf_section_node *node, const lf_question *q)
{
    const lanes first = all(q->c[q->first]), last = all(q->c[q->last]), behind = all(q->behind);
    unsigned out = 0;
    for (int i = 0; i < WIDE; i += LF_WIDTH) {
        const lanes near = most(load(node->d0 + i) - q->d, behind), far = load(node->d1 + i) - q->d,
                    s0 = load(node->s0 + i) - q->s, s1 = load(node->s1 + i) - q->s;
        const lanes lo = s0 / choose(is_less(s0, all(0.0f)), near, far),
                    hi = s1 / choose(is_less(s1, all(0.0f)), far, near);
        out |=
            bits_of(both(is_less(behind, far), both(is_at_most(lo, last), is_at_most(first, hi))))
            << i;
    }
    return out;
}

static unsigned meets(const lf_section_node *node, const lf_question *q)
{
    return boxes_before(node, q);
}

LF_INLINE unsigned segments_before(const lf_section_leaf *leaf, const lf_question *q,
                                   float lo[WIDE], float hi[WIDE])
{
    const lanes first = all(q->c[q->first]), last = all(q->c[q->last]), behind = all(q->behind),
                far = all(INFINITY);
    unsigned out = 0;
    for (int i = 0; i < WIDE; i += LF_WIDTH) {
        const lanes d0 = load(leaf->d0 + i) - q->d, d1 = load(leaf->d1 + i) - q->d,
                    s0 = load(leaf->s0 + i) - q->s, s1 = load(leaf->s1 + i) - q->s;
        /* where it crosses the depth of the point */
        const lanes cut = s0 + (s1 - s0) * ((behind - d0) / (d1 - d0));
        const lanes c0 = choose(is_less(d0, behind), cut, s0) / most(d0, behind), c1 = s1 / d1;
        lanes_int triangle;
        memcpy(&triangle, leaf->triangle + i, sizeof triangle);
        const mask before =
            without(is_less(behind, d1), (mask)(triangle == all_int((int32_t)q->on)));
        const lanes from = choose(before, least(c0, c1), far),
                    to = choose(before, most(c0, c1), -far);
        store(lo + i, from);
        store(hi + i, to);
        out |= bits_of(both(is_at_most(from, last), is_at_most(first, to))) << i;
    }
    return out;
}

static unsigned intervals(const lf_section_leaf *leaf, const lf_question *q, float lo[WIDE],
                          float hi[WIDE])
{
    return segments_before(leaf, q, lo, hi);
}

LF_INLINE void hide_between(lf_question *q, float lo, float hi)
{
    const float *at = q->c;
    float *scale = q->scale;
    const int last = q->last;
    for (int k = q->first / LF_WIDTH * LF_WIDTH; k <= last; k += LF_WIDTH) {
        const lanes c = load(at + k);
        const mask hidden = both(is_at_most(all(lo), c), is_at_most(c, all(hi)));
        store(scale + k, (lanes)without((mask)load(scale + k), hidden));
    }
}

/* false: every position is hidden. */
LF_INLINE bool hide_leaf(const lf_section_leaf *leaf, lf_question *q)
{
    float lo[WIDE], hi[WIDE], from, to;
    unsigned hit = segments_before(leaf, q, lo, hi);
    if (!hit)
        return true;
    from = lo[__builtin_ctz(hit)];
    to = hi[__builtin_ctz(hit)];
    /* Segments of one surface share their ends, so mostly one interval remains. */
    for (hit &= hit - 1; hit; hit &= hit - 1) {
        const int i = __builtin_ctz(hit);
        const bool apart = lo[i] > to || hi[i] < from;
        if (apart)
            hide_between(q, from, to);
        from = apart ? lo[i] : lf_min(from, lo[i]);
        to = apart ? hi[i] : lf_max(to, hi[i]);
    }
    hide_between(q, from, to);
    return lf_question_narrow(q);
}

static void hide(const lf_section *section, lf_question *q)
{
    for (int root_at = 0; root_at < section->n_roots; root_at++) {
        for (unsigned nodes = boxes_before(&section->roots[root_at], q); nodes;
             nodes &= nodes - 1) {
            const int node = WIDE * root_at + __builtin_ctz(nodes);
            for (unsigned hit = boxes_before(&section->nodes[node], q); hit; hit &= hit - 1)
                if (!hide_leaf(&section->leaves[WIDE * node + __builtin_ctz(hit)], q))
                    return;
        }
    }
}

/* ------------------------------------------------------------------------------ nearest hits -- */

/* The fan, and its nearest hits so far. */
typedef struct fan {
    float s; /* where its lines meet, at d = 0 */
    int n;
    const float *c;
    float *d;
    int *segment;
} fan;

/* Boxes that lie between the outermost rays, on either side of d = 0. */
static unsigned fan_meets(const lf_section_node *node, const fan *f)
{
    const float first = f->c[0], last = f->c[f->n - 1];
    unsigned out = 0;
    for (int i = 0; i < WIDE; i += LF_WIDTH) {
        const lanes d0 = load(node->d0 + i), d1 = load(node->d1 + i), a = first * d0,
                    b = first * d1, e = last * d0, g = last * d1;
        const lanes below = least(least(a, b), least(e, g)), above = most(most(a, b), most(e, g));
        out |= bits_of(both(is_less(all(-LF_SECTION_FAR), d1),
                            both(is_at_most(load(node->s0 + i) - f->s, above),
                                 is_at_most(below, load(node->s1 + i) - f->s))))
               << i;
    }
    return out;
}

/* A ray meets a segment if the segment's ends lie on different sides of the ray. Segments that
 * share an end agree on its side. */
LF_INLINE void meet_segment(fan *f, int from, const lf_section_leaf *leaf, int i, int segment)
{
    const float d0 = leaf->d0[i], d1 = leaf->d1[i], s0 = leaf->s0[i] - f->s,
                s1 = leaf->s1[i] - f->s;
    for (int k = from; k < from + LF_LANES; k += LF_WIDTH) {
        const lanes c = load(f->c + k), nearest = load(f->d + k), a = s0 - c * d0, b = s1 - c * d1,
                    d = d0 + (d1 - d0) * (a / (a - b));
        const mask nearer =
            both(is_at_most(all(0.0f), a) ^ is_at_most(all(0.0f), b), is_less(nearest, d));
        lanes_int before;
        memcpy(&before, f->segment + k, sizeof before);
        before = choose_int(nearer, all_int(segment), before);
        store(f->d + k, choose(nearer, d, nearest));
        memcpy(f->segment + k, &before, sizeof before);
    }
}

/* Segments that rays between c0 and c1 may meet. The sides are linear in c: if both ends are on one
 * side of both rays, they are for every ray between. */
LF_INLINE unsigned sides(const lf_section_leaf *leaf, float s, float c0, float c1)
{
    unsigned out = 0;
    for (int i = 0; i < WIDE; i += LF_WIDTH) {
        const lanes d0 = load(leaf->d0 + i), d1 = load(leaf->d1 + i), s0 = load(leaf->s0 + i) - s,
                    s1 = load(leaf->s1 + i) - s;
        const mask below = both(both(is_less(s0, c0 * d0), is_less(s0, c1 * d0)),
                                both(is_less(s1, c0 * d1), is_less(s1, c1 * d1))),
                   above = both(both(is_at_most(c0 * d0, s0), is_at_most(c1 * d0, s0)),
                                both(is_at_most(c0 * d1, s1), is_at_most(c1 * d1, s1)));
        out |= bits_of(without(without(is_less(all(-LF_SECTION_FAR), d1), below), above)) << i;
    }
    return out;
}

static void fan_leaf(const lf_section *section, int number, fan *f)
{
    const lf_section_leaf *leaf = &section->leaves[number];
    if (!sides(leaf, f->s, f->c[0], f->c[f->n - 1]))
        return;
    for (int from = 0; from < f->n; from += LF_LANES)
        for (unsigned hit = sides(leaf, f->s, f->c[from], f->c[from + LF_LANES - 1]); hit;
             hit &= hit - 1)
            meet_segment(f, from, leaf, __builtin_ctz(hit), WIDE * number + __builtin_ctz(hit));
}

static void nearest(const lf_section *section, float s0, int n, const float *c, float *d,
                    int *segment)
{
    fan f = {.s = s0, .n = n, .c = c, .d = d, .segment = segment};
    for (int k = 0; k < n; k++) {
        d[k] = -LF_SECTION_FAR;
        segment[k] = -1;
    }
    for (int root_at = 0; root_at < section->n_roots; root_at++) {
        for (unsigned nodes = fan_meets(&section->roots[root_at], &f); nodes; nodes &= nodes - 1) {
            const int node = WIDE * root_at + __builtin_ctz(nodes);
            for (unsigned hit = fan_meets(&section->nodes[node], &f); hit; hit &= hit - 1)
                fan_leaf(section, WIDE * node + __builtin_ctz(hit), &f);
        }
    }
}

#define LF_FANS(which)                                                                             \
    {                                                                                              \
        .name = which, .project = project, .densities = densities, .meets = meets,                 \
        .cosines = cosines, .phases = phases, .pdf = pdf, .collect = collect,                      \
        .collect_shares = collect_shares, .intervals = intervals, .hide = hide, .nearest = nearest \
    }

#endif
