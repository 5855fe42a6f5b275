/* SPDX-License-Identifier: Apache-2.0 */
/* parts.c: which other processes answer. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "alert.h"

static bool connects(const char *path, int type)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    int code;

    if (fd < 0)
        return true; /* a want of ours, not theirs */
    (void)snprintf(address.sun_path, sizeof address.sun_path, "%s", path);
    code = connect(fd, (const struct sockaddr *)&address, sizeof address) == 0 ? 0 : errno;
    (void)close(fd);
    if (code == EPROTOTYPE && type == SOCK_STREAM)
        return connects(path, SOCK_SEQPACKET);
    /* Busy, not allowed, or of yet another kind: somebody listens. */
    return code == 0 || code == EAGAIN || code == EACCES || code == EPERM || code == EPROTOTYPE;
}

/* ttfbox-preview holds its lock as long as it lives; where there is no lock yet, it never lived. */
static bool is_locked(const char *folder)
{
    char path[600];
    bool locked;
    int fd;

    (void)snprintf(path, sizeof path, "%s/.preview/lock", folder);
    fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return errno != ENOENT;
    locked = flock(fd, LOCK_SH | LOCK_NB) < 0 && errno == EWOULDBLOCK;
    (void)close(fd);
    return locked;
}

static void tell(struct parts *p, unsigned i, bool gone)
{
    struct alert alert = {.kind = gone ? "part-gone" : "part-back",
                          .severity = gone ? TTF_ALERT_WARNING : TTF_ALERT_NOTICE,
                          .index = -1};
    struct ttf_utc utc;

    ttf_clock_utc(p->clock, &utc);
    alert.utc_ns = utc.utc_ns;
    (void)snprintf(alert.text, sizeof alert.text, "the %s %s", p->config->parts[i].name,
                   gone ? "does not answer" : "answers again");
    p->told[i] = gone;
    p->tell(p->ctx, &alert);
}

void parts_look(struct parts *p)
{
    int64_t now_ns = ttf_clock_now_ns(p->clock);

    for (unsigned i = 0; i < p->config->n_parts; i++) {
        const struct ttf_alert_part *part = &p->config->parts[i];
        bool there =
            *part->socket ? connects(part->socket, SOCK_STREAM) : is_locked(p->config->data);

        if (there) {
            p->gone_ns[i] = 0;
            if (p->told[i])
                tell(p, i, false);
        } else if (p->gone_ns[i] == 0) {
            p->gone_ns[i] = now_ns;
        } else if (!p->told[i] && now_ns - p->gone_ns[i] >= p->config->grace_ns) {
            tell(p, i, true);
        }
    }
}
