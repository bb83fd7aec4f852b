/* Instruction sets: which there are here, and which is chosen of a table that lacks some. */
#include "base/cpu.h"

#include <stdlib.h>

#include "tests/testing.h"

static const char c = 'c', vector = 'v', widest = 'w';

#if defined(__aarch64__)
#define VECTOR LF_ISA_NEON
#define NAME "neon"
#else
#define VECTOR LF_ISA_AVX2
#define NAME "avx2"
#endif

static void plain_c_is_always_there_and_first(void **state)
{
    (void)state;
    lf_isa_tables all = {&c, &vector, &vector, &widest}, alone = {&c};
    assert_ptr_equal(lf_isa_at(all, 0), &c);
    assert_ptr_equal(lf_isa_at(alone, 0), &c);
    assert_null(lf_isa_at(alone, 1));
    assert_null(lf_isa_at(all, LF_ISAS));
    assert_int_equal(lf_isa_for("c"), LF_ISA_C);
}

static void what_is_unknown_is_the_best(void **state)
{
    (void)state;
    const lf_isa best = lf_isa_for(NULL);
    assert_int_equal(lf_isa_for("abacus"), best);
    assert_int_equal(lf_isa_for(""), best);
    lf_isa_tables all = {&c, &vector, &vector, &widest};
    int n = 0;
    while (lf_isa_at(all, (size_t)n))
        n++;
    assert_true(n == 1 || best != LF_ISA_C);
}

static void a_table_without_the_chosen_set_has_the_next_below(void **state)
{
    (void)state;
    lf_isa_tables alone = {&c}, two = {[LF_ISA_C] = &c, [VECTOR] = &vector};
    assert_ptr_equal(lf_isa_get(alone), &c);
    const char *want = getenv("LF_CPU");
    assert_ptr_equal(lf_isa_get(two), lf_isa_for(want) >= VECTOR ? &vector : &c);
    if (lf_isa_for(NULL) >= VECTOR)
        assert_int_equal(lf_isa_for(NAME), VECTOR);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plain_c_is_always_there_and_first),
        cmocka_unit_test(what_is_unknown_is_the_best),
        cmocka_unit_test(a_table_without_the_chosen_set_has_the_next_below),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
