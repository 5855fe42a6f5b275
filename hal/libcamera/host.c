/* SPDX-License-Identifier: Apache-2.0 */
/*
 * host.c: ttfbox-libcamera-host MODULE VERSION, the process that has libcamera: answers calls (wire.h) by the module's table until whoever
 * called is gone. Its own process, because libcamera ends it where it does not know better (README.md, A process of its own).
 */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "wire.h"

struct host {
    const struct lc_ops *ops;
    struct lc_handle *handle;
    bool gone; /* told so */
};

/* fd: one that goes with it, or -1. */
static void answer(const struct lc_answer *a, int fd)
{
    union {
        struct cmsghdr head;
        char room[CMSG_SPACE(sizeof(int))];
    } control = {0};
    struct iovec words = {.iov_base = (void *)a, .iov_len = sizeof(*a)};
    struct msghdr message = {.msg_iov = &words, .msg_iovlen = 1};

    if (fd >= 0) {
        message.msg_control = control.room;
        message.msg_controllen = sizeof(control.room);
        control.head = (struct cmsghdr){
            .cmsg_len = CMSG_LEN(sizeof(int)), .cmsg_level = SOL_SOCKET, .cmsg_type = SCM_RIGHTS};
        memcpy(CMSG_DATA(&control.head), &fd, sizeof(fd));
    }
    /* Nobody there any more: the next read says so. */
    (void)!sendmsg(LC_CALLS_FD, &message, MSG_NOSIGNAL);
}

static int hold(struct host *host, const char *id)
{
    if (host->handle)
        return -EBUSY;
    host->gone = false;
    return host->ops->hold(NULL, id, &host->handle);
}

static int let_go(struct host *host)
{
    host->ops->let_go(host->handle);
    host->handle = NULL;
    return 0;
}

static int buffer(struct host *host, unsigned i, struct lc_answer *ret, int *ret_fd)
{
    const void *at;
    size_t length = 0;
    int r = host->ops->buffer(host->handle, i, &at, &length);

    if (r == 0)
        r = *ret_fd = host->ops->shared(host->handle, i);
    ret->length = length;
    return r < 0 ? r : 0;
}

/* What needs a camera. */
static int serve_camera(struct host *host, const struct lc_call *c, struct lc_answer *ret,
                        int *ret_fd)
{
    const struct lc_ops *ops = host->ops;

    if (!host->handle)
        return -ENODEV;
    switch (c->word) {
    case LC_SAY_LET_GO:
        return let_go(host);
    case LC_SAY_OFFER:
        return ops->offer(host->handle, c->role, c->number, &ret->with.offer);
    case LC_SAY_CONFIGURE:
        return ops->configure(host->handle, &c->with.ask, &ret->with.granted);
    case LC_SAY_LIMITS:
        return ops->limits(host->handle, &ret->with.limits);
    case LC_SAY_ALLOCATE:
        return ops->allocate(host->handle, c->number, &ret->n);
    case LC_SAY_BUFFER:
        return buffer(host, c->number, ret, ret_fd);
    case LC_SAY_START:
        return ops->start(host->handle, &c->with.settings);
    case LC_SAY_STOP:
        return ops->stop(host->handle);
    case LC_SAY_QUEUE:
        return ops->queue(host->handle, c->number, &c->with.settings);
    default:
        return -ENOSYS;
    }
}

static int serve(struct host *host, const struct lc_call *c, struct lc_answer *ret, int *ret_fd)
{
    switch (c->word) {
    case LC_SAY_BEGIN:
        return host->ops->begin(NULL);
    case LC_SAY_COMPLAINT:
        host->ops->complaint(NULL, ret->with.text, sizeof(ret->with.text));
        return 0;
    case LC_SAY_LIST:
        return host->ops->list(NULL, c->number, &ret->with.identity);
    case LC_SAY_HOLD:
        return hold(host, c->with.id);
    default:
        return serve_camera(host, c, ret, ret_fd);
    }
}

