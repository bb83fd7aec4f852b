/* Shared by the kinds of output: conversion between 8-bit and float views, attributes, common parts
 * of prints and charts. */
#ifndef LF_DAEMON_OUTPUT_INTERNAL_H
#define LF_DAEMON_OUTPUT_INTERNAL_H

#include "daemon/output/output.h"

/* LF_E_CANCELLED, with err filled, if the job was cancelled. */
lf_status output_check_cancel(const lf_output_request *request, lf_error *err);
void output_progress(const lf_output_request *request, double fraction);

/* The attributes in request->settings. */
#define OUTPUT_MAX_ATTRIBUTES 40
typedef struct output_attributes {
    int n;
    lf_attribute list[OUTPUT_MAX_ATTRIBUTES];
    char name[OUTPUT_MAX_ATTRIBUTES][64];
    char value[OUTPUT_MAX_ATTRIBUTES][320];
} output_attributes;
/* Points into itself: do not copy. */
void output_attributes_fill(output_attributes *attributes, const json_t *settings);

/* 8-bit views of any source: its own, or tone-mapped ones in *out_buffer, which the caller frees
 * with lf_free. */
lf_status output_views8(const lf_output_request *request, const lf_output_source *source,
                        lf_views8 *out, uint8_t **out_buffer, lf_error *err);
/* Linear views of any source, for file writers: its own, or its 8-bit codes with their linear
 * values in `light`, which the views point to. */
lf_views32 output_views32(const lf_output_source *source, float light[256]);

/* The n middle views of source; if the rest is odd, one more is dropped on the left. layers:
 * storage for its views32.layers. */
lf_output_source output_middle(const lf_output_source *source, int n, lf_layers32 *layers);

/* The name of a quilt, and of a single view (`complete` of lf_output_kind). */
lf_status output_quilt_path(const char *path, const lf_layout *layout, char **out_path,
                            lf_error *err);
lf_status output_still_path(const char *path, const lf_layout *layout, char **out_path,
                            lf_error *err);
/* Their endings, and the writer of the request's layout in the format of the ending. */
extern const char *const output_quilt_endings[];
lf_status output_quilt_write(const lf_output_request *request, const lf_output_source *source,
                             lf_outfile *files, lf_error *err);
/* Prints and charts are a TIFF or PDF and its manifest "OUT.json": their endings and file names. */
extern const char *const output_print_endings[];
char *output_print_file(const char *path, int i);
/* The part of the request that the print writer needs. */
lf_print_run output_print_run(const lf_output_request *request);

#endif
