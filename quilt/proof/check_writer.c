/* A strip of code views, made by the same writer from the manifest's options, and read back: one
 * white view per row, then a cosine and a sine over the views. It shows order, crosstalk, pitch and
 * phase of what the writer does, which no picture shows by itself. */
#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/alloc.h"
#include "quilt/proof/check_internal.h"

#define MOST_BYTES ((size_t)64 << 20) /* of the code views */
#define LEAST_MM 1.0                  /* of a print */
#define BLOCK_LENSES 20
#define MAX_BLOCKS 24
#define SHARE_TOLERANCE 0.01
/* Compensation needs room at both ends of the light. */
#define HEADROOM 0.3

/* The strip as it is read back: lines across the lenses, one per view, then the two codes. */
typedef struct strip {
    lf_print print;
    lf_print_shape shape;
    lf_check_stripes stripes;
    int n_lines;
    double *light; /* [n_lines][stripes.n] */
    bool repeats;  /* written twice, its bytes are the same */
} strip;

static double code_of(int view, int n_views, bool cosine)
{
    const double turn = 2.0 * acos(-1.0) * (view + 0.5) / n_views;
    return 0.5 + 0.5 * (cosine ? cos(turn) : sin(turn));
}

/* A strip whose dots are seldom at the end of the gamut, and whose light is the writer's. */
static void give_room(lf_print *print)
{
    if (!print->compensation.on)
        return;
    if (print->blur.n_crosstalk == 0 && !(print->blur.spot_mm > 0.0))
        print->blur.spot_mm = 0.5 * 25.4 / print->lpi / print->n_views;
    print->blur.dot_gain = 0.0;
    print->compensation.headroom = HEADROOM;
}

/* The strip's own settings: the same across the lenses, as narrow as can be along them. */
static void shape_strip(const lf_check *check, strip *s)
{
    lf_print *print = &s->print;
    const int along = check->print.horizontal ? 0 : 1;
    const double narrow = fmax((check->print.n_views + 2.5) * 25.4 / check->dpi[along], LEAST_MM);
    *print = check->print;
    print->width_mm = along == 0 ? narrow : print->width_mm + 2.0 * print->bleed_mm;
    print->height_mm = along == 1 ? narrow : print->height_mm + 2.0 * print->bleed_mm;
    print->bleed_mm = 0.0;
    print->marks = false;
    print->sheet = (lf_print_sheet){0};
    print->icc_path = NULL;
    print->bits = 16;
    print->compress = LF_COMPRESS_NONE;
    print->rolled = false;
    print->view_aspect = 0.0;
    give_room(print);
    lf_print_shape_of(print, &s->shape);
    const double bytes = 12.0 * print->n_views * s->shape.n_lenses * s->shape.n_along;
    if (bytes > (double)MOST_BYTES) { /* a long print: its middle */
        double *across = along == 0 ? &print->height_mm : &print->width_mm;
        *across = fmax(*across * (double)MOST_BYTES / bytes, LEAST_MM);
        lf_print_shape_of(print, &s->shape);
    }
    s->n_lines = print->n_views + 2;
    s->stripes = lf_check_stripes_of(
        print, check->dpi, print->horizontal ? s->shape.raster_height : s->shape.raster_width);
}

static lf_status make_views(const strip *s, lf_views32 *out)
{
    const bool horizontal = s->print.horizontal;
    const size_t width = (size_t)s->shape.view_width, height = (size_t)s->shape.view_height;
    const int n_views = s->print.n_views;
    float *data = lf_calloc((size_t)n_views * height, 3 * width * sizeof *data);
    if (!data)
        return LF_E_NOMEM;
    *out = (lf_views32){.n_views = n_views,
                        .width = s->shape.view_width,
                        .height = s->shape.view_height,
                        .view_stride = 3 * width * height,
                        .row_stride = 3 * width,
                        .data = data};
    for (int view = 0; view < n_views; view++) {
        for (size_t i = 0; i < width * height; i++) {
            const int line = (int)(horizontal ? i % width : i / width);
            const double value =
                line < n_views ? line == view : code_of(view, n_views, line == n_views);
            for (size_t c = 0; c < 3; c++)
                data[(size_t)view * out->view_stride + 3 * i + c] = (float)value;
        }
    }
    return LF_OK;
}

