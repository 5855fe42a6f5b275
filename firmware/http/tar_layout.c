/* SPDX-License-Identifier: Apache-2.0 */
#include "tar_layout.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "described.h"
#include "ttf/dataset/hash.h"

#define DEPTH_MAX 4 /* calibration/ID/frames/x.tif is the deepest that the format has */

static int add(struct tar_layout *layout, const char *path)
{
    if (layout->n == layout->room) {
        size_t room = layout->room ? 2 * layout->room : 64;
        struct tar_file *more = realloc(layout->files, room * sizeof *more);

        if (!more)
            return -ENOMEM;
        layout->files = more;
        layout->room = room;
    }
    layout->files[layout->n] = (struct tar_file){.path = strdup(path)};
    return layout->files[layout->n].path ? (int)(layout->n++, 0) : -ENOMEM;
}

static bool is_temporary(const char *name)
{
    size_t n = strlen(name);

    return n >= 4 && strcmp(name + n - 4, ".tmp") == 0;
}

/* All files below dataset/path; path empty: the dataset itself. */
static int walk(const struct folder *folder, struct tar_layout *layout, const char *path,
                unsigned depth)
{
    char whole[4096 + 300], inside[256 + 200];
    DIR *dir;
    const struct dirent *entry;
    struct stat st;
    int r = 0;

    (void)snprintf(whole, sizeof whole, "%s/%s/%s", folder->path, layout->dataset, path);
    dir = opendir(whole);
    if (!dir)
        return -errno;
    while (r == 0 && (entry = folder_next(dir, &r))) {
        if (!folder_is_name(entry->d_name) || is_temporary(entry->d_name))
            continue;
        if (*path == '\0' && strcmp(entry->d_name, "preview") == 0)
            continue;
        (void)snprintf(inside, sizeof inside, "%s%s%s", path, *path ? "/" : "", entry->d_name);
        if (!folder_is_path(inside))
            continue;
        /* Some file systems do not say what an entry is. */
        if (fstatat(dirfd(dir), entry->d_name, &st, AT_SYMLINK_NOFOLLOW) < 0)
            r = errno == ENOENT ? 0 : -errno; /* gone meanwhile; else nothing is left out */
        else if (S_ISDIR(st.st_mode))
            r = depth < DEPTH_MAX ? walk(folder, layout, inside, depth + 1) : 0;
        else if (S_ISREG(st.st_mode))
            r = add(layout, inside);
    }
    (void)closedir(dir);
    return r;
}

/* 0, or -ENOENT: it has gone meanwhile. */
static int measure(const struct folder *folder, const struct tar_layout *layout,
                   struct tar_file *file)
{
    struct stat st;
    int fd = folder_file(folder, layout->dataset, file->path, &st);

    if (fd < 0)
        return fd;
    file->bytes = st.st_size;
    file->mtime_s = st.st_mtime;
    file->stamp[0] = (uint64_t)st.st_ino;
    file->stamp[1] = (uint64_t)st.st_mtim.tv_nsec;
    if (folder_grows(file->path, layout->sealed))
        file->bytes = folder_whole_lines(fd, st.st_size);
    (void)close(fd);
    return file->bytes < 0 ? (int)file->bytes : 0;
}

static int by_path(const void *a, const void *b)
{
    return strcmp(((const struct tar_file *)a)->path, ((const struct tar_file *)b)->path);
}

