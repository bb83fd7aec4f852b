/* The albedo by which images are divided before smoothing (docs/developer/reconstruction.md,
 * "Albedo"); private to render/. */
#ifndef LF_RENDER_ALBEDO_H
#define LF_RENDER_ALBEDO_H

/* Albedo of a surface: red, green, blue, and its metallic share; all in [0, 1]. */
enum { LF_ALBEDO_METAL = 3, LF_ALBEDO_NUMBERS };

/* Smallest albedo that is distinguished from 0. */
#define LF_LEAST_ALBEDO 0.02f

#endif
