/* Reading glTF JSON that is not trusted: a value of the wrong type counts as absent. */
#ifndef LF_RENDER_GLTF_JSON_H
#define LF_RENDER_GLTF_JSON_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Larger than any array index: for values that are absent, negative or not integers. */
#define LF_GLTF_NONE UINT32_MAX

/* A non-negative integer; `unsaid` if it is absent. Values beyond 2^53 become 2^53. */
uint64_t lf_gltf_whole(const json_t *object, const char *key, uint64_t unsaid);
/* An index; LF_GLTF_NONE if it is absent or larger. */
uint32_t lf_gltf_index(const json_t *object, const char *key);
/* A number that is finite as a float; `unsaid` if it is absent. */
float lf_gltf_number(const json_t *object, const char *key, float unsaid);
/* Reads an array of exactly n numbers; otherwise false, and *out is unchanged. */
bool lf_gltf_numbers(const json_t *object, const char *key, size_t n, double *out);
/* A string, or ""; never NULL. */
const char *lf_gltf_text(const json_t *object, const char *key);
/* Copies a text of the file for a one-line warning: as many whole characters as fit into size
 * bytes, with ? for line breaks. */
void lf_gltf_line(const char *text, char *out, size_t size);
/* The extension object of an object; NULL: none. */
const json_t *lf_gltf_extension(const json_t *object, const char *name);
/* An element of an array of the document; NULL: no such element. */
const json_t *lf_gltf_element(const json_t *document, const char *array, uint64_t number);
size_t lf_gltf_count(const json_t *document, const char *array);

#endif
