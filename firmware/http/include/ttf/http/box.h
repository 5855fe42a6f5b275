/* SPDX-License-Identifier: Apache-2.0 */
/*
 * box.h: the box behind the interface, as a table of what can be asked of it. Whoever runs a box fills it; the server
 * knows no more of a box than this.
 *
 * Functions are called from the server's threads, several at once. They return 0, or a negative errno with *err set, which becomes
 * the answer's status: -EINVAL 400, -EPERM 403, -ENOENT 404, -EBUSY and -EEXIST 409, -ENODEV and -EAGAIN 503. Texts
 * that they give are by malloc and the caller's. Shapes of JSON: openapi.yaml. None may wait for a slot, and none may hold what a slot waits for.
 */
#ifndef TTF_HTTP_BOX_H
#define TTF_HTTP_BOX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/calibration.h"
#include "ttf/dataset/notes.h"

struct ttf_http_box;

enum ttf_http_ask_kind {
    TTF_HTTP_ASK_STOP = 0,
    TTF_HTTP_ASK_PAUSE,
    TTF_HTTP_ASK_RESUME,
    TTF_HTTP_ASK_COUNT,
    TTF_HTTP_ASK_UNTIL,
    TTF_HTTP_ASK_INTERVAL,
    TTF_HTTP_ASK_KIND_COUNT
};

/* Something asked of the run under way. */
struct ttf_http_ask {
    enum ttf_http_ask_kind kind;
    char reason[120]; /* PAUSE */
    int64_t value;    /* COUNT: slots; UNTIL: UTC in ns; INTERVAL: ns */
};

#define TTF_HTTP_LAMPS_MAX 8

/* What a picture from the camera is to be like. */
struct ttf_http_view {
    char camera[32];     /* empty: the first */
    int64_t exposure_ns; /* 0: one that suits */
    int64_t gain_milli;  /* 0: the least */
    unsigned n_lamps;
    struct {
        char name[32];
        unsigned level_permille;
    } lamps[TTF_HTTP_LAMPS_MAX];
    uint32_t x, y, width, height; /* width 0: all of it, shrunk to fit */
};

/* What it became. */
struct ttf_http_shown {
    void *jpeg; /* by malloc */
    size_t bytes;
    int64_t exposure_ns; /* as the camera did it; 0: not known */
    int64_t gain_milli;
};

/* A step of a calibration. */
struct ttf_http_calibrate {
    char name[65]; /* of the calibration that it goes into */
    enum ttf_calibration_part part;
    char plan[65];        /* whose first shot it is for; empty: all lamps, fully lit */
    int64_t exposure_ns;  /* 0: the plan's */
    int64_t gain_milli;   /* 0: the plan's */
    unsigned frames;      /* averaged; 0: as many as suit */
    double reflectance;   /* of the flat's target, 0..1; 0: not said */
    double pitch_mm;      /* of the geometry's dots */
    double corners[4][2]; /* of the chart, in the camera's pixels */
};

struct ttf_http_box_ops {
    const char *name;
    int (*status)(struct ttf_http_box *box, char **ret_json, struct ttf_err *err);
    int (*devices)(struct ttf_http_box *box, char **ret_json, struct ttf_err *err); /* slow */
    int (*boards)(struct ttf_http_box *box, char **ret_json, struct ttf_err *err);
    /* plan: NULL: the board's own file */
    int (*board)(struct ttf_http_box *box, const char *name, const char *plan, char **ret_yaml,
                 struct ttf_err *err);
    /* yaml has a zero behind it */
    int (*board_check)(struct ttf_http_box *box, const char *yaml, size_t bytes, char **ret_json,
                       struct ttf_err *err);
    /* Kept and listed, never put in force. put: -EINVAL, and nothing has changed, where it would not do */
    int (*board_put)(struct ttf_http_box *box, const char *name, const char *yaml, size_t bytes,
                     char **ret_json, struct ttf_err *err);
    int (*board_delete)(struct ttf_http_box *box, const char *name, struct ttf_err *err);
    int (*plans)(struct ttf_http_box *box, char **ret_json, struct ttf_err *err);
    int (*plan)(struct ttf_http_box *box, const char *name, char **ret_yaml, struct ttf_err *err);
    /* slow; yaml has a zero behind it. put: -EINVAL, and nothing has changed, where it would not do */
    int (*plan_check)(struct ttf_http_box *box, const char *yaml, size_t bytes, char **ret_json,
                      struct ttf_err *err);
    int (*plan_put)(struct ttf_http_box *box, const char *name, const char *yaml, size_t bytes,
                    char **ret_json, struct ttf_err *err);
    int (*plan_delete)(struct ttf_http_box *box, const char *name, struct ttf_err *err);
    /* plan, dataset: empty: not said */
    int (*start)(struct ttf_http_box *box, const char *plan, const char *dataset, char **ret_json,
                 struct ttf_err *err);
    int (*ask)(struct ttf_http_box *box, const struct ttf_http_ask *ask, char **ret_json,
               struct ttf_err *err);
    int (*asked)(struct ttf_http_box *box, int64_t number, char **ret_json, struct ttf_err *err);
    /* A PC's UTC, for a box that has none better: {"taken","why"} */
    int (*time)(struct ttf_http_box *box, int64_t utc_ns, char **ret_json, struct ttf_err *err);
    /* slow: it is synced */
    int (*note)(struct ttf_http_box *box, const char *dataset, const struct ttf_note *note,
                struct ttf_err *err);
    /* A step is asked for, and done while nothing runs; what came of it, calibrations tells */
    int (*calibrations)(struct ttf_http_box *box, char **ret_json, struct ttf_err *err);
    int (*calibrate)(struct ttf_http_box *box, const struct ttf_http_calibrate *what,
                     char **ret_json, struct ttf_err *err);
    /* name: empty: the configuration's again */
    int (*calibration_use)(struct ttf_http_box *box, const char *name, struct ttf_err *err);
    /* slow. -EBUSY: something needs it */
    int (*calibration_delete)(struct ttf_http_box *box, const char *name, struct ttf_err *err);
    /* slow. A JPEG. -EBUSY: a run is under way */
    int (*live)(struct ttf_http_box *box, const struct ttf_http_view *view,
                struct ttf_http_shown *ret, struct ttf_err *err);
    /* Does the box's token wait to be shown, once? NULL: it never does. */
    bool (*token_waits)(struct ttf_http_box *box);
    /* slow: that it is shown now reaches the disk before it is. 0, once; -EEXIST: it does not wait. NULL: never */
    int (*token_show)(struct ttf_http_box *box, struct ttf_err *err);
    /* The dataset of the run under way, or of the last one. -ENOENT: there was none */
    int (*newest)(struct ttf_http_box *box, char ret_dataset[65], struct ttf_err *err);
};

/* Embedded first by whoever has a box. */
struct ttf_http_box {
    const struct ttf_http_box_ops *ops;
};

#endif
