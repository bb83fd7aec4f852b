/* A page written strip by strip, for prints and charts. Several strips are made at the same time,
 * and written in order. */
#include <string.h>

#include "base/alloc.h"
#include "quilt/print/print.h"

/* Strips of a pool's thread that are in flight: one is made while another one waits. */
#define STRIPS_A_THREAD 2

/* A strip and who makes it. */
typedef struct hand {
    lf_print_strip strip;
    void *context; /* of page->draw */
    float *row;
    int y;
    unsigned ink; /* the largest sum of a pixel's inks so far, in codes */
    lf_status status;
} hand;

typedef struct writing {
    const lf_print_page *page;
    const lf_print_colour *colour;
    const lf_print_sink *sink;
    void *state;
    lf_print_witness *witness; /* NULL: none */
    size_t row_bytes;
    int n_hands;
    hand hands[LF_PRINT_MAX_HANDS];
} writing;

int lf_print_hands(const lf_print_run *run)
{
    const int n = run->pool ? STRIPS_A_THREAD * lf_pool_threads(run->pool) : 1;
    return n < LF_PRINT_MAX_HANDS ? n : LF_PRINT_MAX_HANDS;
}

/* ------------------------------------------------------------------------------------ strips -- */

static int channels_of(const lf_print_colour *colour)
{
    return colour ? lf_print_colour_channels(colour) : 1;
}

static int bits_of(const lf_print_page *page, const lf_print_colour *colour)
{
    return colour ? page->print->bits : 16;
}

/* Values 0..1 as 16-bit codes. */
static void encode_heights(size_t n, const float *in, unsigned char *out)
{
    for (size_t i = 0; i < n; i++) {
        const uint16_t code = (uint16_t)(in[i] * 65535.0F + 0.5F);
        memcpy(out + 2 * i, &code, sizeof code);
    }
}

static void mirror_row(float *row, int width)
{
    for (int left = 0, right = width - 1; left < right; left++, right--) {
        float pixel[3];
        memcpy(pixel, row + 3 * (size_t)left, sizeof pixel);
        memcpy(row + 3 * (size_t)left, row + 3 * (size_t)right, sizeof pixel);
        memcpy(row + 3 * (size_t)right, pixel, sizeof pixel);
    }
}

/* The largest sum of four inks in n pixels. */
static unsigned most_ink(int bits, size_t n, const unsigned char *pixels)
{
    const uint16_t *wide = (const void *)pixels;
    unsigned most = 0;
    for (size_t i = 0; i < 4 * n; i += 4) {
        unsigned sum = 0;
        for (size_t c = i; c < i + 4; c++)
            sum += bits == 8 ? pixels[c] : wide[c];
        most = sum > most ? sum : most;
    }
    return most;
}

/* Makes one strip: rows of linear light, then device values. */
static void make_strip(void *context, int item, int worker)
{
    writing *w = context;
    hand *h = &w->hands[item];
    (void)worker;
    for (int r = 0; r < h->strip.n_rows; r++) {
        w->page->draw(h->context, h->y + r, h->row);
        if (w->page->print->mirror && w->colour)
            mirror_row(h->row, w->page->width);
        unsigned char *out = h->strip.data + (size_t)r * w->row_bytes;
        if (w->colour)
            lf_print_colour_encode(w->colour, (size_t)w->page->width, h->row, out);
        else
            encode_heights((size_t)w->page->width, h->row, out);
    }
    if (w->witness)
        lf_print_witness_see(w->witness, h->y, h->strip.n_rows, h->strip.data);
    h->strip.size = (size_t)h->strip.n_rows * w->row_bytes;
    if (channels_of(w->colour) == 4) {
        const unsigned ink = most_ink(
            w->page->print->bits, (size_t)h->strip.n_rows * (size_t)w->page->width, h->strip.data);
        h->ink = ink > h->ink ? ink : h->ink;
    }
    h->status = w->sink->pack ? w->sink->pack(w->state, &h->strip) : LF_OK;
}

