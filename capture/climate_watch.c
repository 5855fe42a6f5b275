/* SPDX-License-Identifier: Apache-2.0 */
#include "climate_watch.h"

#include <math.h>
#include <stdio.h>

int64_t ttf_dew_point_mdegc(int64_t temp_mdegc, int64_t humidity_mpct)
{
    const double a = 17.625, b = 243.04;
    double t = (double)temp_mdegc / 1000, share = (double)humidity_mpct / 1e5;
    double gamma = log(share > 0.001 ? share : 0.001) + a * t / (b + t);

    return llround(1000 * b * gamma / (a - gamma));
}

static const struct ttf_reading *first_of(const struct ttf_reading *readings, unsigned n,
                                          enum ttf_sensor_kind kind)
{
    for (unsigned i = 0; i < n; i++)
        if (readings[i].kind == kind && readings[i].ok)
            return &readings[i];
    return NULL;
}

static const struct ttf_reading *coldest_of(const struct ttf_reading *readings, unsigned n)
{
    const struct ttf_reading *coldest = NULL;

    for (unsigned i = 0; i < n; i++)
        if (readings[i].kind == TTF_SENSOR_TEMP_MDEGC && readings[i].ok &&
            (!coldest || readings[i].value < coldest->value))
            coldest = &readings[i];
    return coldest;
}

static bool dew_changed(struct ttf_climate_watch *watch, const struct ttf_reading *readings,
                        unsigned n, char *text, size_t size)
{
    const struct ttf_reading *air = first_of(readings, n, TTF_SENSOR_TEMP_MDEGC);
    const struct ttf_reading *humidity = first_of(readings, n, TTF_SENSOR_HUMIDITY_MPCT);
    const struct ttf_reading *coldest = coldest_of(readings, n);
    int64_t dew, margin;

    if (!air || !humidity)
        return false;
    dew = ttf_dew_point_mdegc(air->value, humidity->value);
    margin = coldest->value - dew;
    if (watch->dew_near ? margin < TTF_DEW_CLEAR_MDEGC : margin >= TTF_DEW_NEAR_MDEGC)
        return false;
    watch->dew_near = !watch->dew_near;
    (void)snprintf(text, size,
                   watch->dew_near ? "the lens may fog: dew point %.1f degC, %s %.1f degC"
                                   : "no fog is near any more: dew point %.1f degC, %s %.1f degC",
                   (double)dew / 1000, coldest->name, (double)coldest->value / 1000);
    return true;
}

static bool supply_changed(struct ttf_climate_watch *watch, const struct ttf_reading *readings,
                           unsigned n, char *text, size_t size)
{
    const struct ttf_reading *supply = first_of(readings, n, TTF_SENSOR_UNDERVOLTAGE);

    if (!supply || (supply->value != 0) == watch->supply_low)
        return false;
    watch->supply_low = !watch->supply_low;
    (void)snprintf(text, size,
                   watch->supply_low
                       ? "%s: the supply voltage was too low: a stronger supply or a shorter cable"
                       : "%s: the supply voltage is right again",
                   supply->name);
    return true;
}

enum ttf_climate_news ttf_climate_watch_look(struct ttf_climate_watch *watch,
                                             const struct ttf_reading *readings, unsigned n,
                                             char *text, size_t size)
{
    if (dew_changed(watch, readings, n, text, size))
        return TTF_CLIMATE_DEW;
    return supply_changed(watch, readings, n, text, size) ? TTF_CLIMATE_SUPPLY
                                                          : TTF_CLIMATE_NOTHING;
}
