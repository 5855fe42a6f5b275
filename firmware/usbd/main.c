/* SPDX-License-Identifier: Apache-2.0 */
/*
 * main.c: ttfbox-usbd: joins the streams of a box's USB cable to the socket of its HTTP server (firmware/usb/README.md). It is
 * two processes: one opens ep0, keeps it, and runs the other, which does the work and may die.
 */
#include <errno.h>
#include <getopt.h>
#include <malloc.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "supervise.h"
#include "ttf/hal/clock.h"
#include "ttf/hal/systemd.h"
#include "ttf/usb/bridge.h"
#include "ttf/usb/functionfs.h"

#define DEFAULT_FOLDER "/run/ttfbox-usb"
#define FD_NAME        "ep0" /* to the service manager */
#define DEFAULT_SERVER "/run/ttfbox/http.sock"

struct usbd {
    const char *folder; /* where FunctionFS is mounted */
    const char *cable;  /* a simulated one instead; NULL */
    const char *server;
    int ep0; /* of the process that does the work; -1: this one is the other */
    const char *notify;
    enum ttf_usb_bridge_state said;
    bool said_any;
};

static volatile int stop_asked;
static volatile sig_atomic_t stop_signal;

static void on_stop(int number)
{
    (void)number;
    stop_asked = 1;
    stop_signal = 1;
}

static void usage(FILE *to)
{
    fputs("Usage: ttfbox-usbd [--functionfs FOLDER] [--server PATH]\n"
          "Joins the USB cable of a capture box to the socket of its HTTP server.\n\n"
          "  -f, --functionfs FOLDER  where FunctionFS is mounted (default: " DEFAULT_FOLDER ")\n"
          "  -s, --server PATH        the server's UNIX socket (default: " DEFAULT_SERVER ")\n"
          "      --cable PATH         a simulated cable instead, for tests\n"
          "      --version            the program's version\n"
          "  -h, --help               this\n\n"
          "Exit: 0 told to end, 1 failed, 2 wrong options.\n",
          to);
}

/* 0 go on, 1 ended well, -EINVAL. */
static int take_options(struct usbd *u, int argc, char **argv)
{
    static const struct option LONG[] = {{"functionfs", required_argument, NULL, 'f'},
                                         {"server", required_argument, NULL, 's'},
                                         {"cable", required_argument, NULL, 'c'},
                                         {"ep0", required_argument, NULL, 'e'}, /* our own */
                                         {"version", no_argument, NULL, 'v'},
                                         {"help", no_argument, NULL, 'h'},
                                         {NULL, 0, NULL, 0}};
    int c;

    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread runs */
    while ((c = getopt_long(argc, argv, "f:s:h", LONG, NULL)) != -1) {
        switch (c) {
        case 'f':
            u->folder = optarg;
            break;
        case 's':
            u->server = optarg;
            break;
        case 'c':
            u->cable = optarg;
            break;
        case 'e':
            u->ep0 = (int)strtol(optarg, NULL, 10);
            break;
        case 'v':
            puts("ttfbox-usbd " TTFBOX_VERSION);
            return 1;
        case 'h':
            usage(stdout);
            return 1;
        default:
            usage(stderr);
            return -EINVAL;
        }
    }
    if (optind == argc && strlen(u->server) < 108)
        return 0;
    fprintf(stderr, "ttfbox-usbd: %s\n",
            optind == argc ? "--server is too long for a socket's path"
                           : "there is an argument too many");
    usage(stderr);
    return -EINVAL;
}

static void catch_signals(void)
{
    struct sigaction action = {.sa_handler = on_stop};

    (void)sigaction(SIGTERM, &action, NULL);
    (void)sigaction(SIGINT, &action, NULL);
    action.sa_handler = SIG_IGN;
    (void)sigaction(SIGPIPE, &action, NULL);
    (void)sigaction(SIGHUP, &action, NULL);
}

/* What the bridge says: for the journal, and for the manager, which hears from here that the loop is alive. */
static void on_state(void *ctx, enum ttf_usb_bridge_state state, int error)
{
    static const char *const TEXTS[] = {"no PC is there", "a PC begins", "joined to a PC"};
    struct usbd *u = ctx;
    char text[80];

    (void)error;
    (void)ttf_systemd_notify(u->notify, "WATCHDOG=1");
    if (u->said_any && u->said == state)
        return;
    u->said_any = true;
    u->said = state;
    fprintf(stderr, "ttfbox-usbd: %s\n", TEXTS[state]);
    (void)snprintf(text, sizeof text, "STATUS=%s", TEXTS[state]);
    (void)ttf_systemd_notify(u->notify, text);
}