/* Writes the strip to memory; *out_fd and its manifest's are the caller's. */
static lf_status write_strip(const strip *s, const lf_views32 *views, lf_outfile files[2],
                             lf_error *err)
{
    const lf_print_run run = {0};
    lf_status status = LF_OK;
    for (int i = 0; i < 2 && status == LF_OK; i++) {
        const int fd = memfd_create("strip", MFD_CLOEXEC);
        status = fd < 0 ? lf_error_set(err, LF_E_NOMEM, "check", "no memory for a strip")
                        : lf_outfile_adopt(&files[i], fd, err);
        if (status != LF_OK && fd >= 0)
            close(fd);
    }
    if (status == LF_OK)
        status = lf_print_write(&s->print, views, &run, &files[0], &files[1], err);
    return status;
}

static lf_status read_strip(strip *s, const lf_outfile *tiff, lf_error *err)
{
    char path[40];
    lf_print_file *file = NULL;
    snprintf(path, sizeof path, "/proc/self/fd/%d", tiff->fd);
    lf_status status = lf_print_file_open(path, NULL, &file, err);
    uint16_t *row = status == LF_OK ? lf_calloc(1, lf_print_file_raw_bytes(file)) : NULL;
    const int height = s->shape.raster_height, width = s->shape.raster_width;
    const double room = s->print.compensation.on ? HEADROOM : 0.0;
    double slope;
    if (status == LF_OK && !row)
        status = LF_E_NOMEM;
    for (int y = 0; y < height && status == LF_OK; y++) {
        if (!s->print.horizontal && y >= s->n_lines)
            break;
        status = lf_print_file_raw(file, y, row, err);
        for (int x = 0; x < width && status == LF_OK; x++) {
            const int seen = s->print.mirror ? width - 1 - x : x;
            const int line = s->print.horizontal ? seen : y, j = s->print.horizontal ? y : seen;
            if (line < s->n_lines)
                s->light[(size_t)line * (size_t)s->stripes.n + (size_t)j] =
                    (lf_check_light(row[3 * x], 16, &slope) - room) / (1.0 - 2.0 * room);
        }
    }
    lf_free(row);
    lf_print_file_close(file);
    return status;
}

static bool same_bytes(const lf_outfile *a, const lf_outfile *b)
{
    unsigned char left[4096], right[4096];
    for (off_t at = 0;; at += (off_t)sizeof left) {
        const ssize_t n = pread(a->fd, left, sizeof left, at),
                      m = pread(b->fd, right, sizeof right, at);
        if (n != m || n < 0 || memcmp(left, right, (size_t)n) != 0)
            return false;
        if (n == 0)
            return true;
    }
}

static lf_status make_strip(strip *s, lf_error *err)
{
    lf_views32 views = {0};
    lf_outfile first[2] = {{0}}, again[2] = {{0}};
    lf_status status = make_views(s, &views);
    if (status == LF_OK)
        status = write_strip(s, &views, first, err);
    if (status == LF_OK)
        status = write_strip(s, &views, again, err);
    if (status == LF_OK) {
        s->repeats = same_bytes(&first[0], &again[0]);
        status = read_strip(s, &first[0], err);
    }
    for (int i = 0; i < 2; i++) {
        lf_outfile_abandon(&first[i]);
        lf_outfile_abandon(&again[i]);
    }
    lf_free((void *)(uintptr_t)views.data);
    return status;
}

/* --------------------------------------------------------------------------------- measuring -- */

/* The stripes under a line of the strip. */
static lf_check_stripes stripes_of(const strip *s, int line)
{
    lf_check_stripes out = s->stripes;
    const int n = s->print.horizontal ? s->shape.raster_width : s->shape.raster_height;
    out.along_mm = (line + 0.5 - 0.5 * n) * out.along_pixel_mm;
    return out;
}

