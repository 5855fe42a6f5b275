/* SPDX-License-Identifier: Apache-2.0 */
/* The hook itself: what it counts, whose it says that is, and what it lets fail. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <jansson.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "alloc_hook.h"

static void our_allocations_are_counted_until_they_are_freed(void **state)
{
    struct alloc_counts before = alloc_hook_counts(ALLOC_OURS), during, after;
    char *a = malloc(100), *b = strdup("12345");
    void *c = NULL;

    assert_int_equal(posix_memalign(&c, 4096, 10), 0);
    assert_int_equal((uintptr_t)c % 4096, 0);
    during = alloc_hook_counts(ALLOC_OURS);
    assert_int_equal(during.calls - before.calls, 3);
    a = realloc(a, 300);
    free(a);
    free(b);
    free(c);
    after = alloc_hook_counts(ALLOC_OURS);
    assert_int_equal(after.calls - before.calls, 4);
    if (!alloc_hook_sees_all())
        return;
    assert_int_equal(during.live - before.live, 3);
    assert_int_equal(during.live_bytes - before.live_bytes, 116);
    assert_int_equal(after.live, before.live);
    assert_int_equal(after.live_bytes, before.live_bytes);
    assert_true(after.peak_bytes >= before.live_bytes + 316);
}

static void what_a_library_allocates_is_not_ours(void **state)
{
    struct alloc_counts ours = alloc_hook_counts(ALLOC_OURS), all = alloc_hook_counts(ALLOC_ALL);
    json_t *json = json_loads("{\"a\": [1, 2, 3]}", 0, NULL);

    assert_int_equal(alloc_hook_counts(ALLOC_OURS).calls, ours.calls);
    if (alloc_hook_sees_all())
        assert_true(alloc_hook_counts(ALLOC_ALL).calls > all.calls + 3);
    json_decref(json);
    assert_int_equal(alloc_hook_counts(ALLOC_ALL).live, all.live);
}

static void the_nth_fails_and_only_that(void **state)
{
    void *p[4];
    char *text = NULL;

    alloc_hook_arm(ALLOC_OURS, 2, false);
    p[0] = malloc(1);
    errno = 0;
    p[1] = calloc(1, 1);
    assert_int_equal(errno, ENOMEM);
    p[2] = strdup("x");
    assert_int_equal(alloc_hook_disarm(), 1);
    assert_true(alloc_hook_failed_site() != 0);
    assert_non_null(p[0]);
    assert_null(p[1]);
    assert_non_null(p[2]);
    alloc_hook_arm(ALLOC_OURS, 1, true);
    assert_true(asprintf(&text, "%d", 1) < 0);
    assert_int_equal(posix_memalign(&p[3], 64, 64), ENOMEM);
    assert_int_equal(alloc_hook_disarm(), 2);
    free(p[0]);
    free(p[2]);
}

static void a_librarys_allocation_can_fail_too(void **state)
{
    long n, failed;
    json_t *json;

    if (!alloc_hook_sees_all())
        skip();
    for (n = 1;; n++) {
        alloc_hook_arm(ALLOC_ALL, n, false);
        json = json_loads("{\"a\": [1, 2, 3]}", 0, NULL);
        failed = alloc_hook_disarm();
        if (failed == 0)
            break;
        assert_null(json);
    }
    assert_true(n > 4);
    json_decref(json);
}

static void while_paused_nothing_fails_and_nothing_counts(void **state)
{
    long calls = alloc_hook_counts(ALLOC_ALL).calls;
    void *p;

    alloc_hook_arm(ALLOC_ALL, 1, true);
    alloc_hook_pause();
    p = malloc(10);
    alloc_hook_resume();
    assert_int_equal(alloc_hook_disarm(), 0);
    assert_non_null(p);
    assert_int_equal(alloc_hook_counts(ALLOC_ALL).calls, calls);
    free(p);
}

static void *allocate_much(void *ctx)
{
    for (unsigned i = 1; i <= 10000; i++) {
        char *p = malloc(i % 100);

        if (!p)
            ++*(long *)ctx;
        free(p);
    }
    return NULL;
}

static void threads_lose_no_count(void **state)
{
    struct alloc_counts before = alloc_hook_counts(ALLOC_OURS), after;
    pthread_t threads[4];
    long failed[4] = {0};
    unsigned i;

    alloc_hook_arm(ALLOC_OURS, 20000, false);
    for (i = 0; i < 4; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, allocate_much, &failed[i]), 0);
    for (i = 0; i < 4; i++)
        pthread_join(threads[i], NULL);
    assert_int_equal(alloc_hook_disarm(), 1);
    assert_int_equal(failed[0] + failed[1] + failed[2] + failed[3], 1);
    after = alloc_hook_counts(ALLOC_OURS);
    assert_int_equal(after.calls - before.calls, 40000);
    assert_int_equal(after.live, before.live);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(our_allocations_are_counted_until_they_are_freed),
        cmocka_unit_test(what_a_library_allocates_is_not_ours),
        cmocka_unit_test(the_nth_fails_and_only_that),
        cmocka_unit_test(a_librarys_allocation_can_fail_too),
        cmocka_unit_test(while_paused_nothing_fails_and_nothing_counts),
        cmocka_unit_test(threads_lose_no_count),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
