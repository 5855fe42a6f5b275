/* SPDX-License-Identifier: Apache-2.0 */
#include "sys.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include "ttf/hal/descriptor.h"

/* The kernel's own bound for video nodes is 256 minors over four kinds. */
#define NODES_MAX 64

static int kernel_list(void *ctx, unsigned i, char ret_path[64])
{
    unsigned seen = 0;

    (void)ctx;
    for (unsigned node = 0; node < NODES_MAX; node++) {
        struct stat st;

        (void)snprintf(ret_path, 64, "/dev/video%u", node);
        if (stat(ret_path, &st) == 0 && S_ISCHR(st.st_mode) && seen++ == i)
            return 1;
    }
    return 0;
}

static int kernel_open(void *ctx, const char *path)
{
    int fd;

    (void)ctx;
    fd = open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    return fd < 0 ? -errno : fd;
}

static void kernel_close(void *ctx, int fd)
{
    (void)ctx;
    (void)close(fd);
}

static int kernel_ioctl(void *ctx, int fd, unsigned long request, void *arg)
{
    int r;

    (void)ctx;
    do
        r = ioctl(fd, request, arg);
    while (r < 0 && errno == EINTR);
    return r < 0 ? -errno : 0;
}

static int kernel_map(void *ctx, int fd, size_t length, int64_t offset, void **ret)
{
    void *at = mmap(NULL, length, PROT_READ | PROT_WRITE, MAP_SHARED, fd, (off_t)offset);

    (void)ctx;
    if (at == MAP_FAILED)
        return -errno;
    *ret = at;
    return 0;
}

static void kernel_unmap(void *ctx, void *at, size_t length)
{
    (void)ctx;
    (void)munmap(at, length);
}

/* A video node's device is an interface of what is plugged in, which may have a serial number. */
static void kernel_serial(void *ctx, int fd, char ret[64])
{
    char path[96];
    struct stat st;
    ssize_t n = 0;
    int file;

    (void)ctx;
    ret[0] = '\0';
    if (fstat(fd, &st) < 0)
        return;
    (void)snprintf(path, sizeof(path), "/sys/dev/char/%u:%u/device/../serial", major(st.st_rdev),
                   minor(st.st_rdev));
    file = open(path, O_RDONLY | O_CLOEXEC);
    if (file >= 0) {
        n = read(file, ret, 63);
        (void)close(file);
    }
    ret[n > 0 ? n : 0] = '\0';
    ret[strcspn(ret, "\n")] = '\0';
}

static int kernel_wait(void *ctx, int fd, struct ttf_clock *clock, int64_t deadline_ns)
{
    int r = ttf_descriptor_wait(clock, fd, deadline_ns);

    (void)ctx;
    return r == -EIO ? 1 : r;
}

const struct v4l2_sys v4l2_sys_kernel = {
    .list = kernel_list,
    .open = kernel_open,
    .close = kernel_close,
    .ioctl = kernel_ioctl,
    .map = kernel_map,
    .unmap = kernel_unmap,
    .serial = kernel_serial,
    .wait = kernel_wait,
};
