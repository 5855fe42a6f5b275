/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Single flipped bits, one at a time, in every file of datasets that hold everything the
 * format knows: sealed, stopped unsealed, and cut off by power. `verify` must find each,
 * name the file and, of an image, a slot's line, a calibration or a plan, the slot; and
 * must find nothing where nothing is promised (notes, samples, previews, the reserve).
 *
 *   bit_flips [N [SEED]]
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "flip_io.h"
#include "rich_dataset.h"
#include "store_ios.h"
#include "store_test.h"
#include "ttf/dataset/verify.h"

#define FILES_MAX 256
#define FLIPS     2000

static long n_flips = FLIPS;
static uint64_t seed = 20261125;

/* One file of a dataset, and what a flip in it must bring. */
struct subject {
    char path[200]; /* relative */
    int64_t bytes;
    bool outside;        /* not guarded: any flip is harmless */
    int64_t first, last; /* slots that it belongs to; -1: none in particular */
    int64_t tail;        /* from this byte on a flip looks like a crash: told, but no damage */
};

struct dataset {
    char path[300];
    enum rich_ending ending;
    unsigned n;
    struct subject subjects[FILES_MAX];
    char *records; /* their text */
};

struct tally {
    long flips, damage, leftover, harmless;
};

static uint64_t next_random(uint64_t *x)
{
    *x ^= *x << 13;
    *x ^= *x >> 7;
    *x ^= *x << 17;
    return *x;
}

static bool is_outside(const char *path)
{
    return strcmp(path, "notes.jsonl") == 0 || strcmp(path, "samples.json") == 0 ||
           strcmp(path, "report.json") == 0 || strcmp(path, ".events-reserve") == 0 ||
           strncmp(path, "preview/", 8) == 0;
}

/* As rich_build uses them. */
static void owner_of(struct subject *s)
{
    const char *name = strrchr(s->path, '/');
    bool image = strncmp(s->path, "frames/", 7) == 0 || strncmp(s->path, "raw/", 4) == 0;

    s->first = s->last = -1;
    if (image)
        s->first = s->last = strtoll(name + 1, NULL, 10);
    else if (strncmp(s->path, "calibration/cal-a/", 18) == 0)
        s->first = 0, s->last = 8;
    else if (strncmp(s->path, "calibration/cal-b/", 18) == 0)
        s->first = 2, s->last = 6;
    else if (strncmp(s->path, "plans/0.", 8) == 0)
        s->first = 0, s->last = 5;
    else if (strncmp(s->path, "plans/1.", 8) == 0)
        s->first = 6, s->last = 8;
}

/*
 * Where a log of an unsealed dataset may be torn by a crash: the newline of its last line,
 * and the whole of a last line that has none yet.
 */
static int64_t tail_of(const struct dataset *d, const char *path)
{
    size_t n, at;
    char *text;

    if (d->ending == RICH_SEALED || !(strstr(path, ".jsonl") || strcmp(path, "SHA256SUMS") == 0))
        return INT64_MAX;
    text = file_text(in(d->path, "%s", path), &n);
    at = n;
    while (at > 0 && text[at - 1] != '\n')
        at--;
    free(text);
    return at == n && n > 0 ? (int64_t)n - 1 : (int64_t)at - (at > 0);
}

static void learn_dataset(struct dataset *d)
{
    char line[600];
    FILE *list;
    size_t n;

    snprintf(line, sizeof(line), "cd '%s' && find . -type f -size +0 | sort", d->path);
    list = popen(line, "re"); /* NOLINT(cert-env33-c) */
    assert_non_null(list);
    while (fgets(line, sizeof(line), list)) {
        struct subject *s = &d->subjects[d->n];

        assert_true(d->n < FILES_MAX);
        line[strcspn(line, "\n")] = '\0';
        snprintf(s->path, sizeof(s->path), "%.199s", line + 2);
        s->bytes = size_of(in(d->path, "%s", s->path));
        s->outside = is_outside(s->path);
        owner_of(s);
        s->tail = tail_of(d, s->path);
        d->n++;
    }
    pclose(list);
    d->records = file_text(in(d->path, "records.jsonl"), &n);
}

/* Of a byte of records.jsonl: the slot whose line it lies in; -1: of none. */
static int64_t slot_of_line(const struct dataset *d, int64_t at)
{
    const char *begin = d->records + at, *index, *end;

    while (begin > d->records && begin[-1] != '\n')
        begin--;
    end = strchrnul(begin, '\n');
    if (strncmp(begin, "{\"type\":\"slot\"", 14) != 0)
        return -1;
    index = memmem(begin, (size_t)(end - begin), "\"index\":", 8);
    return index ? strtoll(index + 8, NULL, 10) : -1;
}

/* Does the finding name that file (or a line of it)? */
static bool names(const struct ttf_verify_finding *f, const char *path)
{
    size_t n = strlen(path);

    return (strncmp(f->file, path, n) == 0 && (f->file[n] == '\0' || f->file[n] == ':')) ||
           (strcmp(path, "SHA256SUMS") == 0 && strstr(f->text, path));
}

