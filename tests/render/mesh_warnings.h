/* What the tests of docs/reference/formats/meshes.md share: a file that says one thing beside the
 * same without it, and what the reader makes of both. */
#ifndef LF_TESTS_RENDER_MESH_WARNINGS_H
#define LF_TESTS_RENDER_MESH_WARNINGS_H

#include "tests/formats.h"

#include "base/image_io.h"
#include "render/import/scene/mesh_import.h"
#include "tests/base/spoiled.h"

/* A file that says one thing, and the same file without it. */
typedef struct said {
    const char *text;  /* with it */
    const char *base;  /* without; NULL: the format's own */
    const char *words; /* of the warning, or of the error */
} said;

static char *folder; /* of all files here */

/* Which format is walked: the file that is read, the one that says it, and its usual text. */
static struct {
    const char *name, *says, *base;
} format;

/* ------------------------------------------------------------------------------ fingerprints -- */

typedef struct result {
    lf_status status;
    lf_error err;
    lf_mesh_data data;
    double print; /* of all that a picture depends on */
} result;

static inline void mix(double *sum, double value)
{
    *sum = 1.000001 * *sum + sin(value * 12.9898 + 0.1) + 0.01 * value;
}

static inline void mix_floats(double *sum, const float *values, size_t n)
{
    for (size_t i = 0; values && i < n; i++)
        mix(sum, (double)values[i]);
}

static inline void mix_material(double *sum, const lf_material *m)
{
    const float numbers[] = {m->albedo.x,   m->albedo.y,     m->albedo.z,   m->roughness,
                             m->ior,        m->metallic,     m->emission.x, m->emission.y,
                             m->emission.z, (float)m->cover, m->alpha,      m->coat};
    mix_floats(sum, numbers, sizeof numbers / sizeof *numbers);
    for (int i = 0; m->kind->name[i]; i++)
        mix(sum, m->kind->name[i]);
}

static inline double print_of(const lf_mesh_data *d)
{
    const size_t n = (size_t)d->n_vertices;
    double sum = d->n_triangles + 100.0 * d->n_vertices + 10.0 * d->n_materials;
    for (size_t i = 0; i < 3 * n; i++)
        mix(&sum, d->positions[i]);
    mix_floats(&sum, d->normals, 3 * n);
    mix_floats(&sum, d->colours, 4 * n);
    mix_floats(&sum, d->uvs, 2 * n * (size_t)d->n_uv_sets);
    for (int i = 0; i < d->n_materials; i++)
        mix_material(&sum, &d->materials[i]);
    for (int i = 0; i < d->n_materials && d->textures; i++)
        for (int s = 0; s < LF_SLOTS; s++) {
            const lf_texture *t = &d->textures[i].slot[s];
            mix(&sum, (double)t->picture + 3.0 * s + 7.0 * t->wrap_u + (double)t->scale);
            mix_floats(&sum, t->map[0], 3);
            mix_floats(&sum, t->map[1], 3);
        }
    for (int i = 0; i < d->n_triangles && d->triangle_material; i++)
        mix(&sum, d->triangle_material[i]);
    return sum;
}

static inline result read_bytes(const void *bytes, size_t n)
{
    result r = {.print = 0};
    const lf_mesh_desc desc = {
        .name = "m", .file = format.name, .material = -1, .transform = lf_affine_identity()};
    lf_bytes_write(lf_test_path(folder, format.says), bytes, n);
    r.status = lf_mesh_import(&desc, folder, NULL, &r.data, &r.err);
    r.print = r.status == LF_OK ? print_of(&r.data) : 0;
    return r;
}

static inline result read_said(const char *text)
{
    return read_bytes(text, strlen(text));
}

static inline bool warns(const result *r, const char *words)
{
    for (int i = 0; lf_warnings_at(&r->data.warnings, i); i++)
        if (strstr(lf_warnings_at(&r->data.warnings, i), words))
            return true;
    return false;
}

static inline void assert_read(const lf_format_row *row, const result *r)
{
    if (r->status != LF_OK)
        fail_msg("%s: %s \"%s\"", row->name, lf_status_name(r->status), r->err.what);
}

static inline void assert_quiet(const lf_format_row *row, const result *r)
{
    if (lf_warnings_at(&r->data.warnings, 0))
        fail_msg("%s warns: %s", row->name, lf_warnings_at(&r->data.warnings, 0));
}

/* ------------------------------------------------------------------------------------ checks -- */

