/* Ten thousand states with mistakes, each merged with sound ones: refused in one line, or the
 * result is, to the bit, the merge of parts that are sound, and tells how many these are. Never a
 * crash. */
#include "tests/render/films.h"

#include <zlib.h>

#include "base/log.h"
#include "daemon/tools/job_merge.h"

enum {
    PARTS = 3,
    SUBSETS = 1 << PARTS,
    ROWS = 6,
    HEAD = 20,      /* of a state, before its text */
    START = 12,     /* of a film */
    PART_HEAD = 16, /* of a part of a film */
    MOST_BYTES = 1 << 16,
    MOST_PIECES = 64
};

/* Nothing here needs to be on a disk. */
int __wrap_fsync(int fd);
int __wrap_fsync(int fd)
{
    (void)fd;
    return 0;
}

/* A state as bytes. */
typedef struct bytes {
    size_t n, film; /* film: where it begins */
    unsigned char p[MOST_BYTES];
} bytes;

/* Three parts, and the right films of every subset of them. */
typedef struct scenario {
    char *folder;
    char path[PARTS][PATH_MAX], out[PATH_MAX];
    bytes part[PARTS], right[SUBSETS];
    bool is_right[SUBSETS]; /* the subset can be merged with --partial */
    uint64_t random;
} scenario;

static uint32_t draw(scenario *s, uint32_t below)
{
    s->random = lf_hash64(s->random, 1);
    return (uint32_t)((s->random >> 32) * below >> 32);
}

/* --------------------------------------------------------------------------------- the parts -- */

static json_t *head_of(const lf_film_layout *l, int first, int last, int stream, int passes)
{
    return json_pack("{s:s, s:s, s:i, s:i, s:i, s:[i, i], s:i, s:i, s:s, s:b, s:b, s:{s:s, s:s, "
                     "s:s}, s:{s:i}, s:i, s:f, s:f, s:b}",
                     "quiltd", "0", "scene", "fog", "views", l->n_views, "width", l->width,
                     "height", l->height, "rows", first, last, "stream", stream, "seed", 7,
                     "integrator", "mvpt", "reconstruct", 1, "denoise", 1, "hashes", "scene", "a",
                     "camera", "b", "all", "c", "budget", "passes", passes, "passes", passes,
                     "seconds", 1.0, "cpu_seconds", 2.0, "complete", 1);
}

static void take_bytes(const char *path, bytes *out)
{
    size_t n;
    char *data = films_bytes(path, &n);
    uint32_t text;
    assert_true(n <= MOST_BYTES);
    memcpy(out->p, data, n);
    memcpy(&text, out->p + 12, sizeof text);
    out->n = n;
    out->film = HEAD + text;
    lf_free(data);
}

static void make_part(scenario *s, int i, const lf_film_layout *l, int first, int last, int stream)
{
    enum { VISITS = 4 };
    lf_film film = films_empty(l);
    json_t *head = head_of(l, first, last, stream, VISITS * l->n_views);
    lf_outfile file = films_create(s->path[i]);
    lf_error err = {0};
    films_visit(&film, 7, (uint32_t)stream, first, last + 1, 1, VISITS, false);
    lf_assert_ok(lf_job_state_put(&file, head, &err), &err);
    lf_assert_ok(lf_film_write(&film, &file, NULL, &err), &err);
    close(file.fd);
    json_decref(head);
    lf_film_finish(&film);
    take_bytes(s->path[i], &s->part[i]);
}

static lf_status merge(const scenario *s, int subset, bool partial, lf_job_merged *out,
                       lf_error *err)
{
    const char *parts[PARTS];
    lf_job_merge m = {.parts = parts, .out = s->out, .partial = partial};
    for (int i = 0; i < PARTS; i++)
        if (subset >> i & 1)
            parts[m.n_parts++] = s->path[i];
    return lf_job_merge_run(&m, out, err);
}

static void begin(scenario *s, bool bands, uint64_t seed)
{
    const lf_film_layout l = films_layout(2 + (int)(seed % 3), 8, ROWS, bands ? 3 : 34);
    lf_job_merged merged;
    s->folder = lf_test_folder();
    s->random = seed;
    snprintf(s->out, sizeof s->out, "%s/out", s->folder);
    for (int i = 0; i < PARTS; i++) {
        snprintf(s->path[i], sizeof s->path[i], "%s/%d.lfstate", s->folder, i);
        make_part(s, i, &l, bands ? 2 * i : 0, bands ? 2 * i + 1 : ROWS - 1, bands ? 0 : i);
    }
    for (int subset = 1; subset < SUBSETS; subset++) {
        s->is_right[subset] = merge(s, subset, true, &merged, NULL) == LF_OK;
        if (s->is_right[subset])
            take_bytes(s->out, &s->right[subset]);
    }
    assert_true(s->is_right[SUBSETS - 1]);
}

