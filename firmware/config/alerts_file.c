/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/config/alerts_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "decode.h"
#include "paths.h"
#include "ttf/base/time.h"
#include "ttf/config/daemon_file.h"

#define GRACE_NS   (5 * TTF_NS_PER_S)
#define BEGIN_NS   TTF_NS_PER_MIN
#define TIMEOUT_NS (10 * TTF_NS_PER_S)

/* A hook as it is written: one of the four says what it is. */
struct read_hook {
    struct ttf_alert_hook h;
    char command[512], webhook[512], mail[512], mqtt[512];
};

#define H(member) offsetof(struct read_hook, member)

static const struct cfg_name SEVERITIES[] = {
    {"notice", TTF_ALERT_NOTICE}, {"warning", TTF_ALERT_WARNING}, {"alarm", TTF_ALERT_ALARM}, {0}};

static const struct cfg_field HOOK[] = {
    {"command", cfg_path512, H(command), 0, 0, "a program, as /usr/local/bin/tell", 0, 0},
    {"webhook", cfg_path512, H(webhook), 0, 0, "a URL that is posted to", 0, 0},
    {"mail", cfg_path512, H(mail), 0, 0, "an address, as me@example.org", 0, 0},
    {"mqtt", cfg_path512, H(mqtt), 0, 0, "a topic, as ttfbox/alerts", 0, 0},
    {"host", cfg_text128, H(h.host), 0, 0, "the broker of mqtt, as localhost", 0, 0},
    {"program", cfg_path512, H(h.program), 0, 0, "instead of sendmail or mosquitto_pub", 0, 0},
    {"from", cfg_enum, H(h.from), 0, 0, "notice, warning or alarm", SEVERITIES, 0},
    {"timeout", cfg_i64_time, H(h.timeout_ns), 1e8, 3e11, "how long a try may take, as 10s", 0, 0},
    {0}};

static int name_it(struct yaml_node *node, char ret[32], struct ttf_err *err)
{
    size_t n = strlen(node->key);

    node->used = true;
    if (n == 0 || n > 31 || strspn(node->key, "abcdefghijklmnopqrstuvwxyz0123456789-") != n)
        return cfg_error_at_key(node, err, "as 'phone'", "a name of 1 to 31 of a-z 0-9 - is meant");
    memcpy(ret, node->key, n + 1);
    return 0;
}

static bool is_url(const char *text)
{
    return strncmp(text, "http://", 7) == 0 || strncmp(text, "https://", 8) == 0;
}

/* Also where it goes into a mail's header or a list of arguments. */
static bool is_plain(const char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text <= ' ' || *text == 0x7f)
            return false;
    return true;
}

static int finish_hook(struct yaml_node *node, struct read_hook *read, struct ttf_err *err)
{
    const char *const TARGETS[] = {read->command, read->webhook, read->mail, read->mqtt};
    int n = 0;

    for (int i = 0; i < 4; i++) {
        if (!*TARGETS[i])
            continue;
        read->h.kind = i;
        memcpy(read->h.target, TARGETS[i], sizeof read->h.target);
        n++;
    }
    if (n != 1)
        return cfg_error(node, err, "one of command, webhook, mail, mqtt",
                         n == 0 ? "it says nowhere to go" : "it goes to several places");
    if (read->h.kind == TTF_ALERT_WEBHOOK && !is_url(read->h.target))
        return cfg_error(yaml_child(node, "webhook"), err, "as https://...", "is no URL");
    if (read->h.kind == TTF_ALERT_MAIL &&
        (!strchr(read->h.target, '@') || !is_plain(read->h.target) || read->h.target[0] == '-'))
        return cfg_error(yaml_child(node, "mail"), err, "as me@example.org", "is no address");
    if (read->h.kind == TTF_ALERT_MQTT && !is_plain(read->h.target))
        return cfg_error(yaml_child(node, "mqtt"), err, "as ttfbox/alerts", "is no topic");
    if (read->h.kind == TTF_ALERT_COMMAND && read->h.target[0] != '/')
        return cfg_error(yaml_child(node, "command"), err, "a path from / on",
                         "programs are not looked for");
    return 0;
}

