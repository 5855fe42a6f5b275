/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One of every fault each day, in a capture of ten-minute slots:
 *
 *   test_run_month [DAYS [SEED]]     (2 days, as a test; ./dev month: 30)
 *
 * Each slot has its record, each fault costs no more than the slots of its duration,
 * or one, each with its reason. README.md has the rule.
 */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "month.h"
#include "second_run.h"
#include "ttf/base/attr.h"

#define S TTF_NS_PER_S

/* From the first lamp command of a slot to its record: a fault that begins so much later still meets it. */
#define WORK_NS (20 * S)

/* From a device, or the box, that is back to the first slot it can take. */
#define RETURN_NS (30 * S)

/* Of the slot before. */
struct last_due {
    char boot_id[37];
    int64_t due_ns;
};

static const struct month *month;   /* of the run */
static int64_t numbers[MONTH_ASKS]; /* of what was asked in this block */
static unsigned n_numbers;

static int64_t days = 2;
static uint64_t seed = 1;

/* Why a slot may be lost to a fault; NULL: to none of this kind. */
static const char *reason_of(const struct month_fault *f)
{
    switch (f->fault.kind) {
    case TTF_FAULT_FRAME_LATE:
    case TTF_FAULT_FRAME_MISSING:
        /* Nothing came at all: for the session that is a camera that hangs. */
        return f->lasts_ns > 0 ? "camera does not deliver" : NULL;
    case TTF_FAULT_FRAME_SHORT:
        return f->lasts_ns > 0 ? "short" : NULL;
    case TTF_FAULT_FRAME_CORRUPT:
        return f->lasts_ns > 0 ? "corrupt" : NULL;
    case TTF_FAULT_CAMERA_HANG:
        return f->fault.amount == 3 ? "camera does not deliver" : NULL;
    case TTF_FAULT_DISK_FULL:
        return "disk full";
    case TTF_FAULT_IO_ERROR:
        return "storage error";
    case TTF_FAULT_POWER_CUT:
        return "the box was without power";
    default:
        return NULL;
    }
}

/* Slots that a fault can touch: due while it lasts, or being worked on when it comes, or the first after it. */
static bool touches(const struct month *m, const struct month_fault *f, int64_t index)
{
    int64_t due = month_due_ns(m, index);
    int64_t from = f->fault.at_ns - WORK_NS;
    int64_t until = f->fault.at_ns + f->lasts_ns + RETURN_NS;
    /* What strikes once waits for its opportunity. */
    int64_t next = f->fault.at_ns + MONTH_INTERVAL_NS + WORK_NS;
    bool waits = f->lasts_ns == 0 && f->fault.kind != TTF_FAULT_CLOCK_STEP;

    return due >= from && due <= (waits ? next : until);
}

static bool marked(const struct ttf_slot_record *record)
{
    bool mark = record->result != TTF_RESULT_CAPTURED;

    for (unsigned i = 0; i < record->n_images; i++)
        mark |= record->images[i].flags[0] != '\0' || record->images[i].n_shots > 1;
    for (unsigned i = 0; i < record->n_sensors; i++)
        mark |= !record->sensors[i].ok;
    return mark;
}

