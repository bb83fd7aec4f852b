/* Titles and lines of text of a PDF page: any bytes give a file whose texts end where they should.
 */
#include "tests/fuzz/fuzz.h"

#include <fcntl.h>
#include <math.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/alloc.h"
#include "quilt/print/pdf.h"

/* From "Td (" of the only text to its end: a string in brackets, printable, closed once. */
static void require_text(const char *from)
{
    const char *at = strstr(from, " Td (");
    lf_fuzz_require(at);
    for (at += 5; *at != ')'; at++) {
        lf_fuzz_require(*at >= 0x20 && *at < 0x7f && *at != '(');
        at += *at == '\\';
    }
    lf_fuzz_require(strncmp(at, ") Tj ET\n", 8) == 0);
}

static char *read_back(int fd)
{
    const off_t size = lseek(fd, 0, SEEK_END);
    char *file = lf_calloc((size_t)size + 1, 1);
    lf_fuzz_require(file && pread(fd, file, (size_t)size, 0) == size);
    return file;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *text = lf_calloc(size + 1, 1);
    lf_outfile file = {.fd = memfd_create("pdf", MFD_CLOEXEC), .borrowed = true};
    lf_pdf *pdf = NULL;
    lf_fuzz_require(text && file.fd >= 0);
    memcpy(text, data, size);
    const lf_pdf_page page = {.width = 595, .height = 842, .title = text};
    lf_fuzz_require(lf_pdf_open(&file, &page, &pdf, NULL) == LF_OK);
    const double width = lf_pdf_text_width(10, false, text);
    lf_fuzz_require(isfinite(width) && width >= 0);
    lf_pdf_text(pdf, 10, 10, 10, false, 0, text);
    lf_fuzz_require(lf_pdf_close(pdf, NULL) == LF_OK);
    char *whole = read_back(file.fd);
    /* the second line of the file is not text */
    require_text(whole);
    lf_free(whole);
    lf_free(text);
    lf_outfile_abandon(&file);
    return 0;
}
