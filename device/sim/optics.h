/* Simulates by geometry what an eye in front of a panel sees. A check of the interlacer that shares
 * no code with it, and the source of the simulated device's view.png.
 *
 * The panel is a plane of light-emitting subpixels, measured in millimetres from its lower left
 * corner. Above it are cylindrical lenses whose axes all have the same slant. A lens is one pitch
 * wide, measured across its axis.
 *
 * For an eye straight in front of the panel, at the calibrated distance, each lens magnifies the
 * strip of emitters under its axis until the strip fills the lens. An eye further to the right sees
 * a strip further left. Moving through the view cone once shifts the strip by one lens width; then
 * the neighbouring strip appears and the views repeat. Along its axis a lens does not focus, so the
 * eye sees the emitters at their true position. */
#ifndef LF_DEVICE_OPTICS_H
#define LF_DEVICE_OPTICS_H

#include "base/calibration.h"
#include "base/image.h"

typedef struct lf_sim_optics lf_sim_optics;

/* eye_deg: horizontal angle of the eye from the panel's normal, positive = to the right. LF_E_ARG:
 * the panel cannot resolve the lens: it is narrower than two pixels, wider than the panel, or
 * nearer to horizontal than to vertical. On LF_OK the caller owns *out. */
LF_NODISCARD lf_status lf_optics_create(const lf_calibration *calibration, double eye_deg,
                                        lf_sim_optics **out, lf_error *err);
/* Accepts NULL. */
void lf_optics_destroy(lf_sim_optics *optics);
/* Size of the seen image: two pixels per lens width, square pixels. */
void lf_optics_size(const lf_sim_optics *optics, int *out_width, int *out_height);
/* panel: the calibration's screen size, 3 channels. out: the size above, 3 channels. Both are sRGB
 * encoded; light is mixed linearly. Uses scratch memory of the object: one thread at a time. */
void lf_optics_view(lf_sim_optics *optics, const lf_image8 *panel, lf_image8 *out);

#endif
