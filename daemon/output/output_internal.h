/* What the kinds of output share: conversions between 8-bit and float views, attributes, and what
 * prints and charts have in common. */
#ifndef LF_DAEMON_OUTPUT_INTERNAL_H
#define LF_DAEMON_OUTPUT_INTERNAL_H

#include "daemon/output/output.h"

/* LF_E_CANCELLED when the job is to stop, with err filled. */
lf_status output_check_cancel(const lf_output_request *request, lf_error *err);
void output_progress(const lf_output_request *request, double fraction);

/* The attributes that request->settings holds. */
#define OUTPUT_MAX_ATTRIBUTES 32
typedef struct output_attributes {
    int n;
    lf_attribute list[OUTPUT_MAX_ATTRIBUTES];
    char name[OUTPUT_MAX_ATTRIBUTES][64];
    char value[OUTPUT_MAX_ATTRIBUTES][320];
} output_attributes;
/* Points into itself: do not copy. */
void output_attributes_fill(output_attributes *attributes, const json_t *settings);

/* 8-bit views of any source: the source's own, or tone-mapped ones in *out_buffer (released by the
 * caller with lf_free). */
lf_status output_views8(const lf_output_request *request, const lf_output_source *source,
                        lf_views8 *out, uint8_t **out_buffer, lf_error *err);
/* Linear views of any source, for what writes files: the source's own, or its codes with what they
 * mean in light, which they point to. */
lf_views32 output_views32(const lf_output_source *source, float light[256]);

/* The n views in the middle of those of source, of an odd rest the right ones. layers: room for
 * what its views32.layers become. */
lf_output_source output_middle(const lf_output_source *source, int n, lf_layers32 *layers);

/* The name of a quilt, and of one view alone (complete of lf_output_kind). */
lf_status output_quilt_path(const char *path, const lf_layout *layout, char **out_path,
                            lf_error *err);
lf_status output_still_path(const char *path, const lf_layout *layout, char **out_path,
                            lf_error *err);
/* What their names end in, and the picture of the request's layout in the format that says. */
extern const char *const output_quilt_endings[];
lf_status output_quilt_write(const lf_output_request *request, const lf_output_source *source,
                             lf_outfile *files, lf_error *err);
/* Of a TIFF and its manifest "OUT.json", which prints and charts are: their endings, and their
 * files' names. */
extern const char *const output_print_endings[];
char *output_print_file(const char *path, int i);
/* What a print's writer needs to know of the request. */
lf_print_run output_print_run(const lf_output_request *request);

#endif
