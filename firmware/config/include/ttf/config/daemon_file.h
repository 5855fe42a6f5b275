/* SPDX-License-Identifier: Apache-2.0 */
/* daemon_file.h: the configuration of ttfboxd from YAML. The language: firmware/config/README.md. */
#ifndef TTF_CONFIG_DAEMON_FILE_H
#define TTF_CONFIG_DAEMON_FILE_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/config/board_file.h"

#define TTF_DAEMON_SETS_MAX   16
#define TTF_DAEMON_LISTEN_MAX 8
#define TTF_DAEMON_NAMES_MAX  6

/* Where it listens unless its configuration says otherwise. */
#define TTF_DAEMON_LISTEN_TCP  "127.0.0.1:8417"
#define TTF_DAEMON_LISTEN_UNIX "unix:/run/ttfbox/http.sock"
#define TTF_DAEMON_LISTEN_USB \
    "usb0:8417" /* the network over the USB cable to a PC; where there is none, nothing */

struct ttf_daemon_config {
    char board[512];   /* a board's name, or the path of its file */
    char plan[512];    /* the plan's file; it need not be there yet. Empty: runs are asked for */
    char data[512];    /* the folder of datasets */
    char dataset[512]; /* the one to make: data, a slash and its name. Empty without a plan */
    char state[512];   /* the folder of what is to outlive a restart: plans, what was asked for */
    char token_file[512];  /* made if it is missing */
    char calibration[512]; /* empty: none */
    char zone[64];         /* of plans that name none; empty: UTC */
    uint32_t threads;      /* 0: all */
    int64_t retry_ns;  /* what failed is tried again after this, doubled each time up to 12 times */
    unsigned n_listen; /* 0: nowhere */
    bool listen_as_ever; /* its configuration says nothing of it */
    char listen[TTF_DAEMON_LISTEN_MAX][128];
    unsigned
        n_names; /* of the box, beside its addresses, its name in the network and its serial's */
    char names[TTF_DAEMON_NAMES_MAX][128];
    unsigned n_sets; /* changes of the board */
    struct {
        char path[128], value[256];
    } set[TTF_DAEMON_SETS_MAX];
};

/* Where a board is looked for by its name, NULL-ended: the same for ttfboxd and for who guards its lamps. */
const char *const *ttf_daemon_board_folders(void);

/* Paths count from the file's own folder. Errors as ttf_board_load. */
TTF_MUST_USE int ttf_daemon_file_load(const char *path, struct ttf_daemon_config *ret,
                                      struct ttf_err *err);
TTF_MUST_USE int ttf_daemon_file_parse(const char *name, const char *text, size_t bytes,
                                       struct ttf_daemon_config *ret, struct ttf_err *err);

/*
 * The same for who needs nothing but the board and its changes, and must not be kept from it by a mistake elsewhere:
 * `board` and `set` are read and checked, all other keys are passed over, whatever they hold. The rest of *ret is zero.
 */
TTF_MUST_USE int ttf_daemon_file_load_board(const char *path, struct ttf_daemon_config *ret,
                                            struct ttf_err *err);
TTF_MUST_USE int ttf_daemon_file_parse_board(const char *name, const char *text, size_t bytes,
                                             struct ttf_daemon_config *ret, struct ttf_err *err);

#endif
