/* Files that are merged: copies, and what is refused. */
#include "tests/render/merged.h"

#include <math.h>
#include <sys/resource.h>

static void copies_count_once(void **state)
{
    const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, 32);
    result r;
    write_one(*state, 0, &layout, 1, 0, 0, 3, 1, 2);
    write_one(*state, 1, &layout, 1, 0, 3, 6, 1, 2);
    write_one(*state, 2, &layout, 1, 1, 0, 6, 1, 2);
    merge(&r, *state, NULL, 3);
    lf_assert_ok(r.status, &r.err);
    assert_int_equal(rename(lf_test_path(*state, "out"), lf_test_path(*state, "once")), 0);
    write_one(*state, 3, &layout, 1, 0, 3, 6, 1, 2);
    write_one(*state, 4, &layout, 1, 0, 3, 6, 1, 2);
    merge(&r, *state, NULL, 5);
    lf_assert_ok(r.status, &r.err);
    films_assert_same(lf_test_path(*state, "out"), lf_test_path(*state, "once"));
    assert_int_equal(r.total.n_files, 3);
    assert_true(r.copy_of[0] == -1 && r.copy_of[1] == -1 && r.copy_of[2] == -1);
    assert_true(r.copy_of[3] == 1 && r.copy_of[4] == 1);
}

static void samples_twice_are_refused(void **state)
{
    const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, 0);
    write_one(*state, 0, &layout, 1, 2, 0, 4, 1, 2);
    write_one(*state, 1, &layout, 1, 2, 2, 6, 1, 2);
    assert_refused(*state, 2, LF_E_STATE, "has rows 2 to 3 of seed 1, stream 2, and so has");
    write_one(*state, 1, &layout, 1, 2, 0, 4, 1, 3); /* other samples */
    assert_refused(*state, 2, LF_E_STATE, "has rows 0 to 3 of seed 1, stream 2");
    write_one(*state, 1, &layout, 1, 3, 0, 4, 1, 3);
    assert_merged(*state, NULL, 2);
}

/* One number of otherwise equal films. */
static void one_bit_makes_another_film(void **state)
{
    const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, 0);
    for (int k = 0; k < 2; k++) {
        lf_film film = films_empty(&layout);
        films_visit(&film, 1, 0, 0, HEIGHT, 1, 2, false);
        lf_film_at(&film, 5, 1).q[0] = (float)k;
        films_write(&film, nth(*state, k));
        lf_film_finish(&film);
    }
    assert_refused(*state, 2, LF_E_STATE, "has rows 0 to 5 of seed 1, stream 0");
}

static void foreign_films_are_refused(void **state)
{
    lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, 0);
    write_one(*state, 0, &layout, 1, 0, 0, 3, 1, 2);
    lf_film film = films_empty(&layout);
    films_visit(&film, 1, 0, 3, 6, 1, 2, false);
    film.picture[31] ^= 1;
    films_write(&film, nth(*state, 1));
    assert_refused(*state, 2, LF_E_STATE, "is of another scene, camera or settings than");
    film.picture[31] ^= 1;
    film.sky[2] = nextafterf(film.sky[2], 1);
    films_write(&film, nth(*state, 1));
    assert_refused(*state, 2, LF_E_STATE, "is of another sky than");
    lf_film_finish(&film);
    layout.has_signed = true;
    write_one(*state, 1, &layout, 1, 0, 3, 6, 1, 2);
    assert_refused(*state, 2, LF_E_STATE, "is of another scene, camera or settings than");
}

static void films_without_samples_add_nothing(void **state)
{
    const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, 0);
    write_one(*state, 0, &layout, 1, 0, 0, 0, 1, 2);
    assert_refused(*state, 1, LF_E_STATE, "has no samples yet");
    write_one(*state, 1, &layout, 1, 0, 0, HEIGHT, 1, 2);
    assert_merged(*state, NULL, 2);
    films_assert_same(lf_test_path(*state, "out"), nth(*state, 1));
}

static void sums_beyond_what_a_row_can_have_are_refused(void **state)
{
    const lf_film_layout layout = films_layout(1, 2, 1, 0);
    for (int k = 0; k < 2; k++) {
        lf_film film = films_empty(&layout);
        films_visit(&film, 1, (uint32_t)k, 0, 1, 1, 2, false);
        film.rows[0].visits[0] = film.streams[0].rows[0].visits[0] = LF_FILM_MAX_VISITS;
        films_write(&film, nth(*state, k));
        lf_film_finish(&film);
    }
    assert_merged(*state, NULL, 1);
    assert_refused(*state, 2, LF_E_STATE, "row 0 of the sum has too many samples");
}

/* Counts that agree with nothing else, under right checksums. */
static void counts_that_lie_are_refused(void **state)
{
    const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, 0);
    for (int k = 0; k < 7; k++) {
        lf_film film = films_empty(&layout);
        films_visit(&film, 1, 0, 0, HEIGHT, 1, 2, false);
        lf_film_row *row = &film.rows[3];
        lf_film_counts *own = &film.streams[0].rows[3];
        switch (k) {
        case 0:
            row->passes *= 2;
            break;
        case 1:
            row->n[1] *= 2;
            break;
        case 2:
            row->visits[1]++;
            break;
        case 3:
            own->n[0] *= 2;
            break;
        case 4:
            own->n[0] = row->n[0] = NAN;
            break;
        case 5:
            own->n[0] = row->n[0] = -row->n[0];
            break;
        default:
            row->visits[0] = row->visits[1] = 0; /* not written */
            break;
        }
        films_write(&film, nth(*state, 0));
        assert_refused(*state, 1, LF_E_FORMAT,
                       k < 6 ? "row 3 has invalid counts" : "row 3 is missing");
        lf_film_finish(&film);
    }
}

