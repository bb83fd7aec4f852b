/* Instanced meshes (scene/instances.h), cut by a row's plane; private to render/plane/.
 *
 * Rows keep no lists of them. A visit walks the boxes of all instances that its plane meets within
 * the views, and in each the boxes of the mesh's triangles, with the plane transformed to the mesh.
 * Cost and memory grow with the number of cut segments, not with the number of instances. This
 * number is unknown in advance: a section without enough room counts all segments, grows, and cuts
 * again. It keeps its size, so this happens a few times in a worker's life. */
#ifndef LF_RENDER_SECTION_INSTANCES_H
#define LF_RENDER_SECTION_INSTANCES_H

#include "render/plane/section.h"

/* Adds the segments of all instances after the n that the section has, and returns the new number.
 * If there are more than LF_SECTION_MOST it finds only some. If there is not enough room it only
 * counts: the section must then grow to more than that number of segments, and to places.n slots,
 * and be cut again. */
size_t lf_section_cut_instances(lf_section *section, const lf_row_triangles *rows,
                                const lf_scene *scene, const lf_rig *rig, const lf_row_plane *plane,
                                lf_cut_what what, size_t n);

/* The leaf number of the segment of a hit on an instanced mesh; UINT32_MAX: it has no segment. */
uint32_t lf_section_instance_number(const lf_section *section, const lf_hit *on);
/* The triangle that a segment of such a number is cut from. */
void lf_section_instance_face(const lf_section *section, const lf_scene *scene, uint32_t number,
                              lf_face *out);

#endif
