/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/statvfs.h>
#include <sys/wait.h>
#include <unistd.h>

#include "preview.h"

#define LOOK_NS (100 * TTF_NS_PER_MS)
#define GRACE \
    4 /* times what it was given: its estimates are for a machine that has nothing else to do */

struct words {
    char memory[32], time[32], factors[4300], output[4300], said[4300];
};

/* In the child: never comes back. */
static void become(const struct preview_options *options, const struct preview_subject *subject,
                   const struct words *w, pid_t parent)
{
    const char *const argv[] = {options->ttfbox,
                                "synth",
                                "quilt",
                                subject->path,
                                "--preview",
                                "--memory",
                                w->memory,
                                "--time",
                                w->time,
                                "--factors",
                                w->factors,
                                "--threads",
                                "1",
                                "--seed",
                                "1",
                                "--sink",
                                "raw",
                                "-o",
                                w->output,
                                "--json",
                                "-q",
                                NULL};
    char *mutable[sizeof argv / sizeof *argv]; /* as exec wants them; it changes none */
    int out = open(w->said, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    int none = open("/dev/null", O_RDWR | O_CLOEXEC);

    memcpy(mutable, argv, sizeof mutable);
    /* Not to go on when nobody waits for it any more. */
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() == parent && out >= 0 && none >= 0 && dup2(out, STDOUT_FILENO) >= 0 &&
        dup2(none, STDERR_FILENO) >= 0 && dup2(none, STDIN_FILENO) >= 0)
        (void)execvp(options->ttfbox, mutable);
    _exit(127);
}

static int end_of(int status, struct ttf_err *err)
{
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
        return 0;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
        return ttf_err_set(err, -EIO, NULL, "the program ttfbox cannot be started");
    if (WIFEXITED(status))
        return ttf_err_set(err, -EIO, NULL, "the synthesis ended with %d", WEXITSTATUS(status));
    return ttf_err_set(err, -EIO, NULL, "the synthesis was ended by signal %d (%s)",
                       WTERMSIG(status), WTERMSIG(status) == SIGXFSZ ? "too large" : "killed");
}

bool preview_has_room(const struct preview_options *options, int64_t bytes)
{
    struct statvfs v;

    return statvfs(options->folder, &v) == 0 && (int64_t)v.f_bavail * (int64_t)v.f_frsize >= bytes;
}

static int wait_for(const struct preview_options *options, struct ttf_clock *clock, pid_t child,
                    struct ttf_err *err)
{
    int64_t until_ns = ttf_clock_now_ns(clock) + GRACE * options->time_ns + TTF_NS_PER_MIN;
    bool room = true;
    int status = 0;

    for (;;) {
        int64_t now_ns = ttf_clock_now_ns(clock);
        pid_t got = waitpid(child, &status, WNOHANG);

        if (got == child)
            return end_of(status, err);
        if (got < 0 && errno != EINTR)
            return ttf_err_set(err, -errno, NULL, "the synthesis is lost");
        /* Others write, too: what is left is the capture's. */
        room = preview_has_room(options, options->room_bytes / 2);
        if (*options->stop || now_ns > until_ns || !room)
            break;
        (void)ttf_clock_wait_until(clock, now_ns + LOOK_NS);
    }
    (void)kill(child, SIGKILL);
    while (waitpid(child, &status, 0) < 0 && errno == EINTR)
        ;
    if (*options->stop)
        return -ECANCELED;
    return room ? ttf_err_set(err, -ETIME, NULL, "the synthesis took too long")
                : ttf_err_set(err, -ENOSPC, NULL, "room became short while it was made");
}

static int run_once(const struct preview_options *options, struct ttf_clock *clock,
                    const struct preview_subject *subject, const struct words *w,
                    struct ttf_err *err)
{
    pid_t parent = getpid(), child = fork();

    if (child == 0)
        become(options, subject, w, parent);
    if (child < 0)
        return ttf_err_set(err, -errno, NULL, "no process for the synthesis");
    return wait_for(options, clock, child, err);
}

int preview_synthesize(const struct preview_options *options, struct ttf_clock *clock,
                       const struct preview_subject *subject, const struct preview_cache *cache,
                       struct ttf_err *err)
{
    struct words w;
    int r;

    (void)snprintf(w.memory, sizeof w.memory, "%" PRId64 "MiB", options->memory_bytes >> 20);
    (void)snprintf(w.time, sizeof w.time, "%" PRId64 "ms", options->time_ns / TTF_NS_PER_MS);
    (void)snprintf(w.factors, sizeof w.factors, "%s/factors", cache->path);
    (void)snprintf(w.output, sizeof w.output, "%s/making/frames.rgb", cache->path);
    (void)snprintf(w.said, sizeof w.said, "%s/making/said.json", cache->path);
    r = run_once(options, clock, subject, &w, err);
    /* Factors of an input that was reduced otherwise are of no use: without them it starts afresh. */
    if (r == -EIO && access(w.factors, F_OK) == 0) {
        (void)unlink(w.factors);
        (void)unlink(w.output);
        memset(err, 0, sizeof *err);
        r = run_once(options, clock, subject, &w, err);
    }
    return r;
}