/* -------------------------------------------------------------------------------- the damage -- */

/* The parts of a film: where they begin, and the end of the last. */
static int pieces_of(const bytes *b, size_t at[MOST_PIECES + 1])
{
    int n = 0;
    uint64_t size = 0;
    for (size_t p = b->film + START; p < b->n && n < MOST_PIECES; p += PART_HEAD + size) {
        memcpy(&size, b->p + p + 8, sizeof size);
        at[n++] = p;
    }
    at[n] = b->n;
    return n;
}

/* Gives all parts of a film, its end and the head the checksums that fit. */
static void mend(bytes *b)
{
    size_t at[MOST_PIECES + 1];
    const int n = pieces_of(b, at);
    uLong heads = 0;
    for (int i = 0; i < n; i++) {
        unsigned char *p = b->p + at[i];
        const uint32_t of_all = (uint32_t)heads;
        if (memcmp(p, "END ", 4) == 0 && at[i + 1] == at[i] + PART_HEAD + sizeof of_all)
            memcpy(p + PART_HEAD, &of_all, sizeof of_all);
        uLong crc = crc32_z(0, p, 4);
        crc = crc32_z(crc, p + 8, at[i + 1] - at[i] - 8);
        const uint32_t fit = (uint32_t)crc;
        memcpy(p + 4, &fit, sizeof fit);
        heads = crc32_z(heads, p, PART_HEAD);
    }
    uLong crc = crc32_z(0, b->p + 12, 4);
    const uint32_t fit = (uint32_t)crc32_z(crc, b->p + HEAD, b->film - HEAD);
    memcpy(b->p + 16, &fit, sizeof fit);
}

/* Replaces [from, to) by n other bytes. */
static void replace(bytes *b, size_t from, size_t to, const unsigned char *with, size_t n)
{
    static unsigned char kept[MOST_BYTES];
    const size_t rest = b->n - to;
    assert_true(from + n + rest <= MOST_BYTES);
    memcpy(kept, b->p + to, rest);
    memmove(b->p + from, with, n);
    memcpy(b->p + from + n, kept, rest);
    b->n = from + n + rest;
}

static void flip_bits(scenario *s, bytes *b)
{
    for (uint32_t i = 0, n = 1 + draw(s, 3); i < n; i++)
        b->p[draw(s, (uint32_t)b->n)] ^= (unsigned char)(1 << draw(s, 8));
}

/* A bit of what a checksum covers, under a checksum that fits. Nobody can know a row's numbers, its
 * coarse part, and whether its plane met anything. */
static void flip_count(scenario *s, bytes *b)
{
    size_t at[MOST_PIECES + 1];
    const int n = pieces_of(b, at), i = (int)draw(s, (uint32_t)n);
    const bool row = memcmp(b->p + at[i], "ROW ", 4) == 0;
    const size_t size = row ? 40 : at[i + 1] - at[i] - PART_HEAD;
    size_t place = size > 0 ? draw(s, (uint32_t)size) : 0;
    if (row && place >= 4 && place < 8)
        place -= 4;
    if (size > 0)
        b->p[at[i] + PART_HEAD + place] ^= (unsigned char)(1 << draw(s, 8));
    if (size > 0)
        mend(b);
}

static void cut(scenario *s, bytes *b)
{
    b->n = draw(s, (uint32_t)b->n);
}

static void append(scenario *s, bytes *b)
{
    const bytes *other = &s->part[draw(s, PARTS)];
    const size_t n = 1 + draw(s, 200);
    replace(b, b->n, b->n, other->p + draw(s, (uint32_t)(other->n - n)), n);
}

static void swap_pieces(scenario *s, bytes *b)
{
    static bytes old;
    size_t at[MOST_PIECES + 1];
    const int n = pieces_of(b, at), i = (int)draw(s, (uint32_t)n), k = (int)draw(s, (uint32_t)n);
    const int low = i < k ? i : k, high = i < k ? k : i;
    if (low == high)
        return;
    old = *b;
    replace(b, at[high], at[high + 1], old.p + at[low], at[low + 1] - at[low]);
    replace(b, at[low], at[low + 1], old.p + at[high], at[high + 1] - at[high]);
}

static void drop_piece(scenario *s, bytes *b)
{
    size_t at[MOST_PIECES + 1];
    const int i = (int)draw(s, (uint32_t)pieces_of(b, at));
    replace(b, at[i], at[i + 1], NULL, 0);
}

