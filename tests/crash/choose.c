/* SPDX-License-Identifier: Apache-2.0 */
#include "choose.h"

void choose_kept(struct draw *draw, const struct disk *disk, struct disk_kept *kept)
{
    static const unsigned percents[] = {0, 10, 50, 50, 90, 100};
    unsigned n = disk_effects(disk), i, percent = percents[draw_below(draw, 6)], upto = n;
    size_t bytes;
    uint16_t a, b;

    if (draw_below(draw, 4) == 0) {
        upto = (unsigned)draw_below(draw, n + 1);
        percent = 100;
    }
    for (i = 0; i < n; i++) {
        bytes = disk_effect_bytes(disk, i);
        kept[i] = (struct disk_kept){0, 0};
        if (i >= upto || draw_below(draw, 100) >= percent)
            continue;
        kept[i].to = (uint16_t)(bytes ? bytes : 1);
        if (bytes > 1 && draw_below(draw, 5) == 0) {
            a = (uint16_t)draw_below(draw, bytes);
            b = (uint16_t)draw_below(draw, bytes + 1);
            kept[i] = draw_below(draw, 2) ? (struct disk_kept){0, b}
                                          : (struct disk_kept){a, (uint16_t)bytes};
        }
    }
}
