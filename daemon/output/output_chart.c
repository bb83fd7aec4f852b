/* Pitch test charts. */
#include "daemon/output/content.h"
#include "daemon/output/output_internal.h"

static lf_status check(const lf_print *print, const char **out_warning, lf_error *err)
{
    if (out_warning)
        *out_warning = NULL;
    return lf_chart_check(print, err);
}

static lf_status write_files(const lf_output_request *request, const lf_output_source *source,
                             lf_outfile *files, lf_error *err)
{
    const lf_print_run run = output_print_run(request);
    lf_image_notes notes = {0};
    (void)source;
    lf_chart_note(request->print, &notes);
    lf_log_notes(&notes, request->path);
    return lf_chart_write(request->print, &run, &files[0], &files[1], err);
}

const lf_output_kind lf_output_chart = {.name = "chart",
                                        .what = "a chart",
                                        .endings = output_print_endings,
                                        .option = "chart",
                                        .is_drawn = true,
                                        .asks = "lpi, range, step, width and height (mm)",
                                        .n_files = 2,
                                        .reads = "print chart print-size orientation icc bits "
                                                 "compress mirror",
                                        .check_print = check,
                                        .file_name = output_print_file,
                                        .write = write_files};
