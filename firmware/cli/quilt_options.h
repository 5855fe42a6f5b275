/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_options.h: what was typed as a quilting's configuration; what makes no sense together is refused. */
#ifndef CLI_QUILT_OPTIONS_H
#define CLI_QUILT_OPTIONS_H

#include "cli.h"
#include "quilt_sink.h"
#include "ttf/synth/quilt.h"

/* All that can be told from the options alone. -EINVAL naming the option; -EEXIST. */
TTF_MUST_USE int quilt_options_check(struct cli *cli, enum quilt_sink_kind *ret_kind);

/*
 * Defaults and all values. Sizes are for an input as it is; width 0: not said. Of --block auto the
 * default, until the input was looked at.
 */
TTF_MUST_USE int quilt_options_config(struct cli *cli, enum quilt_sink_kind kind,
                                      struct ttf_quilt_config *ret);

/* Will pixels have a pace of their own: by an option, or by what the command is? */
bool quilt_options_pace(const struct cli *cli);

/*
 * The same for an input that was shrunk and of which each step-th frame was kept: sizes of the output, blocks,
 * overlaps, distances; a block's own time, to the nearest frame kept (none where it is less than half of one).
 */
void quilt_config_reduce(struct ttf_quilt_config *config, uint32_t shrink, uint32_t step);

/* The same for a number of frames: to the nearest, at least `least`. */
uint32_t quilt_frames_kept(uint32_t frames, uint32_t step, uint32_t least);

/* An error of a synthesis, which names a field, as one that names the option. Returns code. */
int quilt_options_name(struct cli *cli, int code);

#endif
