/* restir (docs/developer/papers.md): Volumetric ReSTIR by Lin, Wyman and Yuksel (2021), for each
 * view separately. A visit gives every view pixel that it takes a ray and a reservoir of
 * LF_RESTIR_WALKS walks (light_path.h). It combines the reservoir with the one that an earlier
 * visit of the same half left in the pixel (--reuse; M capped), and with the reservoirs of
 * LF_RESTIR_NEIGHBOURS columns of its row, drawn within LF_RESTIR_REACH. It adds the light of all
 * of them, corrected by the exact transmittances of the kept path (lf_path_sample_radiance), to the
 * light behind the media. W of the film is n: every estimate is N/n. Halves never read each other's
 * reservoirs. Reservoirs are not part of the film: a film read from a file continues with new ones.
 *
 * With blocks (--reuse vertices) pixels have LF_RESTIR_BLOCK_WALKS walks, and the pixels of a block
 * of LF_RESTIR_BLOCK_COLUMNS columns share all of their paths (vertex_reuse.h). Each visit has its
 * own offset of the blocks. A visit that takes few of a view's columns leaves few pixels in a
 * block.
 *
 * mvrestir is restir with neighbours in other views, LF_MVRESTIR_VIEWS to either side, near the
 * same position in the window. There the first vertex's distance is counted from the window, so
 * that points in the window do not move; the Jacobian is 1 as before. Its blocks are
 * LF_MVRESTIR_BLOCK_COLUMNS columns of LF_MVRESTIR_BLOCK_VIEWS views. */
#ifndef LF_RENDER_RESTIR_H
#define LF_RENDER_RESTIR_H

#include "render/integrator.h"

extern const lf_integrator lf_integrator_restir;

#define LF_RESTIR_WALKS 8
#define LF_RESTIR_BLOCK_WALKS 2 /* for pixels in blocks */
#define LF_RESTIR_NEIGHBOURS 3
#define LF_RESTIR_BLOCK_COLUMNS 16 /* columns */
#define LF_RESTIR_REACH 10         /* columns */
#define LF_MVRESTIR_VIEWS 4
#define LF_MVRESTIR_REACH 2 /* columns */
#define LF_MVRESTIR_BLOCK_VIEWS 8
#define LF_MVRESTIR_BLOCK_COLUMNS 2 /* columns */
#define LF_RESTIR_HISTORY 20        /* cap of an earlier reservoir's M, in units of a visit's M */

#endif
