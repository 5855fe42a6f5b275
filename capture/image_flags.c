/* SPDX-License-Identifier: Apache-2.0 */
#include "image_flags.h"

#include <stdio.h>
#include <string.h>

void ttf_image_flag(struct ttf_image *image, const char *word)
{
    size_t used = strlen(image->flags);
    size_t n = strlen(word);

    for (const char *at = image->flags; (at = strstr(at, word)) != NULL; at += n) {
        if ((at == image->flags || at[-1] == ',') && (at[n] == ',' || at[n] == '\0'))
            return;
    }
    snprintf(image->flags + used, sizeof(image->flags) - used, "%s%s", used ? "," : "", word);
}