/* Another mesh than without it, and not a word. */
static inline void is_used(const lf_format_row *row)
{
    const said *s = row->with;
    result with = read_said(s->text), without = read_said(s->base ? s->base : format.base);
    assert_read(row, &with);
    assert_quiet(row, &with);
    if (without.status == LF_OK && with.print == without.print)
        fail_msg("%s changes nothing", row->name);
    lf_mesh_data_finish(&with.data);
    lf_mesh_data_finish(&without.data);
}

/* Read, with this warning. */
static inline void is_told(const lf_format_row *row)
{
    const said *s = row->with;
    result with = read_said(s->text);
    assert_read(row, &with);
    if (!warns(&with, s->words))
        fail_msg("%s is not told; the first warning: %s", row->name,
                 lf_warnings_at(&with.data.warnings, 0) ? lf_warnings_at(&with.data.warnings, 0)
                                                        : "none");
    lf_mesh_data_finish(&with.data);
}

/* The same mesh as without it, and not a word. */
static inline void is_ignored(const lf_format_row *row)
{
    const said *s = row->with;
    result with = read_said(s->text), without = read_said(s->base ? s->base : format.base);
    assert_read(row, &with);
    assert_read(row, &without);
    assert_quiet(row, &with);
    if (with.print != without.print)
        fail_msg("%s changes the mesh", row->name);
    lf_mesh_data_finish(&with.data);
    lf_mesh_data_finish(&without.data);
}

static inline void is_refused(const lf_format_row *row)
{
    const said *s = row->with;
    result with = read_said(s->text);
    if (with.status != LF_E_FORMAT || !strstr(with.err.what, s->words))
        fail_msg("%s: %s \"%s\"", row->name, lf_status_name(with.status), with.err.what);
    lf_mesh_data_finish(&with.data);
}

/* clang-format off */
#define FIRST_TWO(a, b, ...) a, b
#define USED(name, ...) \
    {name, "used", is_used, &(const said){FIRST_TWO(__VA_ARGS__, NULL, NULL), NULL}}
#define TOLD(name, text, words) {name, "warned", is_told, &(const said){text, NULL, words}}
#define IGNORED(name, ...) \
    {name, "ignored", is_ignored, &(const said){FIRST_TWO(__VA_ARGS__, NULL, NULL), NULL}}
#define REFUSED(name, text, words) {name, "refused", is_refused, &(const said){text, NULL, words}}
/* clang-format on */

/* -------------------------------------------------------------------------------------- walk -- */

static inline void write_picture(const char *name, bool normals)
{
    lf_image8 image;
    lf_outfile file = {.fd = -1};
    lf_error err;
    lf_assert_ok(lf_image8_init(&image, 4, 4, 3), NULL);
    for (int i = 0; i < 16; i++) {
        uint8_t *p = image.data + (size_t)(i / 4) * image.stride + (size_t)(i % 4) * 3;
        p[0] = p[1] = (uint8_t)(normals ? 120 + i : 16 * i);
        p[2] = (uint8_t)(normals ? 250 : 16 * i);
    }
    lf_assert_ok(lf_outfile_open(&file, lf_test_path(folder, name), true, &err), &err);
    lf_assert_ok(lf_png_write(&file, &image, 1, NULL, 0, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    lf_image8_finish(&image);
}

static inline int begin_said(void **state)
{
    (void)state;
    folder = lf_test_folder();
    write_picture("picture.png", false);
    write_picture("normals.png", true);
    lf_test_write(folder, "pictured.mtl", "newmtl p\nKd 1 1 1\nmap_Kd picture.png\n");
    lf_test_write(folder, "colours.mtl", "newmtl red\nKd 1 0 0\nnewmtl green\nKd 0 1 0\n");
    lf_test_write(
        folder, "user.obj",
        "mtllib said.mtl\nv 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
        "usemtl m\nf 1/1 2/2 3/3 4/4\n");
    return 0;
}

static inline int finish_said(void **state)
{
    (void)state;
    lf_test_folder_remove(folder);
    return 0;
}

static inline void walk(const char *heading, const char *name, const char *says, const char *base,
                        const lf_format_row *rows, size_t n)
{
    format.name = name;
    format.says = says;
    format.base = base;
    lf_formats_walk("meshes.md", heading, rows, n);
}

#define WALK(heading, name, says, base, rows)                                                      \
    walk(heading, name, says, base, rows, sizeof rows / sizeof *rows)

#endif
