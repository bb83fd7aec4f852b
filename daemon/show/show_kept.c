/* Which of the shown frames are in the files of a device that writes them. */
#include "daemon/show/show_internal.h"

#include <string.h>

static bool has_files(const lf_show *show)
{
    return show->device && show->device->ops->kept;
}

void lf_show_forget_kept(lf_show *show)
{
    show->kept = (lf_kept){.awaited = show->kept.awaited};
}

void lf_show_count_push(lf_show *show)
{
    lf_kept *kept = &show->kept;
    const lf_shown *frame = &show->push.frame;
    kept->pushes++;
    if (!has_files(show) || show->push.lacks_views)
        return;
    const lf_kept_push *last = kept->n > 0 ? &kept->pending[kept->n - 1] : &kept->held;
    if (last->number > 0 && last->generation == frame->generation && last->level == frame->level)
        return;
    const int at = kept->n < LF_KEPT_PENDING ? kept->n++ : LF_KEPT_PENDING - 1;
    kept->pending[at] = (lf_kept_push){kept->pushes, frame->generation, frame->level};
}

/* The number of pending pushes that the device has completely written. *out_status: of `kept`. */
static int count_written(lf_show *show, lf_status *out_status)
{
    lf_kept *kept = &show->kept;
    uint64_t written = 0;
    int n = 0;
    *out_status = LF_OK;
    if (!has_files(show))
        return 0;
    *out_status = show->device->ops->kept(show->device, kept->awaited && kept->n > 0, &written);
    kept->lost = kept->lost || *out_status == LF_E_NODEV;
    while (n < kept->n && kept->pending[n].number <= written)
        n++;
    return n;
}

void lf_show_look_at_files(lf_show *show)
{
    lf_kept *kept = &show->kept;
    lf_status status;
    lf_device_info info;
    lf_error err;
    const int n = count_written(show, &status);
    const bool failed = status == LF_E_IO && kept->awaited && kept->n > 0;
    if (failed && lf_show_info(show, &info))
        (void)lf_error_set(&err, status, info.spec, "%s", info.problem);
    if (n > 0)
        kept->held = kept->pending[n - 1];
    kept->n -= n;
    memmove(kept->pending, kept->pending + n, (size_t)kept->n * sizeof *kept->pending);
    if (failed || (n > 0 && kept->n == 0))
        kept->awaited = false;
    if (failed || n > 0)
        show->events.kept(show->context, failed ? &err : NULL);
}

void lf_show_await_files(lf_show *show)
{
    show->kept.awaited = true;
    lf_show_look_at_files(show);
}

bool lf_show_keeps(lf_show *show, int64_t generation, lf_level level)
{
    lf_status status;
    const int n = count_written(show, &status);
    const lf_kept_push *held = n > 0 ? &show->kept.pending[n - 1] : &show->kept.held;
    if (show->kept.lost)
        return false;
    return !has_files(show) ||
           (held->number > 0 && held->generation >= generation && held->level >= level);
}
