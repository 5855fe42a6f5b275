/* SPDX-License-Identifier: Apache-2.0 */
/* hook.c: a queue, a thread, tries. */
#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "alert.h"
#include "log.h"

#define SENDMAIL "/usr/sbin/sendmail"
#define QUEUE    64
#define FIRST_NS (5 * TTF_NS_PER_S) /* before it is tried again; doubled */
#define MOST_NS  (5 * TTF_NS_PER_MIN)
#define TRIED_NS (24 * TTF_NS_PER_H) /* then it is given up */
#define SLICE_NS (100 * TTF_NS_PER_MS)

struct hook {
    const struct ttf_alert_hook *config;
    struct ttf_clock *clock;
    pthread_t thread;
    volatile int stop;
    pthread_mutex_t lock; /* over all below */
    pthread_cond_t changed;
    struct alert queue[QUEUE];
    unsigned first, n;
    int64_t dropped; /* since the last that was told */
};

int hook_try(const struct ttf_alert_hook *c, struct ttf_clock *clock, const volatile int *stop,
             const struct alert *alert, struct ttf_err *err)
{
    char text[ALERT_JSON_MAX], line[ALERT_JSON_MAX + 1];
    const char *const command[] = {c->target, NULL};
    const char *const mail[] = {*c->program ? c->program : SENDMAIL, "-i", "-t", NULL};
    const char *const mqtt[] = {*c->program ? c->program : "mosquitto_pub",
                                "-h",
                                c->host,
                                "-t",
                                c->target,
                                "-q",
                                "1",
                                "-s",
                                NULL};

    switch (c->kind) {
    case TTF_ALERT_WEBHOOK:
        return send_web(c->target, alert_json(alert, text), c->timeout_ns, stop, err);
    case TTF_ALERT_MAIL:
        return send_command(mail, alert_mail(alert, c->target, text), c->timeout_ns, clock, stop,
                            err);
    case TTF_ALERT_MQTT:
        return send_command(mqtt, alert_json(alert, text), c->timeout_ns, clock, stop, err);
    default:
        (void)snprintf(line, sizeof line, "%s\n", alert_json(alert, text));
        return send_command(command, line, c->timeout_ns, clock, stop, err);
    }
}

static void rest(struct hook *hook, int64_t for_ns)
{
    int64_t until_ns = ttf_clock_now_ns(hook->clock) + for_ns;

    while (!hook->stop && ttf_clock_now_ns(hook->clock) < until_ns)
        (void)ttf_clock_wait_until(hook->clock, ttf_clock_now_ns(hook->clock) + SLICE_NS);
}

static void tell(struct hook *hook, const struct alert *alert)
{
    int64_t begun_ns = ttf_clock_now_ns(hook->clock), wait_ns = FIRST_NS;
    char why[300], quoted[400];

    while (!hook->stop) {
        struct ttf_err err = {0};
        int r = hook_try(hook->config, hook->clock, &hook->stop, alert, &err);
        bool over = ttf_clock_now_ns(hook->clock) - begun_ns > TRIED_NS;

        if (r == 0) {
            log_line(LOG_LEVEL_INFO, "told", "hook=%s kind=%s", hook->config->name, alert->kind);
            return;
        }
        if (hook->stop)
            return;
        log_line(LOG_LEVEL_WARNING, over ? "given-up" : "retry", "hook=%s kind=%s in_s=%.0f why=%s",
                 hook->config->name, alert->kind, (double)wait_ns / 1e9,
                 log_text(ttf_err_text(&err, why, sizeof why), quoted, sizeof quoted));
        if (over)
            return;
        rest(hook, wait_ns);
        wait_ns = 2 * wait_ns > MOST_NS ? MOST_NS : 2 * wait_ns;
    }
}

static void *work(void *ctx)
{
    struct hook *hook = ctx;

    (void)pthread_mutex_lock(&hook->lock);
    while (!hook->stop) {
        struct alert alert,
            dropped = {.kind = "dropped", .severity = TTF_ALERT_WARNING, .index = -1};

        if (hook->n == 0) {
            (void)pthread_cond_wait(&hook->changed, &hook->lock);
            continue;
        }
        alert = hook->queue[hook->first];
        hook->first = (hook->first + 1) % QUEUE;
        hook->n--;
        dropped.utc_ns = alert.utc_ns;
        (void)snprintf(dropped.text, sizeof dropped.text,
                       "%lld alerts could not be told, as this hook was away",
                       (long long)hook->dropped);
        if (hook->dropped == 0)
            dropped.kind = NULL;
        hook->dropped = 0;
        (void)pthread_mutex_unlock(&hook->lock);
        if (dropped.kind)
            tell(hook, &dropped);
        tell(hook, &alert);
        (void)pthread_mutex_lock(&hook->lock);
    }
    (void)pthread_mutex_unlock(&hook->lock);
    return NULL;
}

/* Said when it begins, not at the first alert of weeks. A name without a path is mosquitto_pub's. */
static void warn_of_missing(const struct ttf_alert_hook *c)
{
    const char *program = c->kind == TTF_ALERT_COMMAND ? c->target
                          : *c->program                ? c->program
                          : c->kind == TTF_ALERT_MAIL  ? SENDMAIL
                                                       : "";

    if (*program == '/' && access(program, X_OK) < 0)
        log_line(LOG_LEVEL_WARNING, "unreachable",
                 "hook=%s why=\"its program cannot be run: %s%s\"", c->name, strerrordesc_np(errno),
                 c->kind == TTF_ALERT_MAIL ? "; a package as msmtp-mta has /usr/sbin/sendmail"
                                           : "");
}

int hook_create(const struct ttf_alert_hook *config, struct ttf_clock *clock, struct hook **ret,
                struct ttf_err *err)
{
    struct hook *hook = calloc(1, sizeof *hook);
    int r;

    if (!hook)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    hook->config = config;
    hook->clock = clock;
    (void)pthread_mutex_init(&hook->lock, NULL);
    (void)pthread_cond_init(&hook->changed, NULL);
    r = -pthread_create(&hook->thread, NULL, work, hook);
    if (r < 0) {
        free(hook);
        return ttf_err_set(err, r, config->name, "no thread for a hook");
    }
    warn_of_missing(config);
    *ret = hook;
    return 0;
}

void hook_put(struct hook *hook, const struct alert *alert)
{
    if ((int)alert->severity < hook->config->from)
        return;
    (void)pthread_mutex_lock(&hook->lock);
    if (hook->n == QUEUE) {
        hook->first = (hook->first + 1) % QUEUE;
        hook->n--;
        hook->dropped++;
    }
    hook->queue[(hook->first + hook->n++) % QUEUE] = *alert;
    (void)pthread_cond_signal(&hook->changed);
    (void)pthread_mutex_unlock(&hook->lock);
}

void hook_destroy(struct hook *hook)
{
    if (!hook)
        return;
    (void)pthread_mutex_lock(&hook->lock);
    hook->stop = 1;
    (void)pthread_cond_broadcast(&hook->changed);
    (void)pthread_mutex_unlock(&hook->lock);
    (void)pthread_join(hook->thread, NULL);
    (void)pthread_cond_destroy(&hook->changed);
    (void)pthread_mutex_destroy(&hook->lock);
    free(hook);
}
