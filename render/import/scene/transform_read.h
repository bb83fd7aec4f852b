/* Reading transforms and instances of a scene; private to render/. Errors persist in the reader, as
 * in json_reader.h. docs/reference/scene-format.md is the manual. */
#ifndef LF_RENDER_TRANSFORM_READ_H
#define LF_RENDER_TRANSFORM_READ_H

#include "render/import/scene/scene_parse.h"

/* Fails at node unless a map has an inverse (affine.h). */
void lf_refuse_flat(lf_reader *reader, const lf_node *node, const lf_affine *a);

/* Node's "transform"; the identity if it has none. */
lf_affine lf_read_transform(lf_reader *reader, const lf_node *node);

/* Node's "instances": a list of transforms, each as above or as 12 or 16 numbers, or the name of a
 * file of them. */
void lf_read_instances(lf_reader *reader, const lf_node *node, lf_instances_desc *out);

#endif
