/* Samplers of glTF animations (specification, section 3.11 and appendix C): keys, and their
 * interpolation. One thread. */
#ifndef LF_RENDER_GLTF_SAMPLER_H
#define LF_RENDER_GLTF_SAMPLER_H

#include "render/import/reader/gltf_accessor.h"

typedef enum lf_gltf_course { LF_GLTF_LINEAR, LF_GLTF_STEP, LF_GLTF_CUBIC } lf_gltf_course;

typedef struct lf_gltf_sampler {
    lf_gltf_accessor times, values;
    lf_gltf_course course;
    size_t each; /* vectors per key: 1, or the number of weights */
    unsigned components;
    /* the vectors are unit quaternions, so that LINEAR is spherical; lf_gltf_sampler_open sets it
     * to false */
    bool turns;
} lf_gltf_sampler;

/* The keys around a time, and its position between them. */
typedef struct lf_gltf_moment {
    size_t key;
    float share, length; /* 0..1 between the keys; seconds between them */
} lf_gltf_moment;

/* Opens an element of an animation's samplers, whose values are vectors of 1 to 4 components. An
 * unknown interpolation is LINEAR. LF_E_FORMAT, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_sampler_open(lf_gltf *gltf, const json_t *json, unsigned components,
                                            lf_gltf_sampler *out, lf_error *err);
/* Before the first key: the first key; after the last: the last. */
lf_gltf_moment lf_gltf_sampler_moment(const lf_gltf_sampler *sampler, float time);
/* Vector number i, below sampler->each; missing components are 0. */
void lf_gltf_sampler_value(const lf_gltf_sampler *sampler, const lf_gltf_moment *moment, size_t i,
                           float out[4]);

#endif
