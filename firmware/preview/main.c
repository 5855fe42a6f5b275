/* SPDX-License-Identifier: Apache-2.0 */
/* main.c: ttfbox-preview: a small synthesis of the dataset under way, kept up to date (README.md). */
#include <errno.h>
#include <getopt.h>
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "log.h"
#include "preview.h"
#include "ttf/config/daemon_file.h"
#include "ttf/config/units.h"

#define LOOK_NS      (2 * TTF_NS_PER_S)
#define STOP_NS      (100 * TTF_NS_PER_MS) /* how soon a stop is seen */
#define IMAGES_MIN   8                     /* fewer show no evolution */
#define LOOK_MOST_NS (10 * TTF_NS_PER_MIN) /* from look to look where looking fails */
#define TRIES_MOST   5                     /* of the last refresh, of a dataset that has ended */
#define RETRY_WAIT \
    6 /* times --every before the second one (an hour), then twice as long each time */

/* A signal handler can reach nothing but a global. */
static volatile int stop_asked;

static void on_stop(int number)
{
    (void)number;
    stop_asked = 1;
}

static void usage(FILE *to)
{
    fputs("Usage: ttfbox-preview --folder FOLDER | --config FILE [OPTIONS]\n"
          "Keeps a small synthesis of the dataset under way in FOLDER/.preview, refreshed as it "
          "grows.\n"
          "Runs when nothing else wants to. Ends on SIGTERM.\n\n"
          "  -f, --folder FOLDER  of datasets\n"
          "  -c, --config FILE    ttfboxd's configuration: its data folder\n"
          "  -e, --every TIME     from refresh to refresh, at least (10min)\n"
          "  -m, --memory SIZE    for a synthesis (96MiB)\n"
          "  -t, --time TIME      for a synthesis, about (2min)\n"
          "  -r, --room SIZE      with less free it does nothing (1GiB)\n"
          "  -x, --ttfbox FILE    the program that synthesizes (ttfbox)\n"
          "  -u, --eager          takes its share of processor and disk, on a machine that "
          "captures nothing\n"
          "  -1, --once           one look, a refresh if it is due, and the end\n"
          "      --version        the program's version\n"
          "  -h, --help           this\n\n"
          "Exit: 0 told to end, or done; 1 failed; 2 an option or file is wrong.\n",
          to);
}

static int take_unit(enum ttf_unit_kind kind, const char *text, int64_t *ret)
{
    struct ttf_err err = {0};
    char why[300];
    int r = ttf_unit_parse(kind, text, ret, &err);

    if (r == 0 && *ret > 0)
        return 0;
    fprintf(stderr, "ttfbox-preview: '%s': %s\n", text,
            r < 0 ? ttf_err_text(&err, why, sizeof why) : "more than nothing is meant");
    return -EINVAL;
}

static int load_folder(const char *file, struct preview_options *o)
{
    struct ttf_daemon_config *config = malloc(sizeof *config);
    struct ttf_err err = {0};
    char why[700];
    int r = config ? ttf_daemon_file_load(file, config, &err) : -ENOMEM;

    if (r == 0) {
        memcpy(o->configured, config->data, sizeof o->configured);
        o->folder = o->configured;
    }
    if (r < 0)
        fprintf(stderr, "ttfbox-preview: %s\n", ttf_err_text(&err, why, sizeof why));
    free(config);
    return r < 0 ? -EINVAL : 0;
}

/* 0 go on, 1 ended well, -EINVAL. */
static int take_options(struct preview_options *o, int argc, char **argv)
{
    static const struct option LONG[] = {
        {"folder", required_argument, NULL, 'f'}, {"config", required_argument, NULL, 'c'},
        {"every", required_argument, NULL, 'e'},  {"memory", required_argument, NULL, 'm'},
        {"time", required_argument, NULL, 't'},   {"room", required_argument, NULL, 'r'},
        {"ttfbox", required_argument, NULL, 'x'}, {"eager", no_argument, NULL, 'u'},
        {"once", no_argument, NULL, '1'},         {"version", no_argument, NULL, 'v'},
        {"help", no_argument, NULL, 'h'},         {NULL, 0, NULL, 0}};
    int c, r = 0;

    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread runs */
    while (r == 0 && (c = getopt_long(argc, argv, "f:c:e:m:t:r:x:u1h", LONG, NULL)) != -1) {
        switch (c) {
        case 'f':
            o->folder = optarg;
            break;
        case 'c':
            r = load_folder(optarg, o);
            break;
        case 'e':
            r = take_unit(TTF_UNIT_TIME, optarg, &o->every_ns);
            break;
        case 'm':
            r = take_unit(TTF_UNIT_BYTES, optarg, &o->memory_bytes);
            break;
        case 't':
            r = take_unit(TTF_UNIT_TIME, optarg, &o->time_ns);
            break;
        case 'r':
            r = take_unit(TTF_UNIT_BYTES, optarg, &o->room_bytes);
            break;
        case 'x':
            o->ttfbox = optarg;
            break;
        case 'u':
            o->eager = true;
            break;
        case '1':
            o->once = true;
            break;
        case 'v':
            puts("ttfbox-preview " TTFBOX_VERSION);
            return 1;
        case 'h':
            usage(stdout);
            return 1;
        default:
            r = -EINVAL;
        }
    }
    if (r == 0 && o->folder && optind == argc)
        return 0;
    if (r == 0)
        fprintf(stderr, "ttfbox-preview: %s\n",
                o->folder ? "there is an argument too many" : "--folder or --config is missing");
    usage(stderr);
    return -EINVAL;
}

