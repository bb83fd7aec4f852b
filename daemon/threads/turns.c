#include "daemon/threads/turns.h"

#include <math.h>
#include <stdint.h>
#include <time.h>

static double cpu_seconds(void)
{
    struct timespec now = {0};
    (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

int lf_turns_run(sd_event *event, double *longest)
{
    while (sd_event_get_state(event) != SD_EVENT_FINISHED) {
        double before = cpu_seconds();
        int r = sd_event_run(event, UINT64_MAX);
        if (r < 0)
            return r;
        *longest = fmax(*longest, cpu_seconds() - before);
    }
    int code = 0;
    int r = sd_event_get_exit_code(event, &code);
    return r < 0 ? r : code;
}
