/* One daemon that is given scenes whose structure was changed at random (numbers made extreme,
 * parts left out, doubled, exchanged), and that renders each it takes: it answers every one and
 * goes on. The seeds are the shipped scenes with their data, and
 * some of the test's own, which are all shown as they are. A few; $QUILTD_LONG: 10,000;
 * $MUTATIONS: as many as that says. $QUILTD_SEED: others. */
#include "tests/testing.h"

#include <dirent.h>

#include "base/file.h"
#include "tests/daemon/live.h"
#include "tests/scene_file.h"

enum { FEW = 60, MANY = 10000, MOST_SEEDS = 64, MOST_CHANGES = 2 };

/* What the shipped scenes have little of. */
static const char *const own_seeds[] = {
    "thin-instances",   /* and far ones */
    "lights-in-fog",    /* of every kind */
    "keys-and-shutter", /* numbers with keys, while the shutter is open */
};

/* Some are legal, some are not, and some are legal alone. */
static const double extremes[] = {0,    -1,   1e-45, 1e-20, 1e-18, 1e-12, 1e-6, 0.5,
                                  1.5,  90,   180,   360,   1e4,   1e6,   1e9,  -1e9,
                                  1e12, 1e18, 1e19,  1e38,  1e39,  1e300};

typedef struct mutator {
    uint64_t state;
    json_t *seeds[MOST_SEEDS];
    int n_seeds;
} mutator;

/* SplitMix64: Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators", 2014. */
static size_t choose(mutator *m, size_t n)
{
    uint64_t z = m->state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return (size_t)((z ^ (z >> 31)) % n);
}

/* ------------------------------------------------------------------------------------- seeds -- */

/* The files that a scene names lie beside it. */
static void make_absolute(json_t *value, const char *folder)
{
    const char *key;
    json_t *member;
    size_t i;
    json_array_foreach(value, i, member) make_absolute(member, folder);
    json_object_foreach(value, key, member)
    {
        const char *name = json_string_value(member);
        if (name && name[0] != '/' &&
            (strcmp(key, "file") == 0 || strcmp(key, "instances") == 0 ||
             strcmp(key, "include") == 0)) {
            char path[PATH_MAX];
            snprintf(path, sizeof path, "%s/%s", folder, name);
            json_string_set(member, path);
        } else {
            make_absolute(member, folder);
        }
    }
}

