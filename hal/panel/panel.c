/* SPDX-License-Identifier: Apache-2.0 */
/* panel.c: the thread that holds the panel's lines, and what the loop asks of it. */
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "button.h"
#include "light.h"
#include "ttf/hal/lampd.h"
#include "ttf/hal/panel_lines.h"

#define EVENTS_MAX 16
#define ROUND_NS   (50 * TTF_NS_PER_MS) /* of lines without a descriptor to wait on */
#define REOPEN_NS  TTF_NS_PER_S

struct lines_panel {
    struct ttf_panel base; /* first: downcast by address */
    struct ttf_panel_lines_config c;
    struct ttf_door_past door; /* as it was told of last; the loop's alone */
    pthread_t thread;
    bool running;
    int wake; /* readable when the thread has to look up */

    /* the thread's alone */
    struct button button;
    int lit; /* -1: not known */
    int64_t reopen_at_ns;
    bool lost;

    pthread_mutex_t lock; /* of what follows */
    bool ending;
    enum ttf_led led;
    int64_t led_since_ns;
    bool held;
    unsigned n_events; /* oldest first */
    struct ttf_panel_event events[EVENTS_MAX];
};

/* ---- the thread ---- */

static void push(struct lines_panel *p, const struct ttf_panel_event *event)
{
    pthread_mutex_lock(&p->lock);
    if (p->n_events == EVENTS_MAX)
        memmove(&p->events[0], &p->events[1], --p->n_events * sizeof(p->events[0]));
    p->events[p->n_events++] = *event;
    pthread_mutex_unlock(&p->lock);
}

static void heed(struct lines_panel *p, int r)
{
    if (r == -ENODEV)
        p->lost = true;
}

/* When the light changes next; TTF_NS_NEVER. */
static int64_t drive(struct lines_panel *p, int64_t now_ns)
{
    int64_t next_ns;
    bool lit;
    int r;

    pthread_mutex_lock(&p->lock);
    lit = light_at(p->led, p->led_since_ns, now_ns, &next_ns);
    pthread_mutex_unlock(&p->lock);
    if (p->c.led < 0 || p->lost)
        return TTF_NS_NEVER;
    if ((int)lit != p->lit) {
        r = ttf_lines_set(p->c.lines, (unsigned)p->c.led, lit ? 1000 : 0);
        heed(p, r);
        p->lit = r == 0 ? (int)lit : -1;
    }
    return next_ns;
}

/*
 * The kernel keeps a few edges of a line and drops the newest, so of a wire that bounces the last one that is told may not be the
 * last there was: its level is asked after edges, and once more before anything is made of it.
 */
static void ask_button(struct lines_panel *p, bool moved, int64_t now_ns)
{
    int level;

    if (p->lost || (!moved && now_ns < button_next_ns(&p->button)))
        return;
    level = ttf_lines_get(p->c.lines, (unsigned)p->c.button);
    heed(p, level);
    if (level >= 0 && moved)
        button_level(&p->button, level == 1, now_ns);
    else if (level >= 0)
        button_missed(&p->button, level == 1, now_ns);
}

static int64_t feel(struct lines_panel *p, int64_t now_ns)
{
    struct ttf_panel_event pressed;
    struct ttf_line_event event;
    bool moved = false;
    int r = 0;

    if (p->c.button < 0 || p->lost)
        return TTF_NS_NEVER;
    while ((r = ttf_lines_event(p->c.lines, &event)) > 0)
        if ((int)event.i == p->c.button) {
            button_level(&p->button, event.active, now_ns);
            moved = true;
        }
    heed(p, r);
    ask_button(p, moved, now_ns);
    while (button_look(&p->button, now_ns, &pressed))
        push(p, &pressed);
    pthread_mutex_lock(&p->lock);
    p->held = button_held(&p->button);
    pthread_mutex_unlock(&p->lock);
    return button_next_ns(&p->button);
}

