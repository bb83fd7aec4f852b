#include "render/papers/papers.h"

#include "render/papers/general.h"
#include "render/papers/restir.h"

#define CHOICE(name)                                                                               \
    .place = offsetof(lf_choices, of[LF_PAPERS_##name]),                                           \
    .has = offsetof(lf_choices, given[LF_PAPERS_##name]), .type = LF_PARAM_WORD

/* clang-format off */
static const lf_param params[] = {
    [LF_PAPERS_SHIFT] = {
     .option = "shift", .argument = "NAME", CHOICE(SHIFT), .word_at = lf_shift_name,
     .help = "integrators of 2022: how null collisions are shifted to other views",
     .about = "shifts"},
    [LF_PAPERS_SELECTION] = {
     .option = "selection", .argument = "NAME", CHOICE(SELECTION), .word_at = lf_selection_name,
     .help = "mvpt2022, amvpt2022: which views share a path; tv is biased, as printed",
     .about = "selections"},
    [LF_PAPERS_REUSE] = {
     .option = "reuse", .argument = "NAME", CHOICE(REUSE), .word_at = lf_reuse_name,
     .help = "restir, mvrestir: reservoir reuse",
     .about = "reuse of reservoirs"},
    [LF_PAPERS_WEIGHTS] = {
     .option = "weights", .argument = "NAME", CHOICE(WEIGHTS), .word_at = lf_reuse_weights_name,
     .help = "restir, mvrestir: reservoir weights",
     .about = "weights of reservoirs"},
    {0},
};
/* clang-format on */
_Static_assert(sizeof params / sizeof *params - 1 <= LF_MAX_CHOICES, "a place for each");

void lf_papers_add(void)
{
    static const lf_integrator *const all[] = {&lf_integrator_general, &lf_integrator_restir, NULL};
    lf_integrators_add(all, params);
}