/* A part of this film, or of another one, in addition or in place of one. */
static void put_piece(scenario *s, bytes *b)
{
    const bytes *from = &s->part[draw(s, PARTS)];
    size_t at[MOST_PIECES + 1], of[MOST_PIECES + 1];
    const int i = (int)draw(s, (uint32_t)pieces_of(b, at)),
              k = (int)draw(s, (uint32_t)pieces_of(from, of));
    replace(b, at[i], draw(s, 2) ? at[i] : at[i + 1], from->p + of[k], of[k + 1] - of[k]);
}

static void swap_heads(scenario *s, bytes *b)
{
    const bytes *from = &s->part[draw(s, PARTS)];
    replace(b, 0, b->film, from->p, from->film);
}

static json_t *any_value(scenario *s)
{
    switch (draw(s, 7)) {
    case 0:
        return json_integer((json_int_t)draw(s, 20) - 2);
    case 1:
        return json_boolean(draw(s, 2));
    case 2:
        return json_real(-0.5 + draw(s, 100));
    case 3:
        return json_string("mvpt");
    case 4:
        return json_pack("[i, i]", (int)draw(s, 8), (int)draw(s, 8));
    case 5:
        return json_pack("{s:i}", "passes", (int)draw(s, 20));
    default:
        return json_integer(INT64_MAX - (json_int_t)draw(s, 2));
    }
}

/* Replaces the head under a checksum that fits. */
static void put_head(bytes *b, const json_t *head)
{
    char *text = json_dumps(head, JSON_COMPACT);
    const uint32_t n = (uint32_t)strlen(text);
    replace(b, HEAD, b->film, (unsigned char *)text, n);
    memcpy(b->p + 12, &n, sizeof n);
    b->film = HEAD + n;
    mend(b);
    free(text);
}

/* Another value of a key of the head, or none. */
static void change_head(scenario *s, bytes *b)
{
    static const char *const keys[] = {"rows",   "stream", "seed",    "passes",     "complete",
                                       "budget", "views",  "height",  "width",      "hashes",
                                       "parts",  "frame",  "streams", "camera_row", "seconds"};
    const char *key = keys[draw(s, sizeof keys / sizeof keys[0])];
    json_t *head = json_loadb((char *)b->p + HEAD, b->film - HEAD, 0, NULL);
    assert_non_null(head);
    if (draw(s, 5) > 0)
        json_object_set_new(head, key, any_value(s));
    else
        json_object_del(head, key);
    put_head(b, head);
    json_decref(head);
}

static void become_another(scenario *s, bytes *b)
{
    *b = s->part[draw(s, PARTS)];
}

static void (*const damages[])(scenario *, bytes *) = {
    flip_bits,  flip_count, cut,         append,      swap_pieces,
    drop_piece, put_piece,  change_head, swap_heads,  become_another,
    flip_count, flip_bits,  change_head, swap_pieces,
};
enum { DAMAGES = sizeof damages / sizeof damages[0] };

/* ------------------------------------------------------------------------------- the verdict -- */

/* What the result is the merge of; 0: of nothing that is right. */
static int subset_in(const scenario *s, const bytes *got)
{
    for (int subset = SUBSETS - 1; subset > 0; subset--) {
        const bytes *right = &s->right[subset];
        if (s->is_right[subset] && got->n - got->film == right->n - right->film &&
            memcmp(got->p + got->film, right->p + right->film, got->n - got->film) == 0)
            return subset;
    }
    return 0;
}

/* The head of a result says what is in it. */
static void check_head(const scenario *s, const bytes *got, int subset, bool partial)
{
    static const char *const keys[] = {"passes", "rows", "streams", "views", "width", "height"};
    json_t *head = json_loadb((const char *)got->p + HEAD, got->film - HEAD, 0, NULL),
           *right = json_loadb((const char *)s->right[subset].p + HEAD,
                               s->right[subset].film - HEAD, 0, NULL);
    assert_true(head && right);
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++)
        if (!json_equal(json_object_get(head, keys[i]), json_object_get(right, keys[i])) &&
            (json_object_get(head, keys[i]) || json_object_get(right, keys[i])))
            fail_msg("the head of a result differs in %s", keys[i]);
    /* nothing that lacks rows is said to be complete */
    if (!json_is_true(json_object_get(right, "complete")))
        assert_true(partial && !json_is_true(json_object_get(head, "complete")));
    json_decref(head);
    json_decref(right);
}

typedef struct tally {
    int refused, merged, fewer;
} tally;