/* Frames that came back, to whoever waits for them. */
static void pass_frames(struct host *host)
{
    struct lc_frame frame = {0};

    while ((frame.r = host->ops->take(host->handle, &frame.done)) == 0)
        (void)!send(LC_FRAMES_FD, &frame, sizeof(frame), MSG_NOSIGNAL);
    if (frame.r == -EAGAIN)
        return;
    host->gone = true;
    (void)!send(LC_FRAMES_FD, &frame, sizeof(frame), MSG_NOSIGNAL);
}

/* Until whoever called is gone. */
static void run(struct host *host)
{
    for (;;) {
        bool listens = host->handle && !host->gone;
        struct pollfd fds[] = {
            {.fd = LC_CALLS_FD, .events = POLLIN},
            {.fd = listens ? host->ops->descriptor(host->handle) : -1, .events = POLLIN},
        };
        struct lc_call call;
        struct lc_answer a = {0};
        int fd = -1;

        if (poll(fds, 2, -1) < 0 && errno != EINTR)
            return;
        if (fds[1].revents)
            pass_frames(host);
        if (!fds[0].revents)
            continue;
        if (recv(LC_CALLS_FD, &call, sizeof(call), 0) != (ssize_t)sizeof(call))
            return;
        a.r = serve(host, &call, &a, &fd);
        answer(&a, fd);
    }
}

/* Whoever called is gone while a call hangs: nobody waits for it any more, and nobody else could have the camera. */
static void *watch(void *ctx)
{
    struct pollfd fd = {.fd = LC_CALLS_FD}; /* hung up is told without being asked for */

    while (!(fd.revents & POLLHUP))
        (void)poll(&fd, 1, -1);
    _exit(0);
}

static const struct lc_ops *load(const char *path, const char *version, char *why, size_t size)
{
    const struct lc_ops *ops;
    char own[96];
    void *module;

    lc_wire_name(own);
    if (strcmp(version, own) != 0) {
        (void)snprintf(why, size, "another version of ttfbox was installed meanwhile");
        return NULL;
    }
    module = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!module) {
        const char *said = dlerror(); /* NOLINT(concurrency-mt-unsafe): this is the only thread */

        (void)snprintf(why, size, "%s", said ? said : "no reason given");
        return NULL;
    }
    ops = (const struct lc_ops *)dlsym(module, LC_MODULE_SYMBOL);
    if (!ops)
        (void)snprintf(why, size, "it is none of ttfbox's");
    else if (ops->abi != LC_ABI)
        (void)snprintf(why, size, "it is of another version of ttfbox");
    else
        return ops;
    return NULL;
}

int main(int argc, char **argv)
{
    struct host host = {0};
    struct lc_answer hello = {0};
    pthread_t watcher;

    if (argc != 3 || fcntl(LC_CALLS_FD, F_SETFD, FD_CLOEXEC) < 0 ||
        fcntl(LC_FRAMES_FD, F_SETFD, FD_CLOEXEC) < 0) {
        (void)fprintf(stderr, "ttfbox-libcamera-host is started by ttfbox and ttfboxd alone\n");
        return 2;
    }
    /* Told to end, a program ends its slot first, with the camera. This process ends with it. */
    (void)signal(SIGINT, SIG_IGN);
    (void)signal(SIGTERM, SIG_IGN);
    (void)signal(SIGHUP, SIG_IGN);
    host.ops = load(argv[1], argv[2], hello.with.text, sizeof(hello.with.text));
    hello.r = host.ops ? 0 : -ENOTSUP;
    if (host.ops && pthread_create(&watcher, NULL, watch, NULL) != 0)
        hello.r = -EAGAIN;
    if (host.ops)
        (void)snprintf(hello.with.text, sizeof(hello.with.text), "%s", host.ops->version(NULL));
    answer(&hello, -1);
    if (host.ops)
        run(&host);
    /* The kernel stops the stream with its descriptors; libcamera's own ways of ending are what may fail. */
    _exit(host.ops ? 0 : 1);
}
