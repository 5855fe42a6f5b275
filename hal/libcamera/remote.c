/* SPDX-License-Identifier: Apache-2.0 */
/* remote.c: each function of boundary.h's table as a call to the process that has libcamera. */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include "process.h"
#include "remote.h"
#include "ttf/hal/descriptor.h"

#define BUFFERS_MAX 64
#define HELLO_MS    20000 /* of the first process: nothing waits for it yet */

struct mapping {
    void *at;
    size_t length;
};

struct lc_remote;

struct lc_handle {
    struct lc_remote *remote;
    atomic_bool gone;
    struct mapping mapped[BUFFERS_MAX];
};

struct lc_remote {
    struct lc_process process;
    char host[PATH_MAX], module[PATH_MAX];
    int patience_ms;
    char version[160];
};

static int ask(struct lc_remote *remote, const struct lc_call *call, struct lc_answer *ret)
{
    return lc_process_call(&remote->process, call, ret, NULL);
}

static int ask_camera(struct lc_handle *handle, const struct lc_call *call, struct lc_answer *ret)
{
    return ask(handle->remote, call, ret);
}

/* ---- libcamera itself ---- */

static const char *version(void *ctx)
{
    const struct lc_remote *remote = ctx;

    return remote->version;
}

static int start_process(struct lc_remote *remote, int hello_ms, struct lc_answer *ret_hello)
{
    int r = lc_process_start(&remote->process, remote->host, remote->module, hello_ms,
                             remote->patience_ms, ret_hello);

    if (r == 0 && ret_hello->r < 0) {
        lc_process_end(&remote->process);
        r = ret_hello->r;
    }
    if (r == 0)
        (void)snprintf(remote->version, sizeof(remote->version), "%s", ret_hello->with.text);
    return r;
}

static int begin(void *ctx)
{
    struct lc_remote *remote = ctx;
    struct lc_answer a;
    int r = remote->process.pid > 0 ? 0 : start_process(remote, remote->patience_ms, &a);

    if (r == 0)
        r = ask(remote, &(struct lc_call){.word = LC_SAY_BEGIN}, &a);
    if (r < 0)
        lc_process_end(&remote->process);
    return r;
}

/* The next beginning is another process: nothing of what libcamera was in comes over. */
static void end(void *ctx)
{
    struct lc_remote *remote = ctx;

    lc_process_end(&remote->process);
}

static void complaint(void *ctx, char *ret, size_t size)
{
    struct lc_answer a;

    if (ask(ctx, &(struct lc_call){.word = LC_SAY_COMPLAINT}, &a) < 0)
        (void)snprintf(ret, size, "its process has ended");
    else
        (void)snprintf(ret, size, "%.*s", (int)sizeof(a.with.text), a.with.text);
}

static int list(void *ctx, unsigned i, struct lc_identity *ret)
{
    struct lc_answer a;
    int r = ask(ctx, &(struct lc_call){.word = LC_SAY_LIST, .number = i}, &a);

    if (r > 0)
        *ret = a.with.identity;
    return r;
}

/* ---- a camera ---- */

static int hold(void *ctx, const char *id, struct lc_handle **ret)
{
    struct lc_handle *handle = calloc(1, sizeof(*handle));
    struct lc_call call = {.word = LC_SAY_HOLD};
    struct lc_answer a;
    int r;

    if (!handle)
        return -ENOMEM;
    handle->remote = ctx;
    (void)snprintf(call.with.id, sizeof(call.with.id), "%s", id);
    r = ask(ctx, &call, &a);
    if (r < 0) {
        free(handle);
        return r;
    }
    *ret = handle;
    return 0;
}

static void unmap(struct lc_handle *handle)
{
    for (unsigned i = 0; i < BUFFERS_MAX; i++)
        if (handle->mapped[i].at)
            (void)munmap(handle->mapped[i].at, handle->mapped[i].length);
    memset(handle->mapped, 0, sizeof(handle->mapped));
}

/* Frames that nobody took are none of the next stream's. */
static void drain(struct lc_handle *handle)
{
    struct lc_frame frame;
    ssize_t n;

    do {
        n = recv(handle->remote->process.frames, &frame, sizeof(frame), MSG_DONTWAIT);
        if (n == (ssize_t)sizeof(frame) && frame.r < 0)
            atomic_store(&handle->gone, true);
    } while (n > 0 || (n < 0 && errno == EINTR));
}

static void let_go(struct lc_handle *handle)
{
    struct lc_answer a;

    unmap(handle);
    (void)ask_camera(handle, &(struct lc_call){.word = LC_SAY_LET_GO}, &a);
    drain(handle);
    free(handle);
}

static int offer(struct lc_handle *handle, enum lc_role role, unsigned i, struct lc_offer *ret)
{
    const struct lc_call call = {.word = LC_SAY_OFFER, .role = role, .number = i};
    struct lc_answer a;
    int r = ask_camera(handle, &call, &a);

    if (r > 0)
        *ret = a.with.offer;
    return r;
}

static int configure(struct lc_handle *handle, const struct lc_ask *wanted, struct lc_granted *ret)
{
    const struct lc_call call = {.word = LC_SAY_CONFIGURE, .with.ask = *wanted};
    struct lc_answer a;
    int r;

    unmap(handle);
    r = ask_camera(handle, &call, &a);
    if (r == 0)
        *ret = a.with.granted;
    return r;
}

