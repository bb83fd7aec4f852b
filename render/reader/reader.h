/* What quiltimport and quiltimport-vdb are made of: readers of what comes from outside, in a
 * process that has nothing to lose (render/load/import.h). Errors name no file: who asked knows it.
 * One thread. */
#ifndef LF_RENDER_READER_H
#define LF_RENDER_READER_H

#include "render/load/import.h"
#include "render/load/mesh_import.h"

/* Where the file's name would stand in errors and warnings. */
#define LF_HERE "file"

typedef struct lf_named_file {
    char *name;
    int fd;
} lf_named_file;

/* A mesh's file, the first, and those that it has named and that were opened. */
typedef struct lf_mesh_reading {
    int n_files;
    lf_named_file files[LF_MESH_MAX_FILES];
} lf_mesh_reading;

/* What a program reads. */
typedef struct lf_import_reader {
    void (*begin)(void); /* what its libraries do before they are confined; may be NULL */
    /* The file behind fd (the caller's), into sections of parcel. LF_E_FORMAT, LF_E_NOMEM, LF_E_IO.
     */
    lf_status (*read)(const lf_import_request *request, int fd, lf_parcel_writer *parcel,
                      lf_error *err);
} lf_import_reader;

/* All that main does. Not for people: quiltd, quiltrender and quiltbench start these programs. */
int lf_reader_main(const lf_import_reader *reader);

/* Asks whoever asked for a file that the one at hand names (reader.c). On LF_OK the caller
 * owns *out_fd. LF_E_PATH, LF_E_IO, …: it is not to be had. */
LF_NODISCARD lf_status lf_ask_for_file(const char *name, int *out_fd);

/* The mesh file behind fd (the caller's), called desc->file, through Assimp; out as lf_mesh_import
 * fills it but for its files. LF_E_FORMAT, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_read(const lf_mesh_desc *desc, int fd, lf_mesh_data *out,
                                    lf_error *err);

/* Refuses a PLY file whose header promises more elements than the file has room for. LF_E_FORMAT,
 * LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_ply_check(int fd, lf_error *err);

/* Gives up the right to all but reading, writing and sending what is open already, and to more than
 * `memory` bytes and `seconds` of CPU time: for good. LF_E_IO: the system cannot hold us to that.
 */
LF_NODISCARD lf_status lf_confine(uint64_t memory, unsigned seconds, lf_error *err);

#endif
