/* The tables of docs/reference that are made from the tables of the programs.
 *
 * A page has <!-- table: NAME --> and <!-- end --> on lines of their own; the table is between
 * them. NAME begins with the word of its family: "method wait", "options print", "scene camera".
 * `make docs` writes the tables into the pages, and test_tables compares them. */
#ifndef LF_TESTS_TABLES_H
#define LF_TESTS_TABLES_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

/* Paths of the pages in the source tree; NULL behind the last. */
extern const char *const lf_table_pages[];
#define lf_table_scene_page "docs/reference/scene-format.md"

/* What tables are made from. */
typedef struct lf_table_source {
    json_t *schema;    /* docs/scene.schema.json */
    const char *build; /* folder of the programs, whose --help is read */
    const char *page;  /* text of the page: "see HEADING" becomes a link */
    /* text of scene-format.md, where other pages find headings that are not their own */
    const char *scene_page;
} lf_table_source;

/* Call it once, before all others. */
void lf_tables_init(void);

/* The page with every table as it has to be (free). *out_name: the first table that differs, or is
 * not known, or has no end; "": none. NULL: it is one of the last two. */
char *lf_tables_fill(const lf_table_source *source, char *out_name, size_t size);

/* Prints a table of a family; name is what follows the word of the family. false: no such table. */
bool lf_table_method(const lf_table_source *source, const char *name, FILE *out);
bool lf_table_options(const lf_table_source *source, const char *name, FILE *out);
bool lf_table_scene(const lf_table_source *source, const char *name, FILE *out);

/* The names that must be on some page, in turn; NULL behind the last. */
const char *lf_table_method_at(int index);
const char *lf_table_options_at(int index);
const char *lf_table_scene_at(int index);

/* Prints a text as a cell: words that are names as code, "see HEADING" as a link. words: a JSON
 * array of words that are code before a colon; may be NULL. */
void lf_table_text(const lf_table_source *source, const char *text, const json_t *words, FILE *out);

/* "1e9", "0.001", "16". */
void lf_table_number(double value, FILE *out);

/* The text without a default in brackets at its end, "whole size (560)", which goes to
 * default_text; returns kept. */
char *lf_table_default(const char *text, char *kept, char *default_text, size_t size);

#endif