/* A slot that is not as it should be is some fault's, and lost only for that fault's reason. */
static void check_slot(struct month *m, const struct ttf_slot_record *record)
{
    const bool paused = month_paused(m, record->index);

    struct month_fault *f = &m->faults[record->index / MONTH_BLOCK];
    const char *reason = reason_of(f);

    assert_in_range(record->index, f->first, f->last);
    assert_int_equal(record->result == TTF_RESULT_PAUSED, paused);
    if (paused)
        assert_string_equal(record->reason, "paused by a person");
    if (!marked(record) || paused)
        return;
    f->seen++;
    for (unsigned i = 0; !touches(m, f, record->index) && i < record->n_images; i++)
        print_error("its image %u: %s, %u shots\n", i, record->images[i].flags,
                    record->images[i].n_shots);
    if (!touches(m, f, record->index))
        print_error("slot %d: %s, %s; the fault of its block is a %s at %.3f s for %.3f s, it was "
                    "due at %.3f s\n",
                    (int)record->index, ttf_result_name(record->result), record->reason,
                    month_kind_name(f->kind), (double)f->fault.at_ns / 1e9,
                    (double)f->lasts_ns / 1e9, (double)month_due_ns(m, record->index) / 1e9);
    assert_true(touches(m, f, record->index));
    if (record->result == TTF_RESULT_CAPTURED)
        return;
    f->lost++;
    if (f->fault.kind == TTF_FAULT_POWER_CUT &&
        strcmp(record->reason, "the box was getting ready") == 0)
        return;
    if (!reason || strcmp(record->reason, reason) != 0)
        print_error("slot %d: %s, %s, of a %s\n", (int)record->index,
                    ttf_result_name(record->result), record->reason, month_kind_name(f->kind));
    assert_non_null(reason);
    assert_string_equal(record->reason, reason);
}

/* Within a boot each slot comes its interval after the one before, whatever is asked, and wherever it is written. */
static void check_due(const struct month *m, struct ttf_reader *reader,
                      const struct ttf_slot_record *record, struct last_due *last)
{
    struct ttf_segment segment;

    assert_int_equal(ttf_reader_segment(reader, record->segment, &segment), 0);
    assert_int_equal(segment.interval_ns, month_interval_ns(m, record->index));
    if (strcmp(last->boot_id, segment.boot_id) == 0)
        assert_int_equal(record->due_ns - last->due_ns, month_interval_ns(m, record->index));
    last->due_ns = record->due_ns;
    snprintf(last->boot_id, sizeof(last->boot_id), "%s", segment.boot_id);
}

/* Those of one of the two datasets, the next one being that of slot `next`. The next one then. */
static int64_t check_records(struct month *m, const char *path, int64_t next,
                             int64_t counts[TTF_RESULT_COUNT], struct last_due *last)
{
    struct ttf_reader *reader;

    assert_int_equal(ttf_reader_open(ttf_io_posix(), path, &reader, NULL), 0);
    for (int64_t k = 0; k < ttf_reader_summary(reader)->slots; k++) {
        struct ttf_slot_record record;

        assert_int_equal(ttf_reader_slot(reader, k, &record, NULL), 0);
        assert_int_equal(record.index, next++);
        check_slot(m, &record);
        check_due(m, reader, &record, last);
        counts[record.result]++;
        ttf_slot_record_free(&record);
    }
    ttf_reader_close(reader);
    return next;
}

/* A fault that strikes once costs one slot at most; one that lasts no more than it touches. */
static void check_costs(const struct month *m)
{
    for (unsigned i = 0; i < m->n; i++) {
        const struct month_fault *f = &m->faults[i];
        unsigned touched = 0;

        for (int64_t k = f->first; k <= f->last; k++)
            touched += touches(m, f, k);
        assert_true(f->lost <= (f->lasts_ns == 0 ? 1 : touched));
        assert_true(f->lost <= 1 || f->lasts_ns + RETURN_NS + WORK_NS >= MONTH_INTERVAL_NS);
    }
}

