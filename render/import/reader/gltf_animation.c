/* Animations of glTF (specification, section 3.11): which one is played, and the nodes it moves. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/sandbox/reader.h"
#include "render/import/reader/gltf_animation.h"
#include "render/import/reader/gltf_sampler.h"

static lf_status take_weights(const lf_gltf_sampler *s, float time, lf_gltf_node *node,
                              lf_error *err)
{
    float *weights = calloc(s->each, sizeof *weights), value[4];
    if (!weights)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    const lf_gltf_moment moment = lf_gltf_sampler_moment(s, time);
    for (size_t i = 0; i < s->each; i++) {
        lf_gltf_sampler_value(s, &moment, i, value);
        weights[i] = value[0];
    }
    free(node->weights);
    node->weights = weights;
    node->n_weights = s->each;
    return LF_OK;
}

/* One channel: changes one property of its node. */
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
        lf_gltf_sampler s;
        float value[4];
        if (strcmp(path, parts[i].path) != 0)
            continue;
        lf_status status = lf_gltf_sampler_open(gltf, sampled, parts[i].components, &s, err);
        if (status != LF_OK)
            return status;
        if (!parts[i].to)
            return take_weights(&s, time, node, err);
        s.turns = parts[i].components == 4;
        const lf_gltf_moment moment = lf_gltf_sampler_moment(&s, time);
        lf_gltf_sampler_value(&s, &moment, 0, value);
        memcpy(parts[i].to, value, parts[i].components * sizeof *value);
        node->has_matrix = false;
    }
    return LF_OK;
}

/* "Walk", 1, "Run": names of the animations, numbers of unnamed ones. */
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

void lf_gltf_warn_of_clips(const lf_gltf *gltf, const lf_clip *clip, lf_warnings *warnings)
{
    const json_t *animations = json_object_get(gltf->json, "animations");
    char names[256], line[240];
    if (json_array_size(animations) < 2 || clip->chosen)
        return;
    list_clips(animations, names, sizeof names);
    lf_gltf_line(names, line, sizeof line);
    lf_warnings_add(warnings, LF_HERE,
                    "of %zu animations, the first is shown; to choose another, set animation.clip "
                    "of the mesh: %s",
                    json_array_size(animations), line);
}

static lf_status refuse_clip(const lf_clip *clip, const json_t *animations, lf_error *err)
{
    char source[LF_MAX_CLIP + 3], names[1024];
    if (clip->name)
        snprintf(source, sizeof source, "\"%s\"", clip->name);
    else
        snprintf(source, sizeof source, "%d", clip->number);
    list_clips(animations, names, sizeof names);
    if (json_array_size(animations) == 0)
        return lf_error_set(err, LF_E_ARG, LF_HERE, "no animation %s; the file has no animations",
                            source);
    return lf_error_set(err, LF_E_ARG, LF_HERE, "no animation %s; expected one of %s", source,
                        names);
}

/* out NULL: there is no animation, and none was requested. */
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

/* The time of the last key of its channels. A broken channel does not count; applying it reports
 * the error. */
static double measure(lf_gltf *gltf, const json_t *animation)
{
    const json_t *samplers = json_object_get(animation, "samplers");
    double span = 0;
    for (size_t i = 0; i < json_array_size(samplers); i++) {
        lf_gltf_accessor times;
        uint64_t number = lf_gltf_whole(json_array_get(samplers, i), "input", LF_GLTF_NONE);
        float last = 0;
        if (lf_gltf_accessor_open(gltf, number, &times, NULL) != LF_OK || times.count == 0)
            continue;
        lf_gltf_floats(&times, times.count - 1, 1, &last);
        span = fmax(span, (double)last);
    }
    return fmin(span, LF_MAX_SECONDS);
}

lf_status lf_gltf_find_clip(lf_gltf *gltf, const lf_clip *clip, lf_gltf_playing *out, lf_error *err)
{
    lf_gltf_playing playing = {0};
    lf_status status = find_clip(gltf, clip, &playing.animation, err);
    if (status != LF_OK)
        return status;
    if (playing.animation)
        playing.span = measure(gltf, playing.animation);
    playing.time = (float)lf_clip_moment(clip, playing.span);
    *out = playing;
    return LF_OK;
}

lf_status lf_gltf_animate(lf_gltf *gltf, const lf_gltf_playing *playing, lf_gltf_nodes *nodes,
                          lf_error *err)
{
    const json_t *channels = json_object_get(playing->animation, "channels");
    lf_status status = LF_OK;
    for (size_t i = 0; i < json_array_size(channels) && status == LF_OK; i++) {
        const json_t *channel = json_array_get(channels, i),
                     *target = json_object_get(channel, "target"),
                     *sampled = lf_gltf_element(playing->animation, "samplers",
                                                lf_gltf_whole(channel, "sampler", LF_GLTF_NONE));
        uint64_t number = lf_gltf_whole(target, "node", LF_GLTF_NONE);
        lf_gltf_node *node = number < nodes->n ? &nodes->node[number] : NULL;
        if (node)
            status = move(gltf, sampled, lf_gltf_text(target, "path"), playing->time, node, err);
    }
    return status;
}
