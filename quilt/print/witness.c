/* Rows of a print that are kept while it is written. */
#include <string.h>

#include "base/alloc.h"
#include "quilt/print/print.h"

int lf_print_witness_at(const lf_print_witness *witness, int i)
{
    return (int)((2 * (int64_t)i + 1) * witness->height / (2 * (int64_t)witness->n_rows));
}

lf_status lf_print_witness_begin(lf_print_witness *witness, int height, size_t row_bytes)
{
    lf_free(witness->rows);
    witness->n_rows = witness->n_rows < height ? witness->n_rows : height;
    witness->height = height;
    witness->row_bytes = row_bytes;
    witness->rows = lf_calloc((size_t)witness->n_rows, row_bytes);
    return witness->rows ? LF_OK : LF_E_NOMEM;
}

void lf_print_witness_see(lf_print_witness *witness, int y, int n, const void *rows)
{
    for (int i = 0; i < witness->n_rows; i++) {
        const int at = lf_print_witness_at(witness, i);
        if (at >= y && at < y + n)
            memcpy(witness->rows + (size_t)i * witness->row_bytes,
                   (const unsigned char *)rows + (size_t)(at - y) * witness->row_bytes,
                   witness->row_bytes);
    }
}

void lf_print_witness_finish(lf_print_witness *witness)
{
    if (!witness)
        return;
    lf_free(witness->rows);
    memset(witness, 0, sizeof *witness);
}
