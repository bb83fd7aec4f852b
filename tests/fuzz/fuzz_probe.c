/* ffprobe's words: a video within the limits, or one line that says what is wrong. */
#include "tests/fuzz/fuzz.h"

#include <math.h>
#include <string.h>

#include "daemon/media/probe.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lf_movie_info info;
    lf_error err = {0};
    (void)lf_movie_demuxer(data, size);
    if (lf_probe_parse((const char *)data, size, "video.mp4", &info, &err) != LF_OK) {
        lf_fuzz_require(err.what[0] != '\0');
        lf_fuzz_require_text(err.what);
        return 0;
    }
    const double fps = (double)info.rate / info.per;
    lf_fuzz_require(info.width >= 1 && info.width <= LF_MOVIE_SIDE);
    lf_fuzz_require(info.height >= 1 && info.height <= LF_MOVIE_SIDE);
    lf_fuzz_require(info.rate > 0 && info.per > 0);
    lf_fuzz_require(fps >= LF_MOVIE_LEAST_FPS && fps <= LF_MOVIE_MOST_FPS);
    lf_fuzz_require(info.pixel_aspect > 0 && isfinite(info.pixel_aspect));
    lf_fuzz_require(info.seconds >= 0 && isfinite(info.seconds) && info.n_frames >= 0);
    lf_fuzz_require(info.orientation == 1 || info.orientation == 3 || info.orientation == 6 ||
                    info.orientation == 8);
    lf_fuzz_require(memchr(info.codec, '\0', sizeof info.codec));
    return 0;
}
