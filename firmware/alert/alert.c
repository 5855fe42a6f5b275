/* SPDX-License-Identifier: Apache-2.0 */
#include "alert.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "ttf/config/units.h"
#include "ttf/dataset/json_writer.h"

static const char *const SEVERITIES[] = {"notice", "warning", "alarm"};

static void machine(char ret[65])
{
    if (gethostname(ret, 65) < 0)
        ret[0] = '\0';
    ret[64] = '\0';
}

const char *alert_json(const struct alert *alert, char ret[ALERT_JSON_MAX])
{
    struct ttf_json json;
    const char *text;
    char box[65];
    size_t n;

    machine(box);
    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "kind", alert->kind);
    ttf_json_kstring(&json, "severity", SEVERITIES[alert->severity]);
    ttf_json_kstring(&json, "text", alert->text);
    if (*alert->dataset)
        ttf_json_kstring(&json, "dataset", alert->dataset);
    if (alert->index >= 0)
        ttf_json_kint(&json, "index", alert->index);
    ttf_json_kint(&json, "utc_ns", alert->utc_ns);
    ttf_json_kstring(&json, "box", box);
    ttf_json_object_end(&json);
    if (ttf_json_finish(&json, &text, &n) < 0 || n >= ALERT_JSON_MAX)
        text = "{\"kind\":\"alert\"}";
    (void)snprintf(ret, ALERT_JSON_MAX, "%s", text);
    ttf_json_free(&json);
    return ret;
}

/* On one line of plain letters, as a header wants it. */
static const char *plain(const char *text, char *ret, size_t size)
{
    size_t n = 0;

    for (; *text && n + 1 < size; text++)
        ret[n++] = *text < ' ' || *text > '~' ? '?' : *text;
    ret[n] = '\0';
    return ret;
}

const char *alert_mail(const struct alert *alert, const char *to, char ret[ALERT_JSON_MAX])
{
    char box[65], when[40], subject[160];

    machine(box);
    (void)snprintf(ret, ALERT_JSON_MAX,
                   "To: %s\nSubject: [ttfbox %s] %s: %s\nAuto-Submitted: auto-generated\n"
                   "Content-Type: text/plain; charset=utf-8\n\n"
                   "%s\n\nbox: %s\ndataset: %s\nlast slot: %lld\ntime: %s\n",
                   to, box, SEVERITIES[alert->severity],
                   plain(alert->text, subject, sizeof subject), alert->text, box,
                   *alert->dataset ? alert->dataset : "none", (long long)alert->index,
                   ttf_utc_format(alert->utc_ns, when, sizeof when));
    return ret;
}
