/* SPDX-License-Identifier: Apache-2.0 */
/* load.c: where the module that speaks to libcamera is, and the program that loads it. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "remote.h"
#include "ttf/hal/program.h"

#define MODULE      "ttfbox-libcamera.so"
#define HOST        "ttfbox-libcamera-host"
/* Of one call, within what lamps and the watchdog allow a program that waits for its camera (TTF_BLOCKING_MAX_NS). */
#define PATIENCE_MS 8000

static int look(char ret[TTF_PROGRAM_PATH_MAX], struct ttf_err *err)
{
    if (ttf_program_find(HOST, ret) == 0)
        return 0;
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
    char host[TTF_PROGRAM_PATH_MAX], module[TTF_PROGRAM_PATH_MAX + sizeof(MODULE)];
    int folder, r = look(host, err);

    if (r < 0)
        return r;
    folder = (int)(strrchr(host, '/') + 1 - host);
    if (path[0])
        (void)snprintf(module, sizeof(module), "%s", path);
    else
        (void)snprintf(module, sizeof(module), "%.*s" MODULE, folder, host);
    return lc_remote_create(host, module, PATIENCE_MS, ret, err);
}
