/* --rows and --stream: a part of a picture as a state. Its rows are those of the whole picture's
 * state to the bit; streams differ; what cannot be a part is refused in one line. */
#include "tests/daemon/quiltrender.h"
#include "tests/scene_file.h"

#include <fcntl.h>
#include <unistd.h>

#include "daemon/tools/job_state.h"
#include "render/film/film_file.h"

#define SIZE "--view-size 12x10 --threads 2 --seed 3 "

/* The film of a state, and its head. Finish the film. */
static json_t *read_state(const char *path, lf_film *out)
{
    json_t *head = NULL;
    lf_error err = {0};
    int fd = -1;
    *out = (lf_film){0};
    lf_assert_ok(lf_job_state_open(path, &fd, NULL, &head, &err), &err);
    lf_assert_ok(lf_film_read(fd, NULL, out, &err), &err);
    close(fd);
    return head;
}

static bool same_rows(const lf_film *a, const lf_film *b, int row)
{
    const size_t at = (size_t)row * a->row_bytes;
    const lf_film_row *x = &a->rows[row], *y = &b->rows[row];
    return memcmp(a->data + at, b->data + at, lf_film_used_bytes(&a->layout)) == 0 &&
           memcmp(x->n, y->n, sizeof x->n) == 0 &&
           memcmp(x->visits, y->visits, sizeof x->visits) == 0 && x->met == y->met;
}

static json_t *info_of(const char *path)
{
    qr_outcome o;
    qr_run(&o, "--state-info %s", path);
    assert_int_equal(o.code, 0);
    json_t *info = json_loads(o.out, 0, NULL);
    assert_non_null(info);
    return info;
}

static json_int_t number_of(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    assert_true(json_is_integer(value));
    return json_integer_value(value);
}

static void assert_rows(const json_t *head, int first, int last)
{
    const json_t *rows = json_object_get(head, "rows");
    assert_int_equal(json_array_size(rows), 2);
    assert_int_equal(json_integer_value(json_array_get(rows, 0)), first);
    assert_int_equal(json_integer_value(json_array_get(rows, 1)), last);
}

/* With and without data for denoising, and with an odd rest of passes. */
static void rows_are_those_of_the_whole_state(void **state)
{
    static const char *const how[] = {"--spp 3",
                                      "--spp 3 --denoise on",
                                      "--passes 13",
                                      "--passes 1 --estimator cv",
                                      "--spp 2 --integrator vpt",
                                      "--spp 5 --sampler independent"};
    static const int bands[][2] = {{0, 3}, {4, 4}, {5, 9}};
    const qr_files *f = *state;
    char path[PATH_MAX];
    for (size_t i = 0; i < sizeof how / sizeof *how; i++) {
        lf_film whole, band;
        snprintf(path, sizeof path, "%s/whole%zu", f->folder, i);
        qr_succeed("%s -o %s/w.png --state %s " SIZE "%s", f->scene, f->folder, path, how[i]);
        json_t *head = read_state(path, &whole);
        assert_rows(head, 0, 9);
        json_decref(head);
        for (size_t k = 0; k < sizeof bands / sizeof *bands; k++) {
            snprintf(path, sizeof path, "%s/band%zu_%zu", f->folder, i, k);
            qr_succeed("%s -o %s/no.png --rows %d:%d --state %s " SIZE "%s", f->scene, f->folder,
                       bands[k][0], bands[k][1], path, how[i]);
            head = read_state(path, &band);
            assert_rows(head, bands[k][0], bands[k][1]);
            assert_true(json_is_true(json_object_get(head, "complete")));
            json_decref(head);
            for (int row = 0; row < 10; row++) {
                const bool is_in = row >= bands[k][0] && row <= bands[k][1];
                assert_int_equal(lf_film_visited(band.rows[row].visits), is_in);
                if (is_in)
                    assert_true(same_rows(&whole, &band, row));
            }
            lf_film_finish(&band);
            json_t *info = info_of(path);
            assert_int_equal(number_of(info, "film_rows"), bands[k][1] - bands[k][0] + 1);
            json_decref(info);
        }
        lf_film_finish(&whole);
    }
    assert_false(qr_exists(f->folder, "no_qs3x2a0.83.png"));
}

static void a_stream_is_a_picture_of_its_own(void **state)
{
    const qr_files *f = *state;
    lf_film films[4];
    static const char *const what[] = {"", "--stream 0", "--stream 1", "--stream 1 --rows 2:7"};
    for (int i = 0; i < 4; i++) {
        char path[PATH_MAX];
        snprintf(path, sizeof path, "%s/stream%d", f->folder, i);
        qr_succeed("%s -o %s/s.png --spp 2 --state %s " SIZE "%s", f->scene, f->folder, path,
                   what[i]);
        json_t *head = read_state(path, &films[i]);
        assert_int_equal(number_of(head, "stream"), i / 2);
        json_decref(head);
    }
    for (int row = 0; row < 10; row++) {
        assert_true(same_rows(&films[0], &films[1], row));
        assert_int_equal(same_rows(&films[2], &films[3], row), row >= 2 && row <= 7);
    }
    assert_false(same_rows(&films[0], &films[2], 5));
    for (int i = 0; i < 4; i++)
        lf_film_finish(&films[i]);
}