static int by_name(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

static int is_scene(const struct dirent *entry)
{
    return lf_path_has_ending(entry->d_name, ".json");
}

static void make_seeds(mutator *m)
{
    for (size_t i = 0; i < sizeof own_seeds / sizeof *own_seeds; i++)
        m->seeds[m->n_seeds++] = lf_test_scene_document(own_seeds[i]);
}

static void read_seeds(mutator *m, const char *folder)
{
    struct dirent **names;
    int n = scandir(folder, &names, is_scene, by_name);
    assert_true(n > 0);
    for (int i = 0; i < n; i++) {
        json_t *seed = json_load_file(lf_test_path(folder, names[i]->d_name), 0, NULL);
        assert_true(m->n_seeds < MOST_SEEDS && json_is_object(seed));
        make_absolute(seed, folder);
        m->seeds[m->n_seeds++] = seed;
        free(names[i]);
    }
    free(names);
}

/* --------------------------------------------------------------------------------- mutations -- */

static size_t size_of(const json_t *value)
{
    return json_is_object(value) ? json_object_size(value) : json_array_size(value);
}

/* Where a value stands: in an object by its key, or in an array. */
typedef struct place {
    json_t *parent;
    const char *key;
    size_t index;
} place;

static place child_of(json_t *parent, size_t index)
{
    place at = {parent, NULL, index};
    if (json_is_object(parent)) {
        void *iter = json_object_iter(parent);
        for (size_t i = 0; i < index; i++)
            iter = json_object_iter_next(parent, iter);
        at.key = json_object_iter_key(iter);
    }
    return at;
}

static json_t *value_at(const place *at)
{
    return at->key ? json_object_get(at->parent, at->key) : json_array_get(at->parent, at->index);
}

static void put(const place *at, json_t *value)
{
    if (at->key)
        json_object_set_new(at->parent, at->key, value);
    else
        json_array_set_new(at->parent, at->index, value);
}

static void leave_out(const place *at)
{
    if (at->key)
        json_object_del(at->parent, at->key);
    else
        json_array_remove(at->parent, at->index);
}

/* A random value that is not the whole; deep ones are as likely as shallow ones. */
static place choose_place(mutator *m, json_t *scene)
{
    place at = child_of(scene, choose(m, size_of(scene)));
    for (json_t *value = value_at(&at); size_of(value) > 0 && choose(m, 8) > 0;
         value = value_at(&at))
        at = child_of(value, choose(m, size_of(value)));
    return at;
}

static json_t *another(mutator *m, const json_t *was)
{
    static const double factors[] = {-1, 0.1, 0.5, 0.9, 1.1, 2, 10, 1000, 1e-6, 1e-18, 1e-20};
    if (choose(m, 3) > 0)
        return json_real(json_number_value(was) *
                         factors[choose(m, sizeof factors / sizeof *factors)]);
    return json_real(extremes[choose(m, sizeof extremes / sizeof *extremes)]);
}

/* Beside the others, under a name of its own. */
static void repeat(const place *at, json_t *copy)
{
    char name[32];
    snprintf(name, sizeof name, "again%zu", size_of(at->parent));
    if (at->key)
        json_object_set_new(at->parent, name, copy);
    else
        json_array_append_new(at->parent, copy);
}

static void change(mutator *m, json_t *scene)
{
    place at = choose_place(m, scene), other;
    /* most other changes are refused at once, and so is another version of the format */
    for (int i = 0; i < 8 && (!json_is_number(value_at(&at)) || at.parent == scene); i++)
        at = choose_place(m, scene);
    json_t *was = value_at(&at);
    const size_t how = choose(m, 16);
    if (json_is_number(was) && how < 12) {
        put(&at, another(m, was));
    } else if (how < 8) {
        repeat(&at, json_deep_copy(was));
    } else if (how < 10) {
        leave_out(&at);
    } else if (how < 12) {
        put(&at, json_pack("[O,O]", was, was));
    } else {
        other = choose_place(m, m->seeds[choose(m, (size_t)m->n_seeds)]);
        put(&at, json_deep_copy(value_at(&other)));
    }
}

static json_t *mutate(mutator *m)
{
    /* the test's own as often as the shipped ones, which are many */
    const size_t n_own = sizeof own_seeds / sizeof *own_seeds,
                 n = choose(m, 2) > 0 ? n_own : (size_t)m->n_seeds;
    json_t *scene = json_deep_copy(m->seeds[choose(m, n)]);
    for (size_t left = 1 + choose(m, MOST_CHANGES); left > 0 && size_of(scene) > 0; left--)
        change(m, scene);
    return scene;
}

/* ------------------------------------------------------------------------------------ giving -- */

typedef struct outcome {
    int shown, slow, refused;
} outcome;

static bool went_well(json_t *answer)
{
    const json_t *error = json_object_get(answer, "error");
    const char *message = json_string_value(json_object_get(error, "message"));
    assert_true(!error || (message && message[0]));
    json_decref(answer);
    return !error;
}

/* Loads a scene, which stays in scene/mutated.json when the test fails; one that is taken is looked
 * at from elsewhere, and rendered as far as a coarse frame, or for a while. */
static void give(live *l, live_client *c, const json_t *scene, outcome *out)
{
    const char *path = lf_test_path(l->folder, "scene/mutated.json");
    assert_int_equal(json_dump_file(scene, path, 0), 0);
    if (!went_well(live_call(c, "scene.load", json_pack("{s:s}", "file", "mutated.json")))) {
        out->refused++;
        return;
    }
    went_well(live_call(c, "camera.orbit", json_pack("{s:i}", "yaw", 10)));
    if (went_well(live_call(c, "wait", json_pack("{s:s, s:i}", "for", "coarse", "timeout", 20))))
        out->shown++;
    else
        out->slow++;
}

static int how_many(void)
{
    const char *told = getenv("MUTATIONS");
    return told ? atoi(told) : lf_test_long() ? MANY : FEW;
}

static void no_scene_stops_a_daemon(void **state)
{
    (void)state;
    char folder[PATH_MAX];
    live l;
    live_client c;
    mutator m = {.state = lf_test_seed()};
    outcome out = {0};
    assert_non_null(realpath(lf_test_built("../scenes"), folder));
    make_seeds(&m);
    read_seeds(&m, folder);
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, "--allow-path", folder, NULL);
    live_connect(&l, &c);
    for (int i = 0; i < m.n_seeds; i++)
        give(&l, &c, m.seeds[i], &out);
    assert_int_equal(out.refused, 0);
    for (int i = 0; i < how_many(); i++) {
        json_t *scene = mutate(&m);
        give(&l, &c, scene, &out);
        json_decref(scene);
    }
    print_message("shown %d, not yet after 20 s %d, refused %d\n", out.shown, out.slow,
                  out.refused);
    assert_true(out.shown + out.slow > how_many() / 3 && out.refused > 0); /* both are tried */
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", "fog.json")), 0);
    live_wait(&c, "complete");
    for (int i = 0; i < m.n_seeds; i++)
        json_decref(m.seeds[i]);
    live_close(&c);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(no_scene_stops_a_daemon)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
