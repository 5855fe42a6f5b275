/* SPDX-License-Identifier: Apache-2.0 */
/* door.h: what can be asked of this box by HTTP (ttf/http/box.h), as a table. */
#ifndef DAEMON_DOOR_H
#define DAEMON_DOOR_H

#include "ttf/http/box.h"

extern const struct ttf_http_box_ops DOOR_OPS;

#endif
