/* Subsurface: a homogeneous medium inside a closed mesh whose surface has subsurface (skin, wax,
 * marble), in which light scatters many times before it leaves again (Chiang, Kutz and Burley 2016,
 * Practical and Controllable Subsurface Scattering for Production Path Tracing). Private to
 * render/transport/; used only in scenes with LF_TRAIT_SUBSURFACE.
 *
 * Light enters through a cosine lobe (surface_principled.c), walks from collision to collision, and
 * leaves through such a lobe where it meets the mesh from inside. Nothing is refracted or reflected
 * there, and no light is sampled during the walk. The reflectance of a half-space is then its
 * spherical albedo, 1 - 2 sqrt(1 - a) int H(mu) mu dmu (Chandrasekhar 1960). A surface's albedo is
 * converted to this. Volumes inside the mesh are ignored, objects inside are met. */
#ifndef LF_RENDER_SUBSURFACE_H
#define LF_RENDER_SUBSURFACE_H

#include "render/transport/path/path.h"

/* The single-scattering albedo a for which a half-space has the reflectance `albedo`. Uses van de
 * Hulst's fit of its spherical albedo, (1 - s)(1 - 0.139 s)/(1 + 1.17 s), s^2 = (1 - a)/(1 - g a)
 * (Multiple Light Scattering, 1980, volume 2). The inverse is as in Kulla and Conty 2017. Within
 * 0.0025 for g = 0. */
float lf_subsurface_albedo(float albedo, float g);

/* The subsurface medium that a path enters when it leaves the event along w. */
lf_subsurface lf_subsurface_beyond(const lf_event *from, lf_vec3 w);

/* lf_path_next through out->subsurface, which must be set, for a path with throughput beta: up to
 * the surface that the walk meets, of the mesh or of an object inside. The result is an escape with
 * zero throughput if all light is absorbed, or if the walk leaves the scene's box because the mesh
 * is not closed. Distances are drawn for one channel and weighted for all (interior.h). */
void lf_subsurface_walk(lf_tracer *tracer, const lf_event *from, lf_vec3 w, lf_vec3 beta,
                        lf_event *out);

#endif