/* ---- a refresh ---- */

static int64_t utc_ns(struct ttf_clock *clock)
{
    struct ttf_utc utc;

    ttf_clock_utc(clock, &utc);
    return utc.utc_ns;
}

/* Whether the last one failed for what may have passed since: memory was short, or the processor taken. */
static bool is_worth_a_retry(const struct preview_options *o, const struct preview_subject *s,
                             const struct preview_cache *cache, int64_t now_utc_ns)
{
    int64_t waited_ns = now_utc_ns - cache->tried_utc_ns;

    if (!s->ended || cache->tries < 1 || cache->tries >= TRIES_MOST ||
        cache->tried_images != s->images || cache->images >= s->images)
        return false;
    /* A clock that was set back says nothing of how long it was. */
    return waited_ns < 0 || waited_ns >= (RETRY_WAIT << (cache->tries - 1)) * o->every_ns;
}

/* Is it worth another preview? */
static bool is_due(const struct preview_options *o, const struct preview_subject *s,
                   const struct preview_cache *cache, int64_t now_utc_ns)
{
    int64_t before = cache->images > cache->tried_images ? cache->images : cache->tried_images;

    if (s->images < IMAGES_MIN)
        return false;
    if (s->images <= before)
        return is_worth_a_retry(o, s, cache, now_utc_ns);
    return s->ended || s->images > before + before / 10;
}

static int refresh(const struct preview_options *o, struct ttf_io *io, struct ttf_clock *clock,
                   const struct preview_subject *subject, struct preview_cache *cache,
                   struct ttf_err *err)
{
    struct preview_made made = {0};
    char why[700], quoted[800];
    int r = preview_cache_begin(io, cache, err);

    if (r == 0)
        r = preview_synthesize(o, clock, subject, cache, err);
    if (r == 0)
        r = preview_strip(io, subject, cache, &made, err);
    if (r == 0)
        r = preview_cache_commit(io, cache, subject, &made, utc_ns(clock), err);
    if (r == 0) {
        log_line(LOG_LEVEL_INFO, "preview", "dataset=\"%s\" images=%" PRId64 " frames=%u",
                 subject->name, subject->images, made.n_frames);
        return 0;
    }
    if (r == -ECANCELED)
        return r;
    ttf_err_text(err, why, sizeof why);
    log_line(LOG_LEVEL_WARNING, "failed", "dataset=\"%s\" images=%" PRId64 " why=%s", subject->name,
             subject->images, log_text(why, quoted, sizeof quoted));
    return preview_cache_fail(io, cache, subject, why, utc_ns(clock), err);
}

static void rest(struct ttf_clock *clock, int64_t for_ns)
{
    int64_t until_ns = ttf_clock_now_ns(clock) + for_ns;

    while (!stop_asked && ttf_clock_now_ns(clock) < until_ns)
        (void)ttf_clock_wait_until(clock, ttf_clock_now_ns(clock) + STOP_NS);
}

/* Nothing is synthesized of raw frames: that is said once, and not tried. */
static int say_raw(const struct preview_options *o, struct ttf_io *io, struct ttf_clock *clock,
                   struct preview_subject *subject, struct ttf_err *err)
{
    struct preview_cache cache;
    int r = preview_cache_open(io, o->folder, subject, &cache, err);

    if (r == 0 && (!cache.kept || cache.tried_images > 0))
        r = preview_cache_fail(io, &cache, subject, "only raw frames: develop the dataset first",
                               utc_ns(clock), err);
    subject->raw_said = r == 0;
    preview_cache_close(&cache);
    return r;
}

