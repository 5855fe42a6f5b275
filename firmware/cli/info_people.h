/* SPDX-License-Identifier: Apache-2.0 */
/* info_people.h: what people added to a dataset, for `ttfbox info`. */
#ifndef CLI_INFO_PEOPLE_H
#define CLI_INFO_PEOPLE_H

#include "cli.h"

/* Notes and samples, if there are any. A disk that cannot be read is an error in cli->err. */
TTF_MUST_USE int cli_say_people(struct cli *cli, const char *path);

#endif
