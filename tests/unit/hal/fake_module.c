/* SPDX-License-Identifier: Apache-2.0 */
/* fake_module.c: a module as ttfbox-libcamera.so is, of a camera in memory: each request comes back at once. Exposures that are words end or hang it. */
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <unistd.h>

#include "boundary.h"
#include "fake_module.h"

#define BUFFERS 3u

struct lc_handle {
    int memory[BUFFERS];
    unsigned char *at[BUFFERS];
    struct lc_done done[BUFFERS];
    unsigned n_done, seen;
    bool gone;
    int event;
};

static const char *version(void *ctx)
{
    return "9.8.7";
}

static int begin(void *ctx)
{
    return 0;
}

static void end(void *ctx)
{
}

static void complaint(void *ctx, char *ret, size_t size)
{
    (void)snprintf(ret, size, "nothing answers on the bus");
}

static int list(void *ctx, unsigned i, struct lc_identity *ret)
{
    *ret = (struct lc_identity){.id = "/fake/camera", .model = "fake"};
    return i == 0;
}

static int hold(void *ctx, const char *id, struct lc_handle **ret)
{
    if (strcmp(id, "/fake/camera") != 0)
        return -ENODEV;
    *ret = calloc(1, sizeof(**ret));
    (*ret)->event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    return 0;
}

static void let_go(struct lc_handle *h)
{
    for (unsigned i = 0; i < BUFFERS && h->at[i]; i++) {
        (void)munmap(h->at[i], FAKE_BYTES);
        (void)close(h->memory[i]);
    }
    (void)close(h->event);
    free(h);
}

static int offer(struct lc_handle *h, enum lc_role role, unsigned i, struct lc_offer *ret)
{
    *ret = (struct lc_offer){.fourcc = 0x20363152u + (unsigned)role, .width = 64, .height = 48};
    return i < 2;
}

static int configure(struct lc_handle *h, const struct lc_ask *ask, struct lc_granted *ret)
{
    if (ask->width > 64)
        return -EINVAL;
    *ret = (struct lc_granted){.fourcc = ask->fourcc,
                               .width = ask->width,
                               .height = ask->height,
                               .stride = 128,
                               .bytes = FAKE_BYTES,
                               .colour_text = "RAW"};
    return 0;
}

static int limits(struct lc_handle *h, struct lc_limits *ret)
{
    *ret = (struct lc_limits){.has = 1u << LC_EXPOSURE, .min = {10}, .max = {2000000}};
    return 0;
}

static int allocate(struct lc_handle *h, unsigned n, unsigned *ret_n)
{
    for (unsigned i = 0; i < BUFFERS; i++) {
        h->memory[i] = memfd_create("frame", MFD_CLOEXEC);
        if (h->memory[i] < 0 || ftruncate(h->memory[i], FAKE_BYTES) < 0)
            return -ENOMEM;
        h->at[i] = mmap(NULL, FAKE_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED, h->memory[i], 0);
    }
    *ret_n = BUFFERS;
    return 0;
}

static int buffer(struct lc_handle *h, unsigned i, const void **ret_at, size_t *ret_length)
{
    if (i >= BUFFERS)
        return -EINVAL;
    *ret_at = h->at[i];
    *ret_length = FAKE_BYTES;
    return 0;
}

static int shared(struct lc_handle *h, unsigned i)
{
    return i < BUFFERS ? h->memory[i] : -EINVAL;
}

static int start(struct lc_handle *h, const struct lc_settings *settings)
{
    return 0;
}

static void drop(struct lc_handle *h)
{
    uint64_t count;

    (void)!read(h->event, &count, sizeof(count));
    h->n_done = 0;
}

static int stop(struct lc_handle *h)
{
    drop(h);
    return 0;
}

/* The request is back, with its exposure in its metadata and as the colour of its picture. */
static int queue(struct lc_handle *h, unsigned i, const struct lc_settings *settings)
{
    const uint64_t one = 1;
    double exposure_us = settings->value[LC_EXPOSURE][0];

    if (exposure_us == FAKE_DIES_US)
        abort();
    while (exposure_us == FAKE_HANGS_US)
        (void)pause();
    h->gone |= exposure_us == FAKE_GOES_US;
    memset(h->at[i], (int)exposure_us & 0xff, FAKE_BYTES);
    h->done[h->n_done++] = (struct lc_done){
        .buffer = i, .sequence = h->seen++, .bytes = FAKE_BYTES, .told = *settings};
    (void)!write(h->event, &one, sizeof(one));
    return 0;
}

static int take(struct lc_handle *h, struct lc_done *ret)
{
    if (h->gone)
        return -ENODEV;
    if (h->n_done == 0) {
        drop(h);
        return -EAGAIN;
    }
    *ret = h->done[0];
    h->n_done--;
    memmove(h->done, h->done + 1, h->n_done * sizeof(h->done[0]));
    return 0;
}

static int descriptor(struct lc_handle *h)
{
    return h->event;
}

const struct lc_ops ttf_libcamera_ops = {
    .abi = FAKE_ABI,
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
    .shared = shared,
    .start = start,
    .stop = stop,
    .queue = queue,
    .take = take,
    .descriptor = descriptor,
};
