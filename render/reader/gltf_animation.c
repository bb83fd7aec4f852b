/* Animations of glTF (specification, section 3.11 and appendix C): their keys at one time. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/reader/reader.h"
#include "render/reader/gltf_node.h"

/* Morph targets that a mesh may have; more are no use to anybody. */
#define MOST_WEIGHTS 4096

typedef enum course { LINEAR, STEP, CUBIC } course;

typedef struct sampler {
    lf_gltf_accessor times, values;
    course course;
    size_t each; /* values of a key, of one vector: 1, or of weights as many as there are */
    unsigned components;
} sampler;

/* Between which keys a time lies, and where. */
typedef struct moment {
    size_t key;
    float share, length; /* 0..1 on the way to the next key; seconds to it */
} moment;

static float time_at(const sampler *s, size_t key)
{
    float time = 0;
    lf_gltf_floats(&s->times, key, 1, &time);
    return time;
}

static moment find_moment(const sampler *s, float time)
{
    size_t low = 0, high = s->times.count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (time_at(s, middle) <= time)
            low = middle;
        else
            high = middle;
    }
    moment m = {.key = low};
    float begin = time_at(s, low);
    if (low + 1 < s->times.count && time > begin) {
        m.length = time_at(s, low + 1) - begin;
        m.share = m.length > 0 ? (time - begin) / m.length : 0;
    }
    return m;
}

/* Vector number i of a key; part: 0 the tangent that comes in, 1 the value, 2 the one that goes
 * out, where there are tangents. */
static void key_value(const sampler *s, size_t key, int part, size_t i, float out[4])
{
    size_t at = s->course == CUBIC ? (3 * key + (size_t)part) * s->each + i : key * s->each + i;
    memset(out, 0, 4 * sizeof *out);
    lf_gltf_floats(&s->values, at, s->components, out);
}

static void follow_cubic(const sampler *s, const moment *m, size_t i, float out[4])
{
    float t = m->share, t2 = t * t, t3 = t2 * t, a[4], out_of_a[4], b[4], into_b[4];
    key_value(s, m->key, 1, i, a);
    key_value(s, m->key, 2, i, out_of_a);
    key_value(s, m->key + 1, 1, i, b);
    key_value(s, m->key + 1, 0, i, into_b);
    for (int c = 0; c < 4; c++)
        out[c] = (2 * t3 - 3 * t2 + 1) * a[c] + m->length * (t3 - 2 * t2 + t) * out_of_a[c] +
                 (3 * t2 - 2 * t3) * b[c] + m->length * (t3 - t2) * into_b[c];
}

/* On the shorter way from a to b on the sphere of unit quaternions. */
static void turn(const float a[4], const float b[4], float share, float out[4])
{
    float dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3],
          side = dot < 0 ? -1.0f : 1.0f, angle = acosf(fminf(fabsf(dot), 1.0f)), from = 1 - share,
          to = share;
    if (angle > 1e-3f) {
        from = sinf((1 - share) * angle) / sinf(angle);
        to = sinf(share * angle) / sinf(angle);
    }
    for (int c = 0; c < 4; c++)
        out[c] = from * a[c] + side * to * b[c];
}

static void value_at(const sampler *s, float time, size_t i, float out[4])
{
    moment m = find_moment(s, time);
    float a[4], b[4];
    key_value(s, m.key, 1, i, a);
    memcpy(out, a, sizeof a);
    if (m.share <= 0 || s->course == STEP)
        return;
    if (s->course == CUBIC) {
        follow_cubic(s, &m, i, out);
        return;
    }
    key_value(s, m.key + 1, 1, i, b);
    if (s->components == 4)
        turn(a, b, m.share, out);
    else
        for (int c = 0; c < 4; c++)
            out[c] = a[c] + m.share * (b[c] - a[c]);
}

static lf_status open_sampler(lf_gltf *gltf, const json_t *json, unsigned components, sampler *s,
                              lf_error *err)
{
    const char *name = lf_gltf_text(json, "interpolation");
    s->course = strcmp(name, "STEP") == 0          ? STEP
                : strcmp(name, "CUBICSPLINE") == 0 ? CUBIC
                                                   : LINEAR;
    s->components = components;
    lf_status status =
        lf_gltf_accessor_open(gltf, lf_gltf_whole(json, "input", LF_GLTF_NONE), &s->times, err);
    if (status == LF_OK)
        status = lf_gltf_accessor_open(gltf, lf_gltf_whole(json, "output", LF_GLTF_NONE),
                                       &s->values, err);
    if (status != LF_OK)
        return status;
    s->each = s->values.count / (s->times.count * (s->course == CUBIC ? 3 : 1));
    if (s->each < 1 || s->each > MOST_WEIGHTS || s->values.components != components)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "an animation has %zu values for %zu moments", s->values.count,
                            s->times.count);
    return LF_OK;
}

