/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/hal/lines.h"

#include <errno.h>
#include <stddef.h>
#include <string.h>

unsigned ttf_lines_count(const struct ttf_lines *lines)
{
    return lines->n;
}

const struct ttf_line_spec *ttf_lines_spec(const struct ttf_lines *lines, unsigned i)
{
    return i < lines->n ? &lines->spec[i] : NULL;
}

int ttf_lines_set(struct ttf_lines *lines, unsigned i, unsigned permille)
{
    if (i >= lines->n || lines->spec[i].input || permille > 1000)
        return -EINVAL;
    return lines->ops->set(lines, i, permille);
}

int ttf_lines_get(struct ttf_lines *lines, unsigned i)
{
    return i < lines->n ? lines->ops->get(lines, i) : -EINVAL;
}

int ttf_lines_fd(const struct ttf_lines *lines)
{
    return lines->ops->fd(lines);
}

int ttf_lines_event(struct ttf_lines *lines, struct ttf_line_event *ret)
{
    return lines->ops->event(lines, ret);
}

int ttf_lines_reopen(struct ttf_lines *lines, struct ttf_err *err)
{
    return lines->ops->reopen(lines, err);
}

void ttf_lines_destroy(struct ttf_lines *lines)
{
    if (!lines)
        return;
    for (unsigned i = 0; i < lines->n; i++)
        if (!lines->spec[i].input)
            (void)lines->ops->set(lines, i, 0); /* a chip that is gone cannot be told */
    lines->ops->destroy(lines);
}

int ttf_lines_check(const struct ttf_line_spec *specs, unsigned n, struct ttf_err *err)
{
    if (n == 0 || n > TTF_LINES_MAX)
        return ttf_err_set(err, -EINVAL, "lines", "%u lines; a bank has 1 to %d", n, TTF_LINES_MAX);
    for (unsigned i = 0; i < n; i++) {
        if (specs[i].label[0] == '\0' || specs[i].line[0] == '\0')
            return ttf_err_set(err, -EINVAL, specs[i].label[0] ? specs[i].label : "lines",
                               "line %u has no %s", i, specs[i].label[0] ? "wire" : "label");
        for (unsigned k = 0; k < i; k++)
            if (strcmp(specs[k].label, specs[i].label) == 0)
                return ttf_err_set(err, -EINVAL, specs[i].label, "two lines have this label");
    }
    return 0;
}
