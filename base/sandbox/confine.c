/* The system calls that a reader keeps: reading and writing open files, memory, threads, and exit.
 * Calls not on the list fail with EPERM, so that libraries that look something up continue without
 * it. Calls that no reader has a use for end the process. open() of a descriptor's name works, for
 * libraries that accept only names: /proc/self/fd/4 is another descriptor of 4, which dup, on the
 * list, also gives. */
#include <errno.h>
#include <fcntl.h>
#include <linux/capability.h>
#include <linux/landlock.h>
#include <seccomp.h>
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include "base/sandbox/reader.h"

/* Sanitizers map terabytes, and look into /proc. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#else
#define SANITIZED 0
#endif

static const int allowed[] = {
    /* open files */
    SCMP_SYS(read),
    SCMP_SYS(readv),
    SCMP_SYS(pread64),
    SCMP_SYS(write),
    SCMP_SYS(writev),
    SCMP_SYS(pwrite64),
    SCMP_SYS(lseek),
    SCMP_SYS(_llseek),
    SCMP_SYS(close),
    SCMP_SYS(dup),
    SCMP_SYS(fstat),
    SCMP_SYS(fstat64),
    SCMP_SYS(sendmsg),
    SCMP_SYS(recvmsg),

    SCMP_SYS(ftruncate),
    SCMP_SYS(ftruncate64),

    /* memory */

    SCMP_SYS(munmap),
    SCMP_SYS(mremap),
    SCMP_SYS(madvise),
    SCMP_SYS(brk),

    /* threads, for TBB */
    SCMP_SYS(futex),
    SCMP_SYS(futex_time64),
    SCMP_SYS(set_robust_list),
    SCMP_SYS(rseq),
    SCMP_SYS(sched_yield),
    SCMP_SYS(sched_getaffinity),
    SCMP_SYS(gettid),
    SCMP_SYS(getpid),

    SCMP_SYS(nanosleep),
    SCMP_SYS(clock_nanosleep),
    SCMP_SYS(clock_nanosleep_time64),
    /* time, random numbers, signals, exit */
    SCMP_SYS(clock_gettime),
    SCMP_SYS(clock_gettime64),
    SCMP_SYS(gettimeofday),
    SCMP_SYS(getrandom),
    SCMP_SYS(rt_sigaction),
    SCMP_SYS(rt_sigprocmask),
    SCMP_SYS(rt_sigreturn),
    SCMP_SYS(sigreturn),
    SCMP_SYS(restart_syscall),
    SCMP_SYS(exit),
    SCMP_SYS(exit_group),
};

/* Only a compromised reader calls these. */
static const int deadly[] = {
    SCMP_SYS(execve),   SCMP_SYS(execveat),  SCMP_SYS(fork),
    SCMP_SYS(vfork),    SCMP_SYS(socket),    SCMP_SYS(connect),
    SCMP_SYS(bind),     SCMP_SYS(ptrace),    SCMP_SYS(process_vm_writev),
    SCMP_SYS(unlink),   SCMP_SYS(unlinkat),  SCMP_SYS(rename),
    SCMP_SYS(renameat), SCMP_SYS(renameat2), SCMP_SYS(kill),
};

/* Allows threads of this process, but no other process. */
static int allow_threads(scmp_filter_ctx filter)
{
    const unsigned long threads = 0x10000; /* CLONE_THREAD */
    int failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(clone), 1,
                                  SCMP_A0(SCMP_CMP_MASKED_EQ, threads, threads));
    /* clone3's flags are in memory, which a filter cannot see; glibc falls back to clone */
    if (!failed)
        failed = seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0);
    /* abort, only for this process */
    return failed ? failed
                  : seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(tgkill), 1,
                                     SCMP_A0(SCMP_CMP_EQ, (scmp_datum_t)getpid()));
}

/* Denies executable memory. */
static int allow_memory(scmp_filter_ctx filter)
{
    static const int calls[] = {SCMP_SYS(mmap), SCMP_SYS(mmap2), SCMP_SYS(mprotect)};
    int failed = 0;
    for (size_t i = 0; i < sizeof calls / sizeof *calls && !failed; i++)
        failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, calls[i], 1,
                                  SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
    return failed;
}

/* Queries about open files. fcntl: only operations that neither send a signal nor lock. newfstatat,
 * because glibc's fstat uses it: a filter cannot see that its name is empty, so sizes and times of
 * other files can be queried. */
static int allow_looks(scmp_filter_ctx filter)
{
    static const int calls[] = {SCMP_SYS(fcntl), SCMP_SYS(fcntl64)};
    static const unsigned commands[] = {F_GETFL,     F_GETFD,     F_SETFD,
                                        F_ADD_SEALS, F_GET_SEALS, F_DUPFD_CLOEXEC};
    int failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(newfstatat), 1,
                                  SCMP_A3(SCMP_CMP_EQ, AT_EMPTY_PATH));
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++)
        for (size_t k = 0; k < sizeof commands / sizeof *commands && !failed; k++)
            failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, calls[i], 1,
                                      SCMP_A1(SCMP_CMP_EQ, commands[k]));
    return failed;
}

#if defined(__x86_64__) || defined(__aarch64__)
#define TRAP_OF_FILTER 1 /* SYS_SECCOMP of the kernel's asm-generic/siginfo.h */

