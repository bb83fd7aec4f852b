#include "quilt/print/pdf.h"

#include <nettle/sha2.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

#include "base/alloc.h"
#include "base/version.h"
#include "quilt/print/pdf_text.h"

/* The objects of a file; unused ones are marked free. */
enum {
    CATALOG = 1,
    PAGES,
    PAGE,
    CONTENT,
    IMAGE,
    IMAGE_LENGTH,
    PROFILE,
    INTENT,
    INFO,
    METADATA,
    FONT,
    FONT_BOLD,
    N_OBJECTS
};

struct lf_pdf {
    lf_outfile *file;
    lf_pdf_page page;
    uint64_t at; /* bytes written */
    uint64_t offset[N_OBJECTS];
    struct sha256_ctx hash;
    char *content; /* what paints the page */
    size_t content_size, content_room;
    bool has_text;
    uint64_t image_start;
    uint32_t check; /* of the image's bytes before compression */
    lf_error error; /* the first one; status LF_OK = none */
};

/* ------------------------------------------------------------------------------------ output -- */

static const char *file_name(const lf_pdf *pdf)
{
    return pdf->file->path ? pdf->file->path : "print";
}

static void put_bytes(lf_pdf *pdf, const void *data, size_t n)
{
    if (pdf->error.status != LF_OK)
        return;
    if ((double)pdf->at + (double)n > LF_PDF_MAX_BYTES) {
        lf_error_set(&pdf->error, LF_E_ARG, file_name(pdf),
                     "a PDF file holds at most 10 GB; write OUT.tif");
        return;
    }
    sha256_update(&pdf->hash, n, data);
    pdf->at += n;
    /* kept in pdf->error */
    (void)!lf_outfile_write(pdf->file, data, n, &pdf->error);
}

static void put(lf_pdf *pdf, const char *format, ...) LF_PRINTF(2, 3);
static void put(lf_pdf *pdf, const char *format, ...)
{
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    const int n = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (n > 0)
        put_bytes(pdf, text, (size_t)n < sizeof text ? (size_t)n : sizeof text - 1);
}

static void put_object(lf_pdf *pdf, int object)
{
    pdf->offset[object] = pdf->at;
    put(pdf, "%d 0 obj\n", object);
}

/* A number without needless digits: 595.32. A millionth of a point is 0.35 nanometres. */
static char *number(double v, char text[static 32])
{
    snprintf(text, 32, "%.6f", v);
    size_t n = strlen(text);
    while (text[n - 1] == '0')
        text[--n] = '\0';
    if (text[n - 1] == '.')
        text[--n] = '\0';
    return text;
}

static void put_box(lf_pdf *pdf, const char *name, const double box[4])
{
    char text[32];
    put(pdf, "/%s [", name);
    for (int i = 0; i < 4; i++)
        put(pdf, "%s%s", i > 0 ? " " : "", number(box[i], text));
    put(pdf, "]\n");
}

/* Text of the document's properties: ASCII if possible, otherwise UTF-16. */
static void put_string(lf_pdf *pdf, const char *text)
{
    bool plain = true;
    for (const char *c = text; *c;)
        plain &= lf_pdf_next_char(&c) < 0x7f;
    put(pdf, plain ? "(" : "<FEFF");
    for (const char *c = text; *c;) {
        const uint32_t code = lf_pdf_next_char(&c);
        if (plain)
            put(pdf, code == '(' || code == ')' || code == '\\' ? "\\%c" : "%c", (char)code);
        else if (code < 0x10000)
            put(pdf, "%04X", code);
        else
            put(pdf, "%04X%04X", 0xd800 + ((code - 0x10000) >> 10),
                0xdc00 + ((code - 0x10000) & 0x3ff));
    }
    put(pdf, plain ? ")" : ">");
}

/* ----------------------------------------------------------------------------------- content -- */

static bool make_room(lf_pdf *pdf, size_t n)
{
    if (pdf->content_size + n <= pdf->content_room)
        return true;
    const size_t room = 2 * (pdf->content_room + n);
    char *grown = lf_calloc(room, 1);
    if (!grown) {
        if (pdf->error.status == LF_OK)
            lf_error_set(&pdf->error, LF_E_NOMEM, file_name(pdf), "out of memory");
        return false;
    }
    if (pdf->content)
        memcpy(grown, pdf->content, pdf->content_size);
    lf_free(pdf->content);
    pdf->content = grown;
    pdf->content_room = room;
    return true;
}

static void paint(lf_pdf *pdf, const char *format, ...) LF_PRINTF(2, 3);
static void paint(lf_pdf *pdf, const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    const int made = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    const size_t n = made < 0 ? 0 : (size_t)made < sizeof text ? (size_t)made : sizeof text - 1;
    if (!make_room(pdf, n))
        return;
    memcpy(pdf->content + pdf->content_size, text, n);
    pdf->content_size += n;
}

