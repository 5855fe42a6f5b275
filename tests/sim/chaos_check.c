/* SPDX-License-Identifier: Apache-2.0 */
/* What must hold of a dataset, whatever happened to its box. */
#include "chaos.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "exposure.h"
#include "ttf/dataset/verify.h"

/* What a middle may be off without a flag, beyond the camera's bound. */
#define LATE_SLACK_NS TTF_NS_PER_MS

/* A reading of the door or of a lamp comes so much later than its exposure. */
#define READING_NS (200 * TTF_NS_PER_MS)

/* A step of UTC is seen at the next tick, and written then if the storage is there, behind the work that waits. */
#define SEEN_NS (10 * TTF_NS_PER_S)

struct walk {
    struct chaos *c;
    struct ttf_reader *reader; /* of the part that the record is of */
    struct ttf_slot_record record;
    struct ttf_segment segment;
    int64_t power_on_ns;      /* of the record's boot; TTF_NS_UNKNOWN */
    int64_t last_power_on_ns; /* of that of the slot before */
    int64_t last_due_ns;      /* since the first power-on, of the slot before */
    int64_t interval_ns;      /* of that one's segment */
    int64_t first_due_ns;     /* the same, of slot 0 */
    double first[TTF_PLAN_SHOTS_MAX][TTF_PLAN_BRACKETS_MAX]; /* mean of the first image of a kind */
    bool dimmed;                                             /* light may change without a flag */
    int64_t last_end_ns;                                     /* the same, of the exposure before */
};

static bool flagged(const struct ttf_image *image, const char *flag)
{
    return strstr(image->flags, flag) != NULL;
}

bool chaos_any_step(const struct chaos *c)
{
    for (unsigned i = 0; i < c->run.config.n_faults; i++)
        if (c->run.config.faults[i].kind == TTF_FAULT_CLOCK_STEP)
            return true;
    return false;
}

/* UTC was stepped while no run looked: nobody can tell that from an outage. */
static bool unseen_step(const struct chaos *c)
{
    const struct ttf_sim_config *config = &c->run.config;
    const int64_t work_ns = 18 * config->cost_commit_ns + 60 * config->cost_develop_ns;

    for (unsigned i = 0; i < config->n_faults; i++) {
        const struct ttf_fault *f = &config->faults[i];
        bool seen = false;

        if (f->kind != TTF_FAULT_CLOCK_STEP)
            continue;
        for (unsigned b = 0; b < c->n_boots; b++)
            seen |= !c->boots[b].storage_away && f->at_ns > c->boots[b].power_on_ns + SEEN_NS &&
                    f->at_ns < c->boots[b].ended_ns - SEEN_NS - work_ns;
        if (!seen || f->rate_per_million > 0)
            return true;
    }
    return false;
}

static int64_t since_power_on(const struct walk *w, int64_t boot_ns)
{
    return w->power_on_ns + boot_ns;
}

/* A fault of this kind and target, at a time, lasts over all of from..until. */
static bool fault_covers(const struct walk *w, enum ttf_fault_kind kind, const char *target,
                         int64_t from_ns, int64_t until_ns)
{
    const struct ttf_sim_config *config = &w->c->run.config;

    for (unsigned i = 0; i < config->n_faults; i++) {
        const struct ttf_fault *f = &config->faults[i];
        int64_t duration = f->duration_ns;

        if (f->kind != kind || f->rate_per_million > 0 || strcmp(f->target, target) != 0)
            continue;
        if (duration == 0)
            duration = kind == TTF_FAULT_DOOR_OPEN ? 10 * TTF_NS_PER_S : TTF_NS_PER_DAY * 365;
        if (f->at_ns <= from_ns && f->at_ns + duration >= until_ns)
            return true;
    }
    return false;
}

/* What the camera would grant of an exposure that nothing is wrong with. */
static int64_t grant_of(const struct ttf_sim_config *b, int64_t asked_ns)
{
    int64_t steps = (asked_ns + b->exposure_step_ns / 2) / b->exposure_step_ns;

    return steps * b->exposure_step_ns;
}