static int read_hooks(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err)
{
    struct ttf_alerts_config *config = at;

    if (node->kind != YAML_MAP || node->n > TTF_ALERT_HOOKS_MAX)
        return cfg_error(node, err, field->meant, "a map of at most %d hooks is meant",
                         TTF_ALERT_HOOKS_MAX);
    for (struct yaml_node *c = node->child; c; c = c->next) {
        struct read_hook read = {.h = {.timeout_ns = TIMEOUT_NS, .host = "localhost"}};
        int r = name_it(c, read.h.name, err);

        if (r == 0 && c->kind != YAML_MAP)
            r = cfg_error(c, err, "as {webhook: https://...}", "a map is meant");
        if (r == 0)
            r = cfg_map(HOOK, c, &read, err);
        if (r == 0)
            r = finish_hook(c, &read, err);
        if (r < 0)
            return r;
        config->hooks[config->n_hooks++] = read.h;
    }
    return 0;
}

static int read_parts(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err)
{
    struct ttf_alerts_config *config = at;

    if (node->kind != YAML_MAP || node->n > TTF_ALERT_PARTS_MAX)
        return cfg_error(node, err, field->meant, "a map of at most %d processes is meant",
                         TTF_ALERT_PARTS_MAX);
    for (struct yaml_node *c = node->child; c; c = c->next) {
        struct ttf_alert_part *part = &config->parts[config->n_parts];
        const char *text = cfg_scalar(c, field->meant, err);
        int r = text ? name_it(c, part->name, err) : -EINVAL;

        if (r < 0)
            return r;
        if (strcmp(text, "lock") != 0 && (text[0] != '/' || strlen(text) >= sizeof part->socket))
            return cfg_error(c, err, "the path of its socket, or 'lock' of ttfbox-preview",
                             "'%s' is neither", text);
        if (text[0] == '/')
            memcpy(part->socket, text, strlen(text) + 1);
        config->n_parts++;
    }
    return 0;
}

#define A(member) offsetof(struct ttf_alerts_config, member)

static const struct cfg_field ALERTS[] = {
    {"hooks", read_hooks, 0, 0, 0, "who is told, as {phone: {webhook: https://...}}", 0, 0},
    {"parts", read_parts, 0, 0, 0, "processes, as {daemon: /run/ttfbox/http.sock}", 0, 0},
    {"grace", cfg_i64_time, A(grace_ns), 1e8, 3.6e12, "how long a part may be away, as 5s", 0, 0},
    {"begin", cfg_i64_time, A(begin_ns), 1e9, 3.6e12, "how long a run may take to begin, as 1min",
     0, 0},
    {"heartbeat", cfg_path512, A(heartbeat), 0, 0, "a URL that is asked again and again", 0, 0},
    {"every", cfg_i64_time, A(heartbeat_every_ns), 1e8, 8.64e13, "how often, as 1min", 0, 0},
    {0}};

static const struct cfg_field WHOLE[] = {
    {"data", cfg_path512, A(data), 0, 0, "the folder of datasets, as 'data: /var/lib/ttfbox'", 0,
     true},
    {"alerts", cfg_section, 0, 0, 0, "who is told of what", ALERTS, 0},
    {0}};

/* ---- what is the daemon's: taken as it is meant to be, or not at all ---- */

static void take_text(const struct yaml_node *node, char *ret, size_t size)
{
    if (node && node->kind == YAML_SCALAR && strlen(node->text) < size)
        memcpy(ret, node->text, strlen(node->text) + 1);
}

