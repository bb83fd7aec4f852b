/* What the two passes over the files share; private to film_merge*.c. */
#ifndef LF_RENDER_FILM_MERGE_INTERNAL_H
#define LF_RENDER_FILM_MERGE_INTERNAL_H

#include <sys/stat.h>

#include "render/film/film_merge.h"
#include "render/film/film_part.h"

/* Consecutive rows of a file with the same number of passes. */
typedef struct lf_merging_range {
    double passes;
    int first, n;
} lf_merging_range;

/* A stream of a file. */
typedef struct lf_merging_stream {
    uint64_t seed;
    off_t at; /* of its part */
    uint32_t number;
    int file;
} lf_merging_stream;

/* Hashes of what was read, to find copies and files that change. */
typedef struct lf_merging_digest {
    uint64_t streams, rows;
} lf_merging_digest;

typedef struct lf_merging_source {
    char *path;
    off_t at, rows_at; /* of the film and of its first row */
    struct stat seen;
    lf_merging_digest first, second; /* of both passes */
    int first_range, n_ranges, first_stream, n_streams;
    int copy_of; /* -1: none */
    uint32_t tie;
} lf_merging_source;

/* A growing array. */
typedef struct lf_merging_list {
    void *data;
    int n, n_allocated;
} lf_merging_list;

struct lf_merging {
    lf_film like; /* identity, layout and sky of the first file */
    lf_merging_list files, ranges, streams;
    int *order;  /* [files.n] */
    int *sorted; /* [streams.n] of used files: by seed, number, order */
    int n_sorted;
    uint64_t *key;                /* [height] of all visits of a row */
    int *n_holders;               /* [height] files that have a row */
    double *passes;               /* [height] */
    bool *whole;                  /* [height] any visit is not coarse */
    lf_film_counts *counts, *sum; /* [height] room for streams */
    int *owner;                   /* [height] room */
    uint32_t heads;               /* of what is written (film_part.h) */
    int fd, open;                 /* the file that is open, and its number; -1: none */
};

lf_merging_source *lf_merging_source_at(const lf_merging *m, int file);
const lf_merging_range *lf_merging_range_at(const lf_merging *m, int index);
const lf_merging_stream *lf_merging_stream_at(const lf_merging *m, int index);

/* The file name as the place of an error that film_part.h has set; returns its status. */
lf_status lf_merging_blame(const char *path, const lf_error *why, lf_error *err);
/* "changed while it was read". */
lf_status lf_merging_changed(const char *path, lf_error *err);
/* Opens a file again, unless it is open, and seeks. */
LF_NODISCARD lf_status lf_merging_seek(lf_merging *m, int file, off_t at, lf_error *err);
/* Reads a stream's counts into m->counts; adds its head to *digest. */
LF_NODISCARD lf_status lf_merging_read_stream(lf_merging *m, const lf_merging_stream *stream,
                                              uint64_t *digest, lf_error *err);
/* Adds bytes to a digest; n is a multiple of 8. */
uint64_t lf_merging_digest_add(uint64_t digest, const unsigned char *bytes, size_t n);
/* The end of the entries of m->sorted with the stream of entry `from`. */
int lf_merging_group_end(const lf_merging *m, int from);
/* Bytes of a row's part in files of this layout. */
size_t lf_merging_row_bytes(const lf_film_layout *layout);

#endif
