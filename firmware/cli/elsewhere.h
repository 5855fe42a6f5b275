/* SPDX-License-Identifier: Apache-2.0 */
/* elsewhere.h: the rest of a run whose first storage failed. */
#ifndef CLI_ELSEWHERE_H
#define CLI_ELSEWHERE_H

#include "cli.h"
#include "ttf/dataset/reader.h"

/*
 * Of a dataset that may be the first part of a run: says where the rest lies (to people as a line, and as
 * "goes_on_in"), or, if its second storage is not there, that nobody can know. Silent of any other.
 */
void cli_say_elsewhere(struct cli *cli, struct ttf_reader *reader);

#endif
