/* SPDX-License-Identifier: Apache-2.0 */
#include "meddled.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <string.h>

#include "store_test.h"

static int fault(void *ctx, const char *op, const char *path)
{
    struct meddled *m = ctx;
    const char *meddles = m->meddles;
    char begins[64];

    if (meddles && strcmp(op, "sync") == 0) {
        m->meddles = NULL;
        assert_int_equal(run("cd '%s' && %s", m->path, meddles), 0);
    }
    if (m->before)
        m->before(m->ctx, op);
    snprintf(begins, sizeof(begins), "/%s-", m->new_file);
    return cue_fault(&m->cue, op, strstr(path, begins) ? m->new_file : path);
}

void meddled_begin(struct meddled *m, void **state, const char *new_file)
{
    memset(m, 0, sizeof(*m));
    m->path = in(*state, "d");
    ttf_writer_close(small_create(quick_io(), m->path));
    m->new_file = new_file;
    m->cue = (struct cue){.log = m->log, .log_room = sizeof(m->log)};
    m->io = ttf_io_faulty_create(quick_io(), fault, m);
    assert_non_null(m->io);
}

void meddled_forget_log(struct meddled *m)
{
    m->log[m->cue.log_used = 0] = '\0';
}

void meddled_expect_no_new_file(const struct meddled *m)
{
    assert_int_equal(run("! ls -A '%s' | grep -q -- '%s'", m->path, m->new_file), 0);
}

void meddled_end(struct meddled *m)
{
    ttf_io_faulty_destroy(m->io);
}
