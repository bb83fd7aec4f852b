/* What the simulated panel of a live test shows, against interlacing a quilt file. */
#ifndef LF_TESTS_DAEMON_LIVE_PANEL_H
#define LF_TESTS_DAEMON_LIVE_PANEL_H

#include "tests/daemon/live.h"

#include "base/calibration.h"
#include "base/image_io.h"
#include "quilt/quilt.h"

/* How many bytes of the panel's last picture are not what interlacing the quilt gives. */
static inline long live_panel_differences(const live *l, const char *quilt_path)
{
    lf_calibration calibration;
    lf_quilt_file quilt;
    lf_interlacer *interlacer;
    lf_image8 panel = {0}, expected = {0};
    lf_error err;
    lf_assert_ok(
        lf_calibration_load(lf_test_path(l->folder, "sim/calibration.json"), &calibration, &err),
        &err);
    lf_assert_ok(lf_quilt_read(quilt_path, NULL, 0, 0, &quilt, &err), &err);
    lf_assert_ok(lf_interlacer_create(&calibration, quilt.layout.n_views, quilt.layout.view_width,
                                      quilt.layout.view_height, quilt.layout.aspect,
                                      LF_FILTER_NEAREST, LF_INVERT_AUTO, &interlacer, &err),
                 &err);
    lf_assert_ok(lf_image8_init(&expected, 96, 128, 3), NULL);
    lf_interlace(interlacer, &quilt.views8, &expected, NULL);
    lf_assert_ok(lf_image8_read(l->panel, NULL, &panel, &err), &err);
    long differences = 0;
    for (int y = 0; y < 128; y++) {
        for (size_t i = 0; i < 96 * 3; i++) {
            differences += panel.data[(size_t)y * panel.stride + i] !=
                           expected.data[(size_t)y * expected.stride + i];
        }
    }
    lf_image8_finish(&panel);
    lf_image8_finish(&expected);
    lf_interlacer_destroy(interlacer);
    lf_quilt_finish(&quilt);
    return differences;
}

/* Of a picture that stands still. Before the end: there a slow disk has the last one left out. */
static inline void live_wait_for_panel(const live *l, const char *quilt_path)
{
    char path[PATH_MAX]; /* lf_test_path forgets */
    long differences = 1;
    snprintf(path, sizeof path, "%s", quilt_path);
    live_wait_for_file(l->panel);
    for (int i = 0; i < LIVE_PATIENCE_S * 10 && differences > 0; i++, live_nap(100))
        differences = live_panel_differences(l, path);
    assert_int_equal(differences, 0);
}

#endif
