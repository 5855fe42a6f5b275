/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/http/token.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
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

/* The file does not exist: made at once with its content, or not at all. */
static int make_file(const char *path, const char *token, struct ttf_err *err)
{
    char line[TTF_HTTP_TOKEN_SIZE + 1];
    int n = snprintf(line, sizeof line, "%s\n", token);
    int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    int r = fd < 0 ? -errno : 0;

    if (r == 0 && (write(fd, line, (size_t)n) != n || fsync(fd) < 0)) {
        r = errno ? -errno : -EIO;
        (void)unlink(path);
    }
    if (fd >= 0)
        (void)close(fd);
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

int ttf_http_token_load(const char *path, char ret[TTF_HTTP_TOKEN_SIZE], struct ttf_err *err)
{
    int r = ttf_http_token_read(path, ret, err);

    if (r != -ENOENT)
        return r;
    r = ttf_http_token_make(ret, err);
    return r == 0 ? make_file(path, ret, err) : r;
}
