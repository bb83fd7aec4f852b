/* Flesh: what fills a closed mesh whose surface has subsurface (skin, wax, marble), a homogeneous
 * medium in which light is scattered many times before it leaves again (Chiang, Kutz and Burley
 * 2016, Practical and Controllable Subsurface Scattering for Production Path Tracing). Private to
 * render/transport/; only scenes with LF_TRAIT_SUBSURFACE ask.
 *
 * Light enters by a lobe that is even but for the cosine (surface_principled.c), walks from
 * collision to collision, and leaves by such a lobe where it meets the mesh from within; nothing is
 * refracted or reflected there, and no light is sampled on the way. What a half-space of it gives
 * back is then its spherical albedo, 1 - 2 sqrt(1 - a) int H(mu) mu dmu (Chandrasekhar 1960), and a
 * surface's albedo is made into that. Volumes inside of it are not met; things are. */
#ifndef LF_RENDER_SUBSURFACE_H
#define LF_RENDER_SUBSURFACE_H

#include "render/transport/path/path.h"

/* The single-scattering albedo a with which a half-space gives back `albedo`, by van de Hulst's
 * fit of its spherical albedo, (1 - s)(1 - 0.139 s)/(1 + 1.17 s), s^2 = (1 - a)/(1 - g a)
 * (Multiple Light Scattering, 1980, volume 2; the inverse as in Kulla and Conty 2017). Within
 * 0.0025 for g = 0. */
float lf_subsurface_albedo(float albedo, float g);

/* The flesh in which a path goes on that leaves the event along w. */
lf_subsurface lf_subsurface_beyond(const lf_event *from, lf_vec3 w);

/* lf_path_next in out->flesh, which is there, of a path that carries beta: up to the surface that
 * the walk meets, be it that of the mesh or a thing inside. An escape with nothing left where all
 * is absorbed, or where the walk leaves the scene's box, the mesh not being closed. Ways are drawn
 * for one channel and weighed for all (interior.h). */
void lf_subsurface_walk(lf_tracer *tracer, const lf_event *from, lf_vec3 w, lf_vec3 beta,
                        lf_event *out);

#endif
