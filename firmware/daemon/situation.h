/* SPDX-License-Identifier: Apache-2.0 */
/*
 * situation.h: what the box does, as it is told to whoever asks. Written by the thread that runs things, between runs, and
 * by the one that takes the mailbox out; read by any. Nothing that a slot waits for takes its lock.
 */
#ifndef DAEMON_SITUATION_H
#define DAEMON_SITUATION_H

#include <stdbool.h>
#include <stdint.h>

#include "course.h"
#include "mailbox.h"
#include "orders.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/json_writer.h"
#include "ttf/hal/clock.h"

enum doing {
    DOING_IDLE = 0,
    DOING_WAITING, /* for something outside: the plan's file, a clock, the plan's start */
    DOING_ARMING,
    DOING_CAPTURING,
    DOING_PAUSED,
    DOING_STOPPING,
    DOING_RETRYING,
    DOING_STOPPED
};

const char *doing_name(enum doing doing);

struct situation;

struct situation *situation_create(struct ttf_clock *clock); /* NULL: no memory */
void situation_destroy(struct situation *situation);         /* NULL allowed */

/*
 * Which run it is about from now on; what was known of another one is forgotten. second: the folder of its second storage, "": it has
 * none; NULL: that is not known, and what was known of this run holds. Returns its number, another one for each dataset.
 */
int64_t situation_run(struct situation *situation, const struct order *order, const char *second);
/* What a slot takes, and what the plan leaves free: with less than both a slot is missed. */
void situation_storage(struct situation *situation, int64_t slot_bytes, int64_t reserve_bytes);
void situation_sealed(struct situation *situation);

/* why: NULL or empty: nothing to be said. retry_ns: until it is tried again, TTF_NS_UNKNOWN: it is not. true: it is another than before. */
bool situation_set(struct situation *situation, enum doing doing, const char *why,
                   int64_t retry_ns);
/* From one to the other, and only from it. */
bool situation_turn(struct situation *situation, enum doing from, enum doing to);
enum doing situation_doing(struct situation *situation);

/*
 * What a run said. true: it does something else now, ends elsewhere by an event, or an alarm is over. Of another run than the one it is about, alarms alone are
 * taken, and that they are over.
 */
bool situation_letter(struct situation *situation, const struct letter *letter);
bool situation_is_of(struct situation *situation, const struct letter *letter);

/*
 * What the records of a dataset say, in their order; one that is begun anew is forgotten first. Nothing happens where it is about
 * another by now. part: in which storage they lie.
 */
void situation_forget(struct situation *situation, const char *dataset);
void situation_segment(struct situation *situation, const char *dataset, enum course_part part,
                       const struct ttf_segment *segment);
void situation_record(struct situation *situation, const char *dataset, enum course_part part,
                      const struct ttf_slot_record *record, const char *readings);

/* The name of the dataset that all this is about; "": none. */
void situation_dataset(struct situation *situation, char ret[65]);

/* The same, and the folder of the run's second storage; "": it has none. */
void situation_records(struct situation *situation, char ret[65], char ret_second[512]);

/* Members of the status: state, why, time, run, readings, alarms. */
void situation_status(struct situation *situation, struct ttf_json *json);
/* Data of the events `state`, and `slot` for a letter. */
void situation_state_event(struct situation *situation, struct ttf_json *json);
void situation_slot_event(struct situation *situation, const struct letter *letter,
                          struct ttf_json *json);

#endif