static void check_exposure(struct walk *w, const struct ttf_image *image,
                           const struct ttf_shot *shot, const struct ttf_exposure *planned)
{
    const struct ttf_sim_config *b = &w->c->run.config;
    int64_t took = shot->end_ns - shot->start_ns - shot->granted.exposure_ns;

    if (took > 2 * b->jitter_ns + b->readout_ns + 1 || took < -2 * b->jitter_ns - 1)
        chaos_fail(w->c, "slot %lld: exposed %.3f ms, said to be %.3f ms",
                   (long long)w->record.index, (double)(shot->end_ns - shot->start_ns) / 1e6,
                   (double)shot->granted.exposure_ns / 1e6);
    if (flagged(image, "wrong-settings"))
        return;
    if (llabs(shot->granted.exposure_ns - grant_of(b, planned->exposure_ns)) > b->exposure_step_ns)
        chaos_fail(w->c, "slot %lld, %s: %.3f ms without a flag, the plan says %.3f ms",
                   (long long)w->record.index, image->stream,
                   (double)shot->granted.exposure_ns / 1e6, (double)planned->exposure_ns / 1e6);
    if (llabs((int64_t)shot->granted.gain_milli - (int64_t)planned->gain_milli) >
        b->gain_step_milli)
        chaos_fail(w->c, "slot %lld: gain %u without a flag, the plan says %u",
                   (long long)w->record.index, shot->granted.gain_milli, planned->gain_milli);
}

/* Light that was not as planned is flagged. */
static void check_light(struct walk *w, const struct ttf_image *image, const struct ttf_shot *shot)
{
    int64_t from = since_power_on(w, shot->start_ns);
    int64_t until = since_power_on(w, shot->end_ns);

    if (w->c->run.config.door_switch && fault_covers(w, TTF_FAULT_DOOR_OPEN, "", from, until) &&
        !flagged(image, "door-open"))
        chaos_fail(w->c, "slot %lld, %s: exposed with the door open, no flag",
                   (long long)w->record.index, image->stream);
    for (unsigned i = 0; i < shot->n_lamps; i++) {
        const struct ttf_shot_lamp *lamp = &shot->lamps[i];

        if (lamp->commanded_permille >= 300 &&
            fault_covers(w, TTF_FAULT_LAMP_DEAD, lamp->name, from, until + READING_NS) &&
            !flagged(image, "lamp-level") && !flagged(image, "lamp-tripped"))
            chaos_fail(w->c, "slot %lld, %s: lamp %s was dead, no flag", (long long)w->record.index,
                       image->stream, lamp->name);
    }
}

/* The lamps burnt as the plan says, or a flag says that they did not. */
static void check_lamps(struct walk *w, const struct ttf_image *image, const struct ttf_shot *shot,
                        const struct ttf_plan_shot *plan)
{
    for (unsigned i = 0; i < shot->n_lamps; i++) {
        int wanted = 0;

        for (unsigned k = 0; k < plan->n_levels; k++)
            if (strcmp(plan->levels[k].lamp, shot->lamps[i].name) == 0)
                wanted = (int)plan->levels[k].permille;
        if (shot->lamps[i].commanded_permille != wanted)
            chaos_fail(w->c, "slot %lld, %s: lamp %s commanded %d, the plan says %d",
                       (long long)w->record.index, image->stream, shot->lamps[i].name,
                       shot->lamps[i].commanded_permille, wanted);
    }
    if (w->c->run.plan.lamps != TTF_LAMPS_NONE && shot->n_lamps != w->c->run.config.n_lamps)
        chaos_fail(w->c, "slot %lld: %u lamps in the record", (long long)w->record.index,
                   shot->n_lamps);
}

/* A dark picture of what was lit, or a bright one of the dark, says so. */
static void check_level(struct walk *w, const struct ttf_image *image,
                        const struct ttf_plan_shot *plan)
{
    unsigned light = 0;

    for (unsigned i = 0; i < plan->n_levels; i++)
        light += plan->levels[i].permille;
    if (image->flags[0] != '\0' || !(image->mean_level == image->mean_level))
        return;
    if (light == 0 && image->mean_level > 0.3 && w->c->run.config.door_switch)
        chaos_fail(w->c, "slot %lld, %s: mean %.3f without light, no flag",
                   (long long)w->record.index, image->stream, image->mean_level);
    if (light >= 900 && plan->exposure.exposure_ns >= 20 * TTF_NS_PER_MS &&
        image->mean_level < 0.005)
        chaos_fail(w->c, "slot %lld, %s: mean %.4f in full light, no flag",
                   (long long)w->record.index, image->stream, image->mean_level);
}