static void check_one(scenario *s, const bytes *b, int at, bool partial, tally *t, int which)
{
    static bytes got;
    lf_job_merged merged = {0};
    lf_error err = {0};
    films_put(s->path[at], (const char *)b->p, b->n);
    unlink(s->out);
    const lf_status status = merge(s, SUBSETS - 1, partial, &merged, &err);
    if (status != LF_OK) {
        assert_true(err.what[0] && err.where[0] && !strchr(err.what, '\n'));
        assert_int_not_equal(access(s->out, F_OK), 0);
        t->refused++;
    } else {
        take_bytes(s->out, &got);
        const int subset = subset_in(s, &got);
        if (subset == 0)
            fail_msg("a merge of other samples than the parts have (damage %d)", which);
        check_head(s, &got, subset, partial);
        /* the program tells their number, and a warning names copies */
        if (__builtin_popcount((unsigned)subset) < PARTS)
            assert_true(merged.n_parts <= __builtin_popcount((unsigned)subset) || !merged.complete);
        t->merged++;
        t->fewer += subset != SUBSETS - 1;
    }
}

static void no_damage_makes_a_wrong_image(void **state)
{
    (void)state;
    enum { ROUNDS = 6, EACH = 1667 };
    static scenario s;
    static bytes b;
    tally t = {0};
    lf_log_init("test", LF_LOG_ERROR);
    for (int round = 0; round < ROUNDS * (lf_test_long() ? 10 : 1); round++) {
        begin(&s, round % 2 == 0, lf_test_seed() + (uint64_t)round);
        for (int i = 0; i < EACH; i++) {
            const int at = (int)draw(&s, PARTS);
            b = s.part[at];
            damages[i % DAMAGES](&s, &b);
            check_one(&s, &b, at, i / DAMAGES % 3 == 2, &t, i % DAMAGES);
            films_put(s.path[at], (const char *)s.part[at].p, s.part[at].n);
        }
        lf_test_folder_remove(s.folder);
    }
    print_message("%d refused, %d merged, %d of them without a part\n", t.refused, t.merged,
                  t.fewer);
    assert_true(t.refused > 7000 && t.merged > 300 && t.fewer > 20);
}

/* Heads under right checksums that say other things than the film; the part has rows 2 and 3. */
static void heads_that_lie_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *patch, *words;
    } cases[] = {
        {"{\"rows\": [3, 4], \"complete\": false}", "differ about its rows"},
        {"{\"rows\": [2, 4]}", "differ about being complete"},
        {"{\"passes\": 3}", "differ about being complete"},
        {"{\"stream\": 1}", "differ about its seed and stream"},
        {"{\"seed\": 8}", "differ about its seed and stream"},
        {"{\"seed\": \"18446744073709551615\"}", "differ about its seed and stream"},
        {"{\"streams\": 2}", "differ about its random streams"},
        {"{\"frame\": 3}", "differs in the frame"},
        {"{\"camera_row\": 3}", "differs in the row of cameras"},
        {"{\"complete\": 3}", "its head describes no job"},
    };
    static scenario s;
    static bytes b;
    begin(&s, true, 1);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lf_job_merged merged;
        lf_error err = {0};
        b = s.part[1];
        json_t *head = json_loadb((char *)b.p + HEAD, b.film - HEAD, 0, NULL),
               *patch = json_loads(cases[i].patch, 0, NULL);
        assert_true(head && patch && json_object_update(head, patch) == 0);
        put_head(&b, head);
        json_decref(head);
        json_decref(patch);
        films_put(s.path[1], (const char *)b.p, b.n);
        assert_int_not_equal(merge(&s, SUBSETS - 1, true, &merged, &err), LF_OK);
        if (!strstr(err.what, cases[i].words))
            fail_msg("%s: \"%s\", expected \"%s\"", cases[i].patch, err.what, cases[i].words);
    }
    lf_test_folder_remove(s.folder);
}

/* The negative control, and the limit that the manual names: another number under a checksum that
 * fits makes another image. */
static void numbers_under_right_checksums_cannot_be_known(void **state)
{
    (void)state;
    static scenario s;
    static bytes b, got;
    size_t at[MOST_PIECES + 1];
    lf_job_merged merged;
    lf_error err = {0};
    begin(&s, true, 1);
    b = s.part[1];
    pieces_of(&b, at);
    b.p[at[4] + PART_HEAD + 56 + 3] ^= 1; /* the second row's first number */
    films_put(s.path[1], (const char *)b.p, b.n);
    lf_assert_status(merge(&s, SUBSETS - 1, false, &merged, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "its checksum does not match"));
    mend(&b);
    films_put(s.path[1], (const char *)b.p, b.n);
    lf_assert_ok(merge(&s, SUBSETS - 1, false, &merged, &err), &err);
    take_bytes(s.out, &got);
    assert_int_equal(subset_in(&s, &got), 0);
    lf_test_folder_remove(s.folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_damage_makes_a_wrong_image),
        cmocka_unit_test(heads_that_lie_are_refused),
        cmocka_unit_test(numbers_under_right_checksums_cannot_be_known),
    };
    return cmocka_run_group_tests_name("mutated_states", tests, NULL, NULL);
}
