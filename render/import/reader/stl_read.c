/* STL, text and binary. Its facet normals equal the triangles' own, or are wrong: they are not
 * read.
 */
#include <string.h>

#include "base/sandbox/reader.h"
#include "render/import/reader/input.h"
#include "render/import/reader/mesh_read.h"
#include "render/import/reader/words.h"

/* A binary file has a title of 80 bytes, a number of triangles, and 50 bytes for each: a normal,
 * three corners, and two bytes that some programs use for a colour. */
#define HEADER_BYTES 84
#define FACET_BYTES 50

static uint32_t little_endian(const unsigned char *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

static lf_status put_corner(lf_soup *soup, const double at[3], uint32_t *out, lf_error *err)
{
    *out = (uint32_t)soup->n_points;
    return lf_soup_point(soup, at, err);
}

/* ------------------------------------------------------------------------------------ binary -- */

/* Colours in the last two bytes of facets: five bits per channel, display encoded. In VisCAM and
 * SolidView the highest bit marks a colour. Magics has a colour for the whole mesh in the title,
 * which the highest bit selects, and reversed channels. */
typedef struct facet_colours {
    bool wanted, of_magics, some; /* some: at least one facet has a colour */
    bool lost;                    /* the title has more data than a colour */
    float whole[4];               /* of facets without */
} facet_colours;

static facet_colours begin_colours(const unsigned char *title, bool wanted)
{
    facet_colours c = {.wanted = wanted, .whole = {0.5f, 0.5f, 0.5f, 1}};
    const unsigned char *at = memmem(title, HEADER_BYTES - 4, "COLOR=", 6);
    if (!at || at + 10 > title + HEADER_BYTES - 4)
        return c;
    c.of_magics = true;
    c.lost = at[9] < 255 || memmem(title, HEADER_BYTES - 4, "MATERIAL=", 9);
    for (int i = 0; i < 3; i++)
        c.whole[i] = lf_soup_light(at[6 + i] / 255.0);
    return c;
}

/* Colours the last three points; earlier points had none. */
static lf_status put_colours(unsigned bits, facet_colours *c, lf_soup *soup, lf_error *err)
{
    bool high = bits & 0x8000, own = high != c->of_magics;
    float rgba[4] = {0, 0, 0, 1};
    lf_status status = LF_OK;
    c->some = c->some || own;
    if (!c->wanted || !(c->some || c->of_magics))
        return LF_OK;
    for (int i = 0; i < 3; i++)
        rgba[c->of_magics ? i : 2 - i] = lf_soup_light((bits >> 5 * i & 31) / 31.0);
    while (soup->colours.n + 3 < soup->n_points && status == LF_OK)
        status = lf_soup_colour(soup, c->whole, err);
    for (int i = 0; i < 3 && status == LF_OK; i++)
        status = lf_soup_colour(soup, own ? rgba : c->whole, err);
    return status;
}

static lf_status read_facet(const unsigned char *bytes, facet_colours *colours, lf_soup *soup,
                            lf_error *err)
{
    uint32_t corners[3];
    lf_status status = LF_OK;
    for (int c = 0; c < 3 && status == LF_OK; c++) {
        double at[3];
        for (int i = 0; i < 3; i++) {
            uint32_t bits = little_endian(bytes + 12 + 12 * c + 4 * i);
            float v;
            memcpy(&v, &bits, sizeof v);
            at[i] = (double)v;
        }
        status = put_corner(soup, at, &corners[c], err);
    }
    if (status == LF_OK)
        status = put_colours(bytes[FACET_BYTES - 2] | (unsigned)bytes[FACET_BYTES - 1] << 8,
                             colours, soup, err);
    return status == LF_OK ? lf_soup_triangle(soup, &(lf_soup_face){.corners = corners}, err)
                           : status;
}

static lf_status read_binary(lf_input *in, bool colours_wanted, lf_soup *soup, lf_error *err)
{
    const unsigned char *header = lf_input_bytes(in, HEADER_BYTES);
    if (!header)
        return lf_input_ended(in, "the header of a binary STL file", err);
    uint64_t n = little_endian(header + HEADER_BYTES - 4),
             room = (in->size - HEADER_BYTES) / FACET_BYTES;
    if (n > room)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "the header announces %llu triangles, but the file has room for %llu",
                            (unsigned long long)n, (unsigned long long)room);
    facet_colours colours = begin_colours(header, colours_wanted);
    if (colours.lost && colours_wanted)
        lf_warnings_add(&soup->warnings, LF_HERE,
                        "only the colour of COLOR= and MATERIAL= in the title is used");
    lf_status status = LF_OK;
    for (uint64_t i = 0; i < n && status == LF_OK; i++) {
        const unsigned char *facet = lf_input_bytes(in, FACET_BYTES);
        status =
            facet ? read_facet(facet, &colours, soup, err) : lf_input_ended(in, "a triangle", err);
    }
    return status;
}