static int64_t look_for_chip(struct lines_panel *p, int64_t now_ns)
{
    if (!p->lost)
        return TTF_NS_NEVER;
    if (now_ns >= p->reopen_at_ns) {
        p->reopen_at_ns = now_ns + REOPEN_NS;
        if (ttf_lines_reopen(p->c.lines, NULL) == 0) {
            p->lost = false;
            p->lit = -1;
            button_init(&p->button,
                        p->c.button >= 0 && ttf_lines_get(p->c.lines, (unsigned)p->c.button) == 1,
                        now_ns);
            return now_ns;
        }
    }
    return p->reopen_at_ns;
}

static int64_t sooner(int64_t a_ns, int64_t b_ns)
{
    return a_ns < b_ns ? a_ns : b_ns;
}

static void wait_for_anything(struct lines_panel *p, int64_t until_ns)
{
    int lines = p->c.lines && !p->lost ? ttf_lines_fd(p->c.lines) : -1;
    struct pollfd fds[2] = {{.fd = p->wake, .events = POLLIN}, {.fd = lines, .events = POLLIN}};
    int64_t now_ns = ttf_clock_now_ns(p->c.clock), wait_ns;
    int wait_ms = -1;
    uint64_t count;

    if (lines < 0 && p->c.button >= 0)
        until_ns = sooner(until_ns, now_ns + ROUND_NS);
    if (until_ns != TTF_NS_NEVER) {
        wait_ns = until_ns > now_ns ? until_ns - now_ns : 0;
        wait_ms = (int)((wait_ns + TTF_NS_PER_MS - 1) / TTF_NS_PER_MS); /* a few seconds at most */
    }
    if (poll(fds, 2, wait_ms) > 0 && fds[0].revents)
        (void)!read(p->wake, &count, sizeof(count));
}

static void *run(void *arg)
{
    struct lines_panel *p = arg;
    bool ending = false;

    while (!ending) {
        int64_t now_ns = ttf_clock_now_ns(p->c.clock);
        int64_t next_ns = look_for_chip(p, now_ns);

        next_ns = sooner(next_ns, drive(p, now_ns));
        next_ns = sooner(next_ns, feel(p, now_ns));
        wait_for_anything(p, p->lost ? sooner(next_ns, p->reopen_at_ns) : next_ns);
        pthread_mutex_lock(&p->lock);
        ending = p->ending;
        pthread_mutex_unlock(&p->lock);
    }
    return NULL;
}

static void wake(struct lines_panel *p)
{
    const uint64_t one = 1;

    (void)!write(p->wake, &one, sizeof(one));
}

/* ---- operations ---- */

static int panel_led(struct ttf_panel *base, enum ttf_led led)
{
    struct lines_panel *p = (struct lines_panel *)base;

    if (p->c.led < 0)
        return -ENOTSUP;
    pthread_mutex_lock(&p->lock);
    p->led = led;
    p->led_since_ns = ttf_clock_now_ns(p->c.clock);
    pthread_mutex_unlock(&p->lock);
    wake(p);
    return 0;
}

static int panel_door(struct ttf_panel *base)
{
    struct lines_panel *p = (struct lines_panel *)base;

    return p->c.lamps ? ttf_lamps_lampd_door(p->c.lamps, NULL) : -ENOTSUP;
}

/* The guardian knows when the door moved, however long ago it was asked last. */
static bool door_moved(struct lines_panel *p, struct ttf_panel_event *ret)
{
    struct ttf_door_past now;
    bool opened, closed;

    if (!p->c.lamps || ttf_lamps_lampd_door(p->c.lamps, &now) < 0)
        return false;
    opened = now.opened_ns != TTF_NS_UNKNOWN && now.opened_ns != p->door.opened_ns;
    closed = now.closed_ns != TTF_NS_UNKNOWN && now.closed_ns != p->door.closed_ns;
    if (opened && (!closed || now.opened_ns <= now.closed_ns)) {
        p->door.opened_ns = now.opened_ns;
        *ret = (struct ttf_panel_event){TTF_PANEL_DOOR_OPENED, now.opened_ns};
        return true;
    }
    if (closed) {
        p->door.closed_ns = now.closed_ns;
        *ret = (struct ttf_panel_event){TTF_PANEL_DOOR_CLOSED, now.closed_ns};
    }
    return closed;
}