/* The chart does not change: images of a kind are about equally bright, or say why not. */
static void check_like(struct walk *w, const struct ttf_image *image, double *first)
{
    if (image->flags[0] != '\0' || !(image->mean_level > 0.01) || w->dimmed)
        return;
    if (*first == 0)
        *first = image->mean_level;
    if (image->mean_level < *first * 0.75 || image->mean_level > *first * 1.33)
        chaos_fail(w->c, "slot %lld, %s: mean %.3f, the first was %.3f, no flag",
                   (long long)w->record.index, image->stream, image->mean_level, *first);
}

static void check_files(struct walk *w, const struct ttf_image *image)
{
    enum ttf_keep keep = w->c->run.plan.keep;
    unsigned want = keep == TTF_KEEP_RAW || keep == TTF_KEEP_DEVELOPED ? 1 : 2;

    if (image->lacking[0] != '\0') {
        if (image->n_files > 0)
            chaos_fail(w->c, "slot %lld: lacking, but has files", (long long)w->record.index);
        return;
    }
    if (image->n_files != want && !flagged(image, "-lost"))
        chaos_fail(w->c, "slot %lld, %s: %u files of %u, no flag", (long long)w->record.index,
                   image->stream, image->n_files, want);
    if (image->n_files == 0)
        chaos_fail(w->c, "slot %lld, %s: no files", (long long)w->record.index, image->stream);
}

/* Image `bracket` of shot `s`. */
static void check_image(struct walk *w, const struct ttf_image *image, unsigned s, unsigned bracket)
{
    const struct ttf_plan *plan = &w->c->run.plan;
    struct ttf_exposure planned = ttf_shot_exposure(&plan->shots[s], bracket, plan->mains_hz,
                                                    w->c->run.config.exposure_max_ns);
    /* A rolling shutter begins the next frame while the last rows are read. */
    int64_t overlap = 2 * w->c->run.config.jitter_ns + w->c->run.config.readout_ns;
    unsigned good = 0;

    if (strcmp(image->stream, plan->shots[s].stream) != 0)
        chaos_fail(w->c, "slot %lld: image of %s where %s should be", (long long)w->record.index,
                   image->stream, plan->shots[s].stream);
    check_files(w, image);
    for (unsigned i = 0; i < image->n_shots; i++) {
        const struct ttf_shot *shot = &image->shots[i];

        if (shot->start_ns == TTF_NS_UNKNOWN)
            continue;
        /* A frame exposed too long by a fault reaches into the one before it, in this box. */
        if (shot->granted.exposure_ns <= planned.exposure_ns + w->c->run.config.exposure_step_ns &&
            since_power_on(w, shot->start_ns) < w->last_end_ns - overlap)
            chaos_fail(w->c, "slot %lld: an exposure began before the one before it ended",
                       (long long)w->record.index);
        w->last_end_ns = since_power_on(w, shot->end_ns);
        if (shot->refused[0] != '\0')
            continue;
        good++;
        check_exposure(w, image, shot, &planned);
        check_light(w, image, shot);
        check_lamps(w, image, shot, &plan->shots[s]);
    }
    if (image->lacking[0] != '\0')
        return;
    check_level(w, image, &plan->shots[s]);
    check_like(w, image, &w->first[s][bracket]);
    if (good != image->n_averaged || good == 0)
        chaos_fail(w->c, "slot %lld: %u good shots, %u averaged", (long long)w->record.index, good,
                   image->n_averaged);
    if (good < plan->shots[s].average && !flagged(image, "short-average"))
        chaos_fail(w->c, "slot %lld: %u of %u averaged, no flag", (long long)w->record.index, good,
                   plan->shots[s].average);
}

