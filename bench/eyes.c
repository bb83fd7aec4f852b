#include "bench/eyes.h"

#include <math.h>

#include "base/alloc.h"
#include "device/sim/optics.h"
#include "quilt/quilt.h"

#define PLACE_STEP 0.25 /* fraction of the cone between two directions */
#define CONE_DEG 40.0   /* default of the optics, for calibrations without it */

struct lf_eyes {
    lf_pool *pool; /* borrowed */
    double epsilon;
    int n_views, view_width, view_height;
    lf_tone *tone;
    lf_interlacer *interlacer;
    lf_sim_optics *optics[LF_EYES]; /* pairs of an eye and the one a view further right */
    uint8_t *views;                 /* [row][view][column][3] */
    lf_image8 panel, seen[LF_EYES];
    float to_linear[256];
    size_t n; /* floats of one eye's picture */
    /* [eye][row][column][3]: r; e of r; e of the last picture; e of the current one */
    float *reference, *noise, *last, *now;
    double reference_error, reference_flicker;
};

static lf_status create_eyes(lf_eyes *eyes, const lf_calibration *c, lf_error *err)
{
    lf_calibration said = *c;
    if (!(said.view_cone_deg > 0))
        said.view_cone_deg = CONE_DEG;
    const double a_view = said.view_cone_deg / eyes->n_views;
    int width = 0, height = 0;
    lf_status status = lf_image8_init(&eyes->panel, c->screen_width_px, c->screen_height_px, 3);
    for (int i = 0; i < LF_EYES && status == LF_OK; i++) {
        const int number = i / 2;
        const double place = PLACE_STEP * (number - 0.5 * (LF_EYE_PLACES - 1));
        status = lf_optics_create(&said, place * said.view_cone_deg + (i % 2) * a_view,
                                  &eyes->optics[i], err);
        if (status != LF_OK)
            return status;
        lf_optics_size(eyes->optics[i], &width, &height);
        status = lf_image8_init(&eyes->seen[i], width, height, 3);
    }
    eyes->n = (size_t)width * (size_t)height * 3;
    float **const arrays[] = {&eyes->reference, &eyes->noise, &eyes->last, &eyes->now};
    for (int i = 0; i < 4 && status == LF_OK; i++) {
        *arrays[i] = lf_calloc(LF_EYES * eyes->n, sizeof(float));
        status = *arrays[i] ? LF_OK : LF_E_NOMEM;
    }
    return status == LF_OK ? LF_OK : lf_error_set(err, status, "eyes", "out of memory");
}

lf_status lf_eyes_create(const lf_calibration *calibration, const lf_render_settings *settings,
                         const lf_film_settings *film, double epsilon, lf_pool *pool, lf_eyes **out,
                         lf_error *err)
{
    const int n_views = settings->camera.n_views;
    lf_eyes *eyes = lf_calloc(1, sizeof *eyes);
    if (!eyes)
        return lf_error_set(err, LF_E_NOMEM, "eyes", "out of memory");
    eyes->pool = pool;
    eyes->epsilon = epsilon;
    eyes->n_views = n_views;
    eyes->view_width = settings->width;
    eyes->view_height = settings->height;
    lf_srgb_light(eyes->to_linear);
    lf_status status = lf_tone_create(film->exposure, film->tonemap, &eyes->tone, err);
    if (status == LF_OK)
        status = lf_interlacer_create(calibration, n_views, settings->width, settings->height,
                                      settings->camera.aspect, LF_FILTER_NEAREST, LF_INVERT_AUTO,
                                      &eyes->interlacer, err);
    if (status == LF_OK)
        status = create_eyes(eyes, calibration, err);
    const size_t n_pixels = (size_t)n_views * (size_t)settings->width * (size_t)settings->height;
    if (status == LF_OK && !(eyes->views = lf_calloc(n_pixels, 3)))
        status = lf_error_set(err, LF_E_NOMEM, "eyes", "out of memory");
    if (status == LF_OK)
        *out = eyes;
    else
        lf_eyes_destroy(eyes);
    return status;
}

void lf_eyes_destroy(lf_eyes *eyes)
{
    if (!eyes)
        return;
    lf_tone_destroy(eyes->tone);
    lf_interlacer_destroy(eyes->interlacer);
    for (int i = 0; i < LF_EYES; i++) {
        lf_optics_destroy(eyes->optics[i]);
        lf_image8_finish(&eyes->seen[i]);
    }
    lf_image8_finish(&eyes->panel);
    lf_free(eyes->views);
    lf_free(eyes->reference);
    lf_free(eyes->noise);
    lf_free(eyes->last);
    lf_free(eyes->now);
    lf_free(eyes);
}