static void tell(const struct month *m, const int64_t n[TTF_RESULT_COUNT], int64_t in_first,
                 unsigned boots)
{
    unsigned lost_of_all = 0;

    printf("%d days, seed %llu: %d slots, %d captured, %d partial, %d missed, %d failed, %d power, "
           "%d paused; %u boots; the first %d before the storage could only be read\n",
           (int)m->days, (unsigned long long)m->seed, (int)(m->days * MONTH_DAY_SLOTS),
           (int)n[TTF_RESULT_CAPTURED], (int)n[TTF_RESULT_PARTIAL], (int)n[TTF_RESULT_MISSED],
           (int)n[TTF_RESULT_FAILED], (int)n[TTF_RESULT_POWER], (int)n[TTF_RESULT_PAUSED], boots,
           (int)in_first);
    printf("%-22s %7s %7s %7s %7s %7s  %s\n", "fault", "drawn", "marked", "slots", "lost", "most",
           "reason");
    for (unsigned kind = 0; kind < MONTH_KINDS; kind++) {
        unsigned drawn = 0, struck = 0, seen = 0, lost = 0, most = 0;
        const char *reason = NULL;

        for (unsigned i = 0; i < m->n; i++) {
            const struct month_fault *f = &m->faults[i];

            if (f->kind != kind)
                continue;
            drawn++;
            struck += f->seen > 0;
            seen += f->seen;
            lost += f->lost;
            most = f->lost > most ? f->lost : most;
            reason = f->lost > 0 ? reason_of(f) : reason;
        }
        lost_of_all += lost;
        printf("%-22s %7u %7u %7u %7u %7u  %s\n", month_kind_name(kind), drawn, struck, seen, lost,
               most, reason ? reason : "-");
    }
    printf("%u slots lost\n", lost_of_all);
    assert_int_equal(lost_of_all,
                     m->days * MONTH_DAY_SLOTS - n[TTF_RESULT_CAPTURED] - n[TTF_RESULT_PAUSED]);
    assert_int_equal(n[TTF_RESULT_PAUSED], m->days * MONTH_PAUSE_SLOTS);
}

/* What leaves a mark at the latest in the slot that it is drawn for did so each day. */
static void check_struck(const struct month *m, const struct sim_run *run)
{
    const struct sim_run second = second_run_of(run);
    unsigned steps = 0;

    for (unsigned i = 0; i < m->n; i++) {
        const struct month_fault *f = &m->faults[i];
        enum ttf_fault_kind kind = f->fault.kind;

        steps += kind == TTF_FAULT_CLOCK_STEP;
        if (kind == TTF_FAULT_CLOCK_STEP || kind == TTF_FAULT_POWER_CUT ||
            kind == TTF_FAULT_LAMP_STUCK || kind == TTF_FAULT_DISK_FULL ||
            kind == TTF_FAULT_IO_ERROR)
            continue; /* events; an outage between slots; dark, as commanded; a second try */
        if (f->seen == 0)
            print_error("%s at %.3f s left no mark\n", month_kind_name(f->kind),
                        (double)f->fault.at_ns / 1e9);
        assert_true(f->seen > 0);
    }
    assert_int_equal(sim_run_events(run, "clock-step", NULL) +
                         sim_run_events(&second, "clock-step", NULL),
                     steps);
}

/* ---- what people ask ---- */

static void ask(struct sim_run *run, const struct ttf_ask *what)
{
    assert_true(n_numbers < MONTH_ASKS);
    numbers[n_numbers] = ttf_control_ask(run->control, what);
    assert_true(numbers[n_numbers++] > 0);
}

/* When the last slot of the block has its record, all that was asked in it is done. */
static void expect_done(struct sim_run *run)
{
    assert_int_equal(n_numbers, MONTH_ASKS);
    for (unsigned i = 0; i < n_numbers; i++) {
        struct ttf_err err = {0};
        int r = ttf_control_answer(run->control, numbers[i], &err);

        if (r < 0)
            print_error("ask %u of its block: %d: %s: %s\n", i, r, err.where, err.what);
        assert_int_equal(r, 0);
    }
    n_numbers = 0;
}

