/* SPDX-License-Identifier: Apache-2.0 */
/*
 * orders.h: what is to run: what a person asked for, which is on the disk and holds over boots, else what the
 * configuration names. A person's decision holds for the configuration that it was made under: a run that was asked for
 * is gone on with in any case, but a stop does not keep back what the configuration names now and did not then.
 * Any thread.
 */
#ifndef DAEMON_ORDERS_H
#define DAEMON_ORDERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

enum order_state {
    ORDER_NONE = 0, /* nothing is to be run */
    ORDER_RUN,
    ORDER_STOPPED, /* by a person; may be gone on with */
    ORDER_DONE
};

struct order {
    enum order_state state;
    int64_t
        generation; /* another one after each decision: what was begun under one says nothing of the next */
    bool by_request;  /* else the configuration's */
    char dataset[65]; /* its name */
    char plan[65];    /* its name, of one by request */
    char why[400];    /* STOPPED: by whom else than a person; empty: by one */
    char *yaml;       /* the plan by request, as it was then; by malloc */
};

struct orders;

/*
 * plan, dataset: the configuration's, the dataset's with its folder; "" and "": it has none. A file that says nothing that can be
 * understood is put aside, and the order is STOPPED, with why. -ENOMEM.
 */
TTF_MUST_USE int orders_create(struct ttf_io *io, const char *folder, const char *plan,
                               const char *dataset, struct orders **ret, struct ttf_err *err);
void orders_destroy(struct orders *orders); /* NULL allowed */

/* From now on a stop puts value into the flag, where it is 0: whoever runs what was stopped ends it. Borrowed; before any
 * other thread knows of the orders. */
void orders_flag(struct orders *orders, volatile int *flag, int value);

/* A copy of what holds now, to be freed. -ENOMEM. */
TTF_MUST_USE int orders_get(struct orders *orders, struct order *ret);
void order_free(struct order *order);

/*
 * The same for whoever acts on it: a stop that the flag still tells of is of one before, and is taken out of it. Errors of the
 * disk, for which what was decided cannot be read yet; *ret has the generation then, and nothing else.
 */
TTF_MUST_USE int orders_take(struct orders *orders, struct order *ret, struct ttf_err *err);

/* Looks for a file that was not there, or could not be read: its disk may have come late. true: something else holds now, and what
 * ran under what was held until then is told to end. */
bool orders_read_again(struct orders *orders);

int64_t orders_generation(struct orders *orders); /* of what holds now */

/* Each on the disk before it returns. -EBUSY: a run is under way; errors of the disk, and nothing has changed. */
TTF_MUST_USE int orders_start(struct orders *orders, const char *plan, const char *yaml,
                              const char *dataset, struct ttf_err *err);
/* -ENOENT: nothing runs (stop), nothing was stopped (go_on). -EAGAIN: what was decided before cannot be read yet. */
TTF_MUST_USE int orders_stop(struct orders *orders, struct ttf_err *err);
TTF_MUST_USE int orders_go_on(struct orders *orders, struct ttf_err *err);

/*
 * What was run under this generation is over: done, or stopped where it was run. Nothing happens if something else was decided
 * meanwhile. It holds here also where the disk does not take it (its error), until orders_save brings it there.
 */
TTF_MUST_USE int orders_ended(struct orders *orders, int64_t generation, enum order_state to,
                              struct ttf_err *err);
/* Once more what the disk did not take; 0: it has all. Room is kept for the next decision, so that a full disk takes a stop. */
TTF_MUST_USE int orders_save(struct orders *orders, struct ttf_err *err);

#endif
