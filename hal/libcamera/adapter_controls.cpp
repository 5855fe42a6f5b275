/* SPDX-License-Identifier: Apache-2.0 */
/* adapter_controls.cpp: controls by their meaning. Whatever differs between versions of libcamera is in this file. */
#include <array>
#include <cmath>

#include <libcamera/control_ids.h>
#include <libcamera/property_ids.h>
#include <libcamera/version.h>

#include "adapter.hpp"

#define LIBCAMERA_AT_LEAST(major, minor)  \
    (LIBCAMERA_VERSION_MAJOR > (major) || \
     (LIBCAMERA_VERSION_MAJOR == (major) && LIBCAMERA_VERSION_MINOR >= (minor)))

namespace controls = libcamera::controls;
using libcamera::ControlId;
using libcamera::ControlInfoMap;
using libcamera::ControlList;
using libcamera::ControlValue;

namespace
{

/* One meaning may have another control from a version on. */
struct entry {
    enum lc_control meaning;
    const ControlId *id;
    bool told; /* frames tell it by the same control */
};

const entry ENTRIES[] = {
    {LC_EXPOSURE, &controls::ExposureTime, true},
    {LC_GAIN, &controls::AnalogueGain, true},
    {LC_COLOUR_GAINS, &controls::ColourGains, true},
    {LC_LENS, &controls::LensPosition, true},
    {LC_FRAME_DURATION, &controls::FrameDurationLimits, false},
    {LC_DIGITAL_GAIN, &controls::DigitalGain, true},
#if LIBCAMERA_AT_LEAST(0, 5)
    {LC_AUTO_EXPOSURE, &controls::ExposureTimeMode, false},
#else
    {LC_AUTO_EXPOSURE, &controls::AeEnable, false},
#endif
    {LC_AUTO_BALANCE, &controls::AwbEnable, false},
    {LC_AUTO_FOCUS, &controls::AfMode, false},
    {LC_NOISE_REDUCTION, &controls::draft::NoiseReductionMode, false},
#if LIBCAMERA_AT_LEAST(0, 3)
    {LC_HDR, &controls::HdrMode, false},
    {LC_FLICKER, &controls::AeFlickerMode, false},
#endif
    {LC_SHARPNESS, &controls::Sharpness, false},
    {LC_BRIGHTNESS, &controls::Brightness, false},
    {LC_CONTRAST, &controls::Contrast, false},
    {LC_SATURATION, &controls::Saturation, false},
};

/* Of an array the first. */
double number(const ControlValue &value)
{
    if (value.isNone() || value.numElements() == 0)
        return 0;
    const auto *at = value.data().data();
    switch (value.type()) {
    case libcamera::ControlTypeBool:
        return *reinterpret_cast<const bool *>(at);
    case libcamera::ControlTypeByte:
        return *at;
    case libcamera::ControlTypeInteger32:
        return *reinterpret_cast<const int32_t *>(at);
    case libcamera::ControlTypeInteger64:
        return static_cast<double>(*reinterpret_cast<const int64_t *>(at));
    case libcamera::ControlTypeFloat:
        return static_cast<double>(*reinterpret_cast<const float *>(at));
    default:
        return 0;
    }
}

ControlValue value_of(const ControlId &id, double number)
{
    switch (id.type()) {
    case libcamera::ControlTypeBool:
        return ControlValue(number != 0);
    case libcamera::ControlTypeInteger32:
        return ControlValue(static_cast<int32_t>(std::lround(number)));
    case libcamera::ControlTypeInteger64:
        return ControlValue(static_cast<int64_t>(std::llround(number)));
    default:
        return ControlValue(static_cast<float>(number));
    }
}

void put(enum lc_control meaning, double a, double b, struct lc_settings *ret)
{
    ret->set |= 1u << meaning;
    ret->value[meaning][0] = a;
    ret->value[meaning][1] = b;
}

#if LIBCAMERA_AT_LEAST(0, 5)
bool offers(const libcamera::ControlInfo &info, int32_t mode)
{
    for (const ControlValue &value : info.values())
        if (value.get<int32_t>() == mode)
            return true;
    return info.values().empty() && number(info.min()) <= mode && number(info.max()) >= mode;
}

/* Its modes' numbers are not ours: there 0 is "automatic". Of the gain's mode the two numbers are the same. */
void translate_automatic_exposure(const ControlInfoMap &map, struct lc_limits *ret)
{
    bool off = true, on = false;

    for (const ControlId *id : {static_cast<const ControlId *>(&controls::ExposureTimeMode),
                                static_cast<const ControlId *>(&controls::AnalogueGainMode)}) {
        const auto found = map.find(id->id());

        if (found == map.end())
            continue;
        off = off && offers(found->second, controls::ExposureTimeModeManual);
        on = on || offers(found->second, controls::ExposureTimeModeAuto);
    }
    ret->min[LC_AUTO_EXPOSURE] = off ? 0 : 1;
    ret->max[LC_AUTO_EXPOSURE] = on ? 1 : ret->min[LC_AUTO_EXPOSURE];
}

/* Exposure and gain are two automatics here: off is "manual" of both. */
void write_automatic_exposure(bool on, const ControlInfoMap &map, ControlList *ret)
{
    if (map.find(controls::ExposureTimeMode.id()) != map.end())
        ret->set(controls::ExposureTimeMode,
                 on ? controls::ExposureTimeModeAuto : controls::ExposureTimeModeManual);
    if (map.find(controls::AnalogueGainMode.id()) != map.end())
        ret->set(controls::AnalogueGainMode,
                 on ? controls::AnalogueGainModeAuto : controls::AnalogueGainModeManual);
}
#else
void write_automatic_exposure(bool on, const ControlInfoMap &, ControlList *ret)
{
    ret->set(controls::AeEnable, on);
}
#endif

} // namespace