void lf_pdf_text(lf_pdf *pdf, double x, double y, double size, bool bold, double grey,
                 const char *text)
{
    char n[4][32];
    pdf->has_text = true;
    paint(pdf, "BT /%s %s Tf %s g %s %s Td (", bold ? "B" : "R", number(size, n[0]),
          number(grey, n[1]), number(x, n[2]), number(y, n[3]));
    while (*text) {
        const unsigned code = lf_pdf_next_latin(&text);
        if (code == '(' || code == ')' || code == '\\')
            paint(pdf, "\\%c", (char)code);
        else
            paint(pdf, code < 0x7f ? "%c" : "\\%03o", code);
    }
    paint(pdf, ") Tj ET\n");
}

void lf_pdf_rect(lf_pdf *pdf, double x, double y, double width, double height, double grey)
{
    char n[5][32];
    paint(pdf, "%s g %s %s %s %s re f\n", number(grey, n[0]), number(x, n[1]), number(y, n[2]),
          number(width, n[3]), number(height, n[4]));
}

/* ------------------------------------------------------------------------------------- image -- */

static lf_status report(const lf_pdf *pdf, lf_error *err)
{
    if (pdf->error.status != LF_OK && err)
        *err = pdf->error;
    return pdf->error.status;
}

static const char *colours_of(const lf_pdf *pdf, int channels, char text[static 48])
{
    /* PDF/X wants plain CMYK where the output intent has the same profile. */
    if (pdf->page.profile && pdf->page.profile_channels == channels && channels == 3)
        snprintf(text, 48, "[/ICCBased %d 0 R]", PROFILE);
    else
        snprintf(text, 48, "%s",
                 channels == 1   ? "/DeviceGray"
                 : channels == 3 ? "/DeviceRGB"
                                 : "/DeviceCMYK");
    return text;
}

lf_status lf_pdf_image_begin(lf_pdf *pdf, const lf_pdf_image *image, lf_error *err)
{
    static const unsigned char zlib_header[2] = {0x78, 0x9c};
    char colours[48], n[4][32];
    put_object(pdf, IMAGE);
    put(pdf,
        "<< /Type /XObject /Subtype /Image /Width %d /Height %d /BitsPerComponent %d\n"
        "/ColorSpace %s /Interpolate false /Intent /RelativeColorimetric\n"
        "/Filter /FlateDecode /DecodeParms << /Predictor 15 /Colors %d /BitsPerComponent %d "
        "/Columns %d >>\n/Length %d 0 R >>\nstream\n",
        image->width, image->height, image->bits, colours_of(pdf, image->channels, colours),
        image->channels, image->bits, image->width, IMAGE_LENGTH);
    pdf->image_start = pdf->at;
    pdf->check = (uint32_t)adler32(0, NULL, 0);
    put_bytes(pdf, zlib_header, sizeof zlib_header);
    paint(pdf, "q %s 0 0 %s %s %s cm /I Do Q\n", number(image->width_pt, n[0]),
          number(image->height_pt, n[1]), number(image->x, n[2]), number(image->y, n[3]));
    return report(pdf, err);
}

lf_status lf_pdf_image_strip(lf_pdf *pdf, const lf_pdf_strip *strip, lf_error *err)
{
    put_bytes(pdf, strip->data, strip->size);
    pdf->check = (uint32_t)adler32_combine(pdf->check, strip->check, (z_off_t)strip->raw);
    return report(pdf, err);
}

lf_status lf_pdf_image_end(lf_pdf *pdf, lf_error *err)
{
    const unsigned char check[4] = {(unsigned char)(pdf->check >> 24),
                                    (unsigned char)(pdf->check >> 16),
                                    (unsigned char)(pdf->check >> 8), (unsigned char)pdf->check};
    put_bytes(pdf, check, sizeof check);
    const uint64_t length = pdf->at - pdf->image_start;
    put(pdf, "\nendstream\nendobj\n");
    put_object(pdf, IMAGE_LENGTH);
    put(pdf, "%llu\nendobj\n", (unsigned long long)length);
    return report(pdf, err);
}

/* ---------------------------------------------------------------------------------- document -- */

bool lf_pdf_page_is_x(const lf_pdf_page *page)
{
    return page->profile && page->profile_size >= 16 &&
           memcmp((const char *)page->profile + 12, "prtr", 4) == 0;
}

static bool is_side(double points)
{
    return points >= 3.0 && points <= LF_PDF_MAX_POINTS;
}

