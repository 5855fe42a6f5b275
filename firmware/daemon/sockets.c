/* SPDX-License-Identifier: Apache-2.0 */
#include "sockets.h"

#include <string.h>
#include <sys/stat.h>

#include "log.h"

/* Each has a place. */
_Static_assert(sizeof((struct ttf_daemon_config *)0)->listen /
                       sizeof *((struct ttf_daemon_config *)0)->listen <=
                   TTF_HTTP_PLACES_MAX,
               "places");

static void listening(const struct ttf_http_place *place)
{
    /* The folder that it lies in says who reaches it: /run/ttfbox is the group's. */
    if (strncmp(place->at, "unix:", 5) == 0)
        (void)chmod(place->at + 5, 0660);
    if (strcmp(place->text, place->at) == 0)
        log_line(LOG_LEVEL_NOTICE, "listening", "at=\"%s\"", place->name);
    else
        log_line(LOG_LEVEL_NOTICE, "listening", "at=\"%s\" for=\"%s\"", place->name, place->text);
}

static void tell(void *ctx, enum ttf_http_place_news news, const struct ttf_http_place *place,
                 const struct ttf_err *err)
{
    char text[900], quoted[1000];

    (void)ctx;
    switch (news) {
    case TTF_HTTP_PLACE_LISTENING:
        listening(place);
        break;
    case TTF_HTTP_PLACE_LEFT:
        log_line(LOG_LEVEL_NOTICE, "left", "at=\"%s\"", place->name);
        break;
    case TTF_HTTP_PLACE_UNREACHABLE:
        log_line(LOG_LEVEL_WARNING, "unreachable", "at=\"%s\" why=%s", place->text,
                 log_text(ttf_err_text(err, text, sizeof text), quoted, sizeof quoted));
        break;
    }
}

void sockets_init(struct ttf_http_places *places, const struct ttf_daemon_config *config)
{
    *places = (struct ttf_http_places){.address_of = ttf_http_address_of,
                                       .sys = "/sys",
                                       .as_ever = config->listen_as_ever,
                                       .tell = tell};
    for (unsigned i = 0; i < config->n_listen; i++)
        (void)!ttf_http_places_add(places, config->listen[i]);
}