static int place(const struct folder *folder, struct tar_layout *layout)
{
    struct ttf_sha256 hash;
    unsigned char header[TAR_BLOCK];
    char sums[65] = "";
    size_t kept = 0;

    ttf_sha256_init(&hash);
    for (size_t i = 0; i < layout->n; i++) {
        struct tar_file *file = &layout->files[i];
        int r = measure(folder, layout, file);

        if (r == -ENOENT) {
            free(file->path);
            continue;
        }
        if (r == 0 && !tar_header(layout, file, header))
            r = -ENAMETOOLONG;
        if (r < 0) {
            /* what is not kept is freed with the rest: close the gap first */
            memmove(&layout->files[kept], file, (layout->n - i) * sizeof *file);
            layout->n = kept + (layout->n - i);
            return r;
        }
        file->offset = layout->bytes;
        layout->bytes += TAR_BLOCK + (file->bytes + TAR_BLOCK - 1) / TAR_BLOCK * TAR_BLOCK;
        ttf_sha256_add(&hash, header, sizeof header);
        ttf_sha256_add(&hash, &file->stamp, sizeof file->stamp);
        if (kept != i)
            layout->files[kept] = *file;
        kept++;
    }
    layout->n = kept;
    layout->bytes += (int64_t)2 * TAR_BLOCK;
    /* The seal's own line for the records stands, by the crc of each, for all that they name. */
    if (described_sha256(folder, layout->dataset, "records.jsonl", sums) == 0)
        ttf_sha256_add(&hash, sums, strlen(sums));
    ttf_sha256_hex(&hash, layout->etag);
    return 0;
}

int tar_layout_make(const struct folder *folder, const char *dataset, struct tar_layout *ret)
{
    struct tar_layout layout = {0};
    char path[4096 + 80];
    int r = folder_dataset(folder, dataset, path, sizeof path);

    if (r < 0)
        return r;
    (void)snprintf(layout.dataset, sizeof layout.dataset, "%s", dataset);
    layout.sealed = described_sealed(folder, dataset);
    r = walk(folder, &layout, "", 0);
    if (r == 0 && layout.n > 1)
        qsort(layout.files, layout.n, sizeof *layout.files, by_path);
    if (r == 0)
        r = place(folder, &layout);
    if (r < 0) {
        tar_layout_free(&layout);
        return r;
    }
    *ret = layout;
    return 0;
}

void tar_layout_free(struct tar_layout *layout)
{
    for (size_t i = 0; i < layout->n; i++)
        free(layout->files[i].path);
    free(layout->files);
    *layout = (struct tar_layout){0};
}

/* Octal with zeros in front and a zero behind; what does not fit (8 GiB and more) as GNU and POSIX tars write it: base 256. */
static void put_number(unsigned char *field, size_t size, int64_t value)
{
    uint64_t v = value < 0 ? 0 : (uint64_t)value;

    if (v >> (3 * (size - 1)) == 0) {
        field[size - 1] = '\0';
        for (size_t i = size - 1; i-- > 0; v >>= 3)
            field[i] = (unsigned char)('0' + (v & 7));
        return;
    }
    for (size_t i = size; i-- > 1; v >>= 8)
        field[i] = (unsigned char)v;
    field[0] = 0x80;
}

/* Names of up to 100 bytes stand whole; longer ones are cut at a slash into prefix (155) and name. No zero is needed behind. */
static bool put_name(unsigned char *header, const char *name)
{
    size_t n = strlen(name);
    const char *cut = n > 100 ? strchr(name + n - 101, '/') : NULL;

    if (n > 100 && (!cut || cut - name > 155))
        return false;
    for (size_t i = 0; cut && name + i < cut; i++)
        header[345 + i] = (unsigned char)name[i];
    name = cut ? cut + 1 : name;
    for (size_t i = 0; name[i]; i++)
        header[i] = (unsigned char)name[i];
    return true;
}

bool tar_header(const struct tar_layout *layout, const struct tar_file *file,
                unsigned char ret[TAR_BLOCK])
{
    char name[65 + 192];
    unsigned sum = 0;

    memset(ret, 0, TAR_BLOCK);
    (void)snprintf(name, sizeof name, "%s/%s", layout->dataset, file->path);
    if (!put_name(ret, name))
        return false;
    put_number(ret + 100, 8, 0644);
    put_number(ret + 108, 8, 0);
    put_number(ret + 116, 8, 0);
    put_number(ret + 124, 12, file->bytes);
    put_number(ret + 136, 12, file->mtime_s);
    memset(ret + 148, ' ', 8);
    ret[156] = '0';
    memcpy(ret + 257, "ustar", 6); /* with its zero; then the version */
    ret[263] = ret[264] = '0';
    for (size_t i = 0; i < TAR_BLOCK; i++)
        sum += ret[i];
    put_number(ret + 148, 7, sum);
    return true;
}
