#include "quilt/print/pdf_text.h"

#include "quilt/print/pdf.h"

/* Widths of ' ' to '~' in thousandths of the size, as Adobe publishes them for these fonts. */
static const uint16_t widths[2][95] = {
    {278,  278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278,
     556,  556, 556, 556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556,
     1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778,
     667,  778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556,
     333,  556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556,
     556,  556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584},
    {278, 333, 474, 556, 556, 889, 722, 238, 333, 333, 389, 584, 278, 333, 278, 278,
     556, 556, 556, 556, 556, 556, 556, 556, 556, 556, 333, 333, 584, 584, 584, 611,
     975, 722, 722, 722, 722, 667, 611, 778, 722, 278, 556, 722, 611, 833, 722, 778,
     667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 333, 278, 333, 584, 556,
     333, 556, 611, 556, 611, 556, 333, 611, 611, 278, 278, 556, 278, 889, 611, 611,
     611, 611, 389, 556, 333, 611, 556, 778, 556, 556, 500, 389, 280, 389, 584}};
/* Of other Latin letters, most of which are as wide as the letter without its accent. */
#define USUAL_WIDTH 556

uint32_t lf_pdf_next_char(const char **text)
{
    static const uint32_t least[] = {0x20, 0x80, 0x800, 0x10000};
    const unsigned char *at = (const unsigned char *)*text;
    const int more = at[0] < 0x80             ? 0
                     : (at[0] & 0xe0) == 0xc0 ? 1
                     : (at[0] & 0xf0) == 0xe0 ? 2
                     : (at[0] & 0xf8) == 0xf0 ? 3
                                              : -1;
    uint32_t code = more > 0 ? at[0] & (0x3fU >> more) : at[0];
    int read = 0;
    while (read < more && (at[read + 1] & 0xc0) == 0x80)
        code = code << 6 | (at[++read] & 0x3f);
    const bool valid = read == more && code >= least[more] && code <= 0x10ffff && code != 0x7f &&
                       (code < 0xd800 || code > 0xdfff) && (code & 0xfffe) != 0xfffe;
    *text += valid ? more + 1 : 1;
    return valid ? code : '?';
}

unsigned lf_pdf_next_latin(const char **text)
{
    const uint32_t code = lf_pdf_next_char(text);
    return code < 0x7f || (code >= 0xa0 && code <= 0xff) ? code : '?';
}

double lf_pdf_text_width(double size, bool bold, const char *text)
{
    double width = 0.0;
    while (*text) {
        const unsigned code = lf_pdf_next_latin(&text);
        width += code < 0x7f ? widths[bold][code - 0x20] : USUAL_WIDTH;
    }
    return width * size / 1000.0;
}