static lf_status take_weights(const sampler *s, float time, lf_gltf_node *node, lf_error *err)
{
    float *weights = calloc(s->each, sizeof *weights), value[4];
    if (!weights)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    for (size_t i = 0; i < s->each; i++) {
        value_at(s, time, i, value);
        weights[i] = value[0];
    }
    free(node->weights);
    node->weights = weights;
    node->n_weights = s->each;
    return LF_OK;
}

/* One channel: what it moves of its node. */
static lf_status move(lf_gltf *gltf, const json_t *sampled, const char *path, float time,
                      lf_gltf_node *node, lf_error *err)
{
    const struct {
        const char *path;
        unsigned components;
        float *to;
    } parts[] = {{"translation", 3, node->pose.translation},
                 {"rotation", 4, node->pose.rotation},
                 {"scale", 3, node->pose.scale},
                 {"weights", 1, NULL}};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        sampler s;
        float value[4];
        if (strcmp(path, parts[i].path) != 0)
            continue;
        lf_status status = open_sampler(gltf, sampled, parts[i].components, &s, err);
        if (status != LF_OK)
            return status;
        if (!parts[i].to)
            return take_weights(&s, time, node, err);
        value_at(&s, time, 0, value);
        memcpy(parts[i].to, value, parts[i].components * sizeof *value);
        node->has_matrix = false;
    }
    return LF_OK;
}

/* "Walk", 1, "Run": names of the animations, numbers of those without. */
static void list_clips(const json_t *animations, char *out, size_t size)
{
    size_t n = 0;
    out[0] = '\0';
    for (size_t i = 0; i < json_array_size(animations) && n < size; i++) {
        const char *name = lf_gltf_text(json_array_get(animations, i), "name");
        int added = *name ? snprintf(out + n, size - n, "%s\"%s\"", i > 0 ? ", " : "", name)
                          : snprintf(out + n, size - n, "%s%zu", i > 0 ? ", " : "", i);
        n += added > 0 ? (size_t)added : 0;
    }
}

static lf_status refuse_clip(const lf_clip *clip, const json_t *animations, lf_error *err)
{
    char said[LF_MAX_CLIP + 3], names[1024];
    if (clip->name)
        snprintf(said, sizeof said, "\"%s\"", clip->name);
    else
        snprintf(said, sizeof said, "%d", clip->number);
    list_clips(animations, names, sizeof names);
    if (json_array_size(animations) == 0)
        return lf_error_set(err, LF_E_ARG, LF_HERE, "no animation %s: nothing moves in this file",
                            said);
    return lf_error_set(err, LF_E_ARG, LF_HERE, "no animation %s; there %s %s", said,
                        json_array_size(animations) == 1 ? "is" : "are", names);
}

/* *out NULL: nothing moves, and nobody says that it does. */
static lf_status find_clip(const lf_gltf *gltf, const lf_clip *clip, const json_t **out,
                           lf_error *err)
{
    const json_t *animations = json_object_get(gltf->json, "animations");
    size_t n = json_array_size(animations), at = clip->name ? n : (size_t)clip->number;
    for (size_t i = 0; clip->name && i < n && at == n; i++)
        if (strcmp(lf_gltf_text(json_array_get(animations, i), "name"), clip->name) == 0)
            at = i;
    *out = at < n ? json_array_get(animations, at) : NULL;
    return *out || !clip->chosen ? LF_OK : refuse_clip(clip, animations, err);
}

/* Until the last moment of its channels. A broken one counts nothing: who moves by it tells. */
static double measure(lf_gltf *gltf, const json_t *animation)
{
    const json_t *samplers = json_object_get(animation, "samplers");
    double span = 0;
    for (size_t i = 0; i < json_array_size(samplers); i++) {
        sampler s = {0};
        uint64_t times = lf_gltf_whole(json_array_get(samplers, i), "input", LF_GLTF_NONE);
        if (lf_gltf_accessor_open(gltf, times, &s.times, NULL) == LF_OK && s.times.count > 0)
            span = fmax(span, (double)time_at(&s, s.times.count - 1));
    }
    return fmin(span, LF_MAX_SECONDS);
}

lf_status lf_gltf_animate(lf_gltf *gltf, const lf_clip *clip, lf_gltf_nodes *nodes,
                          double *out_span, lf_error *err)
{
    const json_t *animation = NULL;
    *out_span = 0;
    lf_status status = find_clip(gltf, clip, &animation, err);
    if (status == LF_OK && animation)
        *out_span = measure(gltf, animation);
    float time = (float)lf_clip_moment(clip, *out_span);
    const json_t *channels = json_object_get(animation, "channels");
    for (size_t i = 0; i < json_array_size(channels) && status == LF_OK; i++) {
        const json_t *channel = json_array_get(channels, i),
                     *target = json_object_get(channel, "target"),
                     *sampled = lf_gltf_element(animation, "samplers",
                                                lf_gltf_whole(channel, "sampler", LF_GLTF_NONE));
        uint64_t number = lf_gltf_whole(target, "node", LF_GLTF_NONE);
        lf_gltf_node *node = number < nodes->n ? &nodes->node[number] : NULL;
        if (node)
            status = move(gltf, sampled, lf_gltf_text(target, "path"), time, node, err);
    }
    return status;
}
