/* SPDX-License-Identifier: Apache-2.0 */
/* sim_boot.c: see sim_boot.h. */
#include "sim_boot.h"

#include <errno.h>
#include <string.h>

#include "ttf/hal/clock.h"

/* What is known of the boot that is being walked. */
struct walk {
    char boot_id[37];
    int64_t zero_ns; /* since the first power-on, where its boot clock reads 0 */
    int64_t last_ns; /* since the first power-on, of its last record (or its beginning) */
};

/* A segment of another boot: the box came back, by its UTC or, unvouched for, after the outage. */
static void next_boot(struct walk *w, const struct ttf_segment *s,
                      const struct ttf_sim_config *config)
{
    bool first = !*w->boot_id;
    int64_t by_utc = TTF_NS_UNKNOWN;

    if (strcmp(s->trust, "none") != 0 && s->origin_utc_ns != TTF_NS_UNKNOWN)
        by_utc = s->origin_utc_ns - s->origin_ns - config->start_utc_ns;
    if (first) /* of a run gone on with in a second storage: not the box's first boot */
        w->zero_ns = s->first_index > 0 && by_utc > TTF_NS_PER_S ? by_utc : 0;
    else if (by_utc > w->last_ns)
        w->zero_ns = by_utc;
    else
        w->zero_ns = w->last_ns + config->outage_ns;
    w->last_ns = w->zero_ns;
    memcpy(w->boot_id, s->boot_id, sizeof w->boot_id);
}

/* How long ago, by the machine's clock, the first segment began. */
static int real_age(struct ttf_reader *reader, int64_t *ret_ns, struct ttf_err *err)
{
    struct ttf_clock *clock = ttf_clock_real_create();
    struct ttf_segment first;
    struct ttf_utc utc;
    int r;

    if (!clock)
        return ttf_err_set(err, -errno, "clock", "the machine's clock cannot be had");
    ttf_clock_utc(clock, &utc);
    r = ttf_reader_segment(reader, 0, &first);
    if (r == 0 && strcmp(first.boot_id, ttf_clock_boot_id(clock)) == 0)
        *ret_ns = utc.boot_ns - first.origin_ns;
    else if (r == 0 && first.origin_utc_ns != TTF_NS_UNKNOWN)
        *ret_ns = utc.utc_ns - first.origin_utc_ns;
    else
        *ret_ns = 0;
    if (*ret_ns < 0)
        *ret_ns = 0;
    ttf_clock_destroy(clock);
    return 0;
}

int sim_boot_power_on(struct ttf_reader *reader, const struct ttf_sim_config *config,
                      int64_t *ret_power_on_ns, struct ttf_err *err)
{
    const struct ttf_reader_summary *summary = ttf_reader_summary(reader);
    struct walk w = {{0}, 0, 0};
    int segment = -1;

    if (config->real_time)
        return real_age(reader, ret_power_on_ns, err);
    for (int64_t i = 0; i < summary->slots; i++) {
        struct ttf_slot_record record;
        int r = ttf_reader_slot(reader, i, &record, err);

        if (r < 0)
            return r;
        while (segment < record.segment) {
            struct ttf_segment s;

            if (ttf_reader_segment(reader, ++segment, &s) == 0 && strcmp(s.boot_id, w.boot_id) != 0)
                next_boot(&w, &s, config);
        }
        /* Slots that passed without power were due before this boot. */
        if (record.result != TTF_RESULT_POWER && record.due_ns > 0 &&
            w.zero_ns + record.due_ns > w.last_ns)
            w.last_ns = w.zero_ns + record.due_ns;
        ttf_slot_record_free(&record);
    }
    *ret_power_on_ns = w.last_ns + config->outage_ns;
    return 0;
}