/* ----------------------------------------------------------------------------------- looking -- */

typedef struct look {
    lf_eyes *eyes;
    float *out; /* [eye][row][column][3] linear */
} look;

static void look_from(void *context, int eye, int worker)
{
    const look *l = context;
    lf_eyes *eyes = l->eyes;
    lf_image8 *seen = &eyes->seen[eye];
    float *out = l->out + (size_t)eye * eyes->n;
    (void)worker;
    lf_optics_view(eyes->optics[eye], &eyes->panel, seen);
    for (int y = 0; y < seen->height; y++) {
        const uint8_t *row = seen->data + (size_t)y * seen->stride;
        for (int i = 0; i < 3 * seen->width; i++)
            *out++ = eyes->to_linear[row[i]];
    }
}

/* Simulates all eyes for a picture. */
static void see(lf_eyes *eyes, const float *picture, float *out)
{
    const size_t row = (size_t)eyes->view_width * 3, rows = row * (size_t)eyes->n_views;
    const lf_views8 views = {eyes->n_views, eyes->view_width, eyes->view_height, row,
                             rows,          eyes->views};
    look l = {.eyes = eyes};
    l.out = out;
    lf_tone_map(eyes->tone, rows / 3 * (size_t)eyes->view_height, picture, eyes->views);
    lf_interlace(eyes->interlacer, &views, &eyes->panel, eyes->pool);
    (void)!lf_pool_run(eyes->pool, LF_EYES, look_from, &l, NULL); /* cannot be cancelled */
}

static double mean_square(const lf_eyes *eyes, const float *e)
{
    double sum = 0;
    for (size_t i = 0; i < LF_EYES * eyes->n; i++)
        sum += (double)e[i] * (double)e[i];
    return sum / (double)(LF_EYES * eyes->n);
}

/* Mean square of the change from each direction's eye to its neighbour. */
static double mean_square_step(const lf_eyes *eyes, const float *e)
{
    double sum = 0;
    for (size_t place = 0; place < LF_EYE_PLACES; place++) {
        const float *a = e + 2 * place * eyes->n, *b = a + eyes->n;
        for (size_t i = 0; i < eyes->n; i++)
            sum += (double)(b[i] - a[i]) * (double)(b[i] - a[i]);
    }
    return sum / (double)(LF_EYE_PLACES * eyes->n);
}

static double scale_at(const lf_eyes *eyes, size_t i)
{
    const double r = (double)eyes->reference[i];
    return 1 / sqrt(r * r + eyes->epsilon);
}

void lf_eyes_set_reference(lf_eyes *eyes, const float *first, const float *second)
{
    see(eyes, first, eyes->reference);
    see(eyes, second, eyes->now);
    for (size_t i = 0; i < LF_EYES * eyes->n; i++) {
        const double a = (double)eyes->reference[i], b = (double)eyes->now[i];
        eyes->reference[i] = (float)(0.5 * (a + b));
        eyes->noise[i] = (float)(0.5 * (a - b) * scale_at(eyes, i));
    }
    eyes->reference_error = mean_square(eyes, eyes->noise);
    eyes->reference_flicker = mean_square_step(eyes, eyes->noise);
}

/* Computes e of a picture. */
static void find_errors(lf_eyes *eyes, const float *picture, float *out)
{
    see(eyes, picture, out);
    for (size_t i = 0; i < LF_EYES * eyes->n; i++)
        out[i] = (float)(((double)out[i] - (double)eyes->reference[i]) * scale_at(eyes, i));
}

void lf_eyes_look(lf_eyes *eyes, const float *picture, double *out_rel_mse, double *out_flicker)
{
    find_errors(eyes, picture, eyes->last);
    *out_rel_mse = mean_square(eyes, eyes->last) - eyes->reference_error;
    *out_flicker = mean_square_step(eyes, eyes->last) - eyes->reference_flicker;
}

double lf_eyes_change(lf_eyes *eyes, const float *picture)
{
    find_errors(eyes, picture, eyes->now);
    for (size_t i = 0; i < LF_EYES * eyes->n; i++)
        eyes->now[i] -= eyes->last[i];
    return mean_square(eyes, eyes->now);
}
