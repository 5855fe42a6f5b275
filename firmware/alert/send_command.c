/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "alert.h"

#define LOOK_NS (20 * TTF_NS_PER_MS)

/* In a group of its own, so that what it starts ends with it; its output goes nowhere. */
static int start(const char *const argv[], int input, pid_t *ret)
{
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    sigset_t defaults;
    int r;

    (void)sigemptyset(&defaults);
    (void)sigaddset(&defaults, SIGPIPE);
    if (posix_spawn_file_actions_init(&files) != 0)
        return -ENOMEM;
    if (posix_spawnattr_init(&attributes) != 0) {
        (void)posix_spawn_file_actions_destroy(&files);
        return -ENOMEM;
    }
    r = posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
    if (r == 0)
        r = posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    if (r == 0)
        r = posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    if (r == 0)
        r = posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    if (r == 0)
        r = posix_spawnattr_setsigdefault(&attributes, &defaults);
    if (r == 0)
        r = posix_spawnp(ret, argv[0], &files, &attributes, (char *const *)argv, environ);
    (void)posix_spawnattr_destroy(&attributes);
    (void)posix_spawn_file_actions_destroy(&files);
    return -r;
}

static int wait_for(pid_t child, int64_t timeout_ns, struct ttf_clock *clock,
                    const volatile int *stop, struct ttf_err *err)
{
    int64_t until_ns = ttf_clock_now_ns(clock) + timeout_ns;
    int status = 0;
    pid_t got;

    while ((got = waitpid(child, &status, WNOHANG)) == 0 && !*stop &&
           ttf_clock_now_ns(clock) < until_ns)
        (void)ttf_clock_wait_until(clock, ttf_clock_now_ns(clock) + LOOK_NS);
    (void)kill(-child, SIGKILL); /* also what it left behind */
    if (got == 0) {
        (void)waitpid(child, &status, 0);
        return ttf_err_set(err, -ETIME, NULL, "the program took too long");
    }
    if (got == child && WIFEXITED(status) && WEXITSTATUS(status) == 0)
        return 0;
    return ttf_err_set(err, -EIO, NULL, "the program ended with %d",
                       WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status));
}

int send_command(const char *const argv[], const char *input, int64_t timeout_ns,
                 struct ttf_clock *clock, const volatile int *stop, struct ttf_err *err)
{
    size_t n = strlen(input);
    int ends[2], r;
    pid_t child = 0;

    if (pipe2(ends, O_CLOEXEC) < 0)
        return ttf_err_set(err, -errno, NULL, "no pipe to the program");
    r = start(argv, ends[0], &child);
    (void)close(ends[0]);
    if (r < 0) {
        (void)close(ends[1]);
        return ttf_err_set(err, r, NULL, "the program cannot be started: %s", strerrordesc_np(-r));
    }
    /* Fits into the pipe whole: this does not wait for whoever reads, or does not. */
    (void)!write(ends[1], input, n);
    (void)close(ends[1]);
    return wait_for(child, timeout_ns, clock, stop, err);
}
