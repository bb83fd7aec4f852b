#include "render/transport/lanes/lane_surfaces.h"

#include "render/transport/path/path.h"

static lf_vec3 vec_of(const float v[3])
{
    return lf_v3(v[0], v[1], v[2]);
}

static lf_vec3 place_of(const lf_volume *volume, const float q[3])
{
    float p[3];
    for (int i = 0; i < 3; i++) {
        const float *row = volume->to_scene[i];
        p[i] = row[0] * q[0] + row[1] * q[1] + row[2] * q[2] + row[3];
    }
    return lf_v3(p[0], p[1], p[2]);
}

static bool meet(void *of, const lf_lane_segment *segment, float out[3])
{
    lf_tracer *tracer = of;
    lf_vec3 o = place_of(&tracer->scene->volumes[0], segment->q), beta = vec_of(segment->beta),
            found = lf_v3(0.0f, 0.0f, 0.0f);
    lf_event event = {.kind = LF_EVENT_SURFACE, .w = vec_of(segment->w), .from = o};
    tracer->rng = (uint64_t)segment->random[0] | (uint64_t)segment->random[1] << 32;
    tracer->width = 0.0f;
    tracer->spread = LF_SUFFIX_SPREAD;
    if (!lf_trace_surface(tracer, o, event.w, segment->length, &event.hit))
        return false;
    event.p = event.hit.p;
    event.t = event.surface = event.hit.t;
    if (segment->depth > segment->max_depth || lf_path_survives(tracer, &beta)) {
        const double cut = tracer->suffixes_cut;
        found = lf_mul(beta, lf_path_scattered(tracer, &event, segment->depth, segment->max_depth));
        tracer->suffixes_cut = cut + (tracer->suffixes_cut - cut) * (double)lf_max3(beta);
    }
    out[0] = found.x;
    out[1] = found.y;
    out[2] = found.z;
    return true;
}

static float passed(void *of, const float q[3], const float w[3])
{
    lf_tracer *tracer = of;
    return lf_trace_passed(tracer, place_of(&tracer->scene->volumes[0], q), vec_of(w), INFINITY);
}

lf_lane_surfaces lf_lane_surfaces_of(lf_tracer *tracer)
{
    return (lf_lane_surfaces){.of = tracer, .meet = meet, .passed = passed};
}
