/* SPDX-License-Identifier: Apache-2.0 */
/* load.c: finds and loads the module that speaks to libcamera; waits for what it has to say. */
#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "system.h"
#include "ttf/hal/descriptor.h"

#define MODULE "ttfbox-libcamera.so"

static int module_wait(const struct lc_system *system, struct lc_handle *handle,
                       struct ttf_clock *clock, int64_t deadline_ns)
{
    return ttf_descriptor_wait(clock, system->ops->descriptor(handle), deadline_ns);
}

/* The folder of the running program, without a slash at its end. */
static int own_folder(char ret[PATH_MAX])
{
    ssize_t n = readlink("/proc/self/exe", ret, PATH_MAX - 1);
    char *slash;

    if (n < 0)
        return -errno;
    ret[n] = '\0';
    slash = strrchr(ret, '/');
    if (!slash)
        return -ENOENT;
    *slash = '\0';
    return 0;
}

static int not_found(const char *path, const char *why, struct ttf_err *err)
{
    ttf_err_set(err, -ENOTSUP, path, "the module for libcamera cannot be loaded: %s", why);
    ttf_err_hint(
        err, "it comes with ttfbox where libcamera was there when it was built, and needs the same "
             "libcamera to run: reinstall it for this system");
    return -ENOTSUP;
}

static void *open_module(const char *path, struct ttf_err *err)
{
    /* Never unloaded: libcamera leaves threads and handlers behind. */
    void *module = dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);

    if (!module) {
        const char *why =
            dlerror(); /* NOLINT(concurrency-mt-unsafe): glibc's is the thread's own */

        not_found(path, why ? why : "no reason given", err);
    }
    return module;
}

/* Beside the program, then where a program in PREFIX/bin has it. */
static void *look(struct ttf_err *err)
{
    static const char *const places[] = {"", "/../lib/ttfbox"};
    char folder[PATH_MAX], path[PATH_MAX + 64];

    if (own_folder(folder) < 0)
        return open_module(MODULE, err);
    for (unsigned i = 0; i < TTF_COUNT_OF(places); i++) {
        (void)snprintf(path, sizeof(path), "%s%s/" MODULE, folder, places[i]);
        if (access(path, R_OK) == 0)
            return open_module(path, err);
    }
    not_found(MODULE, "there is none, neither beside the program nor in ../lib/ttfbox from there",
              err);
    return NULL;
}

int lc_load(const char *path, struct lc_system *ret, struct ttf_err *err)
{
    void *module = path[0] ? open_module(path, err) : look(err);
    const struct lc_ops *ops;

    if (!module)
        return -ENOTSUP;
    ops = (const struct lc_ops *)dlsym(module, LC_MODULE_SYMBOL);
    if (!ops)
        return not_found(path[0] ? path : MODULE, "it is none of ttfbox's", err);
    if (ops->abi != LC_ABI)
        return not_found(path[0] ? path : MODULE, "it is of another version of ttfbox", err);
    *ret = (struct lc_system){.ops = ops, .wait = module_wait};
    return 0;
}