/* The share of each pixel of a line that stripes of a view cover, by definition. */
static void share_line(const strip *s, int line, int view, double *out)
{
    const lf_check_stripes stripes = stripes_of(s, line);
    const double half = 0.5 * lf_check_stripe_reach(&stripes);
    for (int j = 0; j < stripes.n; j++) {
        const double middle = lf_check_stripe_at(&stripes, j + 0.5, 0.0);
        double sum = 0.0;
        for (double stripe = floor(middle - half); stripe < middle + half; stripe += 1.0) {
            const double m = stripe - stripes.n_views * floor(stripe / stripes.n_views);
            const int at = s->print.reverse ? (int)m : stripes.n_views - 1 - (int)m;
            if (at != view)
                continue;
            if (stripes.nearest)
                sum += floor(middle + 1e-9) == stripe;
            else
                sum += lf_check_stripe_share(&stripes, stripe + 1.0 - middle) -
                       lf_check_stripe_share(&stripes, stripe - middle);
        }
        out[j] = sum;
    }
}

/* The pixel at a place in stripes, from a guess near by. */
static double pixel_at(const lf_check_stripes *stripes, double place, double guess)
{
    const double px = lf_check_stripe_px(stripes);
    for (int i = 0; i < 4; i++)
        guess += (place - lf_check_stripe_at(stripes, guess, 0.0)) * px;
    return guess;
}

/* Light of a spot, half a stripe wide, in the middle of stripe m under every lens: its mean, and
 * its least over the lenses; NAN: no lens lies wholly inside. sums[n + 1]: light of the pixels
 * before. */
static double seen_in(const lf_check_stripes *stripes, const double *sums, int m, double *out_least)
{
    const double px = lf_check_stripe_px(stripes), lens_px = px * stripes->n_views;
    const double first = ceil(lf_check_stripe_at(stripes, 0.0, 0.0) / stripes->n_views) + 1.0;
    double sum = 0.0, least = INFINITY, at = 0.0;
    int n = 0;
    for (double k = first;; k += 1.0) {
        at = pixel_at(stripes, k * stripes->n_views + m + 0.5, at + lens_px);
        const double left = at - 0.25 * px, right = at + 0.25 * px;
        if (!(right + lens_px < stripes->n))
            break;
        if (left < 0.0)
            continue;
        const int l = (int)left, r = (int)right;
        const double light = (sums[r] + (right - r) * (sums[r + 1] - sums[r])) -
                             (sums[l] + (left - l) * (sums[l + 1] - sums[l]));
        sum += light / (right - left);
        least = fmin(least, light / (right - left));
        n++;
    }
    *out_least = n > 0 ? least : 0.0;
    return n > 0 ? sum / n : (double)NAN;
}

typedef struct shares {
    bool any; /* lenses lie wholly inside */
    bool in_order;
    double mean, worst, neighbour; /* own share; light of the strongest other view */
} shares;

/* lines: [n_views][n], line i has view i white. */
static shares shares_of(const strip *s, const double *lines, double *sums)
{
    const int n_views = s->print.n_views, n = s->stripes.n;
    shares out = {.any = true, .in_order = true, .worst = INFINITY};
    double *seen = sums + n + 2; /* [n_views][n_views], eye and view */
    for (int view = 0; view < n_views; view++) {
        const lf_check_stripes stripes = stripes_of(s, view);
        sums[0] = 0.0;
        for (int j = 0; j < n; j++)
            sums[j + 1] = sums[j] + lines[(size_t)view * (size_t)n + (size_t)j];
        sums[n + 1] = sums[n];
        for (int eye = 0; eye < n_views; eye++) {
            double least;
            /* the spot moves left as the eye moves right */
            seen[eye * n_views + view] = seen_in(&stripes, sums, n_views - 1 - eye, &least);
            const int own = s->print.reverse ? n_views - 1 - eye : eye;
            out.any = out.any && !isnan(seen[eye * n_views + view]);
            if (own == view)
                out.worst = fmin(out.worst, least);
        }
    }
    for (int eye = 0; eye < n_views; eye++) {
        const int own = s->print.reverse ? n_views - 1 - eye : eye;
        out.mean += seen[eye * n_views + own] / n_views;
        for (int view = 0; view < n_views; view++) {
            if (view == own)
                continue;
            out.neighbour = fmax(out.neighbour, seen[eye * n_views + view]);
            out.in_order = out.in_order && seen[eye * n_views + view] < seen[eye * n_views + own];
        }
    }
    return out;
}

