/* SPDX-License-Identifier: Apache-2.0 */
/* The datasets of a run of chaos as one: which slots each of them holds, and whether one goes on where the other stopped. */
#include "chaos.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "second_run.h"
#include "second_storage.h"

int64_t chaos_boot_ns(const struct chaos *c, const char *boot_id)
{
    for (unsigned i = 0; i < c->n_boots; i++)
        if (strcmp(c->boots[i].id, boot_id) == 0)
            return c->boots[i].power_on_ns;
    return TTF_NS_UNKNOWN;
}

void chaos_part_path(const struct chaos *c, unsigned storage, char ret[128])
{
    struct sim_run second = second_run_of(&c->run);

    snprintf(ret, 128, "%s", storage == 0 ? c->run.path : second.path);
}

bool chaos_part_exists(const struct chaos *c, unsigned storage)
{
    struct stat st;
    char dataset[128], path[160];

    chaos_part_path(c, storage, dataset);
    snprintf(path, sizeof(path), "%s/dataset.json", dataset);
    return stat(path, &st) == 0;
}

/* The slots of the second are the second's, from its first segment on, whether it has taken one or not. */
static int64_t slots_before(const struct ttf_reader *reader, int64_t index)
{
    int64_t slots = ttf_reader_summary(reader)->slots, at;
    enum ttf_result result;

    while (ttf_reader_brief(reader, slots - 1, &at, &result) == 0 && at >= index)
        slots--;
    return slots;
}

static void divide(struct chaos_parts *parts)
{
    struct ttf_segment segment;

    for (unsigned i = 0; i < parts->n; i++)
        parts->part[i].slots = ttf_reader_summary(parts->part[i].reader)->slots;
    if (parts->n == 2 && ttf_reader_segment(parts->part[1].reader, 0, &segment) == 0)
        parts->part[0].slots = slots_before(parts->part[0].reader, segment.first_index);
}

bool chaos_parts_open(struct chaos *c, struct chaos_parts *ret)
{
    ret->n = 0;
    for (unsigned storage = 0; storage < 2; storage++) {
        struct chaos_part *part = &ret->part[ret->n];
        struct ttf_err err = {0};

        if (!chaos_part_exists(c, storage))
            continue;
        part->storage = storage;
        chaos_part_path(c, storage, part->path);
        if (ttf_reader_open(ttf_io_posix(), part->path, &part->reader, &err) < 0) {
            chaos_fail(c, "reader: %s: %s", err.where, err.what);
            chaos_parts_close(ret);
            return false;
        }
        /* One that a move made and did not begin is nothing to the run. */
        if (storage == 1 && ttf_reader_summary(part->reader)->n_segments == 0)
            ttf_reader_close(part->reader);
        else
            ret->n++;
    }
    divide(ret);
    return true;
}

void chaos_parts_close(struct chaos_parts *parts)
{
    for (unsigned i = 0; i < parts->n; i++)
        ttf_reader_close(parts->part[i].reader);
    parts->n = 0;
}

int64_t chaos_parts_last(const struct chaos_parts *parts)
{
    const struct chaos_part *part = &parts->part[parts->n - 1];
    struct ttf_segment segment;
    enum ttf_result result;
    int64_t last;

    if (parts->n == 0)
        return -1;
    if (ttf_reader_brief(part->reader, part->slots - 1, &last, &result) == 0)
        return last;
    return part->storage == 1 && ttf_reader_segment(part->reader, 0, &segment) == 0
               ? segment.first_index - 1
               : -1;
}

bool chaos_plan_load(const struct chaos_part *part, int plan, struct ttf_plan *ret)
{
    char path[160];
    char *text;
    size_t bytes;
    int r;

    snprintf(path, sizeof(path), "%s/plans/%d.json", part->path, plan);
    if (ttf_io_slurp(ttf_io_posix(), path, 1 << 20, &text, &bytes, NULL) < 0)
        return false;
    r = ttf_plan_read(text, bytes, path, ret, NULL);
    free(text);
    return r == 0;
}

/* ---- does the second go on where the first stopped? ---- */

static void check_group(struct chaos *c, const struct ttf_manifest *first,
                        const struct ttf_manifest *second)
{
    if (strcmp(first->group_uuid, first->uuid) != 0 ||
        strcmp(first->group_member, TTF_MEMBER_FIRST) != 0)
        chaos_fail(c, "the first is member '%s' of group %s, and is %s", first->group_member,
                   first->group_uuid, first->uuid);
    if (strcmp(second->group_uuid, first->uuid) != 0 ||
        strcmp(second->group_member, TTF_MEMBER_SECOND) != 0 ||
        strcmp(second->uuid, first->uuid) == 0)
        chaos_fail(c, "the second, %s, is member '%s' of group %s, and the first is %s",
                   second->uuid, second->group_member, second->group_uuid, first->uuid);
}

/* It begins with the first slot without a record; the failing disk may have taken that one's after all. */
static void check_begins(struct chaos *c, const struct ttf_reader *first,
                         const struct ttf_segment *segment)
{
    int64_t last =
        ttf_reader_summary(first)->slots > 0 ? ttf_reader_summary(first)->last_index : -1;

    if (segment->segment != 0)
        chaos_fail(c, "the second begins with segment %d", segment->segment);
    if (segment->first_index != last + 1 && segment->first_index != last)
        chaos_fail(c, "the second begins with slot %lld, and the first ends with %lld",
                   (long long)segment->first_index, (long long)last);
    if (ttf_reader_summary(first)->ended)
        chaos_fail(c, "the first was ended, though the run went on in the second");
}

