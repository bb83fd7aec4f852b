/* Words of other renderers' files, and their replacements here; private to render/import/scene/. */
#ifndef LF_RENDER_FOREIGN_WORDS_H
#define LF_RENDER_FOREIGN_WORDS_H

#include "render/import/scene/json_reader.h"

/* Fail the reader with an explanation in two cases: the "type" of a material or light is another
 * renderer's word, or a key belongs to another renderer or another type of light. Other words are
 * left to the caller. */
void lf_refuse_foreign_material(lf_reader *reader, const lf_node *material);
void lf_refuse_foreign_light(lf_reader *reader, const lf_node *light);

#endif