/* Makes the strips from row y on, one a hand. Returns their number. */
static int make_strips(writing *w, lf_pool *pool, int y)
{
    const int strip_rows = w->sink->strip_rows(w->state), height = w->page->height;
    int n = 0;
    for (; n < w->n_hands && y < height; n++, y += strip_rows) {
        hand *h = &w->hands[n];
        h->y = y;
        h->strip.index = y / strip_rows;
        h->strip.n_rows = height - y < strip_rows ? height - y : strip_rows;
        h->strip.is_last = y + h->strip.n_rows == height;
    }
    if (!pool || lf_pool_run(pool, n, make_strip, w, NULL) != LF_OK)
        for (int i = 0; i < n; i++)
            make_strip(w, i, 0);
    return n;
}

static lf_status write_strips(writing *w, const lf_print_run *run, lf_error *err)
{
    const int height = w->page->height;
    lf_status status = LF_OK;
    for (int y = 0; y < height && status == LF_OK;) {
        if (run->cancel && atomic_load_explicit(run->cancel, memory_order_relaxed))
            return lf_error_set(err, LF_E_CANCELLED, "print", "cancelled");
        const int n = make_strips(w, w->n_hands > 1 ? run->pool : NULL, y);
        for (int i = 0; i < n && status == LF_OK; i++) {
            const hand *h = &w->hands[i];
            status = h->status == LF_OK ? w->sink->write(w->state, &w->hands[i].strip, err)
                                        : lf_error_set(err, h->status, "print", "out of memory");
            y += h->strip.n_rows;
        }
        if (status == LF_OK && run->progress)
            run->progress(run->context, (double)y / height);
    }
    return status;
}

/* The densest pixel, in percent; 0 without inks. */
static double ink_of(const writing *w)
{
    unsigned most = 0;
    for (int i = 0; i < w->n_hands; i++)
        most = w->hands[i].ink > most ? w->hands[i].ink : most;
    return most * 100.0 / (w->page->print->bits == 8 ? 255.0 : 65535.0);
}

static lf_status make_hands(writing *w)
{
    const lf_print_page *page = w->page;
    const size_t rows = (size_t)w->sink->strip_rows(w->state);
    w->n_hands = page->n_hands > 0 ? page->n_hands : 1;
    for (int i = 0; i < w->n_hands; i++) {
        hand *h = &w->hands[i];
        h->context = page->n_hands > 0 ? page->hands[i] : page->context;
        h->row = lf_calloc((size_t)page->width, 3 * sizeof *h->row);
        h->strip.data = lf_calloc(rows, w->row_bytes);
        if (!h->row || !h->strip.data)
            return LF_E_NOMEM;
    }
    return LF_OK;
}

static void finish_hands(writing *w)
{
    for (int i = 0; i < w->n_hands; i++) {
        lf_free(w->hands[i].row);
        lf_free(w->hands[i].strip.data);
        lf_pdf_strip_finish(&w->hands[i].strip.packed);
    }
}

lf_status lf_print_page_write(const lf_print_page *page, const lf_print_colour *colour,
                              const lf_print_run *run, int rows_per_strip, lf_outfile *file,
                              lf_error *err)
{
    writing w = {.page = page,
                 .colour = colour,
                 .sink = run->format == LF_PRINT_PDF ? &lf_print_pdf_sink : &lf_print_tiff_sink,
                 .witness = colour ? run->witness : NULL, /* a relief has none */
                 .row_bytes = (size_t)page->width * (size_t)channels_of(colour) *
                              (size_t)bits_of(page, colour) / 8};
    lf_status status =
        lf_print_room_for(page->print, run->format, (double)w.row_bytes * page->height, file, err);
    if (status == LF_OK)
        status = w.sink->open(file, page, colour, rows_per_strip, &w.state, err);
    if (status != LF_OK)
        return status;
    status = make_hands(&w);
    if (status == LF_OK && w.witness)
        status = lf_print_witness_begin(w.witness, page->height, w.row_bytes);
    if (status != LF_OK)
        lf_error_set(err, status, "print", "out of memory");
    if (status == LF_OK)
        status = write_strips(&w, run, err);
    if (run->out_ink && colour)
        *run->out_ink = ink_of(&w);
    finish_hands(&w);
    if (status == LF_OK)
        return w.sink->close(w.state, err);
    w.sink->abandon(w.state);
    return status;
}
