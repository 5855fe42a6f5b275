/* SPDX-License-Identifier: Apache-2.0 */
/* lines_file.c: wires that are bytes of a file. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "ttf/hal/lines.h"

struct file_lines {
    struct ttf_lines base;
    char path[256];
    int file; /* -1: lost */
    bool last[TTF_LINES_MAX];
};

static bool is_lost(struct file_lines *f)
{
    struct stat st;

    /* Taken away: the chip has vanished. */
    if (f->file >= 0 && (fstat(f->file, &st) < 0 || st.st_nlink == 0)) {
        (void)close(f->file);
        f->file = -1;
    }
    return f->file < 0;
}

static int file_set(struct ttf_lines *base, unsigned i, unsigned permille)
{
    struct file_lines *f = (struct file_lines *)base;
    char byte = (char)((permille >= 500) != base->spec[i].active_low ? '1' : '0');

    if (is_lost(f))
        return -ENODEV;
    return pwrite(f->file, &byte, 1, i) == 1 ? 0 : -EIO;
}

static int file_get(struct ttf_lines *base, unsigned i)
{
    struct file_lines *f = (struct file_lines *)base;
    char byte = '0';

    if (is_lost(f))
        return -ENODEV;
    if (pread(f->file, &byte, 1, i) != 1)
        return -EIO;
    return (byte == '1') != base->spec[i].active_low;
}

static int file_fd(const struct ttf_lines *base)
{
    (void)base;
    return -1;
}

static int file_event(struct ttf_lines *base, struct ttf_line_event *ret)
{
    struct file_lines *f = (struct file_lines *)base;

    for (unsigned i = 0; i < base->n; i++) {
        int level = base->spec[i].input ? file_get(base, i) : f->last[i];

        if (level < 0)
            return level;
        if ((level != 0) == f->last[i])
            continue;
        f->last[i] = level != 0;
        *ret = (struct ttf_line_event){.i = i, .active = level != 0};
        return 1;
    }
    return 0;
}

static void let_go(struct file_lines *f)
{
    if (f->file >= 0)
        (void)close(f->file);
    f->file = -1;
}

/* Half a request is none: the wires stay lost, and are looked for again. */
static int give_up(struct file_lines *f, int code)
{
    let_go(f);
    return code;
}

/* Inputs keep what they have; outputs are dark from the first byte that is written. */
static int request(struct file_lines *f, struct ttf_err *err)
{
    struct stat st;

    f->file = open(f->path, O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (f->file < 0 || fstat(f->file, &st) < 0)
        return give_up(f, ttf_err_set(err, -errno, f->path, "cannot be opened"));
    for (unsigned i = 0; i < f->base.n; i++) {
        char idle = f->base.spec[i].active_low ? '1' : '0';

        if ((!f->base.spec[i].input || (off_t)i >= st.st_size) && pwrite(f->file, &idle, 1, i) != 1)
            return give_up(f, ttf_err_set(err, -EIO, f->path, "cannot be written"));
    }
    for (unsigned i = 0; i < f->base.n; i++)
        f->last[i] = f->base.spec[i].input && file_get(&f->base, i) == 1;
    return 0;
}

static int file_reopen(struct ttf_lines *base, struct ttf_err *err)
{
    struct file_lines *f = (struct file_lines *)base;
    struct stat st;

    if (stat(f->path, &st) < 0)
        return ttf_err_set(err, -ENODEV, f->path, "is not there");
    let_go(f);
    return request(f, err);
}

static void file_destroy(struct ttf_lines *base)
{
    struct file_lines *f = (struct file_lines *)base;

    let_go(f);
    free(f);
}

static const struct ttf_lines_ops OPS = {
    .name = "file",
    .set = file_set,
    .get = file_get,
    .fd = file_fd,
    .event = file_event,
    .reopen = file_reopen,
    .destroy = file_destroy,
};

int ttf_lines_file_create(const char *path, const struct ttf_line_spec *specs, unsigned n,
                          struct ttf_lines **ret, struct ttf_err *err)
{
    struct file_lines *f;
    int r = ttf_lines_check(specs, n, err);

    if (r < 0)
        return r;
    f = calloc(1, sizeof(*f));
    if (!f)
        return ttf_err_set(err, -ENOMEM, path, "no memory");
    f->base.ops = &OPS;
    f->base.n = n;
    f->file = -1;
    memcpy(f->base.spec, specs, n * sizeof(*specs));
    if (snprintf(f->path, sizeof(f->path), "%s", path) >= (int)sizeof(f->path))
        r = ttf_err_set(err, -ENAMETOOLONG, path, "is too long a path");
    if (r == 0)
        r = request(f, err);
    if (r < 0) {
        file_destroy(&f->base);
        return r;
    }
    *ret = &f->base;
    return 0;
}
