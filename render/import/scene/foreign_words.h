/* Words of other renderers' files, and what is said for them here; private to render/import/scene/.
 */
#ifndef LF_RENDER_FOREIGN_WORDS_H
#define LF_RENDER_FOREIGN_WORDS_H

#include "render/import/scene/json_reader.h"

/* Fail the reader at a material, or light, whose "type" is another renderer's name for what is
 * called otherwise here, or that has a key of another renderer's or of another type of lights, and
 * say how. Any other word is left to who reads it. */
void lf_refuse_foreign_material(lf_reader *reader, const lf_node *material);
void lf_refuse_foreign_light(lf_reader *reader, const lf_node *light);

#endif
