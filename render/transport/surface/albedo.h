/* The albedo that pictures are divided by before they are smoothed
 * (docs/developer/reconstruction.md, "Albedo"); private to render/. */
#ifndef LF_RENDER_ALBEDO_H
#define LF_RENDER_ALBEDO_H

/* What surfaces send on: red, green, blue, and how much of them is metal; all in [0, 1]. */
enum { LF_ALBEDO_METAL = 3, LF_ALBEDO_NUMBERS };

/* Smallest colour that is told. */
#define LF_LEAST_ALBEDO 0.02f

#endif
