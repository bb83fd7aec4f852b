#include "daemon/tools/plan_process.h"

#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/resource.h>
#include <unistd.h>

#include "base/number.h"
#include "base/thread.h"

double lf_process_cpu(void)
{
    struct rusage children;
    getrusage(RUSAGE_CHILDREN, &children);
    return lf_time_cpu() + (double)children.ru_utime.tv_sec + (double)children.ru_stime.tv_sec +
           1e-6 * (double)(children.ru_utime.tv_usec + children.ru_stime.tv_usec);
}

double lf_process_memory(void)
{
    char text[128] = "";
    uint64_t pages = 0;
    FILE *f = fopen("/proc/self/statm", "re");
    const char *after = f && fgets(text, sizeof text, f) ? lf_whole_read(text, &pages) : NULL;
    if (after) /* the second number */
        (void)lf_whole_read(after + 1, &pages);
    if (f)
        fclose(f);
    return (double)pages * (double)sysconf(_SC_PAGESIZE);
}

double lf_process_peak(void)
{
    struct rusage self;
    getrusage(RUSAGE_SELF, &self);
    return 1024.0 * (double)self.ru_maxrss;
}

double lf_process_child_peak(void)
{
    struct rusage children;
    getrusage(RUSAGE_CHILDREN, &children);
    return 1024.0 * (double)children.ru_maxrss;
}

void lf_process_forget_peak(void)
{
    const int fd = open("/proc/self/clear_refs", O_WRONLY | O_CLOEXEC);
    if (fd < 0)
        return;
    (void)!write(fd, "5", 1);
    close(fd);
}