/* A slot that both have is the same one. */
static void check_both(struct chaos *c, struct ttf_reader *first, struct ttf_reader *second,
                       int64_t index)
{
    struct ttf_slot_record a, b;
    int64_t in_first = ttf_reader_find(first, index), in_second = ttf_reader_find(second, index);

    if (in_first < 0 || in_second < 0 || ttf_reader_slot(first, in_first, &a, NULL) < 0)
        return;
    if (ttf_reader_slot(second, in_second, &b, NULL) == 0) {
        struct ttf_segment of_a, of_b;

        if (ttf_reader_segment(first, a.segment, &of_a) == 0 &&
            ttf_reader_segment(second, b.segment, &of_b) == 0 &&
            strcmp(of_a.boot_id, of_b.boot_id) == 0 && a.due_ns != b.due_ns)
            chaos_fail(c, "slot %lld is due %.3f s later in the second than in the first",
                       (long long)index, (double)(b.due_ns - a.due_ns) / 1e9);
        ttf_slot_record_free(&b);
    }
    ttf_slot_record_free(&a);
}

/* The segments of the first, and behind them the one that the second begins with. */
struct chain {
    int n;
    struct ttf_segment *segments;
};

static bool read_chain(struct ttf_reader *first, const struct ttf_segment *begun, struct chain *ret)
{
    ret->n = ttf_reader_summary(first)->n_segments + 1;
    ret->segments = calloc((size_t)ret->n, sizeof(*ret->segments));
    for (int i = 0; i + 1 < ret->n; i++)
        if (ret->segments && ttf_reader_segment(first, i, &ret->segments[i]) < 0)
            ret->n = 0;
    if (!ret->segments || ret->n < 2) {
        free(ret->segments);
        return false;
    }
    ret->segments[ret->n - 1] = *begun;
    return true;
}

static bool one_boot(const struct ttf_segment *a, const struct ttf_segment *b)
{
    return strcmp(a->boot_id, b->boot_id) == 0;
}

/* From where the first of a segment is due to where the first of the next one would be by its grid. */
static int64_t by_grid_ns(const struct ttf_segment *a, const struct ttf_segment *b)
{
    return (b->first_index - a->first_index) * a->interval_ns;
}

/* The run's own time since slot 0, as the segments of both add up: within a boot by its clock, over a boot by slots. */
static void check_run_time(struct chaos *c, const struct chain *chain)
{
    const struct ttf_segment *begun = &chain->segments[chain->n - 1];
    int64_t run_ns = begun->run_ns > 0 ? begun->run_ns : begun->first_index * begun->interval_ns;
    int64_t sum = 0;

    for (const struct ttf_segment *s = chain->segments; s < begun; s++)
        sum += one_boot(s, s + 1) ? s[1].origin_ns - s->origin_ns : by_grid_ns(s, s + 1);
    if (run_ns != sum)
        chaos_fail(c, "the second begins %.3f s after slot 0, by the first %.3f s",
                   (double)run_ns / 1e9, (double)sum / 1e9);
    if (one_boot(begun - 1, begun) && begun->gap_ns != 0)
        chaos_fail(c, "a gap before the second, in the boot that it was begun in");
}

/* Of outages of unknown length some end so soon that the slot which is taken at once comes before its time. */
static int64_t early_ns(const struct chaos *c, const struct chain *chain)
{
    int64_t sum = 0;

    for (int i = 1; i < chain->n; i++) {
        const struct ttf_segment *a = &chain->segments[i - 1], *b = a + 1;
        int64_t late = chaos_boot_ns(c, b->boot_id) + b->origin_ns - chaos_boot_ns(c, a->boot_id) -
                       a->origin_ns - by_grid_ns(a, b);

        if (!one_boot(a, b) && late < 0)
            sum -= late;
    }
    return sum;
}

/*
 * UTC of slot 0, by a clock that is right all the time, less outages that no slot stands for: when the run's first
 * segment has it due, though one before it may have been cut off; earlier by what slots came early.
 */
static void check_run_utc(struct chaos *c, const struct chain *chain)
{
    const struct ttf_segment *first = &chain->segments[0], *begun = &chain->segments[chain->n - 1];
    int64_t late_ns;

    if ((begun->run_utc_ns > 0) != (begun->run_trust[0] != '\0'))
        chaos_fail(c, "run_utc_ns %lld, run_trust '%s'", (long long)begun->run_utc_ns,
                   begun->run_trust);
    if (first->origin_utc_ns != TTF_NS_UNKNOWN && strcmp(first->trust, "none") != 0 &&
        begun->run_utc_ns == 0)
        chaos_fail(c, "the second does not know when slot 0 was due, and the first does");
    if (begun->run_utc_ns == 0 || chaos_any_step(c))
        return;
    late_ns = begun->run_utc_ns - c->run.config.start_utc_ns - chaos_boot_ns(c, first->boot_id) -
              first->origin_ns;
    if (late_ns > TTF_NS_PER_MS || late_ns < -early_ns(c, chain) - TTF_NS_PER_MS)
        chaos_fail(c, "by the second, slot 0 was due %.3f s later than it was",
                   (double)late_ns / 1e9);
}

void chaos_parts_check(struct chaos *c, const struct chaos_parts *parts)
{
    struct ttf_reader *first = parts->part[0].reader, *second = parts->part[1].reader;
    struct ttf_segment begun;
    struct chain chain;

    if (parts->n < 2 || ttf_reader_segment(second, 0, &begun) < 0)
        return;
    check_group(c, ttf_reader_manifest(first), ttf_reader_manifest(second));
    check_begins(c, first, &begun);
    check_both(c, first, second, begun.first_index);
    if (!read_chain(first, &begun, &chain))
        return;
    check_run_time(c, &chain);
    check_run_utc(c, &chain);
    free(chain.segments);
}
