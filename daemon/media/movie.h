/* movie: an open quilt video: its descriptor, its properties as ffprobe tells them, and how its
 * pictures are cut into views. Immutable once open. The lf_player of a video owns it.
 *
 * Thread: any. */
#ifndef LF_DAEMON_MOVIE_H
#define LF_DAEMON_MOVIE_H

#include "quilt/quilt.h"

#define LF_MOVIE_SIDE 8192 /* pixels, at most */
#define LF_MOVIE_LEAST_FPS 0.01
#define LF_MOVIE_MOST_FPS 240

/* Which matrix leads from YUV to RGB. */
typedef enum lf_movie_matrix { LF_MATRIX_BT601, LF_MATRIX_BT709, LF_MATRIX_BT2020 } lf_movie_matrix;

/* What ffprobe tells of the first video stream. */
typedef struct lf_movie_info {
    int width, height;   /* of a decoded picture, before it is rotated */
    int orientation;     /* of lf_orient, by which players rotate it: 1, 3, 6 or 8 */
    double pixel_aspect; /* width / height of a pixel before it is rotated; 1 = square */
    int rate, per;       /* frames per second: rate / per */
    double seconds;      /* duration; 0 = unknown */
    int64_t n_frames;    /* as the file says, or from the duration; 0 = unknown */
    lf_movie_matrix matrix;
    char codec[32]; /* such as "h264" */
} lf_movie_info;

/* How decoded pictures are cut into views. */
typedef struct lf_movie_cut {
    int left, top;               /* of the part of a decoded picture that is kept */
    int width, height;           /* of this part, rotated */
    int orientation;             /* of lf_orient, by which ffmpeg rotates the picture */
    int columns, rows;           /* tiles of the rotated picture */
    int tile_width, tile_height; /* of the rotated picture; views are as large */
    /* view of a tile: [row from the top][column] */
    uint16_t view_of[LF_MAX_TILES * LF_MAX_TILES];
} lf_movie_cut;

typedef struct lf_movie {
    char *file;
    int fd;              /* of the file */
    const char *demuxer; /* ffmpeg's name of the format, by the file's magic */
    lf_movie_info info;
    lf_movie_cut cut;
    size_t frame_bytes; /* of the views of a frame, one below the other, view 0 first */
    lf_layout layout;   /* as shown; views may be cut by --photo fill */
    /* views of a frame as shown; data is NULL */
    lf_views8 views;
    size_t first;         /* offset of its first byte in a frame */
    lf_image_notes notes; /* as of a picture: padding and cuts */
} lf_movie;

/* ffmpeg's demuxer for a file with these first n bytes; NULL: not a video. GIF counts if it is
 * named. */
const char *lf_movie_demuxer(const uint8_t *head, size_t n);
/* True when path names a file that starts like a video: MP4, QuickTime, Matroska, WebM, AVI or
 * GIF. */
bool lf_is_movie(const char *path, const lf_roots *roots);
/* True if a name ends like a video. */
bool lf_movie_ending(const char *name);

/* Opens a video under the read rule. columns, rows 0: from the name. photo as for pictures (is not
 * NULL). stopped (may be NULL) is asked while ffprobe works. Release with lf_movie_finish.
 * LF_E_ARG: the name has no tiles; LF_E_FORMAT: not a video, or too large; LF_E_IO: no ffprobe;
 * LF_E_TIMEOUT; LF_E_CANCELLED; errors of lf_roots_open. */
LF_NODISCARD lf_status lf_movie_open(const char *path, const lf_roots *roots, int columns, int rows,
                                     const lf_photo *photo, bool (*stopped)(void), lf_movie *out,
                                     lf_error *err);
/* Accepts a zeroed struct whose fd is -1. */
void lf_movie_finish(lf_movie *movie);

/* Frames per second. */
static inline double lf_movie_fps(const lf_movie *movie)
{
    return (double)movie->info.rate / movie->info.per;
}

#endif
