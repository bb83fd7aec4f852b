#include "base/wakeup.h"

#include <stdint.h>
#include <sys/eventfd.h>
#include <unistd.h>

int lf_wakeup_make(void)
{
    return eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
}

void lf_wakeup_signal(int wakeup)
{
    /* It can only fail if the counter is full, and is signalled then. */
    ssize_t n = write(wakeup, &(uint64_t){1}, sizeof(uint64_t));
    (void)n;
}

void lf_wakeup_clear(int wakeup)
{
    uint64_t pending;
    /* Clearing twice is not an error. */
    ssize_t n = read(wakeup, &pending, sizeof pending);
    (void)n;
}
