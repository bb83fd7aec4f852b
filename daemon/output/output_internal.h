/* What the parts of daemon/output/ share: the files of one job, and conversions between 8-bit and
 * float views. */
#ifndef LF_DAEMON_OUTPUT_INTERNAL_H
#define LF_DAEMON_OUTPUT_INTERNAL_H

#include "daemon/output/output.h"

/* The files of one job: opened together, published together. Zeroed is a valid empty set. */
typedef struct output_files {
    int n;
    lf_outfile *file; /* [n] */
} output_files;

/* Opens paths[n], or takes over request->fds, which must then be n. On failure nothing is open (and
 * the fds are closed). */
lf_status output_files_open(output_files *files, const lf_output_request *request, int n,
                            const char *const *paths, lf_error *err);
lf_status output_files_commit(output_files *files, const lf_output_request *request, lf_error *err);
/* Accepts zeroed and committed sets. */
void output_files_abandon(output_files *files);
/* Closes request->fds, for a job that ends before its files were opened. */
void output_close_fds(const lf_output_request *request);

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
/* Linear float views of any source: the source's own, or decoded ones in *out_buffer (released by
 * the caller with lf_free). */
lf_status output_views32(const lf_output_request *request, const lf_output_source *source,
                         lf_views32 *out, float **out_buffer, lf_error *err);

/* The kinds. They take request->fds over. */
lf_status output_write_quilt(const lf_output_request *request, const lf_output_source *source,
                             lf_error *err);
lf_status output_write_panel(const lf_output_request *request, const lf_output_source *source,
                             lf_error *err);
lf_status output_write_views(const lf_output_request *request, const lf_output_source *source,
                             lf_error *err);
lf_status output_write_print(const lf_output_request *request, const lf_output_source *source,
                             lf_error *err);

/* True when text ends with ending, whatever the case. */
bool output_has_ending(const char *text, const char *ending);

#endif
