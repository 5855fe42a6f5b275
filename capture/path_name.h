/* SPDX-License-Identifier: Apache-2.0 */
/* path_name.h: a dataset's own name in its path: others lie beside it, or by the same name elsewhere. */
#ifndef TTF_CAPTURE_PRIVATE_PATH_NAME_H
#define TTF_CAPTURE_PRIVATE_PATH_NAME_H

#include <stddef.h>

/* Where the last part begins, and its length without slashes behind it. What is before is the folder with its slash; empty: the present one. */
size_t ttf_path_name(const char *path, size_t *ret_length);

#endif
