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

/* ---- wanted.c: what ttfboxd is to do, as it stands on the disk: also while it is dead ---- */

enum wants {
    WANTS_NOTHING = 0, /* nobody asked for a run, or it is done */
    WANTS_RUN,
    WANTS_REST,  /* stopped by a person: so it is to stay */
    WANTS_PERSON /* nobody knows what was decided */
};

struct wanted {
    enum wants wants;
    char dataset[65]; /* of the run; empty: of none */
    char second[512]; /* its plan's second storage; empty: none */
    char why[512];    /* PERSON */
    bool known;
    struct ttf_io_stat seen[2]; /* of which files that is so: what was decided, the plan */
};

/* Looks once. What cannot be read now is as it was. */
void wanted_look(struct wanted *wanted, const struct ttf_alerts_config *config, struct ttf_io *io);

/* ---- watch.c: the dataset; judge.c: what follows from it ---- */

/* What the daemon says of itself just now, "" if it says nothing. */
typedef void says_fn(void *ctx, char *ret, size_t size);

struct watch {
    struct ttf_io *io;
    struct ttf_clock *clock;
    const struct ttf_alerts_config *config;
    alert_fn *tell;
    says_fn *says; /* NULL: nobody is asked */
    void *ctx;
    bool looked; /* at least once */
    struct wanted wanted;
    int64_t since_ns; /* since when that is wanted, as far as it was seen from here */
    /* the dataset under way; name empty: none */
    char name[65], path[4096];
    struct ttf_growth records, events;
    bool fresh; /* the first look at it: what lies there is no news */
    bool came;  /* a record has come since since_ns */
    bool ended, losing;
    bool stopped;          /* an alarm was told, and no record has come since */
    bool rests;            /* stopped by a person: so it was told */
    bool by_button;        /* that is to come, or has */
    bool doubted;          /* it has ended, and yet it may be wanted to go on */
    int64_t asked_ns;      /* when that was last asked, or settled */
    int64_t plan_mtime_ns; /* of the plan's file, as the end was seen */
    int64_t told_end_ns;   /* when its events said that it was told to end; TTF_NS_UNKNOWN */
    int64_t interval_ns, index, lost;
    struct ttf_segment segment; /* the last; segment -1: none */
    int64_t seen_ns;            /* when the last record was seen to come */
};

void watch_init(struct watch *watch, const struct ttf_alerts_config *config, struct ttf_io *io,
                struct ttf_clock *clock);

/* Looks once. Errors of the disk are no alert by themselves: records do not come then. */
void watch_look(struct watch *watch);

/* When it is to look again, at the latest. */
int64_t watch_next_ns(const struct watch *watch, int64_t now_ns);

/* An alert about the dataset. */
void watch_tell(struct watch *watch, const char *kind, enum ttf_alert_severity severity,
                const char *text);

/* What is to be told now. ended_before: its end had been seen before this look. */
void judge(struct watch *watch, bool ended_before);

/* ---- says.c ---- */

/* Asks ttfboxd at its UNIX socket for a moment: "retrying: the lamp guardian does not answer". */
void says_ask(const char *socket, char *ret, size_t size);

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

/* One try in the caller's thread, whatever the hook wishes to hear. 0, or as below. */
TTF_MUST_USE int hook_try(const struct ttf_alert_hook *config, struct ttf_clock *clock,
                          const volatile int *stop, const struct alert *alert, struct ttf_err *err);
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
