/* SPDX-License-Identifier: Apache-2.0 */
/* main.c: ttfboxd: a plan, a board, a data folder, from boot to boot (README.md). */
#include <errno.h>
#include <getopt.h>
#include <signal.h>
#include <stdio.h>

#include "daemon.h"
#include "log.h"
#include "run.h"

/* A signal handler can reach nothing but a global. */
static volatile int stop_asked;

static void on_stop(int number)
{
    (void)number;
    stop_asked = DAEMON_STOP;
}

static void catch_signals(void)
{
    /* Once: a second one ends the program at once; what is committed is safe. */
    struct sigaction action = {.sa_handler = on_stop, .sa_flags = (int)SA_RESETHAND};

    (void)sigemptyset(&action.sa_mask);
    (void)sigaction(SIGTERM, &action, NULL);
    (void)sigaction(SIGINT, &action, NULL);
    action = (struct sigaction){.sa_handler = SIG_IGN};
    (void)sigaction(SIGPIPE, &action, NULL);
    (void)sigaction(SIGHUP, &action, NULL);
}

static void usage(FILE *to)
{
    fputs(
        "Usage: ttfboxd --config FILE\n"
        "Runs plans on a box, those of its configuration and those asked for by HTTP, goes on "
        "with\n"
        "them after each start, and stays until it is told to end (SIGTERM), which it does within\n"
        "a slot.\n\n"
        "  -c, --config FILE   which board, plan and data folder\n"
        "      --check         read configuration, board, plan and token, and end\n"
        "      --version       the program's version\n"
        "  -h, --help          this\n\n"
        "Exit: 0 told to end, 1 failed, 2 the configuration or the board is wrong.\n",
        to);
}

/* 0 go on, 1 ended well, -EINVAL. */
static int take_options(struct daemon_options *options, int argc, char **argv)
{
    static const struct option LONG[] = {{"config", required_argument, NULL, 'c'},
                                         {"check", no_argument, NULL, 'k'},
                                         {"version", no_argument, NULL, 'v'},
                                         {"help", no_argument, NULL, 'h'},
                                         {NULL, 0, NULL, 0}};
    int c;

    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread runs yet */
    while ((c = getopt_long(argc, argv, "c:h", LONG, NULL)) != -1) {
        switch (c) {
        case 'c':
            options->config = optarg;
            break;
        case 'k':
            options->check = true;
            break;
        case 'v':
            puts("ttfboxd " TTFBOX_VERSION);
            return 1;
        case 'h':
            usage(stdout);
            return 1;
        default:
            usage(stderr);
            return -EINVAL;
        }
    }
    if (options->config && optind == argc)
        return 0;
    fprintf(stderr, "ttfboxd: %s\n",
            options->config ? "there is an argument too many" : "--config is missing");
    usage(stderr);
    return -EINVAL;
}

int main(int argc, char **argv)
{
    struct daemon_options options = {.stop = &stop_asked};
    struct ttf_err err = {0};
    char text[900], quoted[1000];
    int r = take_options(&options, argc, argv);

    if (r != 0)
        return r > 0 ? 0 : 2;
    catch_signals();
    r = daemon_run(&options, &err);
    if (r < 0)
        log_line(LOG_LEVEL_ERROR, "failed", "why=%s",
                 log_text(ttf_err_text(&err, text, sizeof text), quoted, sizeof quoted));
    return run_exit_code(r);
}
