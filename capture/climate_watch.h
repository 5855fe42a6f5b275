/* SPDX-License-Identifier: Apache-2.0 */
/*
 * climate_watch.h: what a box's sensors say together: whether its lens is about to fog, whether its supply sags.
 * Pure; told once when it begins and once when it has ended.
 */
#ifndef TTF_CAPTURE_PRIVATE_CLIMATE_WATCH_H
#define TTF_CAPTURE_PRIVATE_CLIMATE_WATCH_H

#include <stdbool.h>
#include <stddef.h>

#include "ttf/hal/sensors.h"

#define TTF_DEW_NEAR_MDEGC  2000 /* the coldest sensor so near the dew point: warned of */
#define TTF_DEW_CLEAR_MDEGC 3000 /* so far from it again: over */

/* Zeroed at the beginning. */
struct ttf_climate_watch {
    bool dew_near, supply_low;
};

enum ttf_climate_news {
    TTF_CLIMATE_NOTHING = 0,
    TTF_CLIMATE_DEW,    /* begins or ends */
    TTF_CLIMATE_SUPPLY, /* begins or ends */
};

/*
 * The dew point in thousandths of a degree of air at temp_mdegc with humidity_mpct, by the Magnus formula with the
 * constants of Alduchov and Eskridge 1996 (17.625, 243.04 degC; within 0.4 K from -40 to 50 degC). Humidity below
 * 0.1 % counts as that.
 */
int64_t ttf_dew_point_mdegc(int64_t temp_mdegc, int64_t humidity_mpct);

/*
 * Looks at n readings of one moment. Returns what is new and says it in text; to be called again until it returns
 * TTF_CLIMATE_NOTHING. The air is where the first humidity sensor is: the first temperature on the board is taken
 * for its. A sensor that does not answer changes nothing.
 */
enum ttf_climate_news ttf_climate_watch_look(struct ttf_climate_watch *watch,
                                             const struct ttf_reading *readings, unsigned n,
                                             char *text, size_t size);

#endif
