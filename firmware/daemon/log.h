/* SPDX-License-Identifier: Apache-2.0 */
/* log.h: lines on standard error that people, and the journal, can read (README.md, "Lines"). */
#ifndef DAEMON_LOG_H
#define DAEMON_LOG_H

#include <stddef.h>

#include "ttf/base/attr.h"

/* As <syslog.h> numbers them. */
enum log_level {
    LOG_LEVEL_ALERT = 1,
    LOG_LEVEL_ERROR = 3,
    LOG_LEVEL_WARNING = 4,
    LOG_LEVEL_NOTICE = 5,
    LOG_LEVEL_INFO = 6
};

/* One line, written at once. Any thread. fmt: "key=%d key=%s ...", texts through log_text. */
void log_line(enum log_level level, const char *word, const char *fmt, ...) TTF_PRINTF(3, 4);

/* text in quotes, on one line, cut to what fits. Returns buf. */
const char *log_text(const char *text, char *buf, size_t size);

#endif
