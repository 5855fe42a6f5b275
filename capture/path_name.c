/* SPDX-License-Identifier: Apache-2.0 */
#include "path_name.h"

#include <string.h>

size_t ttf_path_name(const char *path, size_t *ret_length)
{
    size_t n = strlen(path);
    size_t at;

    while (n > 1 && path[n - 1] == '/')
        n--;
    for (at = n; at > 0 && path[at - 1] != '/'; at--)
        ;
    *ret_length = n - at;
    return at;
}
