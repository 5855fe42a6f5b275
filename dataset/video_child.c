/* SPDX-License-Identifier: Apache-2.0 */
#include "video_child.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

static void close_end(int *fd)
{
    if (*fd >= 0)
        close(*fd);
    *fd = -1;
}

/* Signals that we or our caller block or ignore are the child's again. */
static int spawn_attributes(posix_spawnattr_t *attr)
{
    sigset_t none, pipe_signal;

    sigemptyset(&none);
    sigemptyset(&pipe_signal);
    sigaddset(&pipe_signal, SIGPIPE);
    return posix_spawnattr_setsigmask(attr, &none) ||
           posix_spawnattr_setsigdefault(attr, &pipe_signal) ||
           posix_spawnattr_setflags(attr, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
}

/* fds: what becomes its stdin, stdout, stderr; -1: nothing. */
static int spawn(pid_t *ret, const char *const argv[], const int fds[3])
{
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attr;
    int error;

    if (posix_spawn_file_actions_init(&actions))
        return ENOMEM;
    if (posix_spawnattr_init(&attr)) {
        posix_spawn_file_actions_destroy(&actions);
        return ENOMEM;
    }
    error = spawn_attributes(&attr);
    for (int i = 0; i < 3 && !error; i++) {
        if (fds[i] >= 0)
            error = posix_spawn_file_actions_adddup2(&actions, fds[i], i);
        else
            error = posix_spawn_file_actions_addopen(&actions, i, "/dev/null",
                                                     i == 0 ? O_RDONLY : O_WRONLY, 0);
    }
    if (!error)
        error = posix_spawnp(ret, argv[0], &actions, &attr, (char *const *)argv, environ);
    posix_spawnattr_destroy(&attr);
    posix_spawn_file_actions_destroy(&actions);
    return error;
}

int video_child_start(struct video_child *child, const char *const argv[],
                      enum video_direction direction, struct ttf_err *err)
{
    int data[2] = {-1, -1}, messages[2] = {-1, -1}, error = 0;

    *child = (struct video_child){.pid = -1, .in = -1, .out = -1, .messages = -1};
    snprintf(child->program, sizeof(child->program), "%s", argv[0]);
    /* Towards it a socket and no pipe: only a socket can be written to without SIGPIPE. */
    if (pipe2(messages, O_CLOEXEC) < 0 ||
        (direction == VIDEO_WRITE ? socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, data)
                                  : pipe2(data, O_CLOEXEC)) < 0)
        error = errno;
    if (!error) {
        int fds[3] = {-1, -1, messages[1]};

        if (direction == VIDEO_WRITE)
            fds[0] = data[0];
        else
            fds[1] = data[1];
        error = spawn(&child->pid, argv, fds);
    }
    close_end(&messages[1]);
    close_end(&data[direction == VIDEO_WRITE ? 0 : 1]);
    if (error) {
        child->pid = -1;
        close_end(&messages[0]);
        close_end(&data[direction == VIDEO_WRITE ? 1 : 0]);
        ttf_err_set(err, -error, argv[0], "cannot be started: %s", strerrordesc_np(error));
        if (error == ENOENT)
            ttf_err_hint(err, "install ffmpeg: it reads and writes video");
        return -error;
    }
    child->messages = messages[0];
    if (direction == VIDEO_WRITE) {
        child->in = data[1];
        fcntl(child->in, F_SETFL, O_NONBLOCK);
    } else {
        child->out = data[0];
    }
    return 0;
}

/* Takes what is there of its words, keeping the last of them. Blocks if nothing is. */
static void listen_once(struct video_child *child)
{
    char piece[512];
    ssize_t n = read(child->messages, piece, sizeof(piece));
    size_t room = sizeof(child->said) - 1;

    if (n < 0 && errno == EINTR)
        return;
    if (n <= 0) {
        close_end(&child->messages);
        return;
    }
    if (child->n_said + (size_t)n > room) {
        size_t drop = child->n_said + (size_t)n - room;

        memmove(child->said, child->said + drop, child->n_said - drop);
        child->n_said -= drop;
    }
    memcpy(child->said + child->n_said, piece, (size_t)n);
    child->n_said += (size_t)n;
    child->said[child->n_said] = 0;
}

/* Waits until data can move on fd, hearing its words meanwhile so that it never blocks on them. */
static int wait_for(struct video_child *child, int fd, short events)
{
    for (;;) {
        struct pollfd fds[2] = {{.fd = fd, .events = events},
                                {.fd = child->messages, .events = POLLIN}};

        if (poll(fds, 2, -1) < 0) {
            if (errno == EINTR)
                continue;
            return -errno;
        }
        if (child->messages >= 0 && fds[1].revents)
            listen_once(child);
        if (fds[0].revents)
            return 0;
    }
}

/* The last line it said: that is where programs put the reason. */
static int fail(struct video_child *child, struct ttf_err *err, const char *happened)
{
    char *end, *line;

    while (child->messages >= 0)
        listen_once(child);
    end = child->said + child->n_said;
    while (end > child->said && (end[-1] == '\n' || end[-1] == '\r' || end[-1] == ' '))
        *--end = 0;
    line = end;
    while (line > child->said && line[-1] != '\n' && line[-1] != '\r')
        line--;
    if (!*line)
        return ttf_err_set(err, -EPROTO, child->program, "%s", happened);
    return ttf_err_set(err, -EPROTO, child->program, "%s: %s", happened, line);
}

ssize_t video_child_read(struct video_child *child, void *buf, size_t n, struct ttf_err *err)
{
    size_t done = 0;

    while (done < n) {
        int code = wait_for(child, child->out, POLLIN);
        ssize_t got;

        if (code)
            return ttf_err_set(err, code, child->program, "cannot be read from");
        got = read(child->out, (char *)buf + done, n - done);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return ttf_err_set(err, -errno, child->program, "cannot be read from");
        if (got == 0)
            break;
        done += (size_t)got;
    }
    return (ssize_t)done;
}

int video_child_write(struct video_child *child, const void *data, size_t n, struct ttf_err *err)
{
    size_t done = 0;

    while (done < n) {
        int code = wait_for(child, child->in, POLLOUT);
        ssize_t put;

        if (code)
            return ttf_err_set(err, code, child->program, "cannot be written to");
        put = send(child->in, (const char *)data + done, n - done, MSG_NOSIGNAL);
        if (put < 0 && (errno == EINTR || errno == EAGAIN))
            continue;
        if (put < 0) {
            close_end(&child->in);
            return fail(child, err, "stopped while frames were coming");
        }
        done += (size_t)put;
    }
    return 0;
}

static int reap(struct video_child *child)
{
    int status = 0;

    while (waitpid(child->pid, &status, 0) < 0 && errno == EINTR)
        ;
    child->pid = -1;
    return status;
}

int video_child_finish(struct video_child *child, struct ttf_err *err)
{
    char happened[64];
    int status;

    close_end(&child->in);
    close_end(&child->out);
    while (child->messages >= 0)
        listen_once(child);
    status = reap(child);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
        return 0;
    if (WIFSIGNALED(status))
        snprintf(happened, sizeof(happened), "was ended by signal %d", WTERMSIG(status));
    else
        snprintf(happened, sizeof(happened), "failed with exit code %d", WEXITSTATUS(status));
    return fail(child, err, happened);
}

void video_child_stop(struct video_child *child)
{
    if (child->pid > 0) {
        kill(child->pid, SIGKILL);
        reap(child);
    }
    close_end(&child->in);
    close_end(&child->out);
    close_end(&child->messages);
}
