/* SPDX-License-Identifier: Apache-2.0 */
/* program.h: programs that are installed together with this one. */
#ifndef TTF_HAL_PROGRAM_H
#define TTF_HAL_PROGRAM_H

#include "ttf/base/attr.h"

#define TTF_PROGRAM_PATH_MAX 4096

/*
 * Where the program of that name is (without a slash, shorter than 64): beside the running one, as in a folder that was copied, else where one in
 * PREFIX/bin has it, in PREFIX/lib/ttfbox. -ENOENT: it is at neither, or nobody can tell where this one lies; -EACCES: it is there, and may not be run.
 */
TTF_MUST_USE int ttf_program_find(const char *name, char ret[TTF_PROGRAM_PATH_MAX]);

#endif