static void people(struct sim_run *run, const struct ttf_progress *p)
{
    const struct month_fault *f;
    int64_t slot, next;

    if (!month || p->kind != TTF_PROGRESS_SLOT)
        return;
    f = month_fault_of(month, p->index);
    slot = p->index - f->first;
    next = p->index + 1;
    if (f->fault.kind != TTF_FAULT_CLOCK_STEP)
        return;
    if (slot == MONTH_PAUSE_FIRST - 1)
        ask(run, &(struct ttf_ask){.kind = TTF_ASK_PAUSE, .from_index = next});
    if (slot == MONTH_PAUSE_FIRST + MONTH_PAUSE_SLOTS - 1)
        ask(run, &(struct ttf_ask){.kind = TTF_ASK_CONTINUE, .from_index = next});
    if (slot == MONTH_ASK_AFTER) {
        int64_t day = p->index / MONTH_DAY_SLOTS + 2;
        struct ttf_ask note = {.kind = TTF_ASK_NOTE};

        snprintf(note.note.text, sizeof(note.note.text), "seen on day %d", (int)day - 2);
        note.note.utc_ns = TTF_NS_UNKNOWN;
        ask(run, &(struct ttf_ask){.kind = TTF_ASK_COUNT,
                                   .count = (day < days ? day : days) * MONTH_DAY_SLOTS});
        for (unsigned i = 0; i < 3; i++)
            ask(run, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL,
                                       .from_index = next + i,
                                       .interval_ns = month_interval_ns(month, next + i)});
        ask(run, &note);
    }
    if (slot == MONTH_BLOCK - 1)
        expect_done(run);
}

static void begin(struct sim_run *run)
{
    second_run_init(run);
    run->control = ttf_control_create();
    assert_non_null(run->control);
    run->on_progress = people;
    run->scene = "chart";
    run->config.width = 26;
    run->config.height = 22;
    run->plan.interval_ns = MONTH_INTERVAL_NS;
    run->plan.count = MONTH_DAY_SLOTS; /* each day another is asked for */
    for (unsigned i = 0; i < run->config.n_lamps; i++)
        run->config.lamps[i].info.max_temp_mdegc = 60000;
}

/* When slot 0 is due without any trouble. */
static int64_t find_due0(void)
{
    struct sim_run run;
    int64_t due;

    begin(&run);
    run.plan.count = 1;
    assert_int_equal(sim_run_boot(&run), 0);
    due = sim_run_due_ns(&run, 0);
    ttf_control_destroy(run.control);
    sim_run_finish(&run);
    return due;
}

static void one_of_every_fault_each_day_costs_what_it_lasts_and_no_more(void **state)
{
    struct month *m = malloc(sizeof(*m));
    int64_t counts[TTF_RESULT_COUNT] = {0};
    struct last_due last = {{0}, 0};
    struct sim_run run, second;
    unsigned boots = 0;
    int64_t in_first;
    int r;

    (void)state;
    assert_non_null(m);
    month_draw(m, seed, days, find_due0());
    month = m;
    begin(&run);
    do {
        month_fill(m, &run.config, run.config.power_on_ns);
        r = sim_run_boot(&run);
        if (r < 0 && r != -ESHUTDOWN)
            print_error("boot %u: %d: %s: %s\n", boots, r, run.err.where, run.err.what);
        assert_true(r == 0 || r == -ESHUTDOWN);
        assert_int_equal(run.bites, 0);
        run.config.power_on_ns = run.back_ns;
        boots++;
    } while (r == -ESHUTDOWN);
    second = second_run_of(&run);
    sim_run_expect_undamaged(&run, false);
    sim_run_expect_undamaged(&second, true);
    in_first = check_records(m, run.path, 0, counts, &last);
    assert_true(in_first >= MONTH_BLOCK - 2 && in_first <= MONTH_BLOCK);
    assert_int_equal(check_records(m, second.path, in_first, counts, &last),
                     days * MONTH_DAY_SLOTS);
    tell(m, counts, in_first, boots);
    check_costs(m);
    check_struck(m, &run);
    assert_int_equal(boots, days + 1);
    month = NULL;
    ttf_control_destroy(run.control);
    sim_run_finish(&run);
    free(m);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_of_every_fault_each_day_costs_what_it_lasts_and_no_more),
    };

    if (argc > 1)
        days = strtoll(argv[1], NULL, 10);
    if (argc > 2)
        seed = strtoull(argv[2], NULL, 10);
    if (days < 1 || days > MONTH_DAYS_MAX) {
        fprintf(stderr, "usage: test_run_month [DAYS [SEED]]; at most %d days\n", MONTH_DAYS_MAX);
        return 2;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