/* -------------------------------------------------------------------------------------- text -- */

/* A facet has three corners; a few programs write more. */
typedef struct facet {
    uint32_t corners[16];
    size_t n;
    bool open; /* begun */
} facet;

static lf_status bad_line(const lf_input *in, const char *what, lf_error *err)
{
    return lf_error_set(err, LF_E_FORMAT, LF_HERE, "line %lld: %s", (long long)in->line, what);
}

static lf_status take_vertex(const lf_input *in, const char *at, facet *f, lf_soup *soup,
                             lf_error *err)
{
    double position[3];
    if (!f->open)
        return bad_line(in, "a vertex outside a facet", err);
    if (f->n == sizeof f->corners / sizeof *f->corners)
        return bad_line(in, "a facet with more than 16 corners", err);
    if (!lf_numbers(&at, 3, position))
        return bad_line(in, "expected three numbers", err);
    return put_corner(soup, position, &f->corners[f->n++], err);
}

static lf_status end_facet(const lf_input *in, facet *f, lf_soup *soup, lf_error *err)
{
    if (!f->open || f->n < 3)
        return bad_line(in, "a facet with fewer than three corners", err);
    f->open = false;
    return lf_soup_polygon(soup, f->n, &(lf_soup_face){.corners = f->corners}, err);
}

/* One line. *ended: a solid has ended, and no other has begun. */
static lf_status read_line(const lf_input *in, const char *line, facet *f, bool *ended,
                           lf_soup *soup, lf_error *err)
{
    size_t n;
    const char *word = lf_word(&line, &n);
    if (n == 0 || lf_word_reads(word, n, "outer") || lf_word_reads(word, n, "endloop"))
        return LF_OK;
    if (lf_word_reads(word, n, "vertex"))
        return take_vertex(in, line, f, soup, err);
    if (lf_word_reads(word, n, "endfacet"))
        return end_facet(in, f, soup, err);
    if (f->open)
        return bad_line(in, "expected a vertex or the end of the facet", err);
    if (lf_word_reads(word, n, "facet")) {
        *f = (facet){.open = true};
        return LF_OK;
    }
    *ended = lf_word_reads(word, n, "endsolid");
    if (*ended)
        return LF_OK;
    return lf_word_reads(word, n, "solid")
               ? lf_soup_part(soup, err)
               : bad_line(in, "expected solid, facet, vertex or the end of one of them", err);
}

static lf_status read_text(lf_input *in, lf_soup *soup, lf_error *err)
{
    facet f = {0};
    bool ended = false;
    lf_status status = LF_OK;
    const char *line;
    while (status == LF_OK && (line = lf_input_line(in, false)))
        status = read_line(in, line, &f, &ended, soup, err);
    if (status == LF_OK && (in->status != LF_OK || f.open))
        return lf_input_ended(in, "the rest of a facet", err);
    if (status == LF_OK && !ended)
        lf_warnings_add(&soup->warnings, LF_HERE,
                        "the file does not end in \"endsolid\"; it may be cut off");
    return status;
}

/* -------------------------------------------------------------------------------------- both -- */

/* Reads a file whose size does not identify it as binary. */
static lf_status read_by_words(lf_input *in, const lf_mesh_desc *desc, lf_soup *soup, lf_error *err)
{
    size_t n, blanks = 0;
    lf_status status = lf_input_begin_text(in, err);
    if (status != LF_OK)
        return status;
    const unsigned char *begin = lf_input_peek(in, HEADER_BYTES, &n);
    while (blanks < n && lf_is_blank((char)begin[blanks]))
        blanks++;
    if (n >= blanks + 5 && lf_word_reads((const char *)begin + blanks, 5, "solid"))
        return read_text(in, soup, err);
    if (n == HEADER_BYTES)
        return read_binary(in, desc->material < 0, soup, err);
    return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                        "cannot be read as a mesh: not STL, text (\"solid\") or binary");
}

/* A binary file may begin with "solid", or with a title of any bytes: its size decides. */
lf_status lf_stl_read(const lf_mesh_desc *desc, int fd, lf_soup *soup, lf_error *err)
{
    lf_input in = {.fd = -1};
    size_t n;
    lf_status status = lf_input_open_bytes(&in, fd, err);
    if (status == LF_OK) {
        const unsigned char *begin = lf_input_peek(&in, HEADER_BYTES, &n);
        uint64_t facets = n == HEADER_BYTES ? little_endian(begin + HEADER_BYTES - 4) : 0;
        uint64_t size = HEADER_BYTES + FACET_BYTES * facets;
        /* or it has more bytes than declared, and a byte in its title that does not occur in text
         */
        bool fits = n == HEADER_BYTES &&
                    (in.size == size || (facets > 0 && in.size > size && memchr(begin, 0, n)));
        status = fits ? read_binary(&in, desc->material < 0, soup, err)
                      : read_by_words(&in, desc, soup, err);
    }
    lf_input_close(&in);
    return status;
}
