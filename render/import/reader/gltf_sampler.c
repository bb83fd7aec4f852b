#include "render/import/reader/gltf_sampler.h"

#include <math.h>
#include <string.h>

#include "base/sandbox/reader.h"

/* Maximum number of morph targets of a mesh. */
#define MOST_WEIGHTS 4096

static float time_at(const lf_gltf_sampler *s, size_t key)
{
    float time = 0;
    lf_gltf_floats(&s->times, key, 1, &time);
    return time;
}

lf_gltf_moment lf_gltf_sampler_moment(const lf_gltf_sampler *s, float time)
{
    size_t low = 0, high = s->times.count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (time_at(s, middle) <= time)
            low = middle;
        else
            high = middle;
    }
    lf_gltf_moment m = {.key = low};
    float begin = time_at(s, low);
    if (low + 1 < s->times.count && time > begin) {
        m.length = time_at(s, low + 1) - begin;
        m.share = m.length > 0 ? (time - begin) / m.length : 0;
    }
    return m;
}

/* Vector number i of a key; part: 0 the in-tangent, 1 the value, 2 the out-tangent, if there are
 * tangents. */
static void key_value(const lf_gltf_sampler *s, size_t key, int part, size_t i, float out[4])
{
    size_t at =
        s->course == LF_GLTF_CUBIC ? (3 * key + (size_t)part) * s->each + i : key * s->each + i;
    memset(out, 0, 4 * sizeof *out);
    lf_gltf_floats(&s->values, at, s->components, out);
}

static void follow_cubic(const lf_gltf_sampler *s, const lf_gltf_moment *m, size_t i, float out[4])
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

/* Interpolates on the shorter arc from a to b on the sphere of unit quaternions. */
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

void lf_gltf_sampler_value(const lf_gltf_sampler *s, const lf_gltf_moment *m, size_t i,
                           float out[4])
{
    float a[4], b[4];
    key_value(s, m->key, 1, i, a);
    memcpy(out, a, sizeof a);
    if (m->share <= 0 || s->course == LF_GLTF_STEP)
        return;
    if (s->course == LF_GLTF_CUBIC) {
        follow_cubic(s, m, i, out);
        return;
    }
    key_value(s, m->key + 1, 1, i, b);
    if (s->turns)
        turn(a, b, m->share, out);
    else
        for (int c = 0; c < 4; c++)
            out[c] = a[c] + m->share * (b[c] - a[c]);
}

lf_status lf_gltf_sampler_open(lf_gltf *gltf, const json_t *json, unsigned components,
                               lf_gltf_sampler *s, lf_error *err)
{
    const char *name = lf_gltf_text(json, "interpolation");
    s->course = strcmp(name, "STEP") == 0          ? LF_GLTF_STEP
                : strcmp(name, "CUBICSPLINE") == 0 ? LF_GLTF_CUBIC
                                                   : LF_GLTF_LINEAR;
    s->components = components;
    s->turns = false;
    lf_status status =
        lf_gltf_accessor_open(gltf, lf_gltf_whole(json, "input", LF_GLTF_NONE), &s->times, err);
    if (status == LF_OK)
        status = lf_gltf_accessor_open(gltf, lf_gltf_whole(json, "output", LF_GLTF_NONE),
                                       &s->values, err);
    if (status != LF_OK)
        return status;
    if (s->values.components != components)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "the animated values have %u components; expected %u",
                            s->values.components, components);
    s->each = s->values.count / (s->times.count * (s->course == LF_GLTF_CUBIC ? 3 : 1));
    if (s->each < 1 || s->each > MOST_WEIGHTS)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "an animation has %zu values for %zu times",
                            s->values.count, s->times.count);
    return LF_OK;
}
