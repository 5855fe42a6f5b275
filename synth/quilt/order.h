/* SPDX-License-Identifier: Apache-2.0 */
/*
 * order.h: all blocks of a plan, placed by all threads, with the result of raster order. Block (column c, row r) overlaps
 * (c-1, r), (c-1, r-1), (c, r-1) and (c+1, r-1): so a row may follow the one above two blocks behind, and each row is one
 * thread's at a time. Where repetition is avoided a block looks as far as (c+3, r-1). (A tileable output's edges meet blocks
 * that come later, and the search over all frames has one state: these are placed one by one.)
 */
#ifndef TTF_SYNTH_QUILT_ORDER_H
#define TTF_SYNTH_QUILT_ORDER_H

#include "quilt/ahead.h"
#include "quilt/plan_private.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"

/* Side by side. ahead: rows are handed on to it as they become final; NULL: not. -ENOMEM, -ECANCELED, ahead's sink's. */
TTF_MUST_USE int ttf_order_rows(struct ttf_plan *plan, struct ttf_ahead *ahead,
                                struct ttf_err *err);

/* One by one. -ENOMEM, -ECANCELED. */
TTF_MUST_USE int ttf_order_raster(struct ttf_plan *plan, struct ttf_err *err);

#endif
