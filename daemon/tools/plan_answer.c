/* What follows the passes of a light field: holes, fit, answer, layers, catchers, files, states.
 * Done here for the rows of the pilot; files and states go to memory. */
#include <math.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/output/guides.h"
#include "daemon/output/hologram.h"
#include "daemon/tools/plan_measure.h"
#include "daemon/tools/plan_process.h"

/* A video of frames that were written: CPU seconds and bytes per pixel of a frame, ours and the
 * encoder's, which holds up to 45 frames (docs/lab/farms.md). */
#define JOIN_CPU 1.6e-7
#define JOIN_BYTES 32
#define JOIN_FRAMES 45

/* Bytes per pixel of a catcher's sums while a denoised image is made. */
#define CAUGHT_BYTES 57

/* A picture of the pilot's rows. */
typedef struct answer {
    lf_rendering *r;
    const lf_plan_pilot *pilot;
    int channels;
    size_t row;     /* view pixels of a row */
    float *picture; /* [pilot row][view][column][3] */
    float *layers;  /* [pilot row][view][column][channels]; NULL: none */
    double fit;     /* memory of the fit of these rows */
    double kept;    /* the part of it that stays after the fit */
    double writing; /* memory for a picture of these rows */
    double share;   /* of all files that these rows make */
} answer;

static unsigned layers_of(const lf_rendering *r)
{
    const lf_options *o = &r->arguments->options;
    return o->guides ? LF_GUIDE_LAYERS : o->layers;
}

/* Calls fn for every row of the pilot. */
static lf_status for_rows(answer *a, lf_status (*fn)(answer *a, int row, int index))
{
    lf_status status = LF_OK;
    for (int i = 0, index = 0; i < a->pilot->n; i++) {
        int end;
        for (int row = lf_plan_strip(a->pilot, i, &end); row < end && status == LF_OK; row++)
            status = fn(a, row, index++);
    }
    return status;
}

/* ------------------------------------------------------------------------------------ answer -- */

static lf_status fill_holes(answer *a)
{
    lf_status status = LF_OK;
    for (int i = 0; i < a->pilot->n && status == LF_OK; i++) {
        lf_part part = {0};
        part.first_row = lf_plan_strip(a->pilot, i, &part.end_row);
        status = lf_renderer_fill_holes(a->r->renderer, &part, a->r->cancel);
    }
    return status;
}

static lf_status fit(answer *a)
{
    lf_process_forget_peak();
    const double before = lf_process_memory();
    const lf_status status = lf_renderer_fit(a->r->renderer, a->r->cancel);
    const double after = lf_process_memory();
    a->fit = fmax(0, fmax(after, lf_process_peak()) - before);
    a->kept = fmax(0, after - before);
    return status;
}

static lf_status answer_row(answer *a, int row, int index)
{
    const lf_rendering *r = a->r;
    const lf_estimator estimator = r->arguments->options.estimator;
    float *out = a->picture + (size_t)index * a->row * 3;
    lf_status status = r->reconstructs
                           ? lf_renderer_show_row(r->renderer, row, out)
                           : lf_renderer_resolve_row(r->renderer, estimator, row, out, NULL);
    if (status == LF_OK && a->layers)
        status = lf_renderer_layers_row(r->renderer, estimator, layers_of(r), row,
                                        a->layers + (size_t)index * a->row * (size_t)a->channels);
    return status;
}

/* Samples of catchers, as many as the film has. */
static lf_status catch_rows(const answer *a)
{
    lf_caught *caught = NULL;
    const lf_status status = lf_caught_begin(&caught, a->r->renderer);
    for (int i = 0; i < a->pilot->n && caught; i++) {
        int end;
        for (int row = lf_plan_strip(a->pilot, i, &end); row < end; row++)
            for (int before = -1; lf_caught_samples(caught, row) > before;) {
                before = lf_caught_samples(caught, row);
                lf_caught_add(caught, row);
            }
    }
    lf_caught_destroy(caught);
    return status;
}

static lf_status make_picture(answer *a)
{
    lf_rendering *r = a->r;
    lf_status status = LF_OK;
    if (!r->reconstructs && r->arguments->options.estimator == LF_ESTIMATOR_MWIS)
        status = fill_holes(a);
    if (status == LF_OK && r->reconstructs)
        status = fit(a);
    if (status == LF_OK)
        status = for_rows(a, answer_row);
    if (status == LF_OK && lf_scene_has_catchers(r->scene))
        status = catch_rows(a);
    return status;
}

/* ------------------------------------------------------------------------------------- files -- */

