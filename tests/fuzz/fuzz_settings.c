/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A configuration of ttfboxd, as each of its readers takes it: the daemon, who needs the board alone, who tells people. What is
 * taken lies within its bounds.
 */
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"
#include "ttf/config/alerts_file.h"
#include "ttf/config/daemon_file.h"

static void check_daemon(const struct ttf_daemon_config *c)
{
    if (c->n_listen > TTF_DAEMON_LISTEN_MAX || c->n_names > TTF_DAEMON_NAMES_MAX ||
        c->n_sets > TTF_DAEMON_SETS_MAX || c->retry_ns < 0)
        abort();
}

static void check_alerts(const struct ttf_alerts_config *c)
{
    if (c->n_hooks > TTF_ALERT_HOOKS_MAX || c->n_parts > TTF_ALERT_PARTS_MAX || c->grace_ns < 0 ||
        c->begin_ns < 0 || c->heartbeat_every_ns < 0)
        abort();
    for (unsigned i = 0; i < c->n_hooks; i++)
        if (!*c->hooks[i].target || c->hooks[i].from < TTF_ALERT_NOTICE ||
            c->hooks[i].from > TTF_ALERT_ALARM || c->hooks[i].timeout_ns <= 0)
            abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct ttf_daemon_config *daemon = malloc(sizeof *daemon);
    struct ttf_alerts_config *alerts = malloc(sizeof *alerts);
    const char *text = (const char *)data;
    struct ttf_err err;

    if (daemon && ttf_daemon_file_parse("ttfboxd.yaml", text, size, daemon, &err) == 0)
        check_daemon(daemon);
    if (daemon && ttf_daemon_file_parse_board("ttfboxd.yaml", text, size, daemon, &err) == 0)
        check_daemon(daemon);
    if (alerts && ttf_alerts_file_parse("ttfboxd.yaml", text, size, alerts, &err) == 0)
        check_alerts(alerts);
    free(daemon);
    free(alerts);
    return 0;
}
