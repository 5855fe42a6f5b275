/* SPDX-License-Identifier: Apache-2.0 */
/* main.c: ttfbox-alertd: somebody is told (README.md). */
#include <curl/curl.h>
#include <errno.h>
#include <getopt.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alert.h"
#include "log.h"
#include "ttf/hal/systemd.h"

#define ALIVE_NS        (10 * TTF_NS_PER_S) /* a loop that looked within this is alive */
#define SLICE_NS        (100 * TTF_NS_PER_MS)
#define BEAT_TIMEOUT_NS (10 * TTF_NS_PER_S)

/* A signal handler can reach nothing but a global. */
static volatile int stop_asked;

static void on_stop(int number)
{
    (void)number;
    stop_asked = 1;
}

struct alertd {
    struct ttf_alerts_config config;
    struct ttf_clock *clock;
    struct hook *hooks[TTF_ALERT_HOOKS_MAX];
    struct watch watch;
    struct parts parts;
    pthread_t heart;
    bool has_heart;
    int64_t looked_ns; /* by the loop; read by the heart */
    int stopped;       /* the capture; so too */
};

static void usage(FILE *to)
{
    fputs("Usage: ttfbox-alertd --config FILE [--check | --try]\n"
          "Tells people by hooks what happens to a capture, and that it has stopped.\n\n"
          "  -c, --config FILE   ttfboxd's configuration: data and alerts\n"
          "      --check         reads it, and ends\n"
          "      --try           sends a trial to each hook, says what came of it, and ends\n"
          "      --version       the program's version\n"
          "  -h, --help          this\n\n"
          "Exit: 0 told to end, or the trial arrived everywhere; 1 failed, 2 the file is wrong.\n",
          to);
}

static void tell(void *ctx, const struct alert *alert)
{
    struct alertd *a = ctx;
    char quoted[500];

    log_line(alert->severity == TTF_ALERT_ALARM     ? LOG_LEVEL_ALERT
             : alert->severity == TTF_ALERT_WARNING ? LOG_LEVEL_WARNING
                                                    : LOG_LEVEL_NOTICE,
             alert->kind, "text=%s", log_text(alert->text, quoted, sizeof quoted));
    for (unsigned i = 0; i < a->config.n_hooks; i++)
        hook_put(a->hooks[i], alert);
}

static void says(void *ctx, char *ret, size_t size)
{
    const struct alertd *a = ctx;

    says_ask(a->config.http_at, ret, size);
}

/* ---- the heartbeat ---- */

static void *beat(void *ctx)
{
    struct alertd *a = ctx;
    int64_t next_ns = ttf_clock_now_ns(a->clock);
    bool failing = false;

    while (!stop_asked) {
        int64_t now_ns = ttf_clock_now_ns(a->clock);
        struct ttf_err err = {0};
        char why[300], quoted[400];

        if (now_ns < next_ns) {
            (void)ttf_clock_wait_until(a->clock,
                                       now_ns + SLICE_NS < next_ns ? now_ns + SLICE_NS : next_ns);
            continue;
        }
        next_ns = now_ns + a->config.heartbeat_every_ns;
        if (__atomic_load_n(&a->stopped, __ATOMIC_RELAXED) ||
            now_ns - __atomic_load_n(&a->looked_ns, __ATOMIC_RELAXED) > ALIVE_NS)
            continue; /* silence is the message */
        if (send_web(a->config.heartbeat, NULL, BEAT_TIMEOUT_NS, &stop_asked, &err) == 0) {
            failing = false;
            continue;
        }
        if (!failing && !stop_asked)
            log_line(LOG_LEVEL_WARNING, "heartbeat", "why=%s",
                     log_text(ttf_err_text(&err, why, sizeof why), quoted, sizeof quoted));
        failing = true;
    }
    return NULL;
}

/* ---- the trial: better today than in the third week ---- */

static int say_tried(const char *what, int r, const struct ttf_err *err)
{
    char why[300];

    if (r == 0)
        printf("%-20s took it\n", what);
    else
        printf("%-20s FAILED: %s\n", what, ttf_err_text(err, why, sizeof why));
    return r == 0 ? 0 : 1;
}

/* How many failed, at once and one after the other; nobody to tell is a failure, too. */
static int try_all(const struct alertd *a)
{
    struct alert alert = {.kind = "trial", .severity = TTF_ALERT_NOTICE, .index = -1};
    const struct ttf_alerts_config *c = &a->config;
    struct ttf_utc now;
    int failed = 0;

    ttf_clock_utc(a->clock, &now);
    alert.utc_ns = now.utc_ns;
    (void)snprintf(alert.text, sizeof alert.text,
                   "a trial: this is where alerts of the capture box come, and nothing is wrong");
    for (unsigned i = 0; i < c->n_hooks && !stop_asked; i++) {
        struct ttf_err err = {0};
        int r = hook_try(&c->hooks[i], a->clock, &stop_asked, &alert, &err);

        failed += say_tried(c->hooks[i].name, r, &err);
    }
    if (*c->heartbeat && !stop_asked) {
        struct ttf_err err = {0};
        int r = send_web(c->heartbeat, NULL, BEAT_TIMEOUT_NS, &stop_asked, &err);

        failed += say_tried("heartbeat", r, &err);
    }
    if (c->n_hooks == 0 && !*c->heartbeat) {
        puts("nobody would be told: alerts: names no hook and no heartbeat");
        failed++;
    }
    return failed + stop_asked;
}

