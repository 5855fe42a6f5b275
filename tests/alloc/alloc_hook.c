/* SPDX-License-Identifier: Apache-2.0 */
/* The hook's counters and its decision which allocation fails. It allocates nothing itself. */
#include "alloc_hook.h"

#include <stdatomic.h>
#include <stdint.h>

#include "alloc_hook_private.h"

#define SITES 1024u

/* Made by the linker: where the program begins in memory. */
extern const char
    __executable_start; /* NOLINT(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp) */

struct counters {
    atomic_long calls, live, live_bytes, peak_bytes;
};

struct site {
    _Atomic(const void *) at;
    atomic_long calls, bytes;
};

/* A malloc has no other place to keep what it knows. */
static struct counters counters[2];
static struct site sites[SITES];
static atomic_bool watching;
static atomic_int armed = -1; /* an alloc_whose */
static atomic_long fail_at, asked, failed;
static atomic_bool fail_for_ever;
static _Atomic(const void *) failed_site;
static _Thread_local unsigned paused, ours;

void alloc_hook_pause(void)
{
    paused++;
}

void alloc_hook_resume(void)
{
    paused--;
}

bool alloc_hook_is_paused(void)
{
    return paused > 0;
}

void alloc_hook_enter_ours(void)
{
    ours++;
}

void alloc_hook_leave_ours(void)
{
    ours--;
}

bool alloc_hook_in_ours(void)
{
    return ours > 0;
}

static void remember_site(const void *at, size_t bytes)
{
    size_t i = (uintptr_t)at / 4 % SITES, n;

    for (n = 0; n < SITES; n++, i = (i + 1) % SITES) {
        const void *none = NULL;

        if (sites[i].at == at || atomic_compare_exchange_strong(&sites[i].at, &none, at) ||
            none == at) {
            sites[i].calls++;
            sites[i].bytes += (long)bytes;
            return;
        }
    }
}

bool alloc_hook_asks(enum alloc_whose whose, size_t bytes, const void *site)
{
    long n;

    if (paused > 0)
        return false;
    counters[ALLOC_ALL].calls++;
    if (whose == ALLOC_OURS) {
        counters[ALLOC_OURS].calls++;
        if (watching)
            remember_site(site, bytes);
    }
    if (armed < (int)whose)
        return false;
    n = ++asked;
    if (fail_at == 0 || n < fail_at || (n > fail_at && !fail_for_ever))
        return false;
    if (failed++ == 0)
        failed_site = site;
    return true;
}

static void raise_to(atomic_long *peak, long value)
{
    long was = *peak;

    while (was < value && !atomic_compare_exchange_weak(peak, &was, value))
        ;
}

static void live(struct counters *c, long blocks, long bytes)
{
    c->live += blocks;
    raise_to(&c->peak_bytes, atomic_fetch_add(&c->live_bytes, bytes) + bytes);
}

void alloc_hook_live(bool is_ours, long blocks, long bytes)
{
    live(&counters[ALLOC_ALL], blocks, bytes);
    if (is_ours)
        live(&counters[ALLOC_OURS], blocks, bytes);
}

struct alloc_counts alloc_hook_counts(enum alloc_whose whose)
{
    const struct counters *c = &counters[whose];

    return (struct alloc_counts){.calls = c->calls,
                                 .live = c->live,
                                 .live_bytes = c->live_bytes,
                                 .peak_bytes = c->peak_bytes};
}

void alloc_hook_reset_peak(void)
{
    for (unsigned i = 0; i < 2; i++)
        counters[i].peak_bytes = counters[i].live_bytes;
}

void alloc_hook_arm(enum alloc_whose whose, long n, bool for_ever)
{
    armed = -1;
    asked = failed = 0;
    failed_site = NULL;
    fail_at = n;
    fail_for_ever = for_ever;
    armed = (int)whose;
}

long alloc_hook_disarm(void)
{
    armed = -1;
    return failed;
}

long alloc_hook_asked(void)
{
    return asked;
}

static unsigned long in_program(const void *at)
{
    return at ? (unsigned long)((uintptr_t)at - (uintptr_t)&__executable_start) : 0;
}

unsigned long alloc_hook_failed_site(void)
{
    return in_program(failed_site);
}

void alloc_hook_watch_sites(bool on)
{
    watching = on;
}

void alloc_hook_print_sites(FILE *to)
{
    for (unsigned i = 0; i < SITES; i++)
        if (sites[i].at)
            fprintf(to, "%8ld %12ld 0x%lx\n", (long)sites[i].calls, (long)sites[i].bytes,
                    in_program(sites[i].at));
}
