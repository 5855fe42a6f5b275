/* SPDX-License-Identifier: Apache-2.0 */
/* sockets.h: the places of the configuration (`ttf/http/places.h`), with a line in the log for each change. */
#ifndef DAEMON_SOCKETS_H
#define DAEMON_SOCKETS_H

#include "ttf/config/daemon_file.h"
#include "ttf/http/places.h"

/* config: borrowed. */
void sockets_init(struct ttf_http_places *places, const struct ttf_daemon_config *config);

#endif
