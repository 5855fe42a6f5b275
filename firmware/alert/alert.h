/* SPDX-License-Identifier: Apache-2.0 */
/* alert.h: what the files of this program share (README.md). */
#ifndef ALERT_ALERT_H
#define ALERT_ALERT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/config/alerts_file.h"
#include "ttf/dataset/growth.h"
#include "ttf/dataset/io.h"
#include "ttf/hal/clock.h"

/* ---- an alert ---- */

struct alert {
    const char *kind; /* static */
    enum ttf_alert_severity severity;
    char text[400];
    char dataset[65]; /* empty: of none */
    int64_t index;    /* of the last slot recorded; -1: none */
    int64_t utc_ns;
};

#define ALERT_JSON_MAX 2048

/* One object, without a line end. Returns ret. */
const char *alert_json(const struct alert *alert, char ret[ALERT_JSON_MAX]);
/* A mail: headers, a blank line, words. Returns ret. */
const char *alert_mail(const struct alert *alert, const char *to, char ret[ALERT_JSON_MAX]);

/* What is told of goes here. */
typedef void alert_fn(void *ctx, const struct alert *alert);

/* ---- watch.c ---- */

struct watch {
    struct ttf_io *io;
    struct ttf_clock *clock;
    const char *folder;
    alert_fn *tell;
    void *ctx;
    /* the dataset under way; name empty: none */
    char name[65], path[4096];
    struct ttf_growth records, events;
    bool fresh; /* the first look at it: what lies there is no news */
    bool ended, stopped, losing;
    int64_t interval_ns, index, lost;
    int64_t
        seen_ns; /* when the last record was seen to come; of a dataset as it was found: when it was found */
};

/* Looks once. Errors of the disk are no alert by themselves: records do not come then. */
void watch_look(struct watch *watch);

/* When it is to look again, at the latest. */
int64_t watch_next_ns(const struct watch *watch, int64_t now_ns);

/* ---- parts.c ---- */

struct parts {
    const struct ttf_alerts_config *config;
    struct ttf_clock *clock;
    alert_fn *tell;
    void *ctx;
    int64_t gone_ns[TTF_ALERT_PARTS_MAX]; /* since when; 0: it answers */
    bool told[TTF_ALERT_PARTS_MAX];
};

void parts_look(struct parts *parts);

/* ---- hook.c ---- */

struct hook;

/* Starts its thread. config must outlive it. */
TTF_MUST_USE int hook_create(const struct ttf_alert_hook *config, struct ttf_clock *clock,
                             struct hook **ret, struct ttf_err *err);
/* Never waits for anything but a lock that is held for moments. */
void hook_put(struct hook *hook, const struct alert *alert);
/* Ends a try that is under way; what was not told is not. NULL allowed. */
void hook_destroy(struct hook *hook);

/* ---- one try: send_command.c, send_web.c. 0, or a negative errno with words that have no address in them ---- */

TTF_MUST_USE int send_command(const char *const argv[], const char *input, int64_t timeout_ns,
                              struct ttf_clock *clock, const volatile int *stop,
                              struct ttf_err *err);
/* json NULL: a GET */
TTF_MUST_USE int send_web(const char *url, const char *json, int64_t timeout_ns,
                          const volatile int *stop, struct ttf_err *err);

#endif
