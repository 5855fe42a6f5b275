/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "preview.h"

/* linux/ioprio.h, as packages of kernel headers have it or not */
#define IO_OF_PROCESS 1
#define IO_IDLE       (3 << 13)

/* Bytes of one file that it, or its child, writes: the two large ones of a refresh leave three quarters of the room. */
#define ROOM_SHARE 8
#define FILE_LEAST ((int64_t)16 << 20)
#define FILE_MOST  ((int64_t)512 << 20)

/* Libraries, threads' stacks and what malloc holds ready are address space too. */
#define BESIDE_BYTES ((int64_t)320 << 20)

static int limit(int which, rlim_t value)
{
    const struct rlimit both = {value, value};

    return setrlimit((__rlimit_resource_t)which, &both) < 0 ? -errno : 0;
}

/* The kernel takes this one first when memory is short. */
static void volunteer(void)
{
    int fd = open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);

    if (fd < 0)
        return;
    (void)!write(fd, "900", 3);
    (void)close(fd);
}

static rlim_t file_bytes(const struct preview_options *options)
{
    int64_t share = options->room_bytes / ROOM_SHARE;

    return (rlim_t)(share < FILE_LEAST ? FILE_LEAST : share > FILE_MOST ? FILE_MOST : share);
}

int preview_be_humble(const struct preview_options *options, struct ttf_err *err)
{
    const struct sched_param none = {0};
    int r = limit(RLIMIT_AS, (rlim_t)(options->memory_bytes + BESIDE_BYTES));

    if (r == 0)
        r = limit(RLIMIT_FSIZE, file_bytes(options));
    if (r == 0)
        r = limit(RLIMIT_CORE, 0);
    if (r < 0)
        return ttf_err_set(err, r, NULL, "the limits of this process cannot be set");
    volunteer();
    if (options->eager)
        return 0;
    (void)setpriority(PRIO_PROCESS, 0, 19);
    (void)sched_setscheduler(0, SCHED_IDLE, &none);
    (void)syscall(SYS_ioprio_set, IO_OF_PROCESS, 0, IO_IDLE);
    return 0;
}
