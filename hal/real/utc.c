/* SPDX-License-Identifier: Apache-2.0 */
#include "utc.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/timex.h>
#include <time.h>

/* An RTC may be seconds off; two, as it is read in whole seconds and drifts. */
#define RTC_UNCERTAINTY_NS (2 * TTF_NS_PER_S)
#define STEP_NS            (5 * TTF_NS_PER_MS)

static int64_t read_ns(clockid_t id)
{
    struct timespec ts = {0};

    clock_gettime(id, &ts);
    return (int64_t)ts.tv_sec * TTF_NS_PER_S + ts.tv_nsec;
}

int64_t real_boot_ns(void)
{
    return read_ns(CLOCK_BOOTTIME);
}

/* A number in a file of a clock; -1: there is none. */
static int64_t read_number(const char *sys, const char *rtc, const char *name)
{
    char path[512], text[32];
    int64_t number = -1;
    FILE *f;

    (void)snprintf(path, sizeof(path), "%s/class/rtc/%.64s/%s", sys, rtc, name);
    f = fopen(path, "re");
    if (f && fgets(text, sizeof(text), f))
        number = strtoll(text, NULL, 10);
    if (f)
        fclose(f);
    return number;
}

/*
 * Any of them may be the one that the kernel sets its time by (hctosys). One that has no date itself did not do so
 * usefully: it has no battery, and what the system's time is now, its last shutdown or its build has told.
 */
void real_utc_init(struct real_utc *u, const char *sys)
{
    char path[512];
    struct dirent *entry;
    DIR *dir;

    *u = (struct real_utc){0};
    (void)snprintf(path, sizeof(path), "%s/class/rtc", sys);
    dir = opendir(path);
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): of a stream of its own */
    while (dir && !u->rtc && (entry = readdir(dir)) != NULL)
        u->rtc =
            strncmp(entry->d_name, "rtc", 3) == 0 &&
            read_number(sys, entry->d_name, "hctosys") == 1 &&
            read_number(sys, entry->d_name, "since_epoch") >= TTF_UTC_EARLIEST_NS / TTF_NS_PER_S;
    if (dir)
        closedir(dir);
}

void real_utc_note(struct real_utc *u, int64_t boot_ns, int64_t utc_ns, int64_t reading_ns)
{
    if (u->known) {
        int64_t passed = boot_ns - u->boot_ns;
        int64_t moved = utc_ns - u->utc_ns - passed;
        int64_t allowed = STEP_NS + passed / 2000 + reading_ns;

        if (moved > allowed || moved < -allowed)
            u->steps++;
    }
    u->known = true;
    u->boot_ns = boot_ns;
    u->utc_ns = utc_ns;
}

/* Another clock between two readings of the boot clock; the tightest of a few. */
static int64_t bracket(clockid_t other, int64_t *ret_boot, int64_t *ret_other)
{
    int64_t best = TTF_NS_NEVER;

    for (int i = 0; i < 4; i++) {
        int64_t before = real_boot_ns(), found = read_ns(other), after = real_boot_ns();

        if (after - before < best) {
            best = after - before;
            *ret_boot = before + best / 2;
            *ret_other = found;
        }
    }
    return best;
}

int64_t real_monotonic_offset_ns(int64_t *ret_uncertainty_ns)
{
    int64_t boot = 0, monotonic = 0;

    *ret_uncertainty_ns = bracket(CLOCK_MONOTONIC, &boot, &monotonic) / 2;
    return boot - monotonic;
}

void real_utc_look(struct real_utc *u, struct ttf_utc *ret)
{
    struct timex tx = {.modes = 0};
    int64_t boot = 0, utc = 0;
    int64_t reading = bracket(CLOCK_REALTIME, &boot, &utc);
    int state = adjtimex(&tx);

    real_utc_note(u, boot, utc, reading);
    ret->boot_ns = boot;
    ret->utc_ns = utc;
    ret->steps = u->steps;
    ret->trust = TTF_TRUST_NONE;
    ret->uncertainty_ns = TTF_NS_UNKNOWN;
    if (utc < TTF_UTC_EARLIEST_NS)
        return;
    if (state >= 0 && state != TIME_ERROR && !(tx.status & STA_UNSYNC)) {
        ret->trust = TTF_TRUST_NTP;
        ret->uncertainty_ns = (int64_t)tx.maxerror * TTF_NS_PER_US + reading;
    } else if (u->rtc) {
        ret->trust = TTF_TRUST_RTC;
        ret->uncertainty_ns = RTC_UNCERTAINTY_NS;
    }
}
