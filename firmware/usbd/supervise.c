/* SPDX-License-Identifier: Apache-2.0 */
#include "supervise.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "ttf/base/time.h"

#define AGAIN_NS (100 * TTF_NS_PER_MS)
#define MOST_NS  (10 * TTF_NS_PER_S) /* between tries of what gives up at once, each time */
#define LOOK_NS  (100 * TTF_NS_PER_MS)
#define END_NS   (3 * TTF_NS_PER_S) /* then it is killed */

static pid_t begin(const char *const *argv, int fd)
{
    pid_t parent = getpid(), child = fork();

    if (child != 0)
        return child;
    /* It must not outlive us: another one would be started beside it. */
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() == parent && fcntl(fd, F_SETFD, 0) == 0)
        (void)execv(argv[0], (char *const *)argv);
    _exit(127);
}

/* Waits for the child, for a while or until it is told to stop. True: it has ended. */
static bool ended(pid_t child, int *ret_status, struct ttf_clock *clock)
{
    pid_t r = waitpid(child, ret_status, WNOHANG);

    if (r == child || (r < 0 && errno == ECHILD))
        return true;
    (void)ttf_clock_wait_until(clock, ttf_clock_now_ns(clock) + LOOK_NS);
    return false;
}

static void end(pid_t child, struct ttf_clock *clock)
{
    int64_t until = ttf_clock_now_ns(clock) + END_NS;
    int status;

    (void)kill(child, SIGTERM);
    while (!ended(child, &status, clock)) {
        if (ttf_clock_now_ns(clock) >= until)
            (void)kill(child, SIGKILL);
    }
}

/* How long to wait before the next. One that was killed is needed at once; one that finds that it cannot work will find that again. */
static int64_t pause_after(int status, int64_t lived_ns, int64_t before_ns)
{
    if (WIFSIGNALED(status) || lived_ns > MOST_NS || before_ns == 0)
        return AGAIN_NS;
    return 2 * before_ns < MOST_NS ? 2 * before_ns : MOST_NS;
}

int supervise(const char *const *argv, int fd, struct ttf_clock *clock,
              const volatile sig_atomic_t *stop)
{
    int64_t pause_ns = 0;

    while (!*stop) {
        int64_t begun_ns = ttf_clock_now_ns(clock), until_ns;
        pid_t child = begin(argv, fd);
        bool over = child < 0;
        int status = 0;

        while (!*stop && !over)
            over = ended(child, &status, clock);
        if (!over) {
            end(child, clock);
        } else if (!*stop) {
            if (child > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 2)
                return 2;
            fprintf(stderr, "ttfbox-usbd: ended by %s %d: started again\n",
                    WIFSIGNALED(status) ? "signal" : "exit",
                    WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status));
            pause_ns = pause_after(status, ttf_clock_now_ns(clock) - begun_ns, pause_ns);
            until_ns = ttf_clock_now_ns(clock) + pause_ns;
            while (!*stop && ttf_clock_now_ns(clock) < until_ns)
                (void)ttf_clock_wait_until(clock, ttf_clock_now_ns(clock) + LOOK_NS);
        }
    }
    return 0;
}
