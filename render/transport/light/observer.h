/* Spectra seen by the CIE 1931 standard observer; private to render/. The matching functions are
 * the fit of Wyman, Sloan and Shirley (JCGT 2(2), 2013, the multi-lobe one). */
#ifndef LF_RENDER_OBSERVER_H
#define LF_RENDER_OBSERVER_H

/* x, y and z of light of this wavelength; y is about 1 at 556 nm. */
void lf_observer(double nm, double out_xyz[3]);

/* XYZ to linear Rec. 709, whose white (D65) of Y = 1 is 1 1 1 (IEC 61966-2-1). Colours outside of
 * the gamut have a negative component. */
void lf_xyz_to_rgb(const double xyz[3], double out_rgb[3]);

#endif
