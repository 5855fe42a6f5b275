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
#include "ttf/config/daemon_file.h"
#include "ttf/hal/lampd.h"
#include "ttf/hal/sysfs.h"
#include "ttf/hal/systemd.h"
#include "wires.h"

#define EXIT_NO_LAMPS 4

struct lampd {
    const char *board_name, *config_file; /* one of them */
    struct ttf_daemon_config config;      /* of config_file */
    struct ttf_board_set sets[TTF_DAEMON_SETS_MAX];
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
    fputs("Usage: ttfbox-lampd --board BOARD | --config FILE [--socket PATH] [--sys FOLDER]\n"
          "Holds the lamps of a board and turns them off when a limit says so, or when nobody\n"
          "shows that they are still wanted. Ends on SIGTERM, with all lamps dark.\n\n"
          "  -b, --board BOARD   a board's name, or its board.yaml\n"
          "  -c, --config FILE   ttfboxd's configuration: its board, with its changes of it\n"
          "  -s, --socket PATH   where clients find it (default: the board's)\n"
          "  -y, --sys FOLDER    where sensors and PWM channels are shown (default: /sys)\n"
          "      --version       the program's version\n"
          "  -h, --help          this\n\n"
          "Exit: 0 told to end, 1 failed, 2 a file is wrong, 4 this board has no lamps to guard.\n",
          to);
}

/* 0 go on, 1 ended well, -EINVAL. */
static int take_options(struct lampd *d, int argc, char **argv)
{
    static const struct option LONG[] = {{"board", required_argument, NULL, 'b'},
                                         {"config", required_argument, NULL, 'c'},
                                         {"socket", required_argument, NULL, 's'},
                                         {"sys", required_argument, NULL, 'y'},
                                         {"version", no_argument, NULL, 'v'},
                                         {"help", no_argument, NULL, 'h'},
                                         {NULL, 0, NULL, 0}};
    int c;

    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread runs yet */
    while ((c = getopt_long(argc, argv, "b:c:s:y:h", LONG, NULL)) != -1) {
        switch (c) {
        case 'b':
            d->board_name = optarg;
            break;
        case 'c':
            d->config_file = optarg;
            break;
        case 's':
            d->socket = optarg;
            break;
        case 'y':
            d->sys = optarg;
            break;
        case 'v':
            puts("ttfbox-lampd " TTFBOX_VERSION);
            return 1;
        case 'h':
            usage(stdout);
            return 1;
        default:
            usage(stderr);
            return -EINVAL;
        }
    }
    if ((!d->board_name) != (!d->config_file) && optind == argc)
        return 0;
    fprintf(stderr, "ttfbox-lampd: %s\n",
            optind != argc  ? "there is an argument too many"
            : d->board_name ? "--board and --config are one too many"
                            : "--board is missing");
    usage(stderr);
    return -EINVAL;
}

/* The daemon's board, so that the two cannot have two different ones; its other keys are none of the lamps' business. */
static int load_config(struct lampd *d, struct ttf_err *err)
{
    int r = ttf_daemon_file_load_board(d->config_file, &d->config, err);

    for (unsigned i = 0; r == 0 && i < d->config.n_sets; i++)
        d->sets[i] = (struct ttf_board_set){d->config.set[i].path, d->config.set[i].value};
    d->board_name = d->config.board;
    return r;
}

static int load(struct lampd *d, struct ttf_err *err)
{
    char path[512];
    int r = d->config_file ? load_config(d, err) : 0;

    if (r == 0)
        r = ttf_board_locate(d->board_name, ttf_daemon_board_folders(), path, sizeof path, err);
    if (r == 0)
        r = ttf_board_load(path, d->sets, d->config.n_sets, &d->board, err);
    if (r == 0 && d->board.guardian.n_wires == 0) {
        ttf_err_set(err, -EINVAL, path,
                    "the board has no lamps with wires: there is nothing to guard");
        ttf_err_hint(err, "a lamp's wire is 'backend: gpiod' with 'chip' and 'line'");
        /* Of a board by name a mistake; of the daemon's, a box without lamps: not to be tried again. */
        return d->config_file ? -ENODATA : -EINVAL;
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

/* Those that lamps are watched by, and no other: whose driver hangs keeps no temperature from the guardian. */
static int open_sensors(struct lampd *d, struct ttf_err *err)
{
    const char *name = d->board.guardian.temp_sensor;
    struct ttf_sysfs_sensor watched[TTF_SENSORS_MAX];
    unsigned n = 0;

    for (unsigned i = 0; i < d->board.n_sysfs; i++)
        if (d->board.sysfs[i].kind == TTF_SENSOR_TEMP_MDEGC &&
            (!*name || strcmp(d->board.sysfs[i].name, name) == 0))
            watched[n++] = d->board.sysfs[i];
    return n == 0 ? 0 : ttf_sensors_sysfs_create(d->sys, watched, n, d->clock, &d->sensors, err);
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
    r = open_sensors(d, err);
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

static int say_error(int r, const struct ttf_err *err)
{
    char text[900];

    fprintf(stderr, "ttfbox-lampd: %s\n", ttf_err_text(err, text, sizeof text));
    if (r == -ENODATA)
        return EXIT_NO_LAMPS;
    return err->code == -EINVAL || err->code == -ENOENT ? 2 : 1;
}

static void close_all(struct lampd *d)
{
    ttf_lines_destroy(d->lines); /* dark, before anything that may hang */
    ttf_watchdog_destroy(d->watchdog);
    if (ttf_lampd_destroy(d->guardian) < 0) {
        fputs("ttfbox-lampd: a temperature's driver hangs; ended without it\n", stderr);
        return;
    }
    ttf_sensors_destroy(d->sensors);
    ttf_clock_destroy(d->clock);
}

int main(int argc, char **argv)
{
    static struct lampd d = {.sys = "/sys"};
    struct ttf_err err = {0};
    int r = take_options(&d, argc, argv);

    if (r != 0)
        return r > 0 ? 0 : 2;
    catch_signals();
    learn_manager(&d);
    r = load(&d, &err);
    /* That is all it has to do here: who ends before it was ready has failed, to the manager, whatever it ends with. */
    if (r == -ENODATA)
        (void)ttf_systemd_notify(d.notify, "READY=1\nSTATUS=no lamps to guard");
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
    return r < 0 ? say_error(r, &err) : 0;
}