/* What verify must say of this flip. */
static void expect(const struct dataset *d, const struct subject *s, int64_t bit,
                   const struct ttf_verify_report *report, struct tally *tally)
{
    int64_t first = s->first, last = s->last;
    bool in_records = strcmp(s->path, "records.jsonl") == 0, named = false, slot_named;
    bool damage = false;

    if (s->outside) {
        tally->harmless++;
        if (report->damaged)
            fail_msg("%s bit %lld: a false alarm: %s: %s", s->path, (long long)bit,
                     report->findings[0].file, report->findings[0].text);
        return;
    }
    if (in_records && bit / 8 < s->tail && d->records[bit / 8] != '\n')
        first = last = slot_of_line(d, bit / 8);
    slot_named = first < 0;
    for (unsigned i = 0; i < report->n_findings; i++) {
        const struct ttf_verify_finding *f = &report->findings[i];

        if (!names(f, s->path) || (f->severity != TTF_FINDING_DAMAGE && bit / 8 < s->tail))
            continue;
        named = true;
        damage = damage || f->severity == TTF_FINDING_DAMAGE;
        slot_named = slot_named || (f->slot == first && f->last_slot == last);
    }
    if (!named || (damage && !report->damaged))
        fail_msg("%s/%s: bit %lld went unseen", d->path, s->path, (long long)bit);
    if (!slot_named)
        fail_msg("%s/%s: bit %lld: slots %lld to %lld are not named", d->path, s->path,
                 (long long)bit, (long long)first, (long long)last);
    tally->damage += damage;
    tally->leftover += !damage;
}

static void flip_once(const struct dataset *d, const struct subject *s, int64_t bit,
                      struct tally *tally)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    struct ttf_err err = {0};
    struct flip_io flip;
    char full[600];

    snprintf(full, sizeof(full), "%s/%s", d->path, s->path);
    flip_io_init(&flip, ttf_io_posix());
    flip.path = full;
    flip.bit = bit;
    if (ttf_verify(&flip.io, d->path, &options, &report, &err) != 0)
        fail_msg("%s: bit %lld: verify gave up: %s", full, (long long)bit, err.what);
    expect(d, s, bit, &report, tally);
    ttf_verify_report_free(&report);
    tally->flips++;
}

static void expect_no_alarm(const struct dataset *d)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;

    assert_int_equal(ttf_verify(ttf_io_posix(), d->path, &options, &report, NULL), 0);
    assert_false(report.damaged);
    assert_int_equal(report.sealed, d->ending == RICH_SEALED);
    /* Of a cut one it is said that a newline is owed; else there is nothing to say. */
    assert_int_equal(report.n_findings, d->ending == RICH_CUT ? 2 : 0);
    ttf_verify_report_free(&report);
}

static void every_flipped_bit_is_found_and_named(void **state)
{
    static struct dataset datasets[3];
    uint64_t x = seed * UINT64_C(0x9e3779b97f4a7c15) + 1;
    struct tally tally = {0};

    print_message("%ld flips, seed %llu\n", n_flips, (unsigned long long)seed);
    for (int e = RICH_SEALED; e <= RICH_CUT; e++) {
        struct dataset *d = &datasets[e];

        d->ending = (enum rich_ending)e;
        snprintf(d->path, sizeof(d->path), "%s/d%d", (char *)*state, e);
        rich_build(quick_io(), d->path, d->ending);
        expect_no_alarm(d);
        learn_dataset(d);
    }
    /* Files in turn, so that the small ones come as often as the large. */
    for (long i = 0; i < n_flips; i++) {
        const struct dataset *d = &datasets[i % 3];
        const struct subject *s = &d->subjects[(unsigned long)(i / 3) % d->n];

        flip_once(d, s, (int64_t)(next_random(&x) % ((uint64_t)s->bytes * 8)), &tally);
    }
    print_message("%ld flips: %ld found as damage, %ld told as what a crash may leave, %ld in "
                  "what is not guarded; 0 unseen, 0 false alarms\n",
                  tally.flips, tally.damage, tally.leftover, tally.harmless);
    for (int e = RICH_SEALED; e <= RICH_CUT; e++)
        free(datasets[e].records);
}

/* The short file that all else hangs on, bit by bit (not each of them in a short run). */
static void every_bit_of_dataset_json_is_guarded(void **state)
{
    struct tally tally = {0};

    for (int e = RICH_SEALED; e <= RICH_CLOSED; e++) {
        struct dataset d = {.ending = (enum rich_ending)e, .records = NULL};
        struct subject s = {.path = "dataset.json", .first = -1, .last = -1, .tail = INT64_MAX};

        snprintf(d.path, sizeof(d.path), "%s/m%d", (char *)*state, e);
        rich_build(quick_io(), d.path, d.ending);
        s.bytes = size_of(in(d.path, "dataset.json"));
        for (int64_t bit = 0; bit < s.bytes * 8; bit += n_flips < 50000 ? 97 : 5)
            flip_once(&d, &s, bit, &tally);
    }
    print_message("%ld flips in dataset.json\n", tally.flips);
}

int main(int argc, char **argv)
{
#define T(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
    const struct CMUnitTest tests[] = {
        T(every_flipped_bit_is_found_and_named),
        T(every_bit_of_dataset_json_is_guarded),
    };

    if (argc > 1)
        n_flips = strtol(argv[1], NULL, 10);
    if (argc > 2)
        seed = strtoull(argv[2], NULL, 0);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
