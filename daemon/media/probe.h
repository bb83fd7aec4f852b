/* probe: what ffprobe tells of a video. Private to daemon/media, and to its tests. */
#ifndef LF_DAEMON_PROBE_H
#define LF_DAEMON_PROBE_H

#include "daemon/media/movie.h"

/* Reads ffprobe's JSON of n bytes, from any source. file: for errors. LF_E_FORMAT: it is no JSON,
 * has no video stream, or a size or rate outside the limits of movie.h. */
LF_NODISCARD lf_status lf_probe_parse(const char *json, size_t n, const char *file,
                                      lf_movie_info *out, lf_error *err);
/* Runs ffprobe on fd, which stays the caller's. Errors of lf_movie_open. */
LF_NODISCARD lf_status lf_probe_run(int fd, const char *demuxer, const char *file,
                                    bool (*stopped)(void), lf_movie_info *out, lf_error *err);

#endif
