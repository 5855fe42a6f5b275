/* SPDX-License-Identifier: Apache-2.0 */
#include "alarms.h"

#include <stdio.h>
#include <string.h>

bool alarms_over(struct alarms *alarms, const char *text)
{
    unsigned kept = 0, n = alarms->n;

    for (unsigned i = 0; i < n; i++)
        if (strcmp(alarms->kept[i].text, text) != 0)
            alarms->kept[kept++] = alarms->kept[i];
    alarms->n = kept;
    return kept < n;
}

void alarms_add(struct alarms *alarms, struct ttf_clock *clock, const char *text)
{
    struct ttf_utc utc;
    struct alarm *alarm;

    ttf_clock_utc(clock, &utc);
    (void)alarms_over(alarms, text);
    if (alarms->n == ALARMS_KEPT)
        memmove(&alarms->kept[0], &alarms->kept[1], --alarms->n * sizeof alarms->kept[0]);
    alarm = &alarms->kept[alarms->n++];
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
