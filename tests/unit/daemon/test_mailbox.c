/* SPDX-License-Identifier: Apache-2.0 */
/* test_mailbox.c: a run never waits for whoever reads what it says. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "mailbox.h"

#define MANY 200000

static void put(struct mailbox *box, int64_t index)
{
    const struct ttf_progress p = {
        .kind = TTF_PROGRESS_SLOT, .index = index, .lit_ns = 5, .settled_ns = 9, .text = "why"};

    mailbox_put(box, &p);
}

static void what_finds_no_room_is_dropped_and_counted(void **state)
{
    struct mailbox *box = calloc(1, sizeof *box);
    struct letter letter;

    (void)state;
    if (!box) {
        fail();
        return;
    }
    for (int64_t i = 0; i < MAILBOX_ROOM + 7; i++)
        put(box, i);
    assert_int_equal(mailbox_dropped(box), 7);
    assert_int_equal(mailbox_dropped(box), 0);
    for (int64_t i = 0; i < MAILBOX_ROOM; i++) {
        assert_true(mailbox_take(box, &letter));
        assert_true(letter.index == i);
    }
    assert_string_equal(letter.text, "why");
    assert_true(letter.lit_ns == 5 && letter.settled_ns == 9);
    assert_false(mailbox_take(box, &letter));
    free(box);
}

static void *write_many(void *ctx)
{
    for (int64_t i = 0; i < MANY; i++)
        put(ctx, i);
    return NULL;
}

/* Whole letters in their order, whatever is lost. */
static void letters_come_whole_and_in_order(void **state)
{
    struct mailbox *box = calloc(1, sizeof *box);
    struct letter letter;
    int64_t last = -1, came = 0, dropped = 0;
    pthread_t writer;

    (void)state;
    if (!box || pthread_create(&writer, NULL, write_many, box) != 0) {
        free(box);
        fail();
        return;
    }
    while (came + dropped < MANY) {
        dropped += mailbox_dropped(box);
        while (mailbox_take(box, &letter)) {
            if (letter.index <= last || strcmp(letter.text, "why") != 0)
                fail_msg("%lld behind %lld", (long long)letter.index, (long long)last);
            last = letter.index;
            came++;
        }
    }
    assert_int_equal(pthread_join(writer, NULL), 0);
    assert_true(came > 0);
    free(box);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_finds_no_room_is_dropped_and_counted),
        cmocka_unit_test(letters_come_whole_and_in_order),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
