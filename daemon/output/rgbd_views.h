/* rgbd_views: the layout of the views of a picture with depth, by options and panel. Thread: any.
 */
#ifndef LF_DAEMON_RGBD_VIEWS_H
#define LF_DAEMON_RGBD_VIEWS_H

#include "daemon/output/options.h"

/* How many views, their size and their shape: as lf_resolve_view, for a scene whose views have the
 * picture's aspect. LF_E_ARG. */
LF_NODISCARD lf_status lf_rgbd_layout(const lf_options *options, double aspect,
                                      const lf_calibration *calibration, lf_layout *out,
                                      lf_error *err);
/* The views of a picture with depth, drawn with threads of its own. */
LF_NODISCARD lf_status lf_rgbd_draw(const lf_rgbd_file *file, const char *name,
                                    const lf_options *options, const lf_layout *layout,
                                    lf_quilt_file *out, lf_error *err);
/* lf_quilt_stand with this many threads of its own; 0: one per processor. */
LF_NODISCARD lf_status lf_rgbd_stand(const lf_standing *standing, int threads, const char *name,
                                     lf_quilt_file *quilt, lf_error *err);
/* The layout for a print, which must have its number of views: the picture's shape, and no more
 * pixels than the print shows. print: checked. */
lf_layout lf_rgbd_print_layout(const lf_rgbd_file *file, const lf_print *print);
/* Makes the depth of unknown geometry so flat that at depthiness 1 no point moves by more than a
 * lens from view to view. Known geometry stays. Returns the largest shift in lenses, with
 * depthiness and focus. */
double lf_rgbd_print_depth(lf_rgbd_file *file, const lf_print *print);
/* What to say of a shift of more than one lens: one line with a remedy. depthiness: as given.
 * Returns buf. */
char *lf_rgbd_print_words(const lf_rgbd *rgbd, double depthiness, double shift, char *buf,
                          size_t size);

#endif