lf_status lf_pdf_open(lf_outfile *file, const lf_pdf_page *page, lf_pdf **out, lf_error *err)
{
    const char *where = file->path ? file->path : "print";
    const double wrong = !is_side(page->width) ? page->width : page->height;
    if (!is_side(wrong))
        return lf_error_set(err, LF_E_ARG, where,
                            "a PDF page is 1.1 to 5080 mm long, not %.5g mm; write OUT.tif",
                            wrong * 25.4 / 72.0);
    lf_pdf *pdf = lf_calloc(1, sizeof *pdf);
    if (!pdf)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    pdf->file = file;
    pdf->page = *page;
    sha256_init(&pdf->hash);
    /* the second line says that the file is binary */
    put(pdf, "%%PDF-1.6\n%%\xe2\xe3\xcf\xd3\n");
    if (report(pdf, err) != LF_OK) {
        lf_pdf_abandon(pdf);
        return LF_E_IO;
    }
    *out = pdf;
    return LF_OK;
}

static void put_profile(lf_pdf *pdf)
{
    const lf_pdf_page *page = &pdf->page;
    if (!page->profile)
        return;
    put_object(pdf, PROFILE);
    put(pdf, "<< /N %d /Length %zu >>\nstream\n", page->profile_channels, page->profile_size);
    put_bytes(pdf, page->profile, page->profile_size);
    put(pdf, "\nendstream\nendobj\n");
    put_object(pdf, INTENT);
    put(pdf, "<< /Type /OutputIntent /S /GTS_PDFX /OutputConditionIdentifier (Custom)\n"
             "/OutputCondition ");
    put_string(pdf, page->profile_name);
    put(pdf, "\n/Info ");
    put_string(pdf, page->profile_name);
    put(pdf, "\n/DestOutputProfile %d 0 R >>\nendobj\n", PROFILE);
}

static void put_page(lf_pdf *pdf)
{
    const lf_pdf_page *page = &pdf->page;
    const double whole[4] = {0.0, 0.0, page->width, page->height};
    put_object(pdf, PAGES);
    put(pdf, "<< /Type /Pages /Kids [%d 0 R] /Count 1 >>\nendobj\n", PAGE);
    put_object(pdf, PAGE);
    put(pdf, "<< /Type /Page /Parent %d 0 R\n", PAGES);
    put_box(pdf, "MediaBox", whole);
    put_box(pdf, "BleedBox", page->bleed[2] > 0.0 ? page->bleed : whole);
    put_box(pdf, "TrimBox", page->trim[2] > 0.0 ? page->trim : whole);
    put(pdf, "/Contents %d 0 R /Resources << ", CONTENT);
    if (pdf->offset[IMAGE])
        put(pdf, "/XObject << /I %d 0 R >> ", IMAGE);
    if (pdf->has_text)
        put(pdf, "/Font << /R %d 0 R /B %d 0 R >> ", FONT, FONT_BOLD);
    put(pdf, ">> >>\nendobj\n");
    put_object(pdf, CONTENT);
    put(pdf, "<< /Length %zu >>\nstream\n", pdf->content_size);
    put_bytes(pdf, pdf->content ? pdf->content : "", pdf->content_size);
    put(pdf, "\nendstream\nendobj\n");
}

static void put_fonts(lf_pdf *pdf)
{
    for (int object = FONT; pdf->has_text && object <= FONT_BOLD; object++) {
        put_object(pdf, object);
        put(pdf,
            "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica%s /Encoding /WinAnsiEncoding "
            ">>\nendobj\n",
            object == FONT_BOLD ? "-Bold" : "");
    }
}

static void put_catalog(lf_pdf *pdf)
{
    put_object(pdf, CATALOG);
    put(pdf, "<< /Type /Catalog /Pages %d 0 R /Metadata %d 0 R", PAGES, METADATA);
    if (pdf->page.profile)
        put(pdf, " /OutputIntents [%d 0 R]", INTENT);
    put(pdf, " >>\nendobj\n");
    put_object(pdf, INFO);
    put(pdf, "<< /Title ");
    put_string(pdf, pdf->page.title);
    put(pdf,
        "\n/Creator (quiltd " LF_VERSION ") /Producer (quiltd " LF_VERSION ")\n"
        "/CreationDate (D:20000101000000Z) /ModDate (D:20000101000000Z) /Trapped /False%s "
        ">>\nendobj\n",
        lf_pdf_page_is_x(&pdf->page) ? " /GTS_PDFXVersion (PDF/X-4)" : "");
}