/* The kind of a task's files: frames of a video are pictures. */
static const lf_output_kind *kind_of(const lf_rendering *r, const lf_plan *plan)
{
    const lf_output_kind *kind = lf_rendering_kind(r);
    if (kind == &lf_output_hologram)
        return r->arguments->hologram.options.format == LF_PLATE_EXR ? &lf_output_views
                                                                     : &lf_output_pictures;
    if (!plan->job.joins_files)
        return kind;
    return kind == &lf_output_track ? &lf_output_still : &lf_output_quilt;
}

/* The largest raster of a print that is made for a plan, in pixels. */
#define PRINT_PIXELS 8e6

/* The upper part of a print; *out_share: of all of it. */
static lf_print part_of_print(const lf_print *print, double *out_share)
{
    lf_print part = *print;
    const double dots = print->dpi / 25.4,
                 pixels = print->width_mm * print->height_mm * dots * dots;
    *out_share = pixels > PRINT_PIXELS ? PRINT_PIXELS / pixels : 1;
    part.height_mm *= *out_share;
    return part;
}

static void close_all(const int *fds, int n)
{
    for (int i = 0; i < n; i++)
        close(fds[i]);
}

/* Files in memory. */
static lf_status open_files(int *fds, int n, const char *where, lf_error *err)
{
    for (int i = 0; i < n; i++) {
        fds[i] = memfd_create("quiltrender-plan", MFD_CLOEXEC);
        if (fds[i] >= 0)
            continue;
        close_all(fds, i);
        return lf_error_set(err, LF_E_IO, where, "cannot make files in memory for --plan");
    }
    return LF_OK;
}

/* Writes the rows as a low picture of this kind. */
static lf_status write_picture(answer *a, const lf_plan *plan, const lf_output_kind *kind,
                               const int *fds, int n_fds, lf_error *err)
{
    const lf_rendering *r = a->r;
    const lf_render_arguments *of = r->arguments;
    const char *names[LF_MAX_LAYER_CHANNELS];
    lf_render_settings low = r->settings;
    lf_film_settings film = *lf_scene_film_settings(r->scene);
    double share = 1;
    const lf_print print = part_of_print(&r->print, &share);
    low.height = a->pilot->n_rows;
    lf_output_source source = lf_output_from_film(&low, a->picture);
    source.reconstructed = r->reconstructs;
    const size_t view = (size_t)low.width * (size_t)a->channels;
    const lf_layers32 layers = {lf_layer_channels(layers_of(r), names), names, view,
                                view * (size_t)low.camera.n_views, a->layers};
    if (a->layers && !of->options.guides)
        source.views32.layers = &layers;
    if (of->options.has_exposure)
        film = lf_exposed_film(&film, of->options.exposure);
    lf_output_request request = {.kind = kind,
                                 .path = r->path,
                                 .overwrite = true,
                                 .fds = fds,
                                 .n_fds = n_fds,
                                 .layout = r->layout,
                                 .calibration = &r->calibration,
                                 .panel = of->panel,
                                 .print = &print,
                                 .rgbd = of->rgbd,
                                 .exposure = film.auto_exposure ? 0 : film.exposure,
                                 .quality = of->options.file.quality,
                                 .tonemap = film.tonemap,
                                 .pool = r->pool,
                                 .cancel = r->cancel};
    request.layout.view_height = low.height;
    if (plan->n_rows > 1) { /* one row of cameras of a grid */
        request.layout.columns = request.layout.n_views = low.camera.n_views;
        request.layout.rows = 1;
    }
    a->share = kind->check_print   ? share
               : kind->needs_panel ? 1
                                   : (double)low.height / a->pilot->height;
    return lf_output_write(&request, &source, err);
}

/* *out_cpu: of these rows, or of the whole if the kind has a raster of its own. */
static lf_status write_files(answer *a, const lf_plan *plan, double *out_cpu, lf_error *err)
{
    const lf_output_kind *kind = kind_of(a->r, plan);
    const int n = lf_output_n_files(kind, &a->r->print, a->r->settings.camera.n_views);
    int *fds = lf_calloc((size_t)n, sizeof *fds);
    lf_status status =
        fds ? LF_OK : lf_error_set(err, LF_E_NOMEM, a->r->arguments->out, "out of memory");
    if (status == LF_OK)
        status = open_files(fds, n, a->r->arguments->out, err);
    if (status == LF_OK) {
        lf_process_forget_peak();
        const double before = lf_process_memory(), start = lf_time_cpu();
        status = write_picture(a, plan, kind, fds, n, err);
        *out_cpu = lf_time_cpu() - start;
        a->writing = fmax(0, lf_process_peak() - before);
    }
    lf_free(fds);
    return status;
}

/* ------------------------------------------------------------------------------------ states -- */