/* The phase of a block of the two code lines; it rises with the place in a cell. */
static double complex block_sum(const strip *s, const double *cosine, int first, int end)
{
    const double pi = acos(-1.0);
    const double *sine = cosine + s->stripes.n;
    double complex sum = 0.0;
    for (int j = first; j < end; j++) {
        const double place = (j + 0.5 - 0.5 * s->stripes.n) * s->stripes.pixel_mm;
        const double window = 1.0 - cos(2.0 * pi * (j + 0.5 - first) / (end - first));
        const double turn =
            (s->print.reverse ? -1.0 : 1.0) * 2.0 * pi * place / s->stripes.pitch_mm;
        sum += window * CMPLX(2.0 * cosine[j] - 1.0, 2.0 * sine[j] - 1.0) * cexp(CMPLX(0.0, turn));
    }
    return sum;
}

/* Lock-in meter: where the strip's codes lie, against those of the definition. ideal: [2][n]. */
static bool lock_in(const strip *s, const double *ideal, lf_check_meter *out)
{
    const double pi = acos(-1.0), pitch = s->stripes.pitch_mm, pixel = s->stripes.pixel_mm;
    const int n = s->stripes.n;
    const int n_blocks = (int)fmin(n * pixel / (BLOCK_LENSES * pitch), MAX_BLOCKS);
    const double *codes = s->light + (size_t)s->print.n_views * (size_t)n;
    double x[MAX_BLOCKS], moved[MAX_BLOCKS], error[MAX_BLOCKS];
    for (int b = 0; b < n_blocks; b++) {
        const int first = (int)((int64_t)n * b / n_blocks),
                  end = (int)((int64_t)n * (b + 1) / n_blocks);
        const double turn =
            carg(block_sum(s, codes, first, end) * conj(block_sum(s, ideal, first, end)));
        moved[b] = (s->print.reverse ? -1.0 : 1.0) * 1e3 * turn * pitch / (2.0 * pi);
        if (b > 0)
            moved[b] += 1e3 * pitch * round((moved[b - 1] - moved[b]) / (1e3 * pitch));
        x[b] = (0.5 * (first + end) - 0.5 * n) * pixel;
        error[b] = 0.05;
    }
    *out = (lf_check_meter){.what = "writer's strip"};
    return s->print.n_views > 1 &&
           lf_check_fit(x, moved, error, n_blocks, n * pixel, INFINITY, out);
}

/* The two code lines by definition: [2][n]. share: room for [n]. */
static void code_lines(const strip *s, double *share, double *out)
{
    const int n = s->stripes.n, n_views = s->print.n_views;
    memset(out, 0, 2 * (size_t)n * sizeof *out);
    for (int code = 0; code < 2; code++) {
        for (int view = 0; view < n_views; view++) {
            share_line(s, n_views + code, view, share);
            for (int j = 0; j < n; j++)
                out[(size_t)code * (size_t)n + (size_t)j] +=
                    share[j] * code_of(view, n_views, code == 0);
        }
    }
}

