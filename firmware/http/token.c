/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/http/token.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include "ttf/http/server.h"

#define RANDOM_BYTES 16

int ttf_http_token_make(char ret[TTF_HTTP_TOKEN_SIZE], struct ttf_err *err)
{
    unsigned char random[RANDOM_BYTES];

    if (getrandom(random, sizeof random, 0) != (ssize_t)sizeof random)
        return ttf_err_set(err, -EIO, NULL, "the kernel gives no randomness");
    for (unsigned i = 0; i < RANDOM_BYTES; i++)
        (void)snprintf(ret + 2 * (size_t)i, 3, "%02x", random[i]);
    return 0;
}

/* The folder's new name on the disk. */
static int token_sync_folder(const char *path)
{
    const char *slash = strrchr(path, '/');
    char folder[4096];
    int fd, r;

    (void)snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1,
                   slash ? path : ".");
    fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0)
        return -errno;
    r = fsync(fd) < 0 ? -errno : 0;
    (void)close(fd);
    return r;
}

/* An empty one is no loss; one that somebody else has made by now is not replaced. */
static int token_put_in_place(const char *from, const char *path)
{
    struct stat st;

    if (stat(path, &st) == 0 && S_ISREG(st.st_mode) && st.st_size == 0)
        return rename(from, path) < 0 ? -errno : 0;
    return renameat2(AT_FDCWD, from, AT_FDCWD, path, RENAME_NOREPLACE) < 0 ? -errno : 0;
}

/* There is none: made at once with its content, or not at all, also where the power is cut. */
static int make_file(const char *path, const char *token, struct ttf_err *err)
{
    char line[TTF_HTTP_TOKEN_SIZE + 1], temporary[4096];
    int n = snprintf(line, sizeof line, "%s\n", token);
    int r = snprintf(temporary, sizeof temporary, "%s.XXXXXX", path);
    int fd;

    if (r >= (int)sizeof temporary)
        return ttf_err_set(err, -ENAMETOOLONG, path, "cannot be made: its name is too long");
    fd = mkostemp(temporary, O_CLOEXEC); /* its mode is 0600 */
    r = fd < 0 ? -errno : 0;
    if (fd >= 0) {
        if (write(fd, line, (size_t)n) != n || fsync(fd) < 0)
            r = errno ? -errno : -EIO;
        (void)close(fd);
        if (r == 0)
            r = token_put_in_place(temporary, path);
        if (r < 0)
            (void)unlink(temporary);
    }
    if (r == 0)
        r = token_sync_folder(path);
    return r == 0 ? 0 : ttf_err_set(err, r, path, "cannot be made: %s", strerrordesc_np(-r));
}

static int read_file(int fd, const char *path, char ret[TTF_HTTP_TOKEN_SIZE], struct ttf_err *err)
{
    char text[256];
    struct stat st;
    ssize_t got;
    size_t n = 0;

    if (fstat(fd, &st) < 0 || (st.st_mode & 077) != 0) {
        ttf_err_set(err, -EPERM, path, "others may read the token in it");
        ttf_err_hint(err, "chmod 600 it, and write another token: this one may be known");
        return -EPERM;
    }
    got = read(fd, text, sizeof text - 1);
    while (n < (size_t)(got < 0 ? 0 : got) && text[n] > ' ' && text[n] < 127)
        n++;
    if (n < TTF_HTTP_TOKEN_MIN || n >= TTF_HTTP_TOKEN_SIZE)
        return ttf_err_set(err, -EINVAL, path, "holds no token of %d to %d printable characters",
                           TTF_HTTP_TOKEN_MIN, TTF_HTTP_TOKEN_SIZE - 1);
    memcpy(ret, text, n);
    ret[n] = '\0';
    return 0;
}

int ttf_http_token_read(const char *path, char ret[TTF_HTTP_TOKEN_SIZE], struct ttf_err *err)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    int r;

    if (fd < 0)
        return ttf_err_set(err, -errno, path, "cannot be read: %s", strerrordesc_np(errno));
    r = read_file(fd, path, ret, err);
    (void)close(fd);
    return r;
}

static int token_make_anew(const char *path, char ret[TTF_HTTP_TOKEN_SIZE], struct ttf_err *err)
{
    int r = ttf_http_token_make(ret, err);

    return r == 0 ? make_file(path, ret, err) : r;
}

/* An empty one is what a power cut can leave of one that was being made: nobody knows it. */
static bool is_missing(const char *path)
{
    struct stat st;

    return stat(path, &st) < 0 ? errno == ENOENT : S_ISREG(st.st_mode) && st.st_size == 0;
}

int ttf_http_token_load(const char *path, char ret[TTF_HTTP_TOKEN_SIZE], struct ttf_err *err)
{
    return is_missing(path) ? token_make_anew(path, ret, err) : ttf_http_token_read(path, ret, err);
}

/* ---- shown once ---- */

static int unshown_path(const char *path, char ret[4096], struct ttf_err *err)
{
    return snprintf(ret, 4096, "%s.unshown", path) < 4096
               ? 0
               : ttf_err_set(err, -ENAMETOOLONG, path, "its name is too long");
}

int ttf_http_token_load_to_show(const char *path, char ret[TTF_HTTP_TOKEN_SIZE],
                                struct ttf_err *err)
{
    char unshown[4096];
    int r;

    if (!is_missing(path))
        return ttf_http_token_read(path, ret, err);
    r = unshown_path(path, unshown, err);
    if (r == 0)
        r = ttf_http_token_make(ret, err);
    if (r < 0)
        return r;
    /* Of a former token, or of one that a power cut kept from being made. */
    (void)unlink(unshown);
    r = make_file(unshown, ret, err);
    return r == 0 ? make_file(path, ret, err) : r;
}

/* It holds the token itself: of another one, as somebody may have put in its place, it says nothing. */
bool ttf_http_token_waits(const char *path, const char *token)
{
    char unshown[4096], waits[TTF_HTTP_TOKEN_SIZE];

    return unshown_path(path, unshown, NULL) == 0 &&
           ttf_http_token_read(unshown, waits, NULL) == 0 && strcmp(waits, token) == 0;
}

int ttf_http_token_show(const char *path, const char *token, struct ttf_err *err)
{
    char unshown[4096];
    int r = 0;

    if (!ttf_http_token_waits(path, token))
        r = -EEXIST;
    else if (unshown_path(path, unshown, NULL) < 0 || unlink(unshown) < 0)
        r = errno == ENOENT ? -EEXIST : -errno; /* of two who ask at once one takes it away */
    else
        r = token_sync_folder(path);
    if (r == -EEXIST) {
        ttf_err_set(err, r, NULL, "the token was shown before, or is one that a person chose");
        ttf_err_hint(err,
                     "ttfbox token, on the box; or write another one: firmware/image/README.md");
    } else if (r < 0) {
        ttf_err_set(err, r, path, "that it is shown cannot be written down: %s",
                    strerrordesc_np(-r));
    }
    return r;
}
