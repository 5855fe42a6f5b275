/* SPDX-License-Identifier: Apache-2.0 */
/* alerts_file.h: `alerts:` of ttfboxd's configuration. The language: firmware/config/README.md, "Alerts". */
#ifndef TTF_CONFIG_ALERTS_FILE_H
#define TTF_CONFIG_ALERTS_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

#define TTF_ALERT_HOOKS_MAX 8
#define TTF_ALERT_PARTS_MAX 8

enum ttf_alert_severity {
    TTF_ALERT_NOTICE = 0,
    TTF_ALERT_WARNING,
    TTF_ALERT_ALARM
};

enum ttf_alert_hook_kind {
    TTF_ALERT_COMMAND = 0, /* target: a program */
    TTF_ALERT_WEBHOOK,     /* a URL */
    TTF_ALERT_MAIL,        /* an address */
    TTF_ALERT_MQTT         /* a topic */
};

struct ttf_alert_hook {
    char name[32];
    int kind;          /* enum ttf_alert_hook_kind */
    char target[512];  /* secret */
    char host[128];    /* MQTT */
    char program[512]; /* MAIL, MQTT: instead of sendmail, mosquitto_pub; empty: those */
    int from;          /* enum ttf_alert_severity: the least that it is told */
    int64_t timeout_ns;
};

struct ttf_alert_part {
    char name[32];
    char socket[108]; /* that it listens on; empty: the preview's lock */
};

struct ttf_alerts_config {
    char data[512]; /* the folder of datasets */
    /* Of the daemon's own keys, as far as they can be read: a mistake in them is no reason to tell nobody. Empty: none */
    char plan[512];
    char dataset[65];  /* the name of the plan's */
    char state[512];   /* the folder where it leaves what is to run */
    char http_at[108]; /* the socket at which it can be asked what it does */
    unsigned n_hooks, n_parts;
    struct ttf_alert_hook hooks[TTF_ALERT_HOOKS_MAX];
    struct ttf_alert_part parts[TTF_ALERT_PARTS_MAX];
    int64_t grace_ns;    /* how long a part may be away */
    int64_t begin_ns;    /* how long a run may take to begin */
    char heartbeat[512]; /* a URL, secret; empty: none */
    int64_t heartbeat_every_ns;
};

/* Other keys of the file than `data` and `alerts` may hold whatever they do. Errors as ttf_board_load. */
TTF_MUST_USE int ttf_alerts_file_load(const char *path, struct ttf_alerts_config *ret,
                                      struct ttf_err *err);
TTF_MUST_USE int ttf_alerts_file_parse(const char *name, const char *text, size_t bytes,
                                       struct ttf_alerts_config *ret, struct ttf_err *err);

#endif
