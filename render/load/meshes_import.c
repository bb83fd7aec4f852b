#include "render/load/meshes_import.h"

#include "base/alloc.h"
#include "base/thread.h"

enum { MOST_READERS = 4 }; /* at once: each may take the memory that --import-memory says */

/* What one mesh after the other comes to, each on whatever thread is free. */
typedef struct importing {
    const lf_scene_desc *desc;
    const char *folder;
    const lf_roots *roots;
    lf_mesh_data *data;
    lf_status *status;
    lf_error *err;
} importing;

static void import_mesh(void *context, int i, int worker)
{
    const importing *all = context;
    const lf_mesh_desc *desc = &all->desc->meshes[i];
    (void)worker;
    all->data[i].name = desc->name;
    all->status[i] =
        desc->shape ? lf_mesh_shape_make(desc, &all->data[i], &all->err[i])
                    : lf_mesh_import(desc, all->folder, all->roots, &all->data[i], &all->err[i]);
}

static int count_files(const lf_scene_desc *desc)
{
    int n = 0;
    for (int i = 0; i < desc->n_meshes; i++)
        n += !desc->meshes[i].shape;
    return n;
}

/* Files are read several at once, a process each. */
static lf_status import_all(importing *all)
{
    int n_files = count_files(all->desc);
    lf_pool *pool = NULL;
    lf_status status = lf_pool_create(n_files < 1              ? 1
                                      : n_files < MOST_READERS ? n_files
                                                               : MOST_READERS,
                                      &pool);
    if (status == LF_OK)
        status = lf_pool_run(pool, all->desc->n_meshes, import_mesh, all, NULL);
    lf_pool_destroy(pool);
    return status;
}

lf_status lf_meshes_import(const lf_scene_desc *desc, const char *folder, const lf_roots *roots,
                           lf_mesh_data *data, int *out_wrong, lf_error *err)
{
    size_t n = (size_t)desc->n_meshes;
    if (n == 0)
        return LF_OK;
    importing all = {
        desc, folder, roots, data, lf_calloc(n, sizeof *all.status), lf_calloc(n, sizeof *all.err)};
    lf_status status = all.status && all.err ? import_all(&all) : LF_E_NOMEM;
    for (int i = 0; i < desc->n_meshes && status == LF_OK; i++) {
        status = all.status[i];
        if (status == LF_OK)
            continue;
        *out_wrong = i;
        *err = all.err[i];
    }
    lf_free(all.status);
    lf_free(all.err);
    return status;
}
