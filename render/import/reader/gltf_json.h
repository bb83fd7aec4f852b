/* What glTF writes in JSON, looked up by people who trust none of it: what is of another type than
 * it should be counts as not said. */
#ifndef LF_RENDER_GLTF_JSON_H
#define LF_RENDER_GLTF_JSON_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* More than any array has elements: what is not said, or negative, or no whole number. */
#define LF_GLTF_NONE UINT32_MAX

/* A whole number that is not negative; unsaid where there is none. Beyond 2^53: 2^53. */
uint64_t lf_gltf_whole(const json_t *object, const char *key, uint64_t unsaid);
/* One that may be the place of something; LF_GLTF_NONE where there is none, or it is larger. */
uint32_t lf_gltf_index(const json_t *object, const char *key);
/* A number that is finite as a float. */
float lf_gltf_number(const json_t *object, const char *key, float unsaid);
/* As many numbers as there are in an array of exactly n; else *out stays as it is. */
bool lf_gltf_numbers(const json_t *object, const char *key, size_t n, double *out);
/* Never NULL. */
const char *lf_gltf_text(const json_t *object, const char *key);
/* A text of the file within one line of a warning: as many whole characters as fit into size bytes,
 * with ? for what would end the line. */
void lf_gltf_line(const char *text, char *out, size_t size);
/* The extension of a thing, which is an object; NULL: it has none. */
const json_t *lf_gltf_extension(const json_t *object, const char *name);
/* An element of an array of the document; NULL: there is none. */
const json_t *lf_gltf_element(const json_t *document, const char *array, uint64_t number);
size_t lf_gltf_count(const json_t *document, const char *array);

#endif
