/* Meshes that stand in many places (scene/placed.h), cut by a row's plane; private to render/rows/.
 *
 * Rows keep no lists of them. A visit walks the boxes of all places that its plane meets where
 * views look, and in each the boxes of the mesh's triangles, with the plane brought there: what it
 * costs and the memory it takes go with what is cut, however many places there are. How many
 * segments that is nobody knows before: a section that has no room counts to the end, grows, and
 * cuts again. It keeps what it has grown to, so that this happens a few times in a worker's life.
 */
#ifndef LF_RENDER_SECTION_INSTANCES_H
#define LF_RENDER_SECTION_INSTANCES_H

#include "render/plane/section.h"

/* Puts the segments of all places behind the n that the section has; returns how many it has then.
 * Of more than LF_SECTION_MOST it finds some.
 * Where there is not enough room, they are counted alone: the section has to grow to that number
 * and more than that, and its places' slots to places.n, and be cut anew. */
size_t lf_section_cut_instances(lf_section *section, const lf_row_triangles *rows,
                                const lf_scene *scene, const lf_rig *rig, const lf_row_plane *plane,
                                lf_cut_what what, size_t n);

/* The number, as leaves have it, of the segment of a hit on such a mesh; UINT32_MAX: it has none.
 */
uint32_t lf_section_instance_number(const lf_section *section, const lf_hit *on);
/* The triangle that a segment of such a number is cut from. */
void lf_section_instance_face(const lf_section *section, const lf_scene *scene, uint32_t number,
                              lf_face *out);

#endif