static int work(struct usbd *u, struct ttf_clock *clock, struct ttf_err *err)
{
    struct ttf_usb_bridge_config config = {.role = TTF_MUX_BOX,
                                           .clock = clock,
                                           .listen_fd = -1,
                                           .server = u->server,
                                           .tell = on_state,
                                           .tell_ctx = u,
                                           .stop = &stop_asked};
    int r = u->cable ? ttf_usb_pipe_create(u->cable, true, u->ep0, &config.link, err)
                     : ttf_usb_functionfs_create(u->folder, u->ep0, &config.link, err);

    if (r == 0)
        r = ttf_usb_bridge_run(&config, err);
    ttf_usb_link_destroy(config.link);
    return r;
}

/* Of a FunctionFS that was taken down since, ep0 is of no use; it would be used for ever. */
static bool is_of_folder(const struct usbd *u, int ep0)
{
    struct stat kept, there;

    if (u->cable || !u->folder)
        return true;
    return fstat(ep0, &kept) == 0 && stat(u->folder, &there) == 0 && kept.st_dev == there.st_dev;
}

/*
 * What must stay open: kept by the manager from the process before this one, with all that was written into it, so that the gadget
 * never came to be unbound; else opened, and given to the manager to keep.
 */
static int open_ep0(const struct usbd *u, struct ttf_err *err)
{
    int fd = ttf_systemd_kept_fd(FD_NAME);

    if (fd >= 0 && is_of_folder(u, fd)) {
        fputs("ttfbox-usbd: goes on with the gadget as it is\n", stderr);
        return fd;
    }
    if (fd >= 0) {
        (void)ttf_systemd_notify(u->notify, "FDSTOREREMOVE=1\nFDNAME=" FD_NAME);
        (void)close(fd);
    }
    fd =
        u->cable ? ttf_usb_pipe_connect(u->cable, err) : ttf_usb_functionfs_prepare(u->folder, err);
    /* FDPOLL=0: it is not for the manager to look whether anything has happened to it. */
    if (fd >= 0)
        (void)ttf_systemd_notify_fd(u->notify, "FDSTORE=1\nFDNAME=" FD_NAME "\nFDPOLL=0", fd);
    return fd;
}

/* Opens what must stay open, and runs this program again for the work. */
static int keep(const struct usbd *u, struct ttf_clock *clock, struct ttf_err *err)
{
    int fd = open_ep0(u, err);
    char number[16];
    const char *const again[] = {"/proc/self/exe",
                                 u->cable ? "--cable" : "--functionfs",
                                 u->cable ? u->cable : u->folder,
                                 "--server",
                                 u->server,
                                 "--ep0",
                                 number,
                                 NULL};

    if (fd < 0)
        return fd;
    (void)snprintf(number, sizeof number, "%d", fd);
    (void)ttf_systemd_notify(u->notify, "READY=1\nSTATUS=waiting for a PC");
    fprintf(stderr, "ttfbox-usbd: ready at %s\n", u->cable ? u->cable : u->folder);
    return supervise(again, fd, clock, &stop_signal);
}

int main(int argc, char **argv)
{
    static struct usbd u = {.folder = DEFAULT_FOLDER, .server = DEFAULT_SERVER, .ep0 = -1};
    struct ttf_err err = {0};
    struct ttf_clock *clock;
    char text[900];
    int r = take_options(&u, argc, argv);

    if (r != 0)
        return r > 0 ? 0 : 2;
    catch_signals();
    /* Windows of streams that are over go back to the system, instead of into the heap. */
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread runs */
    (void)mallopt(M_MMAP_THRESHOLD, 128 * 1024);
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread runs */
    u.notify = getenv("NOTIFY_SOCKET");
    clock = ttf_clock_real_create();
    if (!clock) {
        fprintf(stderr, "ttfbox-usbd: the machine's clock cannot be had: %s\n",
                strerrordesc_np(errno));
        return 1;
    }
    r = u.ep0 >= 0 ? work(&u, clock, &err) : keep(&u, clock, &err);
    ttf_clock_destroy(clock);
    if (r < 0)
        fprintf(stderr, "ttfbox-usbd: %s\n", ttf_err_text(&err, text, sizeof text));
    return r < 0 ? 1 : r;
}
