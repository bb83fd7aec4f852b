/* Limits of reading. */
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/number.h"
#include "base/sandbox/import.h"

static struct {
    _Atomic uint64_t memory;
    _Atomic unsigned seconds;
} limits = {.seconds = LF_IMPORT_SECONDS};

void lf_import_limit(uint64_t memory, int seconds)
{
    atomic_store(&limits.memory, memory);
    atomic_store(&limits.seconds, (unsigned)seconds);
}

/* memory.max of a control group: bytes, or "max". */
static uint64_t group_memory(const char *group)
{
    char path[PATH_MAX + 64], text[32] = "";
    snprintf(path, sizeof path, "/sys/fs/cgroup%s/memory.max", group);
    FILE *file = fopen(path, "re");
    if (!file)
        return UINT64_MAX;
    bool read = fgets(text, sizeof text, file);
    fclose(file);
    uint64_t bytes = UINT64_MAX;
    return read && lf_whole_read(text, &bytes) ? bytes : UINT64_MAX;
}

/* The limit of the process's group in the unified hierarchy, "0::/a/b" in /proc/self/cgroup, and of
 * its parents (the kernel's admin-guide/cgroup-v2). */
static uint64_t groups_memory(void)
{
    char line[PATH_MAX] = "", *group = line + strlen("0::");
    uint64_t least = UINT64_MAX;
    FILE *file = fopen("/proc/self/cgroup", "re");
    while (file && fgets(line, sizeof line, file) && strncmp(line, "0::/", 4) != 0)
        line[0] = '\0';
    if (file)
        fclose(file);
    if (strncmp(line, "0::/", 4) != 0)
        return least;
    line[strcspn(line, "\n")] = '\0';
    for (char *end = group + strlen(group); end; end = strrchr(group, '/')) {
        *end = '\0'; /* finally "": a container's own root has a limit, the machine's has none */
        uint64_t memory = group_memory(group);
        least = memory < least ? memory : least;
    }
    return least;
}

uint64_t lf_import_memory(void)
{
    uint64_t memory = atomic_load(&limits.memory);
    if (memory == 0) {
        uint64_t machine = (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE),
                 groups = groups_memory();
        memory = (groups < machine ? groups : machine) / 2;
    }
    return memory > LF_IMPORT_LEAST_MEMORY ? memory : LF_IMPORT_LEAST_MEMORY;
}

unsigned lf_import_seconds(void)
{
    return atomic_load(&limits.seconds);
}
