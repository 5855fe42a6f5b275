/* SPDX-License-Identifier: Apache-2.0 */
/* PNG files, told by their first bytes: whatever follows, none of another kind gets in here. */
#include <string.h>

#include "fuzz.h"
#include "picture.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const uint8_t BEGIN[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

    if (size >= sizeof BEGIN && memcmp(data, BEGIN, sizeof BEGIN) == 0)
        fuzz_picture(data, size);
    return 0;
}
