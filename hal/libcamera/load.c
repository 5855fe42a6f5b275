/* SPDX-License-Identifier: Apache-2.0 */
/* load.c: where the module that speaks to libcamera is, and the program that loads it. */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "remote.h"

#define MODULE      "ttfbox-libcamera.so"
#define HOST        "ttfbox-libcamera-host"
/* Of one call, within what lamps and the watchdog allow a program that waits for its camera (TTF_BLOCKING_MAX_NS). */
#define PATIENCE_MS 8000

/* The folder of the running program, without a slash at its end. */
static int own_folder(char *ret, size_t size)
{
    ssize_t n = readlink("/proc/self/exe", ret, size - 1);
    char *slash;

    if (n < 0 || (size_t)n == size - 1)
        return -ENOENT;
    ret[n] = '\0';
    slash = strrchr(ret, '/');
    if (!slash)
        return -ENOENT;
    *slash = '\0';
    return 0;
}

/* Beside the program, then where a program in PREFIX/bin has them: the folder, with a slash. */
static int look(char ret[PATH_MAX], struct ttf_err *err)
{
    static const char *const places[] = {"/", "/../lib/ttfbox/"};
    char folder[PATH_MAX - sizeof("/../lib/ttfbox/" HOST)], path[PATH_MAX];

    if (own_folder(folder, sizeof(folder)) == 0)
        for (unsigned i = 0; i < TTF_COUNT_OF(places); i++) {
            (void)snprintf(ret, PATH_MAX, "%s%s", folder, places[i]);
            (void)snprintf(path, sizeof(path), "%s%s" HOST, folder, places[i]);
            if (access(path, X_OK) == 0)
                return 0;
        }
    ttf_err_set(
        err, -ENOTSUP, HOST,
        "the module for libcamera cannot be loaded: there is no program for it, neither beside "
        "this one nor in ../lib/ttfbox from there");
    ttf_err_hint(err, "it comes with ttfbox where libcamera was there when it was built: reinstall "
                      "it for this system");
    return -ENOTSUP;
}

int lc_load(const char *path, struct lc_system *ret, struct ttf_err *err)
{
    char folder[PATH_MAX], host[PATH_MAX + sizeof(HOST)], module[PATH_MAX + sizeof(MODULE)];
    int r = look(folder, err);

    if (r < 0)
        return r;
    (void)snprintf(host, sizeof(host), "%s" HOST, folder);
    (void)snprintf(module, sizeof(module), "%s%s", path[0] ? "" : folder, path[0] ? path : MODULE);
    return lc_remote_create(host, module, PATIENCE_MS, ret, err);
}
