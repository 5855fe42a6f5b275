/* SPDX-License-Identifier: Apache-2.0 */
/* main.c: ttfbox-lampd: the lamp guardian (hal/lampd/README.md) on the wires that a board describes. */
#include <errno.h>
#include <getopt.h>
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/config/board_file.h"
#include "ttf/hal/lampd.h"
#include "ttf/hal/sysfs.h"
#include "ttf/hal/systemd.h"
#include "wires.h"

struct lampd {
    struct ttf_board board;
    const char *socket;  /* given, or the board's */
    const char *sys;     /* where the kernel shows its devices */
    const char *notify;  /* NOTIFY_SOCKET; NULL: nobody listens */
    int64_t watchdog_ns; /* what the unit allows; 0: no watchdog */
    struct ttf_lamp_info info[TTF_LAMPS_MAX];
    struct ttf_clock *clock;
    struct ttf_lines *lines;
    struct ttf_sensors *sensors;
    struct ttf_watchdog *watchdog;
    struct ttf_lampd *guardian;
};

static volatile int stop_flag;

static void on_signal(int number)
{
    (void)number;
    stop_flag = 1;
}

static void usage(FILE *to)
{
    fputs("Usage: ttfbox-lampd --board BOARD [--socket PATH] [--sys FOLDER]\n"
          "Holds the lamps of a board and turns them off when a limit says so, or when nobody\n"
          "shows that they are still wanted. Ends on SIGTERM, with all lamps dark.\n\n"
          "  -b, --board BOARD   a board's name, or its board.yaml\n"
          "  -s, --socket PATH   where clients find it (default: the board's)\n"
          "  -y, --sys FOLDER    where sensors and PWM channels are shown (default: /sys)\n"
          "  -h, --help          this\n",
          to);
}

static int take_options(struct lampd *d, int argc, char **argv, const char **ret_board)
{
    static const struct option LONG[] = {{"board", required_argument, NULL, 'b'},
                                         {"socket", required_argument, NULL, 's'},
                                         {"sys", required_argument, NULL, 'y'},
                                         {"help", no_argument, NULL, 'h'},
                                         {NULL, 0, NULL, 0}};
    int c;

    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread runs yet */
    while ((c = getopt_long(argc, argv, "b:s:y:h", LONG, NULL)) != -1) {
        if (c == 'b')
            *ret_board = optarg;
        else if (c == 's')
            d->socket = optarg;
        else if (c == 'y')
            d->sys = optarg;
        else if (c == 'h')
            return 1;
        else
            return -EINVAL;
    }
    if (!*ret_board || optind != argc) {
        fprintf(stderr, "ttfbox-lampd: %s\n",
                *ret_board ? "there is an argument too many" : "--board is missing");
        return -EINVAL;
    }
    return 0;
}

static int load(struct lampd *d, const char *name, struct ttf_err *err)
{
    static const char *const FOLDERS[] = {"/etc/ttfbox/boards", "boards", TTFBOX_INSTALLED_BOARDS,
                                          NULL};
    char path[512];
    int r = ttf_board_locate(name, FOLDERS, path, sizeof path, err);

    if (r == 0)
        r = ttf_board_load(path, NULL, 0, &d->board, err);
    if (r == 0 && d->board.guardian.n_wires == 0) {
        ttf_err_set(err, -EINVAL, path,
                    "the board has no lamps with wires: there is nothing to guard");
        ttf_err_hint(err, "a lamp's wire is 'backend: gpiod' with 'chip' and 'line'");
        return -EINVAL;
    }
    for (unsigned i = 0; r == 0 && i < d->board.sim.n_lamps; i++)
        d->info[i] = d->board.sim.lamps[i].info;
    if (!d->socket)
        d->socket = d->board.guardian.socket;
    return r;
}

/* What the service manager put into the environment, before there are threads. */
static void learn_manager(struct lampd *d)
{
    d->notify = getenv("NOTIFY_SOCKET"); /* NOLINT(concurrency-mt-unsafe) */
    d->watchdog_ns = ttf_systemd_watchdog_ns();
}

static int open_all(struct lampd *d, struct ttf_err *err)
{
    const struct ttf_board_guardian *g = &d->board.guardian;
    int r =
        lampd_wires_open(&d->board, d->sys, &d->lines, err); /* first: dark, whatever comes after */

    if (r < 0)
        return r;
    d->clock = ttf_clock_real_create();
    if (!d->clock)
        return ttf_err_set(err, -errno, NULL, "the machine's clock cannot be had");
    if (d->board.n_sysfs > 0)
        r = ttf_sensors_sysfs_create(d->sys, d->board.sysfs, d->board.n_sysfs, d->clock,
                                     &d->sensors, err);
    if (r == 0 && d->notify && d->watchdog_ns > 0)
        r = ttf_watchdog_systemd_create(d->notify, d->watchdog_ns, &d->watchdog, err);
    if (r < 0)
        return r;
    const struct ttf_lampd_config config = {
        .socket = d->socket,
        .n = d->board.sim.n_lamps,
        .info = d->info,
        .lines = d->lines,
        .door = g->door,
        .clock = d->clock,
        .sensors = d->sensors,
        .temp_sensor = g->temp_sensor[0] ? g->temp_sensor : NULL,
        .watchdog = d->watchdog,
        .watchdog_ns = d->watchdog_ns,
    };

    return ttf_lampd_create(&config, &d->guardian, err);
}

static void catch_signals(void)
{
    struct sigaction action = {.sa_handler = on_signal};

    (void)sigaction(SIGTERM, &action, NULL);
    (void)sigaction(SIGINT, &action, NULL);
    action.sa_handler = SIG_IGN;
    (void)sigaction(SIGPIPE, &action, NULL);
    (void)sigaction(SIGHUP, &action, NULL);
}

static int say_error(const struct ttf_err *err)
{
    char text[900];

    fprintf(stderr, "ttfbox-lampd: %s\n", ttf_err_text(err, text, sizeof text));
    return err->code == -EINVAL || err->code == -ENOENT ? 2 : 1;
}

static void close_all(struct lampd *d)
{
    ttf_lines_destroy(d->lines); /* dark, before anything that may hang */
    ttf_lampd_destroy(d->guardian);
    ttf_watchdog_destroy(d->watchdog);
    ttf_sensors_destroy(d->sensors);
    ttf_clock_destroy(d->clock);
}

int main(int argc, char **argv)
{
    static struct lampd d = {.sys = "/sys"};
    struct ttf_err err = {0};
    const char *board = NULL;
    int r = take_options(&d, argc, argv, &board);

    if (r != 0) {
        usage(r > 0 ? stdout : stderr);
        return r > 0 ? 0 : 2;
    }
    catch_signals();
    learn_manager(&d);
    r = load(&d, board, &err);
    if (r == 0)
        r = open_all(&d, &err);
    if (r == 0) {
        (void)ttf_systemd_notify(d.notify, "READY=1\nSTATUS=guarding");
        printf("ttfbox-lampd: guarding %u lamp%s of board '%s' at %s\n", d.board.sim.n_lamps,
               d.board.sim.n_lamps == 1 ? "" : "s", d.board.name, d.socket);
        (void)fflush(stdout);
        r = ttf_lampd_run(d.guardian, &stop_flag);
        (void)ttf_systemd_notify(d.notify, "STOPPING=1");
    }
    close_all(&d);
    return r < 0 ? say_error(&err) : 0;
}
