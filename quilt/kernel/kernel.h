/* The loops of quilt/ over every sample of a frame, behind a table of functions with one file per
 * instruction set. kernel_c.c is the reference, which the others must equal to the bit. base/cpu.h
 * selects the table. Private to quilt/. */
#ifndef LF_QUILT_KERNEL_H
#define LF_QUILT_KERNEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Bytes that lf_quilt_kernels.interlace may read past the last sample. */
#define LF_INTERLACE_SLACK 3

/* Parameters for the views of the subpixels of a row. phase = (across + along) * pitch - center in
 * lens periods. z = fract(phase), or 1 - fract(phase) if from_right, clamped into the open
 * interval, times n_views. across[i] belongs to subpixel i, along[i % 6] to its parity and
 * channel. */
typedef struct lf_places {
    const double *across;
    double along[6];
    double pitch, center;
    bool from_right;
    int n_views;
} lf_places;

/* Table from floats to codes (tone.c). The bits of a float are clamped to low .. high, and low is
 * subtracted. The leading bits select the bucket. Its entry is the lower code | offset of the next
 * code's first float << 8. */
typedef struct lf_tone_table {
    const uint32_t *entries;
    int32_t low, high;
    int shift;
} lf_tone_table;

typedef struct lf_quilt_kernels {
    const char *name;
    /* out[i] = from[view[i] * stride + place[i]], i < n. */
    void (*interlace)(size_t n, const uint8_t *view, const uint16_t *place, uint32_t stride,
                      const uint8_t *from, uint8_t *out);
    /* The views of n subpixels: views8 for n_views <= 256, views16 for any. */
    void (*views8)(const lf_places *places, size_t n, uint8_t *out);
    void (*views16)(const lf_places *places, size_t n, uint16_t *out);
    /* n samples. */
    void (*tone)(const lf_tone_table *table, size_t n, const float *in, uint8_t *out);
} lf_quilt_kernels;

extern const lf_quilt_kernels lf_quilt_kernels_c;
#if defined(__x86_64__)
extern const lf_quilt_kernels lf_quilt_kernels_avx2;
#endif

/* The table in use. Thread safe. */
const lf_quilt_kernels *lf_quilt_kernels_get(void);

/* Tables this CPU can run, the reference first; NULL after the last. */
const lf_quilt_kernels *lf_quilt_kernels_at(int index);

#endif
