/* What an eye in front of a panel sees, by geometry alone: a check on the interlacer that shares
 * nothing with it, and the simulated device's view.png.
 *
 * The panel is a plane of light-emitting subpixels, measured in millimetres from its lower left
 * corner, under cylindrical lenses whose axes all lean by the same angle. A lens is one pitch wide,
 * measured across its axis. To an eye at the distance for which the panel was calibrated, straight
 * in front of it, every lens magnifies the strip of emitters under its axis until the strip fills
 * the lens; an eye to the right sees a strip further left, and one turn of the view cone walks over
 * one lens width, after which the neighbour's strip comes in (the views repeat). Along its axis a
 * lens does not focus, so there the eye sees the emitters where they are. */
#ifndef LF_DEVICE_OPTICS_H
#define LF_DEVICE_OPTICS_H

#include "base/calibration.h"
#include "base/image.h"

typedef struct lf_optics lf_optics;

/* eye_deg: horizontal angle of the eye from the panel's normal, positive = the eye is to the right.
 * LF_E_ARG when the lens cannot be resolved by the panel (narrower than two pixels, wider than the
 * panel, or nearer to horizontal than to vertical). On LF_OK the caller owns *out. */
LF_NODISCARD lf_status lf_optics_create(const lf_calibration *calibration, double eye_deg,
                                        lf_optics **out, lf_error *err);
/* Accepts NULL. */
void lf_optics_destroy(lf_optics *optics);
/* Size of the seen picture: two pixels a lens width, square pixels. */
void lf_optics_size(const lf_optics *optics, int *out_width, int *out_height);
/* panel: the calibration's screen size, 3 channels; out: the size above, 3 channels, both sRGB
 * encoded; light is mixed linearly. Uses scratch of the object: one thread at a time. */
void lf_optics_view(lf_optics *optics, const lf_image8 *panel, lf_image8 *out);

#endif
