/* What a proof says in words and numbers. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/log.h"
#include "daemon/tools/simulate_job.h"

json_t *lf_simulate_settings(const lf_simulate_job *j)
{
    const lf_proof_sheet *s = &j->sheet;
    const char *slash = strrchr(j->in, '/');
    return json_pack("{s:s, s:[f,f,f], s:f, s:f, s:f, s:f}", "print", slash ? slash + 1 : j->in,
                     "eye_mm", j->eye.x_mm, j->eye.y_mm, j->eye.distance_mm, "mechanical_lpi",
                     25.4 / s->pitch_mm, "thickness_mm", s->thickness_mm, "index", s->index,
                     "spot_mm", s->spot_mm);
}

static const char *const edges[] = {"left", "right", "top", "bottom"};

static double ghost_of(const json_t *compensation, const char *key)
{
    return json_number_value(json_object_get(json_object_get(compensation, key), "mean"));
}

/* What is true of the whole print, in words. */
void lf_simulate_tell(const lf_simulate_job *j)
{
    const double step = lf_proof_view_step(&j->sheet, j->eye.distance_mm);
    const double range = lf_proof_view_range(&j->sheet, j->eye.distance_mm);
    const lf_own_view own = lf_proof_own_view(&j->printed, &j->sheet);
    const double drift = lf_proof_drift(&j->printed, &j->sheet, j->eye.distance_mm);
    lf_log(LF_LOG_INFO,
           "from %.0f mm: a view is %.3g mm wide; the views jump %.3g mm %s the middle",
           j->eye.distance_mm, step, 0.5 * range,
           j->sheet.horizontal ? "above and below" : "left and right of");
    lf_log(LF_LOG_INFO, "an eye gets %.0f %% of its light from its own view (worst lens %.0f %%)",
           100.0 * own.mean, 100.0 * own.worst);
    const json_t *made = json_object_get(j->manifest, "compensation");
    if (made)
        lf_log(LF_LOG_INFO,
               "compensated: by its manifest, ghosts are %.2g %% of white, and %.2g %% without it",
               100.0 * ghost_of(made, "ghost_left"), 100.0 * ghost_of(made, "ghost_before"));
    if (drift > 0.5 / j->sheet.n_views)
        lf_log(LF_LOG_WARNING,
               "the pitch of the print is not the sheet's: the views shift by %.2g of their range "
               "over the print",
               drift);
}

static void tell_depth(const lf_simulate_job *j, const lf_proof_depth *d)
{
    if (d->measured < LF_PROOF_FLIP) {
        lf_log(LF_LOG_INFO, "the views show different images (a flip); they have no parallax");
        return;
    }
    if (d->over > 0.0)
        lf_log(LF_LOG_WARNING,
               "%s: %.0f %% of what has structure shifts by more than 1 lens from view to view (%s "
               "%.1f); "
               "it looks doubled",
               j->in, fmax(1.0, 100.0 * d->over),
               d->most > LF_PROOF_SEARCH - 1.5 ? "at least" : "up to", d->most);
    else
        lf_log(LF_LOG_INFO, "points shift by up to %.1f lenses from view to view (limit 1)",
               d->most);
    for (int i = 0; i < 4; i++)
        if (d->cut[i])
            lf_log(LF_LOG_WARNING, "%s: something in front of the print touches its %s edge", j->in,
                   edges[i]);
}

lf_status lf_simulate_study(lf_simulate_job *j, lf_proof_depth *out, lf_error *err)
{
    const lf_status status =
        lf_proof_depth_of(j->file, &j->sheet, j->eye.distance_mm, j->cancel, out, err);
    if (status == LF_OK)
        tell_depth(j, out);
    return status;
}

static json_t *cut_edges(const lf_proof_depth *d)
{
    json_t *list = json_array();
    for (int i = 0; i < 4; i++)
        if (d->cut[i] && d->measured >= LF_PROOF_FLIP)
            json_array_append_new(list, json_string(edges[i]));
    return list;
}

static json_t *report_of(const lf_simulate_job *j, const lf_proof_depth *d)
{
    const double distance = j->eye.distance_mm, range = lf_proof_view_range(&j->sheet, distance);
    const lf_own_view own = lf_proof_own_view(&j->printed, &j->sheet);
    const bool flips = d->measured < LF_PROOF_FLIP;
    json_t *assumed = json_array();
    char line[512];
    for (size_t at = 0; lf_image_notes_next(&j->notes, &at, line, sizeof line);)
        json_array_append_new(assumed, json_string(line));
    return json_pack(
        "{s:i, s:o, s:{s:f, s:f, s:[f,f], s:i}, s:{s:f, s:f, s:f}, s:f, s:o, s:o, s:o}",
        "quiltd_proof", 1, "seen", lf_simulate_settings(j), "views", "range_mm", range, "step_mm",
        lf_proof_view_step(&j->sheet, distance), "jumps_mm", -0.5 * range, 0.5 * range, "count",
        j->sheet.n_views, "own_view", "mean", own.mean, "worst", own.worst, "beside", own.beside,
        "drift", lf_proof_drift(&j->printed, &j->sheet, distance), "parallax",
        flips ? json_null()
              : json_pack("{s:f, s:f, s:f}", "most_lenses", d->most, "over_1_lens", d->over,
                          "measured", d->measured),
        "cut_edges", cut_edges(d), "assumed", assumed);
}

lf_status lf_simulate_report(lf_simulate_job *j, lf_error *err)
{
    lf_proof_depth depth;
    lf_status status = lf_simulate_study(j, &depth, err);
    if (status != LF_OK)
        return status;
    json_t *report = report_of(j, &depth);
    char *text = report ? json_dumps(report, JSON_INDENT(2) | JSON_REAL_PRECISION(6)) : NULL;
    status = text ? lf_outfile_text(j->out, text, err)
                  : lf_error_set(err, LF_E_NOMEM, j->out, "out of memory");
    free(text);
    json_decref(report);
    lf_proof_depth_finish(&depth);
    if (status == LF_OK)
        lf_log(LF_LOG_INFO, "wrote %s", j->out);
    return status;
}