static int panel_poll(struct ttf_panel *base, struct ttf_panel_event *ret)
{
    struct lines_panel *p = (struct lines_panel *)base;
    bool any;

    pthread_mutex_lock(&p->lock);
    any = p->n_events > 0;
    if (any) {
        *ret = p->events[0];
        memmove(&p->events[0], &p->events[1], --p->n_events * sizeof(p->events[0]));
    }
    pthread_mutex_unlock(&p->lock);
    return any || door_moved(p, ret);
}

static int panel_held(struct ttf_panel *base)
{
    struct lines_panel *p = (struct lines_panel *)base;
    bool held;

    if (p->c.button < 0)
        return -ENOTSUP;
    pthread_mutex_lock(&p->lock);
    held = p->held;
    pthread_mutex_unlock(&p->lock);
    return held;
}

static void panel_destroy(struct ttf_panel *base)
{
    struct lines_panel *p = (struct lines_panel *)base;

    if (p->running) {
        pthread_mutex_lock(&p->lock);
        p->ending = true;
        pthread_mutex_unlock(&p->lock);
        wake(p);
        pthread_join(p->thread, NULL);
    }
    ttf_lines_destroy(p->c.lines); /* dark */
    if (p->wake >= 0)
        (void)close(p->wake);
    pthread_mutex_destroy(&p->lock);
    free(p);
}

static const struct ttf_panel_ops OPS = {.name = "lines",
                                         .led = panel_led,
                                         .door = panel_door,
                                         .poll = panel_poll,
                                         .held = panel_held,
                                         .destroy = panel_destroy};

/* ---- beginning ---- */

static bool is_line(const struct ttf_panel_lines_config *c, int i, bool input)
{
    return i < 0 || (c->lines && (unsigned)i < ttf_lines_count(c->lines) &&
                     ttf_lines_spec(c->lines, (unsigned)i)->input == input);
}

static int start(struct lines_panel *p, struct ttf_err *err)
{
    int64_t now_ns = ttf_clock_now_ns(p->c.clock);
    int r;

    p->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (p->wake < 0)
        return ttf_err_set(err, -errno, "panel", "no descriptor to wake its thread by");
    button_init(&p->button,
                p->c.button >= 0 && ttf_lines_get(p->c.lines, (unsigned)p->c.button) == 1, now_ns);
    if (p->c.lamps && ttf_lamps_lampd_door(p->c.lamps, &p->door) < 0)
        p->door = (struct ttf_door_past){TTF_NS_UNKNOWN, TTF_NS_UNKNOWN};
    if (p->c.button < 0 && p->c.led < 0)
        return 0;
    r = pthread_create(&p->thread, NULL, run, p);
    p->running = r == 0;
    return r ? ttf_err_set(err, -r, "panel", "no thread for it") : 0;
}

int ttf_panel_lines_create(const struct ttf_panel_lines_config *config, struct ttf_panel **ret,
                           struct ttf_err *err)
{
    struct lines_panel *p = calloc(1, sizeof(*p));
    int r = 0;

    if (!p) {
        ttf_lines_destroy(config->lines);
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    }
    p->base.ops = &OPS;
    p->c = *config;
    p->wake = p->lit = -1;
    pthread_mutex_init(&p->lock, NULL);
    if (!is_line(config, config->button, true) || !is_line(config, config->led, false))
        r = ttf_err_set(err, -EINVAL, "panel", "a button is an input line, a light an output");
    if (r == 0)
        r = start(p, err);
    if (r < 0) {
        panel_destroy(&p->base);
        return r;
    }
    *ret = &p->base;
    return 0;
}