/* ------------------------------------------------------------------------------------- files -- */

static void files_that_are_cut_or_longer_are_refused(void **state)
{
    const lf_film_layout layout = films_layout(2, 4, 3, 34);
    size_t size;
    write_one(*state, 0, &layout, 1, 0, 0, 3, 1, 2);
    char *bytes = films_bytes(nth(*state, 0), &size);
    for (size_t cut = 1; cut < size; cut += 13) {
        films_put(nth(*state, 0), bytes, size - cut);
        assert_refused(*state, 1, LF_E_FORMAT, "is damaged");
    }
    char *longer = lf_calloc(size + 1, 1);
    memcpy(longer, bytes, size);
    films_put(nth(*state, 0), longer, size + 1);
    assert_refused(*state, 1, LF_E_FORMAT, "data after its end");
    lf_free(longer);
    lf_free(bytes);
}

static void any_bit_that_was_changed_is_noticed(void **state)
{
    const lf_film_layout layout = films_layout(2, 4, 3, 34);
    size_t size;
    write_one(*state, 0, &layout, 1, 0, 0, 1, 1, 2);
    write_one(*state, 1, &layout, 1, 0, 1, 3, 1, 2);
    char *bytes = films_bytes(nth(*state, 1), &size);
    for (size_t i = 0; i < size; i += i < 400 ? 1 : 3) {
        result r;
        bytes[i] = (char)(bytes[i] ^ (1 << i % 8));
        films_put(nth(*state, 1), bytes, size);
        merge(&r, *state, NULL, 2);
        assert_true(r.status == LF_E_FORMAT || r.status == LF_E_STATE);
        bytes[i] = (char)(bytes[i] ^ (1 << i % 8));
    }
    lf_free(bytes);
}

/* Between the passes a file becomes another one, or the same one again. */
static void files_that_change_meanwhile_are_noticed(void **state)
{
    const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, 0);
    for (int k = 0; k < 3; k++) {
        lf_merging *m = NULL;
        lf_merging_total total;
        lf_merging_file found;
        lf_error err = {0};
        unlink(nth(*state, 0));
        write_one(*state, 0, &layout, 1, 0, 0, HEIGHT, 1, 2);
        lf_assert_ok(lf_merging_create(&m, NULL), NULL);
        int fd = open(nth(*state, 0), O_RDONLY | O_CLOEXEC);
        lf_assert_ok(lf_merging_add(m, fd, nth(*state, 0), 0, &found, NULL), NULL);
        close(fd);
        lf_assert_ok(lf_merging_arrange(m, &total, NULL), NULL);
        if (k == 1) /* another one in its place */
            unlink(nth(*state, 0));
        if (k == 1)
            write_one(*state, 0, &layout, 1, 0, 0, HEIGHT, 1, 2);
        if (k == 2) { /* changed in place under the same time, while it is open */
            size_t size;
            write_one(*state, 1, &layout, 1, 0, 0, HEIGHT, 1, 4);
            char *bytes = films_bytes(nth(*state, 1), &size);
            films_put(nth(*state, 0), bytes, size);
            lf_free(bytes);
        }
        lf_outfile file = films_create(lf_test_path(*state, "out"));
        const lf_status status = lf_merging_write(m, &file, NULL, NULL, NULL, &err);
        close(file.fd);
        lf_merging_destroy(m);
        assert_int_equal(status, k == 2 ? LF_E_FORMAT : LF_OK);
        assert_true(status == LF_OK || strstr(err.what, "changed while it was read"));
    }
}

/* Thousands of films with few descriptors. */
static void many_files_need_few_descriptors(void **state)
{
    enum { FILES = 2000 };
    const lf_film_layout layout = films_layout(1, 2, 2, 0);
    const struct rlimit few = {24, 24};
    struct rlimit usual;
    double w = 0;
    for (int i = 0; i < FILES; i++) {
        lf_film film = films_empty(&layout);
        films_visit(&film, 3, (uint32_t)i, 0, 2, 1, 2, false);
        w += (double)lf_film_at(&film, 1, 0).scattered[1].w;
        films_write(&film, nth(*state, i));
        lf_film_finish(&film);
    }
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &usual), 0);
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &(struct rlimit){few.rlim_cur, usual.rlim_max}), 0);
    assert_merged(*state, NULL, FILES);
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &usual), 0);
    lf_film sum = merged(*state);
    assert_int_equal(sum.n_streams, FILES);
    lf_assert_close((double)lf_film_at(&sum, 1, 0).scattered[1].w, w, 1e-6, 0);
    lf_film_finish(&sum);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(copies_count_once),
        lf_test_in_folder(samples_twice_are_refused),
        lf_test_in_folder(one_bit_makes_another_film),
        lf_test_in_folder(foreign_films_are_refused),
        lf_test_in_folder(films_without_samples_add_nothing),
        lf_test_in_folder(sums_beyond_what_a_row_can_have_are_refused),
        lf_test_in_folder(counts_that_lie_are_refused),
        lf_test_in_folder(files_that_are_cut_or_longer_are_refused),
        lf_test_in_folder(any_bit_that_was_changed_is_noticed),
        lf_test_in_folder(files_that_change_meanwhile_are_noticed),
        lf_test_in_folder(many_files_need_few_descriptors),
    };
    return cmocka_run_group_tests_name("film_merge_files", tests, NULL, NULL);
}
