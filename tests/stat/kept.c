#include "tests/stat/kept.h"

bool lf_test_keeping(void)
{
    return getenv("QUILTD_KEEP");
}

static FILE *open_set(const char *name, const char *mode)
{
    char path[PATH_MAX];
    snprintf(path, sizeof path, "tests/stat/kept/%s.txt", name);
    FILE *file = fopen(lf_test_source(path), mode);
    if (!file)
        fail_msg("%s: cannot be opened", path);
    return file;
}

/* The number of replicates, then mean and sum of squares about it of each. */
void lf_kept_read(const char *name, int n, lf_moments *out)
{
    FILE *file = open_set(name, "r");
    double replicates = 0.0;
    int read = fscanf(file, "%lf", &replicates);
    char more;
    for (int i = 0; i < n; i++) {
        out[i].n = replicates;
        read += fscanf(file, "%lf %lf", &out[i].mean, &out[i].m2);
    }
    if (read != 1 + 2 * n || fscanf(file, " %c", &more) != EOF)
        fail_msg("%s is not of %d means", name, n);
    fclose(file);
}

void lf_kept_write(const char *name, int n, const lf_moments *moments)
{
    FILE *file = open_set(name, "w");
    fprintf(file, "%.0f\n", moments[0].n);
    for (int i = 0; i < n; i++)
        fprintf(file, "%.12g %.4g\n", moments[i].mean, moments[i].m2);
    assert_int_equal(fclose(file), 0);
}

/* Seeds are others than those of what is kept: the two are independent. */
static void draw(lf_renderer *r, const lf_kept *kept, int replicates, int cycles, lf_blocks *out)
{
    const uint64_t salt = kept->salt + (lf_test_keeping() ? 0 : 1u << 20);
    lf_blocks_init(out, r->film.n_views, r->film.width, r->film.height, kept->block);
    for (int k = 0; k < replicates; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + salt, (uint64_t)k));
        lf_test_cycles(r, cycles);
        lf_blocks_add_picture(out, r, kept->answer);
    }
}

double lf_kept_p(const lf_moments *drawn, const lf_moments *kept, double share)
{
    const double degrees = drawn->n + kept->n - 2.0,
                 pooled = (drawn->m2 / share + kept->m2) / degrees,
                 v = pooled * (share / drawn->n + 1.0 / kept->n), off = drawn->mean - kept->mean;
    if (fabs(off) <= 1e-6 * fmax(fabs(drawn->mean), fabs(kept->mean)))
        return 1.0;
    return v > 0.0 ? lf_p_student(off / sqrt(v), degrees) : 0.0;
}

/* In how many tiles a reference that is 5 % off would be told, and whether one that is 1 % off as a
 * whole would. */
static int power(const lf_blocks *drawn, const lf_blocks *before, double level, double share,
                 bool *out_whole)
{
    int seen = 0;
    for (int i = 0; i < drawn->n; i++) {
        const bool whole = i == drawn->n - 1;
        const double factor = whole ? 1.01 : 1.05;
        lf_moments up = drawn->moments[i], down = up;
        up.mean *= factor;
        down.mean /= factor;
        const bool told = lf_kept_p(&up, &before->moments[i], share) < level &&
                          lf_kept_p(&down, &before->moments[i], share) < level;
        seen += told && !whole;
        *out_whole = told;
    }
    return seen;
}

static void assert_same(const lf_blocks *drawn, const lf_blocks *before, const lf_kept *kept,
                        double share)
{
    double least = 2.0;
    int where = 0;
    bool whole = false;
    for (int i = 0; i < drawn->n; i++) {
        double p = lf_kept_p(&drawn->moments[i], &before->moments[i], share);
        where = p < least ? i : where;
        least = fmin(least, p);
    }
    const int seen = power(drawn, before, kept->level, share, &whole);
    print_message(
        "%s: worst of %d blocks p %.2g; 5 %% would be seen in %d of %d, 1 %% in all: %s\n",
        kept->name, drawn->n, least, seen, drawn->n - 1, whole ? "yes" : "no");
    const lf_moments *a = &drawn->moments[where], *b = &before->moments[where];
    if (!(least > kept->level))
        fail_msg("%s: block %d is %.6g +- %.2g, kept as %.6g +- %.2g", kept->name, where, a->mean,
                 lf_moments_error(a), b->mean, lf_moments_error(b));
    assert_true(whole && 2 * seen >= drawn->n - 1);
}

void lf_test_kept(lf_renderer *r, const lf_kept *kept, lf_blocks *out)
{
    const bool whole = lf_test_keeping() || lf_test_long();
    const int times = lf_test_keeping() ? 8 : whole ? 4 : 1;
    const int parts = whole ? 1 : kept->parts ? kept->parts : 4;
    const int cycles = (kept->cycles + parts - 1) / parts;
    lf_blocks drawn, before;
    draw(r, kept, times * kept->replicates, cycles, &drawn);
    lf_blocks_init(&before, r->film.n_views, r->film.width, r->film.height, kept->block);
    if (lf_test_keeping())
        lf_kept_write(kept->name, drawn.n, drawn.moments);
    lf_kept_read(kept->name, before.n, before.moments);
    assert_same(&drawn, &before, kept, (double)kept->cycles / cycles);
    *out = whole ? drawn : before;
    lf_blocks_finish(whole ? &before : &drawn);
    lf_renderer_destroy(r);
}
