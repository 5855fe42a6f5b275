/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What clients say to the lamp guardian, each step of the input being a client, how much time passed, and a message: whatever they
 * say, no lamp is lit without a lease, beyond what its line takes, or longer than it may burn.
 */
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "fuzz.h"
#include "lampd_private.h"
#include "ttf/hal/clock_backend.h"

#define LAMPS   2
#define CLIENTS 2
#define STEP    (4 + sizeof(struct wire_request))
#define STEPS   64

struct hand_clock {
    struct ttf_clock base; /* first */
    int64_t now_ns;
};

static int64_t hand_now_ns(struct ttf_clock *clock)
{
    return ((struct hand_clock *)clock)->now_ns;
}

static const struct ttf_clock_ops CLOCK_OPS = {.now_ns = hand_now_ns};

struct hand_lines {
    struct ttf_lines base; /* first */
    unsigned level[LAMPS];
};

static int lines_set(struct ttf_lines *lines, unsigned i, unsigned permille)
{
    if (i >= LAMPS || permille > TTF_LAMP_FULL)
        abort();
    ((struct hand_lines *)lines)->level[i] = permille;
    return 0;
}

static const struct ttf_lines_ops LINES_OPS = {.name = "memory", .set = lines_set};

static const struct ttf_lamp_info INFO[LAMPS] = {
    {.name = "left", .steps = 1000, .max_on_ns = 10 * TTF_NS_PER_S, .max_duty_permille = 500},
    {.name = "right", .max_on_ns = TTF_NS_PER_S}};

static void step(struct ttf_lampd *d, struct hand_clock *clock, const struct hand_lines *lines,
                 int other_end[CLIENTS], const uint8_t *data)
{
    unsigned c = data[0] % CLIENTS;
    size_t n = data[1] & 1 ? sizeof(struct wire_request) : data[1] % sizeof(struct wire_request);
    struct wire_answer answer;

    clock->now_ns += (int64_t)(data[2] | data[3] << 8) * TTF_NS_PER_MS;
    if (d->client[c] >= 0) {
        (void)send(other_end[c], data + 4, n, MSG_DONTWAIT | MSG_NOSIGNAL);
        lampd_hear(d, c);
        (void)recv(other_end[c], &answer, sizeof answer, MSG_DONTWAIT);
    }
    lampd_drive(d, clock->now_ns); /* as the loop does, whoever was heard */
    for (unsigned i = 0; i < LAMPS; i++) {
        const struct ttf_guardian_lamp *lamp = &d->guardian.lamp[i];

        if (lines->level[i] > 0 && (!d->guardian.leased || d->holder < 0 ||
                                    clock->now_ns - lamp->on_since_ns > INFO[i].max_on_ns))
            abort();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct hand_clock clock = {.base.ops = &CLOCK_OPS, .now_ns = 1000 * TTF_NS_PER_S};
    struct hand_lines lines = {.base = {.ops = &LINES_OPS, .n = LAMPS}};
    struct ttf_lampd *d = calloc(1, sizeof *d);
    int other_end[CLIENTS], both[2];

    if (!d)
        return 0;
    d->config = (struct ttf_lampd_config){
        .n = LAMPS, .info = INFO, .lines = &lines.base, .door = -1, .clock = &clock.base};
    d->listening = d->holder = -1;
    d->door_opened_ns = d->door_closed_ns = TTF_NS_UNKNOWN;
    for (unsigned c = 0; c < LAMPD_CLIENTS_MAX; c++)
        d->client[c] = -1;
    for (unsigned c = 0; c < CLIENTS; c++) {
        if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, both) < 0)
            abort();
        d->client[c] = both[0];
        other_end[c] = both[1];
    }
    ttf_guardian_init(&d->guardian, INFO, LAMPS, clock.now_ns);
    for (unsigned i = 0; i < STEPS && size >= STEP; i++, data += STEP, size -= STEP)
        step(d, &clock, &lines, other_end, data);
    for (unsigned c = 0; c < CLIENTS; c++) {
        if (d->client[c] >= 0)
            (void)close(d->client[c]);
        (void)close(other_end[c]);
    }
    free(d);
    return 0;
}
