/* SPDX-License-Identifier: Apache-2.0 */
#include "alarms.h"

#include <stdio.h>
#include <string.h>

struct what_ends {
    const char *text;
    int64_t run;
};

typedef bool ends_fn(const struct alarm *alarm, const struct what_ends *what);

static bool take_away(struct alarms *alarms, ends_fn *ends, const struct what_ends *what)
{
    unsigned kept = 0, n = alarms->n;

    for (unsigned i = 0; i < n; i++)
        if (!ends(&alarms->kept[i], what))
            alarms->kept[kept++] = alarms->kept[i];
    alarms->n = kept;
    return kept < n;
}

static bool told_over(const struct alarm *alarm, const struct what_ends *what)
{
    return strcmp(alarm->text, what->text) == 0;
}

static bool over_when_armed(const struct alarm *alarm, const struct what_ends *what)
{
    return alarm->until == TTF_ALARM_UNTIL_ARMED ||
           (alarm->until == TTF_ALARM_UNTIL_NEW && alarm->run != what->run);
}

static bool over_when_done(const struct alarm *alarm, const struct what_ends *what)
{
    return alarm->until == TTF_ALARM_UNTIL_ARMED && alarm->run == what->run;
}

bool alarms_over(struct alarms *alarms, const char *text)
{
    return take_away(alarms, told_over, &(struct what_ends){.text = text});
}

bool alarms_armed(struct alarms *alarms, int64_t run)
{
    return take_away(alarms, over_when_armed, &(struct what_ends){.run = run});
}

bool alarms_done(struct alarms *alarms, int64_t run)
{
    return take_away(alarms, over_when_done, &(struct what_ends){.run = run});
}

void alarms_add(struct alarms *alarms, struct ttf_clock *clock, int64_t run,
                enum ttf_alarm_until until, const char *text)
{
    struct ttf_utc utc;
    struct alarm *alarm;

    ttf_clock_utc(clock, &utc);
    (void)alarms_over(alarms, text);
    if (alarms->n == ALARMS_KEPT)
        memmove(&alarms->kept[0], &alarms->kept[1], --alarms->n * sizeof alarms->kept[0]);
    alarm = &alarms->kept[alarms->n++];
    alarm->run = run;
    alarm->until = until;
    alarm->utc_ns = utc.trust == TTF_TRUST_NONE ? TTF_NS_UNKNOWN : utc.utc_ns;
    (void)snprintf(alarm->text, sizeof alarm->text, "%s", text);
}

void alarms_put(const struct alarms *alarms, struct ttf_json *json)
{
    ttf_json_array(json);
    for (unsigned i = 0; i < alarms->n; i++) {
        ttf_json_object(json);
        if (alarms->kept[i].utc_ns != TTF_NS_UNKNOWN)
            ttf_json_kint(json, "utc_ns", alarms->kept[i].utc_ns);
        ttf_json_kstring(json, "text", alarms->kept[i].text);
        ttf_json_object_end(json);
    }
    ttf_json_array_end(json);
}