static int limits(struct lc_handle *handle, struct lc_limits *ret)
{
    struct lc_answer a;
    int r = ask_camera(handle, &(struct lc_call){.word = LC_SAY_LIMITS}, &a);

    if (r == 0)
        *ret = a.with.limits;
    return r;
}

static int allocate(struct lc_handle *handle, unsigned n, unsigned *ret_n)
{
    struct lc_answer a;
    int r;

    unmap(handle);
    r = ask_camera(handle, &(struct lc_call){.word = LC_SAY_ALLOCATE, .number = n}, &a);
    if (r == 0)
        *ret_n = a.n;
    return r == 0 && a.n > BUFFERS_MAX ? -E2BIG : r;
}

static int map(struct mapping *m, int fd, uint64_t length)
{
    void *at = mmap(NULL, length, PROT_READ, MAP_SHARED, fd, 0);

    if (at == MAP_FAILED)
        return -errno;
    *m = (struct mapping){.at = at, .length = length};
    return 0;
}

static int buffer(struct lc_handle *handle, unsigned i, const void **ret_at, size_t *ret_length)
{
    struct lc_answer a;
    int fd = -1, r = 0;

    if (i >= BUFFERS_MAX)
        return -EINVAL;
    if (!handle->mapped[i].at) {
        r = lc_process_call(&handle->remote->process,
                            &(struct lc_call){.word = LC_SAY_BUFFER, .number = i}, &a, &fd);
        if (r == 0)
            r = map(&handle->mapped[i], fd, a.length);
        if (fd >= 0)
            (void)close(fd);
    }
    *ret_at = handle->mapped[i].at;
    *ret_length = handle->mapped[i].length;
    return r;
}

static int start(struct lc_handle *handle, const struct lc_settings *settings)
{
    const struct lc_call call = {.word = LC_SAY_START, .with.settings = *settings};
    struct lc_answer a;

    return ask_camera(handle, &call, &a);
}

static int stop(struct lc_handle *handle)
{
    struct lc_answer a;
    int r = ask_camera(handle, &(struct lc_call){.word = LC_SAY_STOP}, &a);

    drain(handle);
    return r;
}

static int queue(struct lc_handle *handle, unsigned i, const struct lc_settings *settings)
{
    const struct lc_call call = {.word = LC_SAY_QUEUE, .number = i, .with.settings = *settings};
    struct lc_answer a;

    return ask_camera(handle, &call, &a);
}

static int take(struct lc_handle *handle, struct lc_done *ret)
{
    struct lc_frame frame;
    ssize_t n;

    if (atomic_load(&handle->gone))
        return -ENODEV;
    do {
        n = recv(handle->remote->process.frames, &frame, sizeof(frame), MSG_DONTWAIT);
    } while (n < 0 && errno == EINTR);
    if (n < 0 && errno == EAGAIN)
        return -EAGAIN;
    if (n != (ssize_t)sizeof(frame) || frame.r < 0) {
        atomic_store(&handle->gone, true);
        return -ENODEV;
    }
    *ret = frame.done;
    return 0;
}

static int descriptor(struct lc_handle *handle)
{
    return handle->remote->process.frames;
}

static const struct lc_ops OPS = {
    .abi = LC_ABI,
    .version = version,
    .begin = begin,
    .end = end,
    .complaint = complaint,
    .list = list,
    .hold = hold,
    .let_go = let_go,
    .offer = offer,
    .configure = configure,
    .limits = limits,
    .allocate = allocate,
    .buffer = buffer,
    .start = start,
    .stop = stop,
    .queue = queue,
    .take = take,
    .descriptor = descriptor,
};

/* ---- making one ---- */

static int wait_for(const struct lc_system *system, struct lc_handle *handle,
                    struct ttf_clock *clock, int64_t deadline_ns)
{
    return ttf_descriptor_wait(clock, system->ops->descriptor(handle), deadline_ns);
}

static void destroy(void *ctx)
{
    struct lc_remote *remote = ctx;

    lc_process_end(&remote->process);
    pthread_mutex_destroy(&remote->process.lock);
    free(remote);
}

static int cannot(const char *what, const char *why, struct ttf_err *err)
{
    ttf_err_set(err, -ENOTSUP, what, "the module for libcamera cannot be loaded: %s", why);
    ttf_err_hint(
        err, "it comes with ttfbox where libcamera was there when it was built, and needs the same "
             "libcamera to run: reinstall it for this system");
    return -ENOTSUP;
}

int lc_remote_create(const char *host, const char *module, int patience_ms, struct lc_system *ret,
                     struct ttf_err *err)
{
    struct lc_remote *remote = calloc(1, sizeof(*remote));
    struct lc_answer hello = {0};
    int r;

    if (!remote || pthread_mutex_init(&remote->process.lock, NULL) != 0) {
        free(remote);
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    }
    (void)snprintf(remote->host, sizeof(remote->host), "%s", host);
    (void)snprintf(remote->module, sizeof(remote->module), "%s", module);
    remote->patience_ms = patience_ms;
    r = start_process(remote, HELLO_MS, &hello);
    if (r < 0) {
        destroy(remote);
        if (hello.r < 0)
            return cannot(module, hello.with.text, err);
        return cannot(host,
                      r == -ENODEV ? "its process ended at once, or did not answer"
                                   : strerrordesc_np(-r),
                      err);
    }
    *ret = (struct lc_system){.ops = &OPS, .ctx = remote, .wait = wait_for, .destroy = destroy};
    return 0;
}
