/* Merging the films of many files (film_file.h) of one image into one: rows of different files are
 * put together bit for bit; rows that several files have of different random streams are added, in
 * double precision, in an order that depends only on the films, and rounded once. The result is the
 * same for any order of the files.
 *
 *     lf_merging_create, lf_merging_add for each file, lf_merging_arrange, lf_merging_write,
 *     lf_merging_destroy
 *
 * Files are read twice, one at a time: first their counts, then their rows. Memory is about 300
 * bytes per file, and rows: 8 MB of them, for streams 128 MB, or one row if that is larger. Every
 * checksum is checked when its part is read, before anything is published. Errors name the file:
 * LF_E_IO, LF_E_FORMAT (damaged, or changed meanwhile), LF_E_STATE (another image or version,
 * samples twice), LF_E_NOMEM. After an error only lf_merging_destroy may follow. Thread: one at a
 * time. */
#ifndef LF_RENDER_FILM_MERGE_H
#define LF_RENDER_FILM_MERGE_H

#include <stdint.h>

#include "render/render.h"

typedef struct lf_merging lf_merging;

/* What a file holds. */
typedef struct lf_merging_file {
    int n_views, width, height;
    int n_rows, first_row, last_row;  /* n_rows 0: no samples at all */
    double least_passes, most_passes; /* of a row of the film */
    uint64_t seed;                    /* of its first stream */
    uint32_t stream;
    int n_streams;
} lf_merging_file;

/* What all files hold together. */
typedef struct lf_merging_total {
    int n_files; /* without copies */
    int n_rows, first_row, last_row;
    int least_row, most_row;          /* rows with the least and the most passes */
    double least_passes, most_passes; /* of a row that is there */
    double passes;                    /* sum over all rows */
    int n_streams;                    /* seeds and numbers */
} lf_merging_total;

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_merging_create(lf_merging **out, lf_error *err);
void lf_merging_destroy(lf_merging *merging);

/* Reads the counts of the film that begins at the position of fd, up to the end of the file, and
 * remembers path, under which the file is opened again. Files are numbered from 0 in the order of
 * calls; the first one says which image and layout all must have. tie decides the order of copies.
 */
LF_NODISCARD lf_status lf_merging_add(lf_merging *merging, int fd, const char *path, uint32_t tie,
                                      lf_merging_file *out, lf_error *err);

/* Puts the files into their order and finds copies: films with the same bytes count once.
 * LF_E_STATE if a row has samples of the same stream in two films, or rows of two films have the
 * same passes of a stream in different visits, or no film has any. */
LF_NODISCARD lf_status lf_merging_arrange(lf_merging *merging, lf_merging_total *out,
                                          lf_error *err);
/* The k-th file in the order, k from 0 to the number of calls of lf_merging_add - 1. */
int lf_merging_at(const lf_merging *merging, int k);
/* The file of which this one is a copy, which is not used; -1: it is used. */
int lf_merging_copy_of(const lf_merging *merging, int file);
/* The first file in the order that has a row; -1: none. */
int lf_merging_holder(const lf_merging *merging, int row);
/* The first rows that no file has, inclusive, from row `from` on; false: none. */
bool lf_merging_gap(const lf_merging *merging, int from, int *out_first, int *out_last);

/* "row 3" or "rows 3 to 5"; returns buf. */
const char *lf_merging_rows_text(int first, int last, char *buf, size_t size);

/* Called between 0 and 1 while rows are written. */
typedef void (*lf_merging_fn)(void *context, double done);

/* Appends the merged film to a file. progress and cancel may be NULL. LF_E_CANCELLED: cancel was
 * set. After any error the caller must abandon the file. */
LF_NODISCARD lf_status lf_merging_write(lf_merging *merging, lf_outfile *file,
                                        lf_merging_fn progress, void *context,
                                        const lf_cancel *cancel, lf_error *err);

#endif
