/* restir (docs/developer/papers.md): Volumetric ReSTIR as Lin, Wyman and Yuksel (2021) have it,
 * each view alone. A visit gives every view pixel that it takes a ray and a reservoir of
 * LF_RESTIR_WALKS walks (light_path.h), puts it together with what an earlier visit of the same
 * half left in the pixel (--reuse; M capped) and with those of LF_RESTIR_NEIGHBOURS columns of its
 * row drawn within LF_RESTIR_REACH, and adds what all of them bring, corrected by the exact
 * transmittances of the path that is kept (lf_path_sample_radiance), to what the ray sees behind
 * the media. W of the film is n: every answer is N/n. Halves never see each other's reservoirs.
 * What is kept is no part of the film: one that is read from a file goes on with new reservoirs.
 *
 * By blocks (--reuse vertices) pixels have LF_RESTIR_BLOCK_WALKS walks, and those of a block of
 * LF_RESTIR_BLOCK_COLUMNS columns all of their paths in common (vertex_reuse.h); where blocks begin
 * is the visit's. A visit that takes few of a view's columns leaves few pixels in a block.
 *
 * mvrestir is restir whose neighbours are pixels of other views, LF_MVRESTIR_VIEWS to either side,
 * near the same place in the window. The first vertex's distance counts from the window there, so
 * that what lies in it stays where it is; the Jacobian is 1 as before. Its
 * blocks are LF_MVRESTIR_BLOCK_COLUMNS columns of LF_MVRESTIR_BLOCK_VIEWS views. */
#ifndef LF_RENDER_RESTIR_H
#define LF_RENDER_RESTIR_H

#include "render/integrator.h"

extern const lf_integrator lf_integrator_restir;

#define LF_RESTIR_WALKS 8
#define LF_RESTIR_BLOCK_WALKS 2 /* of pixels in blocks */
#define LF_RESTIR_NEIGHBOURS 3
#define LF_RESTIR_BLOCK_COLUMNS 16 /* columns */
#define LF_RESTIR_REACH 10         /* columns */
#define LF_MVRESTIR_VIEWS 4
#define LF_MVRESTIR_REACH 2 /* columns */
#define LF_MVRESTIR_BLOCK_VIEWS 8
#define LF_MVRESTIR_BLOCK_COLUMNS 2 /* columns */
#define LF_RESTIR_HISTORY 20 /* visits' worth of M that an earlier reservoir counts at most */

#endif
