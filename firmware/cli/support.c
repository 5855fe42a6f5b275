/* SPDX-License-Identifier: Apache-2.0 */
/* support.c: how commands speak and end; see cli.h. */
#include <errno.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "cli.h"
#include "commands.h"

void cli_say(const struct cli *cli, const char *fmt, ...)
{
    va_list args;

    if (cli->opt.json)
        return;
    va_start(args, fmt);
    /* NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): it is begun above */
    (void)vprintf(fmt, args);
    va_end(args);
    (void)putchar('\n');
}

void cli_say_listening(const struct cli *cli, const char *where, const bool *free_to_read)
{
    struct ttf_json json;
    const char *line;
    size_t bytes;

    if (!cli->opt.json)
        return;
    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "listening", where);
    if (free_to_read)
        ttf_json_kbool(&json, "free_to_read", *free_to_read);
    ttf_json_object_end(&json);
    if (ttf_json_finish(&json, &line, &bytes) == 0)
        (void)puts(line);
    ttf_json_free(&json);
}

void cli_warn(const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    /* NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): it is begun above */
    (void)vfprintf(stderr, fmt, args);
    va_end(args);
    (void)fputc('\n', stderr);
}

/* A signal handler can reach nothing but a global. */
static volatile int stop_asked;

static void on_stop(int signal_number)
{
    (void)signal_number;
    stop_asked = 1;
}

void cli_stop_catch(void)
{
    /* Once: a second Ctrl-C ends the program at once; what is committed is safe. */
    struct sigaction action = {.sa_handler = on_stop, .sa_flags = (int)SA_RESETHAND};

    (void)sigemptyset(&action.sa_mask);
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
}

const volatile int *cli_stop_flag(void)
{
    return &stop_asked;
}

int cli_need(struct cli *cli, const char *value, const char *option, const char *hint)
{
    if (value)
        return 0;
    ttf_err_set(&cli->err, -EINVAL, option, "is missing");
    ttf_err_hint(&cli->err, "%s", hint);
    return -EINVAL;
}

struct ttf_sequence_choice cli_choice(const struct cli *cli)
{
    return (struct ttf_sequence_choice){
        .stream = cli->opt.stream,
        .role = cli->opt.role,
        .one_bracket = cli->opt.bracket >= 0,
        .bracket = (int)cli->opt.bracket,
        .with_excluded = cli->opt.with_excluded,
        .threads = (unsigned)cli->opt.threads,
    };
}

int cli_by_option(struct cli *cli, int code, const char *option, const char *path)
{
    struct ttf_err *err = &cli->err;

    if (code >= 0)
        return code;
    if (strchr(err->where, '/') || (path && strncmp(err->where, path, strlen(path)) == 0))
        ttf_err_prefix(err, "%s", option);
    else
        (void)snprintf(err->where, sizeof err->where, "%s", option);
    return code;
}

int cli_refuse_inside_dataset(struct cli *cli, const char *path)
{
    char folder[PATH_MAX], real[PATH_MAX], manifest[PATH_MAX + 16];
    struct ttf_io_stat st;
    char *slash;

    if (strlen(path) >= sizeof folder - 2)
        return ttf_err_set(&cli->err, -ENAMETOOLONG, "-o", "the path is too long");
    (void)snprintf(folder, sizeof folder, "%s%s", strchr(path, '/') ? "" : "./", path);
    /* From the folder above up to the first that exists: where it really lies, links followed. */
    do {
        for (size_t n = strlen(folder); n > 1 && folder[n - 1] == '/'; n--)
            folder[n - 1] = '\0';
        slash = strrchr(folder, '/');
        if (!slash)
            (void)snprintf(folder, sizeof folder, ".");
        else
            slash[slash == folder] = '\0';
    } while (!realpath(folder, real) && slash);
    for (;;) {
        (void)snprintf(manifest, sizeof manifest, "%s/dataset.json", real);
        if (cli->io->ops->stat(cli->io, manifest, &st) == 0) {
            ttf_err_set(&cli->err, -EINVAL, path, "lies inside of the dataset %s", real);
            return ttf_err_hint(&cli->err, "give an -o outside of it"), -EINVAL;
        }
        slash = strrchr(real, '/');
        if (!slash || real[1] == '\0')
            return 0;
        slash[slash == real] = '\0';
    }
}

/* Stops at the first entry: the folder is not empty. */
static int any_entry(void *ctx, const char *name, bool is_dir)
{
    (void)name;
    (void)is_dir;
    *(bool *)ctx = true;
    return 1;
}

int cli_refuse_existing(struct cli *cli, const char *path)
{
    struct ttf_io_stat st;
    bool any = false;
    int r = cli->io->ops->stat(cli->io, path, &st);

    if (r == -ENOENT)
        return 0;
    if (r < 0)
        return ttf_err_set(&cli->err, r, path, "cannot be looked at: %s", strerrordesc_np(-r));
    if (st.is_dir) {
        r = cli->io->ops->list(cli->io, path, any_entry, &any);
        if (r >= 0 && !any)
            return 0;
    }
    ttf_err_set(&cli->err, -EEXIST, path, "exists already");
    ttf_err_hint(&cli->err, "nothing is overwritten: give another -o, or move it away first");
    return -EEXIST;
}