static void judge(lf_check *check, const strip *s, const double *codes, const shares *seen,
                  const shares *ideal)
{
    static const char as_defined[] = "each eye sees its own view most";
    const bool whole = check->differing == 0;
    const lf_check_result holds = whole ? LF_CHECK_PASS : LF_CHECK_NONE;
    const char *where = whole ? "by the writer's strip; the file has the writer's rows"
                              : "by the options alone: the file was not compared with what was "
                                "written";
    char limit[96];
    lf_check_meter meter;
    snprintf(limit, sizeof limit, "at least %.3f on average, %.3f at the worst lens",
             ideal->mean - SHARE_TOLERANCE, fmax(ideal->worst - SHARE_TOLERANCE, 0.0));
    if (check->differing > 0)
        lf_check_say(check, CHECK_ORDER, LF_CHECK_FAIL, as_defined,
                     "The file is not what was written; write the print again.",
                     "%d sampled rows differ from those that were written", check->differing);
    else
        lf_check_say(check, CHECK_ORDER, seen->in_order ? holds : LF_CHECK_FAIL, as_defined,
                     "Report this to the makers of quiltd: the writer is wrong.", "%s %s%s%s",
                     seen->in_order ? "in order" : "not in order", where,
                     s->print.reverse ? "; reversed, as asked" : "",
                     s->print.mirror ? "; mirrored, for the back of the sheet" : "");
    const bool enough = seen->mean >= ideal->mean - SHARE_TOLERANCE &&
                        seen->worst >= ideal->worst - SHARE_TOLERANCE;
    lf_check_say(check, CHECK_SHARE, enough ? holds : LF_CHECK_FAIL, limit,
                 "Report this to the makers of quiltd: the writer is wrong.",
                 "%.3f on average, %.3f at the worst lens; a neighbour has up to %.1f %%%s",
                 seen->mean, seen->worst, 100.0 * seen->neighbour,
                 whole ? "" : "; by the options alone");
    /* compensation moves the light of codes by microns; the own share tells where its stripes lie
     */
    if (!s->print.compensation.on && lock_in(s, codes, &meter) && check->n_meters == 0 && whole &&
        !check->laid)
        lf_check_add_meter(check, &meter);
}

/* Whether the same settings give the same bytes. repeats: the writer's strip does; NULL: there is
 * none. */
static void judge_same(lf_check *check, const bool *repeats)
{
    static const char limit[] = "the same settings give the same bytes";
    const int n_rows = check->differing >= 0 ? check->options->witness->n_rows : 0;
    if (check->differing > 0)
        lf_check_say(check, CHECK_SAME, LF_CHECK_FAIL, limit,
                     "The disk or another program has changed the file; write it again.",
                     "%d of %d sampled rows differ from those that were written", check->differing,
                     n_rows);
    else if (repeats && !*repeats)
        lf_check_say(check, CHECK_SAME, LF_CHECK_FAIL, limit,
                     "Test this machine's memory, then write the print again.",
                     "the writer's strip differs between two runs");
    else if (check->differing == 0)
        lf_check_say(check, CHECK_SAME, LF_CHECK_PASS, limit, NULL,
                     "%d sampled rows are those that were written%s", n_rows,
                     repeats ? ", and two strips are equal" : "");
    else
        lf_check_say(check, CHECK_SAME, LF_CHECK_NONE, limit, NULL,
                     "the file was not compared with what was written%s",
                     repeats ? "; two of the writer's strips are equal" : "");
}

lf_status lf_check_writer(lf_check *check, lf_error *err)
{
    if (!check->known || check->is_chart || lf_print_is_micro(&check->print)) {
        judge_same(check, NULL);
        return LF_OK;
    }
    strip s = {0};
    shape_strip(check, &s);
    const size_t n = (size_t)s.stripes.n, n_views = (size_t)s.print.n_views;
    double *ideal = lf_calloc((n_views + 2) * n, sizeof *ideal); /* as s.light */
    double *sums = lf_calloc(n + 2 + n_views * n_views, sizeof *sums);
    s.light = lf_calloc((size_t)s.n_lines * n, sizeof *s.light);
    lf_status status = ideal && sums && s.light ? make_strip(&s, err) : LF_E_NOMEM;
    if (status == LF_OK) {
        for (int view = 0; view < s.print.n_views; view++)
            share_line(&s, view, view, ideal + (size_t)view * n);
        const shares best = shares_of(&s, ideal, sums), seen = shares_of(&s, s.light, sums);
        code_lines(&s, sums, ideal + n_views * n);
        if (seen.any)
            judge(check, &s, ideal + n_views * n, &seen, &best);
        judge_same(check, &s.repeats);
    }
    lf_free(ideal);
    lf_free(sums);
    lf_free(s.light);
    return status == LF_E_NOMEM ? lf_error_set(err, status, check->path, "out of memory") : status;
}