#define XMP_BEGIN                                                                                  \
    "<?xpacket begin=\"\xef\xbb\xbf\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n"                         \
    "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n"                                                     \
    "<rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"                        \
    "<rdf:Description rdf:about=\"\"\n"                                                            \
    " xmlns:dc=\"http://purl.org/dc/elements/1.1/\"\n"                                             \
    " xmlns:xmp=\"http://ns.adobe.com/xap/1.0/\"\n"                                                \
    " xmlns:xmpMM=\"http://ns.adobe.com/xap/1.0/mm/\"\n"                                           \
    " xmlns:pdf=\"http://ns.adobe.com/pdf/1.3/\"\n"                                                \
    " xmlns:pdfxid=\"http://www.npes.org/pdfx/ns/id/\">\n"
#define XMP_END "</rdf:Description>\n</rdf:RDF>\n</x:xmpmeta>\n<?xpacket end=\"r\"?>"
#define DATE "2000-01-01T00:00:00Z"

static void paint_xml(lf_pdf *pdf, const char *text)
{
    while (*text) {
        const char *from = text;
        const uint32_t code = lf_pdf_next_char(&text);
        if (code == '<' || code == '>' || code == '&' || code == '?')
            paint(pdf, "&#%u;", code);
        else
            paint(pdf, "%.*s", (int)(text - from), from);
    }
}

/* identity: 32 hexadecimal digits. The packet is made in memory, because its length comes first. */
static void put_metadata(lf_pdf *pdf, const char *identity)
{
    pdf->content_size = 0;
    paint(pdf, XMP_BEGIN "<dc:format>application/pdf</dc:format>\n"
                         "<dc:title><rdf:Alt><rdf:li xml:lang=\"x-default\">");
    paint_xml(pdf, pdf->page.title);
    paint(pdf,
          "</rdf:li></rdf:Alt></dc:title>\n"
          "<xmp:CreateDate>" DATE "</xmp:CreateDate><xmp:ModifyDate>" DATE "</xmp:ModifyDate>"
          "<xmp:MetadataDate>" DATE "</xmp:MetadataDate>\n"
          "<xmp:CreatorTool>quiltd " LF_VERSION "</xmp:CreatorTool>\n"
          "<pdf:Producer>quiltd " LF_VERSION "</pdf:Producer><pdf:Trapped>False</pdf:Trapped>\n");
    paint(pdf,
          "<xmpMM:DocumentID>uuid:%.8s-%.4s-%.4s-%.4s-%.12s</xmpMM:DocumentID>\n"
          "<xmpMM:VersionID>1</xmpMM:VersionID>"
          "<xmpMM:RenditionClass>default</xmpMM:RenditionClass>\n",
          identity, identity + 8, identity + 12, identity + 16, identity + 20);
    if (lf_pdf_page_is_x(&pdf->page))
        paint(pdf, "<pdfxid:GTS_PDFXVersion>PDF/X-4</pdfxid:GTS_PDFXVersion>\n");
    paint(pdf, XMP_END);
    put_object(pdf, METADATA);
    put(pdf, "<< /Type /Metadata /Subtype /XML /Length %zu >>\nstream\n", pdf->content_size);
    put_bytes(pdf, pdf->content ? pdf->content : "", pdf->content_size);
    put(pdf, "\nendstream\nendobj\n");
}

static void put_trailer(lf_pdf *pdf, const char *identity)
{
    const uint64_t table = pdf->at;
    put(pdf, "xref\n0 %d\n0000000000 65535 f \n", N_OBJECTS);
    for (int object = 1; object < N_OBJECTS; object++)
        put(pdf, "%010llu %05d %c \n", (unsigned long long)pdf->offset[object],
            pdf->offset[object] ? 0 : 65535, pdf->offset[object] ? 'n' : 'f');
    put(pdf,
        "trailer\n<< /Size %d /Root %d 0 R /Info %d 0 R /ID [<%s> <%s>] >>\nstartxref\n%llu\n"
        "%%%%EOF\n",
        N_OBJECTS, CATALOG, INFO, identity, identity, (unsigned long long)table);
}

lf_status lf_pdf_close(lf_pdf *pdf, lf_error *err)
{
    uint8_t digest[16];
    char identity[2 * sizeof digest + 1];
    put_profile(pdf);
    put_page(pdf);
    put_fonts(pdf);
    put_catalog(pdf);
    sha256_digest(&pdf->hash, sizeof digest, digest);
    for (size_t i = 0; i < sizeof digest; i++)
        snprintf(identity + 2 * i, 3, "%02x", digest[i]);
    put_metadata(pdf, identity);
    put_trailer(pdf, identity);
    const lf_status status = report(pdf, err);
    lf_pdf_abandon(pdf);
    return status;
}

void lf_pdf_abandon(lf_pdf *pdf)
{
    if (!pdf)
        return;
    lf_free(pdf->content);
    lf_free(pdf);
}