static void check_middle(struct walk *w)
{
    const struct ttf_slot_record *record = &w->record;
    const struct ttf_sim_config *b = &w->c->run.config;
    const struct ttf_image *image = &record->images[0];
    int64_t bound = b->jitter_ns + LATE_SLACK_NS +
                    (b->steerable ? b->readout_ns / b->height : b->frame_period_ns / 2 + 1);
    int64_t exposure = 0;

    for (unsigned i = 0; i < image->n_shots; i++)
        if (image->shots[i].refused[0] == '\0')
            exposure = image->shots[i].granted.exposure_ns;
    /* A long exposure makes its frame longer. */
    if (!b->steerable && exposure > b->frame_period_ns)
        bound += exposure / 2;
    if (image->lacking[0] != '\0' || flagged(image, "late"))
        return;
    if (record->middle_ns == TTF_NS_UNKNOWN || llabs(record->middle_ns - record->due_ns) > bound)
        chaos_fail(w->c, "slot %lld: middle off by %.3f ms, no flag", (long long)record->index,
                   (double)(record->middle_ns - record->due_ns) / 1e6);
}

/*
 * With a clock that is kept, the grid is the first boot's for ever, and within a boot in any case, wherever it is written;
 * with another interval the next slot comes one of these later, or the first multiple that can be reached.
 */
static int64_t off_grid(const struct walk *w, int64_t due)
{
    int64_t interval = w->segment.interval_ns, step = due - w->last_due_ns;

    /* It may have been another in between, for no slot. */
    if ((interval == w->interval_ns && !chaos_asks_may_change(w->c)) || step < interval)
        return step - interval;
    return (step + interval / 2) % interval - interval / 2;
}

static void check_times(struct walk *w)
{
    struct chaos *c = w->c;
    int64_t due = since_power_on(w, w->record.due_ns);
    int64_t utc = ttf_reader_due_utc_ns(w->reader, &w->record);

    if (due <= w->last_due_ns && !unseen_step(c))
        chaos_fail(c, "slot %lld is due %.3f s before the one before it",
                   (long long)w->record.index, (double)(w->last_due_ns - due) / 1e9);
    if (w->record.index > 0 &&
        (w->power_on_ns == w->last_power_on_ns || (c->run.config.rtc && !unseen_step(c))) &&
        llabs(off_grid(w, due)) > TTF_NS_PER_MS)
        chaos_fail(c, "slot %lld left the grid by %.3f s", (long long)w->record.index,
                   (double)off_grid(w, due) / 1e9);
    if (utc != TTF_NS_UNKNOWN && !chaos_any_step(c) &&
        llabs(utc - c->run.config.start_utc_ns - due) > TTF_NS_PER_MS)
        chaos_fail(c, "slot %lld: UTC off by %.3f s", (long long)w->record.index,
                   (double)(utc - c->run.config.start_utc_ns - due) / 1e9);
    if (w->record.index == 0)
        w->first_due_ns = due;
    w->last_due_ns = due;
    w->last_power_on_ns = w->power_on_ns;
    w->interval_ns = w->segment.interval_ns;
}

static void find_boot(struct walk *w)
{
    w->power_on_ns = TTF_NS_UNKNOWN;
    if (ttf_reader_segment(w->reader, w->record.segment, &w->segment) < 0) {
        chaos_fail(w->c, "slot %lld has no segment", (long long)w->record.index);
        return;
    }
    w->power_on_ns = chaos_boot_ns(w->c, w->segment.boot_id);
    if (w->power_on_ns == TTF_NS_UNKNOWN)
        chaos_fail(w->c, "slot %lld is of a boot that was not", (long long)w->record.index);
}

static void check_slot(struct walk *w, int64_t index)
{
    struct ttf_slot_record *record = &w->record;
    const struct ttf_plan *plan = &w->c->run.plan;
    unsigned image = 0;

    if (record->index != index)
        chaos_fail(w->c, "slot %lld where %lld should be", (long long)record->index,
                   (long long)index);
    if (record->result != TTF_RESULT_CAPTURED && record->reason[0] == '\0')
        chaos_fail(w->c, "slot %lld: %s without a reason", (long long)index,
                   ttf_result_name(record->result));
    if (record->result == TTF_RESULT_PAUSED && !chaos_asks_may_pause(w->c, index))
        chaos_fail(w->c, "slot %lld: paused by nobody", (long long)index);
    find_boot(w);
    if (w->power_on_ns == TTF_NS_UNKNOWN)
        return;
    check_times(w);
    if (record->result != TTF_RESULT_CAPTURED && record->result != TTF_RESULT_PARTIAL)
        return;
    for (unsigned s = 0; s < plan->n_shots; s++)
        for (unsigned b = 0; b < ttf_shot_images(&plan->shots[s]); b++, image++)
            if (image < record->n_images)
                check_image(w, &record->images[image], s, b);
    if (image != record->n_images)
        chaos_fail(w->c, "slot %lld: %u images of %u", (long long)index, record->n_images, image);
    check_middle(w);
}