static lf_status save_state(const answer *a, double *out_cpu, lf_error *err)
{
    const int fd = memfd_create("quiltrender-plan", MFD_CLOEXEC);
    lf_outfile file = {.fd = -1};
    if (fd < 0)
        return lf_error_set(err, LF_E_IO, a->r->arguments->out,
                            "cannot make files in memory for --plan");
    lf_status status = lf_outfile_adopt(&file, fd, err);
    if (status != LF_OK) {
        close(fd);
        return status;
    }
    const double start = lf_time_cpu();
    status = lf_renderer_save(a->r->renderer, &file, a->r->cancel, err);
    *out_cpu = lf_time_cpu() - start;
    lf_outfile_abandon(&file);
    return status;
}

/* ------------------------------------------------------------------------------------- model -- */

/* What the finish of a video needs. pixels: of a frame. */
static void take_video(const lf_rendering *r, lf_plan *plan, double pixels)
{
    const int n = plan->job.last - plan->job.first + 1;
    const double a_frame = r->arguments->video.codec == LF_CODEC_H265 ? 7 : 5;
    plan->model.join_cpu = JOIN_CPU * pixels;
    plan->model.join = pixels * (JOIN_BYTES + a_frame * fmin(n, JOIN_FRAMES));
}

/* Memory of a fit of `rows` times the measured rows, which took `bytes`. */
static double fit_of(const lf_plan *plan, double bytes, double rows)
{
    return plan->least_fit + fmax(0, bytes - plan->least_fit) * rows;
}

/* Fills the model from the measured rows. cpu: of answer, files and state. */
static void fill_model(const answer *a, lf_plan *plan, const double cpu[3])
{
    lf_plan_model *m = &plan->model;
    const lf_rendering *r = a->r;
    const double grid = plan->job.is_joined ? 1 : plan->n_rows, /* rows of cameras in a frame */
        pixels = grid * (double)a->row * plan->height,
                 rows = a->pilot->n_rows > 0 ? grid * plan->height / a->pilot->n_rows : 0,
                 caught = lf_scene_has_catchers(r->scene) ? CAUGHT_BYTES * pixels : 0,
                 image = pixels * (3 + a->channels) * sizeof(float),
                 writing = a->share > 0 ? a->writing / a->share : 0;
    m->save_cpu = a->pilot->n_rows > 0 ? cpu[2] / a->pilot->n_rows : 0;
    m->answer_cpu = cpu[0] * rows + (a->share > 0 ? grid * cpu[1] / a->share : 0);
    /* the picture is written after the fit */
    m->answer = fmax(fit_of(plan, a->fit, rows),
                     fit_of(plan, a->kept, rows) + image + fmax(caught, writing));
    m->join_cpu = m->answer_cpu;
    m->join = m->base + plan->film_bytes + m->answer;
    if (plan->job.is_joined)
        m->join += (plan->job.last - plan->job.first) * (image + writing);
    if (plan->job.joins_files)
        take_video(r, plan, pixels);
}

lf_status lf_plan_measure_answer(lf_rendering *r, lf_plan *plan, const lf_plan_pilot *pilot,
                                 lf_error *err)
{
    const lf_render_settings *s = &r->settings;
    const size_t n = (size_t)pilot->n_rows;
    answer a = {.r = r,
                .pilot = pilot,
                .channels = lf_layer_channels(layers_of(r), NULL),
                .row = (size_t)s->camera.n_views * (size_t)s->width};
    double cpu[3] = {0};
    if (n == 0) {
        fill_model(&a, plan, cpu);
        return LF_OK;
    }
    a.picture = lf_calloc(n * a.row, 3 * sizeof *a.picture);
    if (a.channels > 0)
        a.layers = lf_calloc(n * a.row, (size_t)a.channels * sizeof *a.layers);
    lf_status status = LF_E_NOMEM;
    if (a.picture && (a.layers || a.channels == 0)) {
        status = save_state(&a, &cpu[2], err);
        const double start = lf_time_cpu();
        if (status == LF_OK)
            status = make_picture(&a);
        cpu[0] = lf_time_cpu() - start;
    }
    if (status == LF_E_NOMEM || status == LF_E_CANCELLED || status == LF_E_STATE)
        lf_error_set(err, status, r->arguments->out, "%s",
                     status == LF_E_CANCELLED ? "interrupted; the plan is not complete"
                                              : "cannot measure the answer");
    if (status == LF_OK && kind_of(r, plan)->write)
        status = write_files(&a, plan, &cpu[1], err);
    if (status == LF_OK)
        fill_model(&a, plan, cpu);
    lf_free(a.picture);
    lf_free(a.layers);
    return status;
}
