#include "bench/metrics.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

typedef struct lf_block_mean {
    int view, x, y;
    double picture, reference;
} lf_block_mean;

#define GUARD 1e-4 /* fraction of the reference's squared mean, added to a block's squared mean */

void lf_metrics_begin(lf_metrics *metrics, int block, double epsilon)
{
    *metrics = (lf_metrics){.block = block, .epsilon = epsilon};
}

static bool finite3(const float *p)
{
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

static void add_pixel(lf_metrics *m, const float *reference, const float *picture,
                      double *block_picture, double *block_reference, int *block_pixels)
{
    bool finite_reference = finite3(reference);
    bool finite_picture = finite3(picture);
    m->n_nonfinite += !finite_picture;
    m->n_nonfinite_reference += !finite_reference;
    if (!finite_reference || !finite_picture)
        return;
    m->n_pixels++;
    m->n_holes += picture[0] == 0 && picture[1] == 0 && picture[2] == 0 &&
                  (reference[0] != 0 || reference[1] != 0 || reference[2] != 0);
    for (int c = 0; c < 3; c++) {
        double r = (double)reference[c];
        double x = (double)picture[c];
        m->sum_picture += x;
        m->sum_reference += r;
        m->sum_square += (x - r) * (x - r);
        m->sum_relative += (x - r) * (x - r) / (r * r + m->epsilon);
        *block_picture += x;
        *block_reference += r;
    }
    ++*block_pixels;
}

static lf_status store_block(lf_metrics *m, const lf_block_mean *block)
{
    if (m->n_stored == m->capacity) {
        size_t capacity = m->capacity ? 2 * m->capacity : 1024;
        lf_block_mean *more = lf_calloc(capacity, sizeof *more);
        if (!more)
            return LF_E_NOMEM;
        if (m->n_stored > 0)
            memcpy(more, m->stored, m->n_stored * sizeof *more);
        lf_free(m->stored);
        m->stored = more;
        m->capacity = capacity;
    }
    m->stored[m->n_stored++] = *block;
    return LF_OK;
}

/* Adds one block, clipped at the picture's edges. Only whole blocks count, or the only one there
 * is. */
static lf_status add_block(lf_metrics *m, lf_block_mean *block, int width, int height,
                           const float *reference, size_t reference_stride, const float *picture,
                           size_t picture_stride)
{
    int n = 0;
    int x1 = block->x + m->block < width ? block->x + m->block : width;
    int y1 = block->y + m->block < height ? block->y + m->block : height;
    bool whole = (block->x + m->block <= width || width < m->block) &&
                 (block->y + m->block <= height || height < m->block);
    for (int y = block->y; y < y1; y++)
        for (int x = block->x; x < x1; x++)
            add_pixel(m, reference + (size_t)y * reference_stride + (size_t)x * 3,
                      picture + (size_t)y * picture_stride + (size_t)x * 3, &block->picture,
                      &block->reference, &n);
    if (!whole || n == 0)
        return LF_OK;
    block->picture /= 3.0 * n;
    block->reference /= 3.0 * n;
    return store_block(m, block);
}

lf_status lf_metrics_add(lf_metrics *metrics, int view, int width, int height,
                         const float *reference, size_t reference_stride, const float *picture,
                         size_t picture_stride)
{
    for (int y = 0; y < height; y += metrics->block) {
        for (int x = 0; x < width; x += metrics->block) {
            lf_block_mean block = {.view = view, .x = x, .y = y};
            if (add_block(metrics, &block, width, height, reference, reference_stride, picture,
                          picture_stride) != LF_OK)
                return LF_E_NOMEM;
        }
    }
    return LF_OK;
}

static void keep_worst(lf_metrics *m, const lf_block_mean *block, double relative)
{
    int i = m->n_worst;
    while (i > 0 && fabs(m->worst[i - 1].relative) < fabs(relative)) {
        if (i < LF_WORST_BLOCKS)
            m->worst[i] = m->worst[i - 1];
        i--;
    }
    if (i == LF_WORST_BLOCKS)
        return;
    m->worst[i] = (lf_worst_block){block->view, block->x,       block->y,
                                   relative,    block->picture, block->reference};
    if (m->n_worst < LF_WORST_BLOCKS)
        m->n_worst++;
}

static void finish_blocks(lf_metrics *m)
{
    double sum = 0;
    double sum_bias = 0;
    double sum_bias_square = 0;
    double n = (double)m->n_stored;
    m->n_blocks = (int64_t)m->n_stored;
    for (size_t i = 0; i < m->n_stored; i++) {
        const lf_block_mean *block = &m->stored[i];
        double difference = block->picture - block->reference;
        double square =
            block->reference * block->reference + GUARD * m->reference_mean * m->reference_mean;
        double relative = square > 0 ? difference / sqrt(square)
                                     : (difference == 0 ? 0 : copysign(INFINITY, difference));
        sum += relative * relative;
        sum_bias += difference;
        sum_bias_square += difference * difference;
        keep_worst(m, block, relative);
    }
    if (n > 0)
        m->block_rms = sqrt(sum / n);
    if (n > 1)
        m->bias_se = sqrt(fmax(0, sum_bias_square - sum_bias * sum_bias / n) / (n - 1) / n);
}

void lf_metrics_finish(lf_metrics *metrics)
{
    double n = 3.0 * (double)metrics->n_pixels;
    if (n > 0) {
        metrics->picture_mean = metrics->sum_picture / n;
        metrics->reference_mean = metrics->sum_reference / n;
        metrics->bias = metrics->picture_mean - metrics->reference_mean;
        metrics->relative_mean =
            metrics->reference_mean != 0 ? metrics->bias / metrics->reference_mean : 0;
        metrics->rmse = sqrt(metrics->sum_square / n);
        metrics->rel_mse = metrics->sum_relative / n;
    }
    finish_blocks(metrics);
    lf_free(metrics->stored);
    metrics->stored = NULL;
    metrics->n_stored = 0;
    metrics->capacity = 0;
}
