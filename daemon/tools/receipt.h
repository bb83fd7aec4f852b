/* The receipt of a run: its files with their sizes and hashes, for --files of quiltrender. Thread:
 * the main thread. */
#ifndef LF_DAEMON_RECEIPT_H
#define LF_DAEMON_RECEIPT_H

#include "daemon/tools/rendering.h"

/* Writes the receipt to r->arguments->files, whole or not at all. To be called after the files were
 * written, or kept:
 *
 *     {"quiltd": version, "files": [{"name": path as given, "bytes": n, "sha256": digits}, …]}
 *
 * LF_E_IO: a file is missing or cannot be read; LF_E_NOMEM; errors of files. */
LF_NODISCARD lf_status lf_receipt_write(lf_rendering *r, lf_error *err);

#endif