/* One look; 0 also where there is nothing to do. */
static int look(const struct preview_options *o, struct ttf_io *io, struct ttf_clock *clock,
                struct preview_subject *subject, int64_t *last_ns, struct ttf_err *err)
{
    struct preview_cache cache;
    int r = preview_find(io, o->folder, subject, err);

    if (r < 0)
        return r == -ENOENT || r == -ESTALE ? 0 : r;
    if (subject->images == 0 && subject->raw >= IMAGES_MIN && !subject->raw_said)
        return say_raw(o, io, clock, subject, err);
    if (subject->images < IMAGES_MIN ||
        (*last_ns != TTF_NS_UNKNOWN && ttf_clock_now_ns(clock) - *last_ns < o->every_ns))
        return 0;
    r = preview_cache_open(io, o->folder, subject, &cache, err);
    if (r == 0 && is_due(o, subject, &cache, utc_ns(clock)) && preview_has_room(o, o->room_bytes)) {
        *last_ns = ttf_clock_now_ns(clock);
        preview_cache_sweep(io, o->folder);
        r = refresh(o, io, clock, subject, &cache, err);
    }
    preview_cache_close(&cache);
    return r;
}

/* What is wrong is said once, until something else is. */
static void complain(char said[700], const char *word, const char *text)
{
    char quoted[800];

    if (strcmp(said, text) == 0)
        return;
    log_line(LOG_LEVEL_WARNING, word, "why=%s", log_text(text, quoted, sizeof quoted));
    (void)snprintf(said, 700, "%s", text);
}

struct complaints {
    char failed[700], passed_over[700];
};

/* How long to rest now. The folder may be away for a while: whoever captures into it will see to it. */
static int64_t judge(struct complaints *said, const struct preview_subject *subject, int r,
                     struct ttf_err *err, int64_t rested_ns)
{
    char why[700];

    if (*subject->passed_over)
        complain(said->passed_over, "passed over", subject->passed_over);
    if (r >= 0 || r == -ECANCELED)
        return LOOK_NS;
    complain(said->failed, "retry", ttf_err_text(err, why, sizeof why));
    memset(err, 0, sizeof *err);
    return 2 * rested_ns < LOOK_MOST_NS ? 2 * rested_ns : LOOK_MOST_NS;
}

static int live(const struct preview_options *o, struct ttf_clock *clock, struct ttf_err *err)
{
    struct preview_subject *subject = calloc(1, sizeof *subject);
    struct complaints *said = calloc(1, sizeof *said);
    struct ttf_io *io = ttf_io_posix();
    int64_t last_ns = TTF_NS_UNKNOWN, rest_ns = LOOK_NS;
    int r = subject && said ? 0 : -ENOMEM, lock = -1;

    if (r == 0)
        r = lock = preview_cache_lock(io, o->folder, err);
    if (r >= 0)
        preview_cache_sweep(io, o->folder);
    while (r >= 0 && !stop_asked) {
        r = look(o, io, clock, subject, &last_ns, err);
        rest_ns = judge(said, subject, r, err, rest_ns);
        if (o->once)
            break;
        r = 0;
        rest(clock, rest_ns);
    }
    if (lock >= 0)
        (void)close(lock);
    free(said);
    free(subject);
    return r == -ECANCELED ? 0 : r;
}

int main(int argc, char **argv)
{
    struct preview_options o = {.ttfbox = "ttfbox",
                                .every_ns = 10 * TTF_NS_PER_MIN,
                                .memory_bytes = (int64_t)96 << 20,
                                .room_bytes = (int64_t)1 << 30,
                                .time_ns = 2 * TTF_NS_PER_MIN,
                                .stop = &stop_asked};
    const struct sigaction action = {.sa_handler = on_stop};
    struct ttf_clock *clock;
    struct ttf_err err = {0};
    char why[700];
    int r = take_options(&o, argc, argv);

    if (r)
        return r == 1 ? 0 : 2;
    (void)sigaction(SIGTERM, &action, NULL);
    (void)sigaction(SIGINT, &action, NULL);
    r = preview_be_humble(&o, &err);
    clock = ttf_clock_real_create();
    if (r == 0 && !clock)
        r = ttf_err_set(&err, -errno, "clock", "the machine's clock cannot be had");
    if (r == 0)
        r = live(&o, clock, &err);
    ttf_clock_destroy(clock);
    if (r < 0 && err.code)
        log_line(LOG_LEVEL_ERROR, "failed", "why=\"%s\"", ttf_err_text(&err, why, sizeof why));
    return r < 0 ? 1 : 0;
}
