#include "base/bell.h"

#include <stdint.h>
#include <sys/eventfd.h>
#include <unistd.h>

int lf_bell_make(void)
{
    return eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
}

void lf_bell_ring(int bell)
{
    /* It can only fail by being full, and rings then. */
    ssize_t n = write(bell, &(uint64_t){1}, sizeof(uint64_t));
    (void)n;
}

void lf_bell_silence(int bell)
{
    uint64_t rings;
    /* Not having rung is no error. */
    ssize_t n = read(bell, &rings, sizeof rings);
    (void)n;
}