/* Done at once, without a look at its sums; and more passes go on from fewer. */
static void a_complete_part_is_done_at_once(void **state)
{
    const qr_files *f = *state;
    char path[PATH_MAX], once[PATH_MAX];
    qr_outcome o;
    snprintf(path, sizeof path, "%s/done", f->folder);
    snprintf(once, sizeof once, "%s/once", f->folder);
    qr_succeed("%s -o %s/d.png --rows 1:2 --spp 2 --state %s " SIZE, f->scene, f->folder, path);
    char *bytes = NULL;
    size_t n = 0;
    lf_error err = {0};
    lf_assert_ok(lf_file_read(path, NULL, 1 << 24, &bytes, &n, &err), &err);
    FILE *file = fopen(path, "r+e");
    assert_non_null(file);
    assert_int_equal(fseek(file, -100, SEEK_END), 0);
    assert_int_equal(fputc(0x55 ^ bytes[n - 100], file), 0x55 ^ bytes[n - 100]);
    assert_int_equal(fclose(file), 0);
    qr_run(&o, "%s -o %s/d.png --rows 1:2 --spp 2 --state %s " SIZE, f->scene, f->folder, path);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "done is complete"));
    /* negative control: it is read to go on */
    qr_run(&o, "%s -o %s/d.png --rows 1:2 --spp 4 --state %s " SIZE, f->scene, f->folder, path);
    qr_assert_fails(&o, 1, "is damaged");
    file = fopen(path, "we");
    assert_int_equal(fwrite(bytes, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
    lf_free(bytes);
    qr_succeed("%s -o %s/d.png --rows 1:2 --spp 4 --state %s " SIZE, f->scene, f->folder, path);
    qr_succeed("%s -o %s/d.png --rows 1:2 --spp 4 --state %s " SIZE, f->scene, f->folder, once);
    lf_film a, b;
    json_decref(read_state(path, &a));
    json_decref(read_state(once, &b));
    assert_true(same_rows(&a, &b, 1) && same_rows(&a, &b, 2));
    lf_film_finish(&a);
    lf_film_finish(&b);
}

static void what_is_no_part_is_one_line(void **state)
{
    static const struct {
        const char *options, *words;
        int code;
    } wrong[] = {
        {"--rows 0:4", "--rows: needs --state FILE", 2},
        {"--stream 1", "--stream: needs --state FILE", 2},
        {"--rows 0:10 --state %s/n", "--rows: 0:10 is outside the image; expected rows within 0:9",
         2},
        {"--rows 4:3 --state %s/n", "--rows: 4:3 ends before it begins", 2},
        {"--rows 4 --state %s/n", "--rows", 2},
        {"--rows -1:4 --state %s/n", "--rows", 2},
        {"--stream 65536 --state %s/n", "--stream", 2},
        {"--stream -1 --state %s/n", "--stream", 2},
        {"--rows 0:4 --time 1 --state %s/n", "--rows: cannot be combined with --time", 2},
        {"--rows 0:4 --target-error 1 --state %s/n", "cannot be combined with --target-error", 2},
        {"--stream 4 --target-error 1 --state %s/n", "cannot be combined with --target-error", 2},
        {"--rows 0:4 --stats - --state %s/n", "--rows: cannot be combined with --stats", 2},
        {"--rows 0:4 --integrator amvpt --state %s/n", "not supported with this --integrator", 2},
        {"--spp 2 --state %s/mine", "differs in the image rows ([2, 5], not [0, 9])", 1},
        {"--spp 2 --rows 2:4 --state %s/mine", "the image rows ([2, 5], not [2, 4])", 1},
        {"--spp 2 --rows 2:5 --stream 1 --state %s/mine", "the random stream (0, not 1)", 1},
        {"--spp 1 --rows 2:5 --state %s/mine", "holds 2 spp, but this job asks for 1", 1},
        {"--spp 2 --rows 2:5 --state %s/none/x", "cannot write to the folder", 1},
    };
    const qr_files *f = *state;
    qr_outcome o;
    qr_succeed("%s -o %s/x.png --rows 2:5 --spp 2 --state %s/mine " SIZE, f->scene, f->folder,
               f->folder);
    const int before = qr_count_files(f->folder);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char options[2 * PATH_MAX];
        const char *at = strstr(wrong[i].options, "%s");
        snprintf(options, sizeof options, "%.*s%s%s",
                 (int)(at ? at - wrong[i].options : (long)strlen(wrong[i].options)),
                 wrong[i].options, at ? f->folder : "", at ? at + 2 : "");
        qr_run(&o, "%s -o %s/x.png " SIZE "%s", f->scene, f->folder, options);
        qr_assert_fails(&o, wrong[i].code, wrong[i].words);
    }
    qr_run(&o, "%s -o %s/x.png --rows 0:1 --state %s/n", f->quilt, f->folder, f->folder);
    qr_assert_fails(&o, 2, "cannot be combined with a finished quilt");
    assert_int_equal(qr_count_files(f->folder), before);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(rows_are_those_of_the_whole_state, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_stream_is_a_picture_of_its_own, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_complete_part_is_done_at_once, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(what_is_no_part_is_one_line, qr_set_up, qr_tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