static void take_dataset(const struct yaml_node *root, struct ttf_alerts_config *config)
{
    char name[128] = "";

    take_text(yaml_child(root, "dataset"), name, sizeof name);
    if (!*name)
        cfg_dataset_of_plan(config->plan, name);
    if (*config->plan && strlen(name) < sizeof config->dataset)
        memcpy(config->dataset, name, strlen(name) + 1);
}

/* The first UNIX socket that it listens at. */
static void take_http(const struct yaml_node *listen, struct ttf_alerts_config *config)
{
    const size_t n = strlen("unix:");
    const struct yaml_node *at = listen && listen->kind == YAML_LIST ? listen->child : NULL;
    char text[128] = "";

    if (!listen)
        (void)snprintf(text, sizeof text, "%s", TTF_DAEMON_LISTEN_UNIX);
    for (; at && !*text; at = at->next)
        if (at->kind == YAML_SCALAR && strncmp(at->text, "unix:", n) == 0)
            take_text(at, text, sizeof text);
    if (strlen(text) > n && strlen(text) - n < sizeof config->http_at)
        memcpy(config->http_at, text + n, strlen(text) - n + 1);
}

static void take_daemons(const char *file, const struct yaml_node *root,
                         struct ttf_alerts_config *config)
{
    take_text(yaml_child(root, "plan"), config->plan, sizeof config->plan);
    take_dataset(root, config);
    take_text(yaml_child(root, "state"), config->state, sizeof config->state);
    cfg_from_folder_of(file, config->plan);
    cfg_from_folder_of(file, config->state);
    /* What is not said lies in the data folder, which is found already. */
    if (!*config->state && snprintf(config->state, sizeof config->state, "%s/.ttfbox",
                                    config->data) >= (int)sizeof config->state)
        config->state[0] = '\0';
    take_http(yaml_child(root, "listen"), config);
}

static int read_all(struct ttf_alerts_config *config, const char *file, struct yaml_node *root,
                    struct ttf_err *err)
{
    const struct yaml_node *alerts = yaml_child(root, "alerts");
    int r;

    config->grace_ns = GRACE_NS;
    config->begin_ns = BEGIN_NS;
    config->heartbeat_every_ns = TTF_NS_PER_MIN;
    for (struct yaml_node *c = root->child; c; c = c->next)
        c->used = strcmp(c->key, "data") != 0 && strcmp(c->key, "alerts") != 0;
    r = cfg_map(WHOLE, root, config, err);
    if (r == 0 && *config->heartbeat && !is_url(config->heartbeat))
        return cfg_error(yaml_child(alerts, "heartbeat"), err, "as https://...", "is no URL");
    if (r < 0)
        return r;
    cfg_from_folder_of(file, config->data);
    take_daemons(file, root, config);
    return 0;
}

int ttf_alerts_file_parse(const char *name, const char *text, size_t bytes,
                          struct ttf_alerts_config *ret, struct ttf_err *err)
{
    struct ttf_alerts_config *read = calloc(1, sizeof *read);
    struct yaml_tree tree;
    int r;

    if (!read)
        return ttf_err_set(err, -ENOMEM, name, "no memory");
    r = yaml_tree_parse(name, "a configuration needs 'data'", text, bytes, &tree, err);
    if (r == 0) {
        r = tree.root->kind != YAML_MAP
                ? cfg_error(tree.root, err, "write 'data: FOLDER'", "a configuration holds keys")
                : read_all(read, name, tree.root, err);
        yaml_tree_free(&tree);
    }
    if (r == 0)
        *ret = *read;
    free(read);
    return r;
}

int ttf_alerts_file_load(const char *path, struct ttf_alerts_config *ret, struct ttf_err *err)
{
    char *text = NULL;
    size_t bytes = 0;
    int r = yaml_read_file(path, &text, &bytes, err);

    if (r < 0)
        return r;
    r = ttf_alerts_file_parse(path, text, bytes, ret, err);
    free(text);
    return r;
}