/* It has as many slots as the plan in force says; of one that ends in time those due before its end. */
static void check_length(struct walk *w, const struct chaos_part *part, int64_t slots)
{
    struct chaos *c = w->c;
    struct ttf_segment last;
    struct ttf_plan plan;
    int64_t end_ns = TTF_NS_UNKNOWN;

    if (ttf_reader_segment(part->reader, ttf_reader_summary(part->reader)->n_segments - 1, &last) <
            0 ||
        !chaos_plan_load(part, last.plan, &plan)) {
        chaos_fail(c, "the plan in force cannot be read");
        return;
    }
    if (plan.end == TTF_END_COUNT && slots != plan.count)
        chaos_fail(c, "%lld records of %lld slots", (long long)slots, (long long)plan.count);
    if (c->run.config.rtc && !chaos_any_step(c) && plan.end == TTF_END_UNTIL)
        end_ns = plan.until_utc_ns - c->run.config.start_utc_ns;
    if (c->run.config.rtc && !chaos_any_step(c) && plan.end == TTF_END_LENGTH)
        end_ns = w->first_due_ns + plan.length_ns;
    if (end_ns == TTF_NS_UNKNOWN || slots == 0)
        return;
    if (w->last_due_ns >= end_ns)
        chaos_fail(c, "the last slot is due %.3f s after the end",
                   (double)(w->last_due_ns - end_ns) / 1e9);
    if (w->last_due_ns + last.interval_ns < end_ns - TTF_NS_PER_MS)
        chaos_fail(c, "the next slot would be due %.3f s before the end",
                   (double)(end_ns - w->last_due_ns - last.interval_ns) / 1e9);
}

/* The slots of one of its datasets, the next one being `next`. The next one then. */
static int64_t check_part(struct walk *w, const struct chaos_part *part, int64_t next)
{
    w->reader = part->reader;
    if (!ttf_reader_manifest(part->reader)->simulated)
        chaos_fail(w->c, "it does not say SIMULATED");
    for (int64_t i = 0; i < part->slots; i++) {
        if (ttf_reader_slot(part->reader, i, &w->record, NULL) < 0) {
            chaos_fail(w->c, "slot line %lld cannot be read", (long long)i);
            continue;
        }
        check_slot(w, next++);
        ttf_slot_record_free(&w->record);
    }
    return next;
}

static bool may_dim(const struct chaos *c)
{
    for (unsigned i = 0; i < c->run.config.n_faults; i++) {
        enum ttf_fault_kind kind = c->run.config.faults[i].kind;

        if (kind == TTF_FAULT_LAMP_DEAD || kind == TTF_FAULT_LAMP_FADING ||
            kind == TTF_FAULT_LAMP_STUCK ||
            (kind == TTF_FAULT_DOOR_OPEN && !c->run.config.door_switch))
            return true;
    }
    return false;
}

void chaos_check_end(struct chaos *c, bool done)
{
    struct walk w = {.c = c,
                     .last_due_ns = INT64_MIN / 2,
                     .last_power_on_ns = TTF_NS_UNKNOWN,
                     .last_end_ns = INT64_MIN / 2,
                     .dimmed = may_dim(c)};
    struct chaos_parts parts;
    int64_t slots = 0;

    if (!chaos_part_exists(c, 0)) {
        if (done)
            chaos_fail(c, "done without a dataset");
        return;
    }
    for (unsigned storage = 0; storage < 2; storage++)
        if (chaos_part_exists(c, storage))
            chaos_check_verify(c, storage, true, done && storage == c->second.begun);
    if (!chaos_parts_open(c, &parts))
        return;
    for (unsigned i = 0; i < parts.n; i++)
        slots = check_part(&w, &parts.part[i], slots);
    chaos_parts_check(c, &parts);
    if (done)
        check_length(&w, &parts.part[parts.n - 1], slots);
    chaos_parts_close(&parts);
}
