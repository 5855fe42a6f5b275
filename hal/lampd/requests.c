/* SPDX-License-Identifier: Apache-2.0 */
/* requests.c: what clients ask of the guardian. */
#include <errno.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "lampd_private.h"

void lampd_let_go(struct ttf_lampd *d, unsigned c)
{
    (void)close(d->client[c]);
    d->client[c] = -1;
    if (d->holder != (int)c)
        return;
    /* It ended or was killed: nobody is there whose lamps they are. */
    d->holder = -1;
    ttf_guardian_release(&d->guardian, ttf_clock_now_ns(d->config.clock));
}

/* Whoever knows its temperature, door or end can turn a lamp off; on only the lease's holder. */
static int set(struct ttf_lampd *d, unsigned c, int64_t now_ns, unsigned i, unsigned permille)
{
    int r;

    if (i >= d->guardian.n || permille > TTF_LAMP_FULL)
        return -EINVAL;
    if (permille > 0 && d->holder != (int)c)
        return -ESTALE;
    if (permille > 0 && (d->lost || d->failed[i]))
        return -ENODEV;
    r = ttf_guardian_set(&d->guardian, now_ns, i, permille);
    lampd_drive(d, now_ns);
    return r < 0 ? r : d->failed[i] ? -ENODEV : 0;
}

static int acquire(struct ttf_lampd *d, unsigned c, int64_t now_ns)
{
    int r = d->lost ? -ENODEV : ttf_guardian_acquire(&d->guardian, now_ns);

    if (r == 0)
        d->holder = (int)c;
    return r;
}

static int renew(struct ttf_lampd *d, unsigned c, int64_t now_ns)
{
    return d->holder == (int)c ? ttf_guardian_renew(&d->guardian, now_ns) : -ESTALE;
}

static int release(struct ttf_lampd *d, unsigned c, int64_t now_ns)
{
    if (d->holder != (int)c)
        return 0;
    d->holder = -1;
    ttf_guardian_release(&d->guardian, now_ns);
    return 0;
}

static int door(struct ttf_lampd *d)
{
    return d->config.door < 0 ? -ENOTSUP : d->guardian.door_open;
}

static int do_op(struct ttf_lampd *d, unsigned c, const struct wire_request *q, int64_t now_ns)
{
    switch (q->op) {
    case WIRE_HELLO:
        return 0;
    case WIRE_ACQUIRE:
        return acquire(d, c, now_ns);
    case WIRE_RENEW:
        return renew(d, c, now_ns);
    case WIRE_SET:
        return set(d, c, now_ns, q->lamp, q->permille);
    case WIRE_CLEAR:
        return q->lamp < d->guardian.n ? ttf_guardian_clear(&d->guardian, now_ns, q->lamp)
                                       : -EINVAL;
    case WIRE_RELEASE:
        return release(d, c, now_ns);
    case WIRE_DOOR:
        return door(d);
    case WIRE_INFO:
    case WIRE_STATE:
        return q->lamp < d->guardian.n ? 0 : -EINVAL;
    default:
        return -ENOSYS;
    }
}

static void describe(const struct ttf_lampd *d, unsigned i, struct wire_answer *a)
{
    const struct ttf_guardian_lamp *lamp = &d->guardian.lamp[i];

    a->info = d->guardian.info[i];
    a->state = (struct ttf_lamp_state){
        .commanded_permille = lamp->commanded_permille,
        .actual_permille = d->failed[i] ? d->driven[i] : lamp->actual_permille,
        .measured_permille = -1,
        .trip = lamp->trip,
        .on_since_ns = lamp->on_since_ns,
        .on_total_ns = lamp->on_total_ns,
    };
}

void lampd_hear(struct ttf_lampd *d, unsigned c)
{
    struct wire_answer answer;
    struct wire_request q;
    ssize_t n = recv(d->client[c], &q, sizeof(q), MSG_DONTWAIT);
    int64_t now_ns;

    if (n < 0 && (errno == EAGAIN || errno == EINTR))
        return;
    if (n != (ssize_t)sizeof(q) || q.magic != WIRE_MAGIC) {
        lampd_let_go(d, c);
        return;
    }
    now_ns = ttf_clock_now_ns(d->config.clock);
    lampd_drive(d, now_ns); /* limits that struck before this was asked come first */
    memset(&answer, 0, sizeof(answer));
    answer.magic = WIRE_MAGIC;
    answer.op = q.op;
    answer.number = q.number;
    answer.n_lamps = (uint16_t)d->guardian.n;
    answer.result = do_op(d, c, &q, now_ns);
    answer.door_opened_ns = d->door_opened_ns;
    answer.door_closed_ns = d->door_closed_ns;
    lampd_drive(d, now_ns);
    if (q.flags & WIRE_SILENT)
        return;
    if (q.lamp < d->guardian.n)
        describe(d, q.lamp, &answer);
    /* Who does not take its answers is not waited for. */
    if (send(d->client[c], &answer, sizeof(answer), MSG_DONTWAIT | MSG_NOSIGNAL) !=
        (ssize_t)sizeof(answer))
        lampd_let_go(d, c);
}
