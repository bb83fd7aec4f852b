/* Scenes of tests by name: tests/scenes/NAME.json, and variants of them by JSON merge patches (RFC
 * 7396), which change, add or (null) remove members. A patch is a printf format in which '
 * stands for ". What cannot be read or patched fails the test by the scene's name. */
#ifndef LF_TESTS_SCENE_FILE_H
#define LF_TESTS_SCENE_FILE_H

#include <jansson.h>

/* The scene as text, with members in the order of the file, new ones last. It stays until the
 * program ends. Thread: the test's own. */
const char *lf_test_scene_text(const char *name);
__attribute__((format(printf, 2, 3))) const char *lf_test_scene_patched(const char *name,
                                                                        const char *patch, ...);
/* The scene with a number of views. */
const char *lf_test_scene_views(const char *name, int views);

/* The scene as a document: a new reference. */
json_t *lf_test_scene_document(const char *name);

/* JSON text in which ' stands for ", which `name` names in errors: a new reference. */
json_t *lf_test_json(const char *name, const char *text);

#endif
