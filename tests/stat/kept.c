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

static void draw(lf_renderer *r, const lf_kept *kept, int replicates, int cycles, lf_blocks *out)
{
    lf_blocks_init(out, r->film.n_views, r->film.width, r->film.height, kept->block);
    for (int k = 0; k < replicates; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + kept->salt, (uint64_t)k));
        lf_test_cycles(r, cycles);
        lf_blocks_add_picture(out, r, kept->answer);
    }
}

/* Where little but the sky is seen few replicates may all have missed the rest, and tell no spread:
 * it is taken to be what those that are kept have, of which one is made of `share` times the
 * cycles. */
static void assert_same(const lf_blocks *drawn, const lf_blocks *before, const lf_kept *kept,
                        double share)
{
    double least = 2.0;
    int where = 0;
    for (int i = 0; i < drawn->n; i++) {
        lf_moments a = drawn->moments[i];
        const double spread = share * lf_moments_variance(&before->moments[i]);
        a.m2 = fmax(a.m2, spread * (a.n - 1.0));
        double p = lf_p_welch(&a, &before->moments[i]);
        where = p < least ? i : where;
        least = fmin(least, p);
    }
    const lf_moments *a = &drawn->moments[where], *b = &before->moments[where];
    const lf_moments *all = &drawn->moments[drawn->n - 1];
    print_message("%s: worst of %d blocks p %.2g; %.6g +- %.2g in all\n", kept->name, drawn->n,
                  least, all->mean, lf_moments_error(all));
    if (!(least > kept->level))
        fail_msg("%s: block %d is %.6g +- %.2g, kept as %.6g +- %.2g", kept->name, where, a->mean,
                 lf_moments_error(a), b->mean, lf_moments_error(b));
}

void lf_test_kept(lf_renderer *r, const lf_kept *kept, lf_blocks *out)
{
    const bool whole = lf_test_keeping() || lf_test_long();
    const int times = lf_test_keeping() ? 8 : whole ? 4 : 1;
    const int cycles = whole ? kept->cycles : (kept->cycles + 3) / 4;
    lf_blocks drawn, before;
    draw(r, kept, times * kept->replicates, cycles, &drawn);
    if (lf_test_keeping())
        lf_kept_write(kept->name, drawn.n, drawn.moments);
    lf_blocks_init(&before, r->film.n_views, r->film.width, r->film.height, kept->block);
    lf_kept_read(kept->name, before.n, before.moments);
    assert_same(&drawn, &before, kept, (double)kept->cycles / cycles);
    *out = whole ? drawn : before;
    lf_blocks_finish(whole ? &before : &drawn);
    lf_renderer_destroy(r);
}