/* ---- */

static int begin(struct alertd *a, struct ttf_err *err)
{
    int r = 0;

    watch_init(&a->watch, &a->config, ttf_io_posix(), a->clock);
    a->watch.tell = tell;
    a->watch.says = says;
    a->watch.ctx = a;
    a->parts = (struct parts){.config = &a->config, .clock = a->clock, .tell = tell, .ctx = a};
    for (unsigned i = 0; i < a->config.n_hooks && r == 0; i++)
        r = hook_create(&a->config.hooks[i], a->clock, &a->hooks[i], err);
    a->looked_ns = ttf_clock_now_ns(a->clock);
    if (r == 0 && *a->config.heartbeat) {
        r = -pthread_create(&a->heart, NULL, beat, a);
        a->has_heart = r == 0;
        if (r < 0)
            ttf_err_set(err, r, "heartbeat", "no thread to send it: %s", strerrordesc_np(-r));
    }
    return r;
}

static void live(struct alertd *a)
{
    while (!stop_asked) {
        int64_t now_ns = ttf_clock_now_ns(a->clock);

        watch_look(&a->watch);
        parts_look(&a->parts);
        __atomic_store_n(&a->stopped, a->watch.stopped, __ATOMIC_RELAXED);
        __atomic_store_n(&a->looked_ns, now_ns, __ATOMIC_RELAXED);
        (void)ttf_clock_wait_until(a->clock, watch_next_ns(&a->watch, now_ns));
    }
}

static void end(struct alertd *a)
{
    if (a->has_heart)
        (void)pthread_join(a->heart, NULL);
    for (unsigned i = 0; i < a->config.n_hooks; i++)
        hook_destroy(a->hooks[i]);
}

enum what {
    LIVE = 0,
    CHECK,
    TRY
};

/* A positive result: so many were not reached. */
static int run(const char *file, enum what what, struct ttf_err *err)
{
    struct alertd *a = calloc(1, sizeof *a);
    int r;

    if (!a)
        return ttf_err_set(err, -ENOMEM, file, "no memory to read it");
    r = ttf_alerts_file_load(file, &a->config, err);
    if (r == 0 && what != CHECK) {
        a->clock = ttf_clock_real_create();
        r = a->clock ? 0 : ttf_err_set(err, -errno, "clock", "the machine's clock cannot be had");
        if (r == 0 && curl_global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK)
            r = ttf_err_set(err, -ENOMEM, "alerts", "no memory to ask other machines");
        if (r == 0)
            r = what == TRY ? try_all(a) : begin(a, err);
        if (r == 0 && what == LIVE) {
            log_line(LOG_LEVEL_NOTICE, "started", "version=%s hooks=%u parts=%u heartbeat=%s",
                     TTFBOX_VERSION, a->config.n_hooks, a->config.n_parts,
                     *a->config.heartbeat ? "yes" : "no");
            live(a);
        }
        stop_asked = 1;
        end(a);
        ttf_clock_destroy(a->clock);
        curl_global_cleanup();
    }
    free(a);
    return r;
}

int main(int argc, char **argv)
{
    static const struct option LONG[] = {
        {"config", required_argument, NULL, 'c'}, {"check", no_argument, NULL, 'k'},
        {"try", no_argument, NULL, 't'},          {"version", no_argument, NULL, 'v'},
        {"help", no_argument, NULL, 'h'},         {NULL, 0, NULL, 0}};
    const struct sigaction action = {.sa_handler = on_stop};
    const struct sigaction ignore = {.sa_handler = SIG_IGN};
    const char *file = NULL;
    struct ttf_err err = {0};
    char why[700], quoted[800];
    enum what what = LIVE;
    int c, r;

    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread runs yet */
    while ((c = getopt_long(argc, argv, "c:h", LONG, NULL)) != -1) {
        if (c == 'c') {
            file = optarg;
        } else if (c == 'k') {
            what = CHECK;
        } else if (c == 't') {
            what = TRY;
        } else if (c == 'v') {
            puts("ttfbox-alertd " TTFBOX_VERSION);
            return 0;
        } else {
            usage(c == 'h' ? stdout : stderr);
            return c == 'h' ? 0 : 2;
        }
    }
    if (!file || optind != argc) {
        fprintf(stderr, "ttfbox-alertd: %s\n",
                file ? "an argument too many" : "--config is missing");
        return 2;
    }
    (void)sigaction(SIGTERM, &action, NULL);
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGPIPE, &ignore, NULL);
    r = run(file, what, &err);
    if (r < 0)
        log_line(LOG_LEVEL_ERROR, "failed", "why=%s",
                 log_text(ttf_err_text(&err, why, sizeof why), quoted, sizeof quoted));
    return r == 0 ? 0 : r == -EINVAL || r == -ENOENT ? 2 : 1;
}