namespace adapter
{

void read_limits(const ControlInfoMap &map, struct lc_limits *ret)
{
    *ret = {};
    for (const entry &e : ENTRIES) {
        auto found = map.find(e.id->id());

        if (found == map.end())
            continue;
        ret->has |= 1u << e.meaning;
        ret->min[e.meaning] = number(found->second.min());
        ret->max[e.meaning] = number(found->second.max());
    }
#if LIBCAMERA_AT_LEAST(0, 5)
    if (ret->has & 1u << LC_AUTO_EXPOSURE)
        translate_automatic_exposure(map, ret);
#endif
}

void write_settings(const struct lc_settings &settings, const ControlInfoMap &map, ControlList *ret)
{
    for (const entry &e : ENTRIES) {
        const double *value = settings.value[e.meaning];

        if (!(settings.set & 1u << e.meaning) || map.find(e.id->id()) == map.end())
            continue;
        if (e.meaning == LC_AUTO_EXPOSURE) {
            write_automatic_exposure(value[0] != 0, map, ret);
        } else if (e.meaning == LC_COLOUR_GAINS) {
            const std::array<float, 2> gains{static_cast<float>(value[0]),
                                             static_cast<float>(value[1])};
            ret->set(controls::ColourGains, libcamera::Span<const float, 2>(gains));
        } else if (e.meaning == LC_FRAME_DURATION) {
            const std::array<int64_t, 2> limits{std::llround(value[0]), std::llround(value[1])};
            ret->set(controls::FrameDurationLimits, libcamera::Span<const int64_t, 2>(limits));
        } else {
            ret->set(e.id->id(), value_of(*e.id, value[0]));
        }
    }
}

void read_metadata(const ControlList &metadata, struct lc_settings *ret_told,
                   int64_t *ret_sensor_ns)
{
    *ret_told = {};
    for (const entry &e : ENTRIES) {
        if (!e.told || !metadata.contains(e.id->id()))
            continue;
        if (e.meaning == LC_COLOUR_GAINS) {
            const auto gains = metadata.get(controls::ColourGains);
            if (gains)
                put(e.meaning, static_cast<double>((*gains)[0]), static_cast<double>((*gains)[1]),
                    ret_told);
        } else {
            put(e.meaning, number(metadata.get(e.id->id())), 0, ret_told);
        }
    }
    if (metadata.contains(controls::FrameDuration.id()))
        put(LC_FRAME_DURATION, number(metadata.get(controls::FrameDuration.id())), 0, ret_told);
    const auto stamp = metadata.get(controls::SensorTimestamp);
    *ret_sensor_ns = stamp ? *stamp : 0;
}

std::string model_of(const libcamera::Camera &camera)
{
    const auto model = camera.properties().get(libcamera::properties::Model);

    return model ? std::string(*model) : std::string();
}

} // namespace adapter
