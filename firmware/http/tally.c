/* SPDX-License-Identifier: Apache-2.0 */
#include "tally.h"

#include <errno.h>
#include <string.h>

static int take_line(void *ctx, const struct ttf_growth_line *line, struct ttf_err *err)
{
    struct ttf_reader_summary *sum = ctx;
    struct ttf_slot_record record;
    struct ttf_segment segment;
    int r;

    if (strcmp(line->type, "end") == 0) {
        sum->ended = true;
        return 0;
    }
    if (strcmp(line->type, "segment") == 0) {
        r = ttf_growth_segment(line, &segment, err);
        if (r == 0 && segment.segment > sum->n_segments)
            r = -ENODATA;
        sum->n_segments += r == 0 && segment.segment == sum->n_segments;
        sum->ended = false;
        return r;
    }
    if (strcmp(line->type, "slot") != 0) {
        sum->ended =
            sum->ended && strcmp(line->type, "plan") != 0 && strcmp(line->type, "calibration") != 0;
        return 0;
    }
    r = ttf_growth_slot(line, &record, err);
    if (r < 0)
        return r;
    if ((sum->slots > 0 && record.index <= sum->last_index) || record.segment >= sum->n_segments)
        r = -ENODATA;
    sum->ended = false;
    sum->first_index = sum->slots == 0 ? record.index : sum->first_index;
    sum->last_index = record.index;
    sum->slots++;
    sum->counts[record.result]++;
    ttf_slot_record_free(&record);
    return r;
}

int tally_read(struct ttf_io *io, const char *records, struct tally *tally)
{
    struct ttf_io_stat st;
    int r = ttf_growth_read(io, records, &tally->growth, 0, take_line, &tally->summary, NULL);

    if (r == -ESTALE) {
        memset(tally, 0, sizeof *tally);
        r = ttf_growth_read(io, records, &tally->growth, 0, take_line, &tally->summary, NULL);
    }
    if (r == 0)
        r = io->ops->stat(io, records, &st);
    /* A line that came since is no reason: it is counted next time. One that is not whole may be: a crash left it. */
    if (r == 0 && (tally->growth.damaged > 0 || st.bytes > tally->growth.bytes))
        r = -ENODATA;
    if (r < 0 && r != -ENODATA)
        memset(tally, 0, sizeof *tally);
    return r;
}
