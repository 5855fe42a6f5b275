/* SPDX-License-Identifier: Apache-2.0 */
#include "usb_box.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/http/listen.h"
#include "ttf/usb/bridge.h"
#include "ttf/usb/libusb.h"

struct usb_bridge {
    struct ttf_usb_bridge_config config;
    struct ttf_http_socket socket;
    char folder[80], where[120];
    volatile int stop;
    pthread_t thread;
    bool runs;
    atomic_int ended; /* 0: it goes on; else why not, and why says it in words */
    struct ttf_err why;
};

static const char *after(const char *text, const char *prefix)
{
    size_t n = strlen(prefix);

    return strncmp(text, prefix, n) == 0 ? text + n : NULL;
}

bool usb_box_is(const char *box)
{
    return strcmp(box, "usb") == 0 || after(box, "usb:") || after(box, "cable:");
}

int usb_box_link(const char *box, struct ttf_usb_link **ret, struct ttf_err *err)
{
    const char *cable = after(box, "cable:"), *serial = after(box, "usb:");

    if (cable)
        return ttf_usb_pipe_create(cable, false, -1, ret, err);
    if (!serial && strcmp(box, "usb") != 0) {
        ttf_err_set(err, -EINVAL, box, "is no box at USB");
        ttf_err_hint(err, "write usb, or usb:SERIAL: 'ttfbox usb list' shows them");
        return -EINVAL;
    }
    return ttf_usb_libusb_create(serial && *serial ? serial : NULL, ret, err);
}

static void *run(void *ctx)
{
    struct usb_bridge *b = ctx;
    int r = ttf_usb_bridge_run(&b->config, &b->why);

    atomic_store(&b->ended, r);
    /* Who waits to be let in is turned away at once, and asks why. */
    (void)close(b->socket.fd);
    b->socket.fd = -1;
    return NULL;
}

int usb_bridge_ended(void *bridge, struct ttf_err *err)
{
    struct usb_bridge *b = bridge;
    int r = atomic_load(&b->ended);

    if (r < 0 && err)
        *err = b->why;
    return r;
}

/* Where others of this machine have no way in: the user's own folder of the session, else a fresh one. */
static int make_folder(struct usb_bridge *b, struct ttf_err *err)
{
    const char *session = getenv("XDG_RUNTIME_DIR"); /* NOLINT(concurrency-mt-unsafe) */

    if (!session || strlen(session) > 50 || access(session, W_OK) < 0)
        session = "/tmp";
    (void)snprintf(b->folder, sizeof b->folder, "%s/ttfbox-XXXXXX", session);
    if (!mkdtemp(b->folder)) {
        int r = -errno;

        b->folder[0] = '\0';
        return ttf_err_set(err, r, session, "no folder can be made: %s", strerrordesc_np(-r));
    }
    (void)snprintf(b->where, sizeof b->where, "unix:%s/usb", b->folder);
    return 0;
}

static int begin_thread(struct usb_bridge *b, struct ttf_err *err)
{
    sigset_t all, before;
    int r;

    /* Signals are the other thread's. */
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_SETMASK, &all, &before);
    r = -pthread_create(&b->thread, NULL, run, b);
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    b->runs = r == 0;
    return r < 0 ? ttf_err_set(err, r, NULL, "no thread") : 0;
}

int usb_bridge_begin(const char *box, bool wait, struct ttf_clock *clock, struct usb_bridge **ret,
                     struct ttf_err *err)
{
    struct usb_bridge *b = calloc(1, sizeof *b);
    int r;

    if (!b)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    b->socket.fd = -1;
    r = make_folder(b, err);
    if (r == 0)
        r = usb_box_link(box, &b->config.link, err);
    if (r == 0) /* a box that is not there is said at once, and not waited for */
        r = b->config.link->ops->open(b->config.link, err);
    if (r == -ENODEV && wait)
        r = 0;
    if (r == 0)
        r = ttf_http_listen(b->where, false, &b->socket, err);
    if (r == 0) {
        b->config.role = TTF_MUX_HOST;
        b->config.clock = clock;
        b->config.listen_fd = b->socket.fd;
        b->config.stop = &b->stop;
        r = begin_thread(b, err);
    }
    if (r < 0) {
        usb_bridge_end(b);
        return r;
    }
    *ret = b;
    return 0;
}

const char *usb_bridge_where(const struct usb_bridge *bridge)
{
    return bridge->where;
}

void usb_bridge_end(struct usb_bridge *bridge)
{
    if (!bridge)
        return;
    bridge->stop = 1;
    if (bridge->runs)
        (void)pthread_join(bridge->thread, NULL);
    ttf_usb_link_destroy(bridge->config.link);
    if (bridge->socket.fd >= 0)
        (void)close(bridge->socket.fd);
    if (bridge->folder[0]) {
        (void)unlink(bridge->where + strlen("unix:"));
        (void)rmdir(bridge->folder);
    }
    free(bridge);
}
