/* Reproductions of papers as a library: what a program has before and after it adds them. */
#include "tests/testing.h"

#include "render/papers/papers.h"

static int count_integrators(void)
{
    int n = 0;
    while (lf_integrator_at(n))
        n++;
    return n;
}

static void what_is_added_is_what_is_known_by_name(void **state)
{
    (void)state;
    const int before = count_integrators();
    for (int i = 0; lf_integrator_reference(i); i++)
        assert_null(lf_integrator_named(lf_integrator_reference(i)));
    assert_null(lf_integrator_params()[0].option);
    lf_papers_add();
    int n = 0;
    for (; lf_integrator_reference(n); n++)
        assert_string_equal(lf_integrator_at(before + n)->name, lf_integrator_reference(n));
    assert_int_equal(count_integrators(), before + n);
    lf_papers_add();
    assert_int_equal(count_integrators(), before + n);
}

static void choices_are_told_apart_by_who_takes_them(void **state)
{
    (void)state;
    lf_papers_add();
    const lf_param *rows = lf_integrator_params();
    const lf_integrator_entry *shifting = lf_integrator_named("mismvpt"),
                              *reusing = lf_integrator_named("restir");
    lf_choices choices = {.of = {[LF_PAPERS_SHIFT] = 2}};
    assert_null(lf_choices_unfit(&choices, shifting));
    assert_ptr_equal(lf_choices_unfit(&choices, reusing), &rows[LF_PAPERS_SHIFT]);
    assert_ptr_equal(lf_choices_unfit(&choices, lf_integrator_at(0)), &rows[LF_PAPERS_SHIFT]);
    choices.given[LF_PAPERS_WEIGHTS] = true; /* the first, but somebody said so */
    assert_ptr_equal(lf_choices_unfit(&choices, shifting), &rows[LF_PAPERS_WEIGHTS]);
    lf_choices_fit(&choices, shifting);
    assert_null(lf_choices_unfit(&choices, shifting));
    assert_int_equal(choices.of[LF_PAPERS_SHIFT], 2);
    lf_choices_fit(&choices, reusing);
    assert_int_equal(choices.of[LF_PAPERS_SHIFT], 0);
    assert_string_equal(rows[LF_PAPERS_SELECTION].option, "selection");
    assert_string_equal(rows[LF_PAPERS_REUSE].option, "reuse");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_added_is_what_is_known_by_name),
        cmocka_unit_test(choices_are_told_apart_by_who_takes_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