/* Replaces openat, whose second argument is name; runs in a signal handler. */
static long open_again(const char *name)
{
    static const char open_ones[] = "/proc/self/fd/";
    const char *digit = name + sizeof open_ones - 1;
    int fd = 0, n = 0;
    if (strncmp(name, open_ones, sizeof open_ones - 1) != 0)
        return -EPERM;
    for (; n < 6 && digit[n] >= '0' && digit[n] <= '9'; n++)
        fd = 10 * fd + (digit[n] - '0');
    const int again = n > 0 && digit[n] == '\0' ? dup(fd) : -1;
    if (again >= 0 && lseek(again, 0, SEEK_SET) == 0)
        return again;
    if (again >= 0)
        close(again);
    return -EPERM;
}

static void on_trap(int number, siginfo_t *info, void *context)
{
    ucontext_t *at = context;
    (void)number;
    if (info->si_code != TRAP_OF_FILTER || info->si_syscall != SYS_openat)
        return;
#ifdef __x86_64__
    greg_t *registers = at->uc_mcontext.gregs;
    registers[REG_RAX] = open_again((const char *)(uintptr_t)registers[REG_RSI]);
#else
    unsigned long long *registers = at->uc_mcontext.regs;
    registers[0] = (unsigned long long)open_again((const char *)(uintptr_t)registers[1]);
#endif
}

static int trap_opening(scmp_filter_ctx filter)
{
    struct sigaction action = {.sa_flags = SA_SIGINFO};
    action.sa_sigaction = on_trap;
    return sigaction(SIGSYS, &action, NULL) != 0
               ? -errno
               : seccomp_rule_add(filter, SCMP_ACT_TRAP, SCMP_SYS(openat), 0);
}
#else
static int trap_opening(scmp_filter_ctx filter)
{
    (void)filter;
    return 0;
}
#endif

static int fill_filter(scmp_filter_ctx filter)
{
    /* libraries have created threads at loading */
    int failed = seccomp_attr_set(filter, SCMP_FLTATR_CTL_TSYNC, 1);
    if (!failed)
        failed = allow_threads(filter);
    if (!failed)
        failed = allow_memory(filter);
    if (!failed)
        failed = allow_looks(filter);
    if (!failed)
        failed = trap_opening(filter);
    for (size_t i = 0; i < sizeof allowed / sizeof *allowed && !failed; i++)
        failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, allowed[i], 0);
    for (size_t i = 0; i < sizeof deadly / sizeof *deadly && !failed; i++)
        failed = seccomp_rule_add(filter, SCMP_ACT_KILL_PROCESS, deadly[i], 0);
    return failed ? failed : seccomp_load(filter);
}

static void limit(int what, uint64_t value)
{
    (void)setrlimit((__rlimit_resource_t)what, &(struct rlimit){(rlim_t)value, (rlim_t)value});
}

/* A second barrier in addition to the filter, if the kernel has Landlock (the kernel's
 * userspace-api/landlock, version 1). This thread and its children cannot open, create or execute
 * anything in the file system. */
static lf_landlock lock_files(void)
{
    const struct landlock_ruleset_attr all = {.handled_access_fs =
                                                  ((uint64_t)LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1};
    int rules = (int)syscall(SYS_landlock_create_ruleset, &all, sizeof all, 0);
    if (rules < 0)
        return errno == ENOSYS || errno == EOPNOTSUPP ? LF_LANDLOCK_OFF : LF_LANDLOCK_REFUSED;
    const bool locked = syscall(SYS_landlock_restrict_self, rules, 0) == 0;
    close(rules);
    return locked ? LF_LANDLOCK_ON : LF_LANDLOCK_REFUSED;
}

/* Root has all capabilities. The bounding set can be lowered only with CAP_SETPCAP, but without
 * capabilities and with no_new_privs it grants nothing. If a sandbox forbids capset, there need not
 * be any. */
static bool drop_capabilities(void)
{
    struct __user_cap_header_struct header = {.version = _LINUX_CAPABILITY_VERSION_3};
    struct __user_cap_data_struct sets[_LINUX_CAPABILITY_U32S_3] = {{0, 0, 0}};
    for (int i = 0; prctl(PR_CAPBSET_DROP, i, 0, 0, 0) == 0; i++) {
    }
    (void)prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0);
    if (syscall(SYS_capset, &header, sets) == 0)
        return true;
    const bool known = syscall(SYS_capget, &header, sets) == 0;
    return known && sets[0].permitted == 0 && sets[1].permitted == 0;
}

/* The memory file and other memory have separate limits, so they share the total. */
static void limit_all(uint64_t memory, unsigned seconds)
{
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_FSIZE, memory / 3);
    limit(RLIMIT_NOFILE, LF_IMPORT_MAX_FILES + 16);
    (void)setrlimit(RLIMIT_CPU, &(struct rlimit){seconds, seconds + 5});
    if (!SANITIZED)
        limit(RLIMIT_AS, memory - memory / 3);
}

lf_status lf_confine(uint64_t memory, unsigned seconds, lf_landlock *out_landlock, lf_error *err)
{
    limit_all(memory, seconds);
    if (!drop_capabilities())
        return lf_error_set(err, LF_E_IO, LF_HERE, "the file reader cannot drop its capabilities");
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
        return lf_error_set(err, LF_E_IO, LF_HERE, "no_new_privs: %s", strerror(errno));
    (void)signal(SIGXFSZ, SIG_IGN); /* a file at its limit is an error like a full disk */
    *out_landlock = LF_LANDLOCK_OFF;
    if (SANITIZED)
        return LF_OK;
    *out_landlock = lock_files();
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ERRNO(EPERM));
    int failed = filter ? fill_filter(filter) : -ENOMEM;
    if (filter)
        seccomp_release(filter);
    if (failed)
        return lf_error_set(err, LF_E_IO, LF_HERE,
                            "the file reader cannot be confined (seccomp): %s", strerror(-failed));
    return LF_OK;
}
