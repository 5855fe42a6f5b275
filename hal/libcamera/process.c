/* SPDX-License-Identifier: Apache-2.0 */
/* process.c: the process that has libcamera: started, asked, ended. */
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include "process.h"

#define ENDING_MS 2000 /* that a killed process may take; longer is stuck in a driver */

/* fds: as 3 and 4 of the process, which has nothing else of ours open but its standard streams. */
static int spawn(const char *host, const char *module, const int fds[2], pid_t *ret)
{
    char version[96];
    char *const argv[] = {(char *)host, (char *)module, version, NULL};
    posix_spawn_file_actions_t files;
    posix_spawnattr_t how;
    sigset_t none, all;
    int r;

    if (access(host, X_OK) != 0) /* where a child is made by fork, posix_spawn cannot say so */
        return -errno;
    lc_wire_name(version);
    (void)sigemptyset(&none);
    (void)sigfillset(&all);
    if (posix_spawn_file_actions_init(&files) != 0)
        return -ENOMEM;
    if (posix_spawnattr_init(&how) != 0) {
        (void)posix_spawn_file_actions_destroy(&files);
        return -ENOMEM;
    }
    /* A group of its own: Ctrl-C is for the program, which ends its slot. */
    (void)posix_spawnattr_setflags(&how, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF |
                                             POSIX_SPAWN_SETPGROUP);
    (void)posix_spawnattr_setsigmask(&how, &none);
    (void)posix_spawnattr_setsigdefault(&how, &all);
    r = posix_spawn_file_actions_adddup2(&files, fds[0], LC_CALLS_FD);
    r = r ? r : posix_spawn_file_actions_adddup2(&files, fds[1], LC_FRAMES_FD);
    r = r ? r : posix_spawn_file_actions_addclosefrom_np(&files, LC_FRAMES_FD + 1);
    r = r ? r : posix_spawn(ret, host, &files, &how, argv, environ);
    (void)posix_spawnattr_destroy(&how);
    (void)posix_spawn_file_actions_destroy(&files);
    return -r;
}

static void close_two(const int fds[2])
{
    for (unsigned i = 0; i < 2; i++)
        if (fds[i] >= 0)
            (void)close(fds[i]);
}

/* The same of numbers that are out of each other's way. */
static int spawn_with(const char *host, const char *module, int calls, int frames, pid_t *ret)
{
    const int far[2] = {fcntl(calls, F_DUPFD_CLOEXEC, LC_FRAMES_FD + 1),
                        fcntl(frames, F_DUPFD_CLOEXEC, LC_FRAMES_FD + 1)};
    int r = far[0] < 0 || far[1] < 0 ? -EMFILE : spawn(host, module, far, ret);

    close_two(far);
    return r;
}

/* An answer, in time: 0; or it is dead. */
static int hear(struct lc_process *p, struct lc_answer *ret, int *ret_fd)
{
    union {
        struct cmsghdr head;
        char room[CMSG_SPACE(sizeof(int))];
    } control = {0};
    struct iovec words = {.iov_base = ret, .iov_len = sizeof(*ret)};
    struct msghdr message = {.msg_iov = &words,
                             .msg_iovlen = 1,
                             .msg_control = control.room,
                             .msg_controllen = sizeof(control.room)};
    int fd = -1;
    ssize_t n;

    do {
        n = recvmsg(p->calls, &message, MSG_CMSG_CLOEXEC);
    } while (n < 0 && errno == EINTR);
    if (n > 0 && message.msg_controllen >= CMSG_LEN(sizeof(int)) &&
        control.head.cmsg_type == SCM_RIGHTS)
        memcpy(&fd, CMSG_DATA(&control.head), sizeof(fd));
    if (ret_fd)
        *ret_fd = fd;
    else if (fd >= 0)
        (void)close(fd);
    if (n == (ssize_t)sizeof(*ret))
        return 0;
    /* Its frames end with it: whoever waits for one hears that. */
    atomic_store(&p->dead, true);
    (void)kill(p->pid, SIGKILL);
    return -ENODEV;
}

static int set_patience(int fd, int ms)
{
    const struct timeval patience = {.tv_sec = ms / 1000,
                                     .tv_usec = (suseconds_t)(ms % 1000) * 1000};

    return setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience)) < 0 ? -errno : 0;
}

int lc_process_start(struct lc_process *p, const char *host, const char *module, int hello_ms,
                     int call_ms, struct lc_answer *ret_hello)
{
    int calls[2], frames[2], r;

    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, calls) < 0)
        return -errno;
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, frames) < 0) {
        r = -errno;
        close_two(calls);
        return r;
    }
    r = set_patience(calls[0], hello_ms);
    if (r == 0)
        r = spawn_with(host, module, calls[1], frames[1], &p->pid);
    if (r < 0) {
        p->pid = 0;
        close_two(calls);
        close_two(frames);
        return r;
    }
    (void)close(calls[1]);
    (void)close(frames[1]);
    p->calls = calls[0];
    p->frames = frames[0];
    atomic_store(&p->dead, false);
    r = hear(p, ret_hello, NULL);
    if (r == 0)
        r = set_patience(p->calls, call_ms);
    if (r < 0)
        lc_process_end(p);
    return r;
}

void lc_process_end(struct lc_process *p)
{
    struct pollfd ended = {.fd = p->calls, .events = POLLIN};
    char rest[sizeof(struct lc_answer)];
    bool gone;
    int n;

    if (p->pid <= 0)
        return;
    (void)kill(p->pid, SIGKILL);
    /* One that is stuck in a driver is left to the kernel: it may not take the capture with it. */
    do {
        n = poll(&ended, 1, ENDING_MS);
        gone = n > 0 && recv(p->calls, rest, sizeof(rest), MSG_DONTWAIT) <= 0;
    } while (!gone && (n > 0 || (n < 0 && errno == EINTR)));
    while (gone && waitpid(p->pid, NULL, 0) < 0 && errno == EINTR)
        continue;
    (void)close(p->calls);
    (void)close(p->frames);
    p->pid = 0;
    atomic_store(&p->dead, false);
}

int lc_process_call(struct lc_process *p, const struct lc_call *call, struct lc_answer *ret,
                    int *ret_fd)
{
    int r = -ENODEV;

    if (ret_fd)
        *ret_fd = -1;
    pthread_mutex_lock(&p->lock);
    if (p->pid > 0 && !atomic_load(&p->dead)) {
        /* One that has ended cannot be written to; that it has is heard next. */
        (void)!send(p->calls, call, sizeof(*call), MSG_NOSIGNAL);
        r = hear(p, ret, ret_fd);
    }
    pthread_mutex_unlock(&p->lock);
    return r < 0 ? r : ret->r;
}
