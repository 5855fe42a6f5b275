/* SPDX-License-Identifier: Apache-2.0 */
/*
 * freeze PID: a deadlock of a program's loop, made from outside. Its first thread, and no other, is stopped where it is
 * about to wait on the boot clock, which the loop does right after it has declared its next sign of life. Prints
 * "frozen NOW UNTIL", boot clock in ns: UNTIL is when the loop meant to be back. Holds it as long as the process lives.
 */
#include <errno.h>
#include <inttypes.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <linux/ptrace.h>

/* The declared instant, if the thread stands before a wait for one; else 0. */
static int64_t waits_until(pid_t pid)
{
    struct ptrace_syscall_info info = {0};
    struct timespec at;
    void *size = (void *)sizeof info; /* NOLINT(performance-no-int-to-ptr): ptrace's own way */
    long words[2];

    if (ptrace(PTRACE_GET_SYSCALL_INFO, pid, size, &info) <= 0 ||
        info.op != PTRACE_SYSCALL_INFO_ENTRY || info.entry.nr != SYS_clock_nanosleep ||
        info.entry.args[0] != CLOCK_BOOTTIME || info.entry.args[1] != TIMER_ABSTIME)
        return 0;
    for (unsigned i = 0; i < 2; i++) {
        uintptr_t from = (uintptr_t)info.entry.args[2] + i * sizeof(long);

        errno = 0;
        words[i] = ptrace(PTRACE_PEEKDATA, pid, (void *)from, NULL); /* NOLINT */
        if (errno)
            return 0;
    }
    at = (struct timespec){.tv_sec = words[0], .tv_nsec = words[1]};
    return (int64_t)at.tv_sec * 1000000000 + at.tv_nsec;
}

/* From stop to stop until it is about to wait; that instant, or -1. */
static int64_t follow(pid_t pid)
{
    int status;

    if (ptrace(PTRACE_SEIZE, pid, NULL, (void *)PTRACE_O_TRACESYSGOOD) < 0 || /* NOLINT */
        ptrace(PTRACE_INTERRUPT, pid, NULL, NULL) < 0)
        return -1;
    while (waitpid(pid, &status, __WALL) == pid && WIFSTOPPED(status)) {
        int64_t until = waits_until(pid);
        /* A signal is handed on; a stop of ours is not. */
        bool ours = WSTOPSIG(status) == (SIGTRAP | 0x80) || status >> 16 != 0;

        if (until > 0)
            return until;
        if (ptrace(PTRACE_SYSCALL, pid, NULL, ours ? 0L : (long)WSTOPSIG(status)) < 0)
            break;
    }
    return -1;
}

int main(int argc, char **argv)
{
    pid_t pid = argc == 2 ? (pid_t)strtol(argv[1], NULL, 10) : 0;
    struct timespec now;
    int64_t until;
    int status;

    if (pid <= 0) {
        fputs("Usage: freeze PID\n", stderr);
        return 2;
    }
    until = follow(pid);
    if (until < 0) {
        perror("freeze");
        return 1;
    }
    (void)clock_gettime(CLOCK_BOOTTIME, &now);
    printf("frozen %" PRId64 " %" PRId64 "\n", (int64_t)now.tv_sec * 1000000000 + now.tv_nsec,
           until);
    (void)fflush(stdout);
    /* What comes of it is for others to see: a killed process is gone without asking us. */
    while (waitpid(pid, &status, __WALL) == pid && WIFSTOPPED(status))
        ;
    return 0;
}
