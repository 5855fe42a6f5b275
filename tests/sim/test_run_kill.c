/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Kill -9 at 30 random moments of captures, resumed each time: no committed frame
 * is lost, every slot is accounted for, and the dataset stays whole. The seed is
 * printed; TTF_SEED and TTF_KILLS in the environment set it and how many (./dev kill).
 */
#include "cmocka_includes.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sim_run.h"
#include "ttf/dataset/reader.h"
#include "ttf/hal/clock.h"

#define KILLS 30
#define SLOTS 300

/* What the child had acknowledged before it died. */
struct acknowledged {
    bool committed[SLOTS];
    char result[SLOTS]; /* its letter */
    int64_t elapsed_ns; /* of its last slot */
    unsigned n;
};

static uint64_t next_random(uint64_t *x)
{
    *x ^= *x << 13;
    *x ^= *x >> 7;
    *x ^= *x << 17;
    return *x;
}

static pid_t start_child(const struct sim_run *run, int64_t power_on_ns, int *ret_fd)
{
    char power_on[32];
    char slots[16];
    int fd[2];
    pid_t pid;

    snprintf(power_on, sizeof(power_on), "%lld", (long long)power_on_ns);
    snprintf(slots, sizeof(slots), "%d", SLOTS);
    assert_int_equal(pipe(fd), 0);
    pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        dup2(fd[1], STDOUT_FILENO);
        close(fd[0]);
        close(fd[1]);
        execl(CAPTURE_CHILD, "capture_child", run->path, power_on, slots, (char *)NULL);
        _exit(127);
    }
    close(fd[1]);
    *ret_fd = fd[0];
    return pid;
}

/* Reads to the pipe's end what the child said; a half line is nothing said. */
static void listen(int fd, struct acknowledged *ack)
{
    FILE *f = fdopen(fd, "r");
    char line[64];

    assert_non_null(f);
    while (fgets(line, sizeof(line), f)) {
        char *end;
        long long index = strtoll(line, &end, 10);

        if (!strchr(line, '\n'))
            break;
        assert_in_range(index, 0, SLOTS - 1);
        assert_false(ack->committed[index]); /* once only */
        ack->committed[index] = true;
        ack->elapsed_ns = strtoll(end, &end, 10);
        ack->result[index] = end[1];
        ack->n++;
    }
    fclose(f);
}

/* True if the child ended by itself before it could be killed. after_ns 0: let it end. */
static bool run_and_kill(const struct sim_run *run, struct ttf_clock *clock, int64_t power_on_ns,
                         int64_t after_ns, struct acknowledged *ack)
{
    int fd;
    int status;
    pid_t pid = start_child(run, power_on_ns, &fd);

    if (after_ns > 0) {
        ttf_clock_wait_until(clock, ttf_clock_now_ns(clock) + after_ns);
        kill(pid, SIGKILL);
    }
    listen(fd, ack);
    assert_int_equal(waitpid(pid, &status, 0), pid);
    if (WIFSIGNALED(status))
        return false;
    assert_int_equal(WEXITSTATUS(status), 0);
    return true;
}

/* Everything acknowledged is there, with its files as recorded (deep verify has hashed them). */
static void expect_nothing_lost(struct sim_run *run, const struct acknowledged *ack)
{
    char results[SLOTS + 1];

    sim_run_expect_whole(run, true);
    sim_run_results(run, results, sizeof(results));
    assert_int_equal(strlen(results), SLOTS);
    for (int64_t k = 0; k < SLOTS; k++) {
        struct ttf_slot_record record;

        sim_run_record(run, k, &record);
        /* Without power, or due while the box that came back was not ready yet. */
        if (results[k] == 'm')
            assert_string_equal(record.reason, "the box was getting ready");
        else
            assert_true(results[k] == 'c' || results[k] == 'w');
        if (results[k] == 'c')
            assert_int_equal(record.images[0].n_files, 2);
        /* What was said to be committed is; nothing else is there but what died unsaid. */
        assert_true(!ack->committed[k] || results[k] == ack->result[k]);
        ttf_slot_record_free(&record);
    }
    assert_true(ack->n > SLOTS / 3);
}

/* It may have been sealed, and killed before it could say so: then it must be whole as a sealed one. */
static bool has_seal(const struct sim_run *run)
{
    struct ttf_reader *reader;
    bool sealed;

    assert_int_equal(ttf_reader_open(ttf_io_posix(), run->path, &reader, NULL), 0);
    sealed = ttf_reader_summary(reader)->sealed;
    ttf_reader_close(reader);
    return sealed;
}

/* A dataset that has not been begun yet is whole too: dataset.json comes last (DESIGN.md). */
static void expect_whole_so_far(struct sim_run *run)
{
    char path[128];

    snprintf(path, sizeof(path), "%s/dataset.json", run->path);
    if (access(path, F_OK) == 0)
        sim_run_expect_whole(run, has_seal(run));
}

static uint64_t from_environment(const char *name, uint64_t otherwise)
{
    const char *given = getenv(name); /* NOLINT(concurrency-mt-unsafe): before any thread */

    return given ? strtoull(given, NULL, 0) : otherwise;
}

static void killed_thirty_times_nothing_committed_is_lost(void **state)
{
    uint64_t seed = from_environment("TTF_SEED", 20260726);
    unsigned wanted = (unsigned)from_environment("TTF_KILLS", KILLS);
    uint64_t x = seed * UINT64_C(0x9e3779b97f4a7c15) + 1;
    struct ttf_clock *clock = ttf_clock_real_create();
    unsigned kills = 0;
    unsigned datasets = 0;

    (void)state;
    print_message("seed %llu\n", (unsigned long long)seed);
    while (kills < wanted) {
        static struct acknowledged ack;
        struct sim_run run;
        int64_t power_on = 0;
        bool done = false;

        memset(&ack, 0, sizeof(ack));
        sim_run_init(&run);
        run.plan.count = SLOTS;
        while (!done) {
            int64_t after = (int64_t)(next_random(&x) % 120 + 3) * TTF_NS_PER_MS;

            if (kills >= wanted)
                after = 0; /* enough: let it end */
            done = run_and_kill(&run, clock, power_on, after, &ack);
            kills += !done;
            if (!done)
                expect_whole_so_far(&run);
            /* As the program does: a new boot, an outage after the last slot. */
            power_on = (ack.elapsed_ns > power_on ? ack.elapsed_ns : power_on) + 70 * TTF_NS_PER_S;
        }
        expect_nothing_lost(&run, &ack);
        sim_run_finish(&run);
        datasets++;
    }
    print_message("%u kills over %u datasets\n", kills, datasets);
    ttf_clock_destroy(clock);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(killed_thirty_times_nothing_committed_is_lost),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
