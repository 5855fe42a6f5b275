/* SPDX-License-Identifier: Apache-2.0 */
/* JPEG files, told by their first bytes: whatever follows, none of another kind gets in here. */
#include <string.h>

#include "fuzz.h"
#include "picture.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const uint8_t BEGIN[] = {0xff, 0xd8, 0xff};

    if (size >= sizeof BEGIN && memcmp(data, BEGIN, sizeof BEGIN) == 0)
        fuzz_picture(data, size);
    return 0;
}
