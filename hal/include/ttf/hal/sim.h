/* SPDX-License-Identifier: Apache-2.0 */
/*
 * sim.h: the simulated box.
 *
 * A product, not a mock: it models a scene, its light, optics and sensor, a
 * free-running camera, heat, and time, and it can be made to fail by name. A
 * frame is a pure function of (seed, virtual time, settings, lamp history), so a
 * run gives the same bits every time. Every default below is what an empty
 * `sim:` section of a board gives. See hal/sim/README.md for the models.
 */
#ifndef TTF_HAL_SIM_H
#define TTF_HAL_SIM_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/hal/box.h"

/* ---- the scene ---- */

/*
 * Where the simulated camera's subject comes from. Reflectance is linear, 0..1,
 * RGB, of a perfect diffuser 1; the sample fills the plane x, y in [0, 1].
 */
struct ttf_scene_ops {
    const char *name;
    /*
     * Writes the true reflectance at time t_ns since the box's first power-on as
     * w x h x 3 floats, row by row from the top left. The same bits for the same
     * arguments, whatever was asked before. Called from the camera's thread only.
     * 0 or a negative errno.
     */
    int (*render)(void *scene, int64_t t_ns, uint32_t w, uint32_t h, float *rgb,
                  struct ttf_err *err);
    void (*destroy)(void *scene);
    /*
     * Makes the memory that render needs for this size, so that it allocates none then.
     * Optional: a scene that reads pictures does so as it goes. 0 or a negative errno.
     */
    int (*prepare)(void *scene, uint32_t w, uint32_t h, struct ttf_err *err);
};

struct ttf_scene {
    const struct ttf_scene_ops *ops;
    void *priv;
};

/*
 * A procedural sample: "grass" "copper" "paint" "banana" "snow" "chart" (a grey
 * chart), "dots" (a grid of them), "white" (an even target); the last three do not change. span_ns: the time in which it goes from its
 * beginning to its end (> 0). *ret is to be given to ttf_sim_box_create or destroyed
 * by its ops. -ENOENT for an unknown name, the names being in err.
 */
TTF_MUST_USE int ttf_scene_procedural(const char *name, uint64_t seed, int64_t span_ns,
                                      struct ttf_scene *ret, struct ttf_err *err);

/* The i-th procedural scene's name, or NULL. */
const char *ttf_scene_name(unsigned i);

/* ---- faults ---- */

enum ttf_fault_kind {
    TTF_FAULT_FRAME_LATE = 0, /* delivered `amount` ms after it should */
    TTF_FAULT_FRAME_SHORT,    /* only `amount` permille of its bytes */
    TTF_FAULT_FRAME_CORRUPT,  /* the driver flags it, its data are noise */
    TTF_FAULT_FRAME_MISSING,  /* never delivered */
    TTF_FAULT_CAMERA_HANG, /* delivers nothing until recovered; `amount`: 0 requeue, 1 restart, 2 reopen, 3 nothing helps (until the fault's time is over) */
    TTF_FAULT_WRONG_SETTINGS, /* exposure off by `amount` permille, and read back so */
    TTF_FAULT_LAMP_DEAD,      /* gives no light; `target` names the lamp */
    TTF_FAULT_LAMP_FADING,    /* loses `amount` permille of its light an hour */
    TTF_FAULT_LAMP_STUCK,     /* stays as it is, whatever is commanded */
    TTF_FAULT_SENSOR_GONE,    /* does not answer; `target` names the sensor */
    /* writing gives ENOSPC; `amount` > 0: it does not, but only so many MiB are left. `target`: as read-only */
    TTF_FAULT_DISK_FULL,
    TTF_FAULT_IO_ERROR,   /* writing or syncing gives EIO; `target`: as read-only */
    TTF_FAULT_CLOCK_STEP, /* UTC jumps by `amount` s */
    TTF_FAULT_POWER_CUT,  /* the box loses power; it is back `amount` s later (0: sim.outage) */
    TTF_FAULT_DOOR_OPEN,  /* the door is open */
    TTF_FAULT_READ_ONLY,  /* writing gives EROFS; `target`: "first" or "second" storage */
    TTF_FAULT_KIND_COUNT
};

/* "frame-late", "frame-short", ... or NULL; and the reverse, -ENOENT if unknown. */
const char *ttf_fault_name(enum ttf_fault_kind kind);
int ttf_fault_find(const char *name);

/*
 * When a fault strikes. Either at given times (rate_per_million == 0): from at_ns
 * for duration_ns (0: one frame, one operation, one instant, or as long as
 * hal/sim/README.md says of the kind); or at random with rate_per_million of
 * opportunities, drawn from the seed: of frames and operations (from at_ns on, for
 * duration_ns, 0: to the end), or, for states that last (lamps, sensors, door, hang), of
 * whole minutes, each time for duration_ns (at most a day; 0: a minute).
 */
struct ttf_fault {
    enum ttf_fault_kind kind;
    int64_t at_ns; /* since the box's first power-on */
    int64_t duration_ns;
    uint32_t rate_per_million;
    int64_t amount; /* see the kinds; 0: the kind's documented default */
    /* lamp or sensor, empty: the first; of storage: "first", "second", empty: all */
    char target[32];
};

#define TTF_SIM_FAULTS_MAX 64

/* ---- the box ---- */

struct ttf_sim_lamp {
    struct ttf_lamp_info info;
    double x, y;     /* above the sample's plane, in units of its width; 0.5, 0.5 is its middle */
    double height;   /* > 0, same unit */
    double strength; /* illuminance at the sample's middle when warm and new; 1 = nominal */
    double cold_fraction; /* of light at switch-on, 0..1 (the rest comes exponentially) */
    int64_t warm_tau_ns;  /* time constant of warming up */
    double ageing_per_kh; /* share of light lost per 1000 h */
    double ripple;        /* amplitude of mains ripple at twice the mains frequency, 0..1 */
    double colour[3];     /* relative R, G, B of its light */
    double heat_degc;     /* box temperature rise in the long run at full level */
};

struct ttf_sim_sensor {
    char name[32];
    enum ttf_sensor_kind kind;
};

/* See ttf_sim_config_defaults for the values. */
struct ttf_sim_config {
    uint64_t seed;
    /* time */
    bool real_time;       /* sim.clock: real; else virtual */
    int64_t start_utc_ns; /* UTC of the first power-on */
    int64_t
        power_on_ns; /* since the first power-on, when this boot began (resume after a cut); 0 = first boot */
    int64_t outage_ns; /* sim.outage: how long a cut or a kill lasts */
    bool rtc;          /* UTC is kept over a cut */
    int64_t
        utc_back_ns; /* without rtc: so long after a later power-on UTC is given again (NTP); 0 = never */
    int64_t cost_develop_ns, cost_commit_ns; /* sim.cost: virtual time that work takes */
    /* light */
    unsigned n_lamps;
    struct ttf_sim_lamp lamps[TTF_LAMPS_MAX];
    double mains_hz; /* 50 or 60 */
    double ambient;  /* light that leaks in, 1 = a lamp's strength */
    double daylight; /* open air: peak of a day's light (06:00-18:00 UTC, sine), 0 = closed box */
    double ambient_degc;   /* mean room temperature */
    double day_swing_degc; /* amplitude over 24 h */
    int64_t heat_tau_ns;   /* the box's thermal time constant */
    /* optics */
    double vignetting;  /* share of light lost in the corner, 0..1 */
    double perspective; /* keystone: relative difference of the scales at top and bottom, 0..0.3 */
    uint32_t
        detail_px; /* longest side at which the sample is drawn, then magnified; 0: as the frame sees it */
    double blur_px; /* sigma of the point spread, pixels */
    double margin;  /* share of the frame's side around the sample on each edge, 0..0.4 */
    double margin_reflectance;
    /* sensor */
    uint32_t width, height; /* even, 16..8192 */
    unsigned bits;          /* 8..16 */
    unsigned black_level;   /* codes */
    double full_well_e;     /* electrons at saturation, gain 1 */
    double read_noise_e;    /* rms electrons */
    double prnu;            /* rms pixel response non-uniformity */
    double dark_e_per_s;    /* mean dark current at 25 degC, doubling every dark_doubling_degc */
    double dark_doubling_degc;
    double hot_fraction; /* share of pixels that are hot */
    double hot_e_per_s;  /* their typical dark current at 25 degC */
    double
        sensitivity_e; /* electrons per second of a green pixel on a perfect diffuser in nominal light */
    double channel_gain[3]; /* relative response of R, G, B pixels to white */
    double
        colour_mix; /* share that a pixel's filter lets through of each other colour, at its own's cost; 0..0.3 */
    bool noise; /* false: no shot, read noise and no PRNU */
    /* timing and control */
    int64_t exposure_min_ns, exposure_max_ns, exposure_step_ns;
    uint32_t gain_min_milli, gain_max_milli, gain_step_milli;
    int64_t frame_period_ns;     /* free running */
    int64_t frame_period_max_ns; /* longest that steering or a long exposure can make it */
    int64_t readout_ns;          /* first row to last row */
    unsigned control_delay_frames;
    bool steerable;
    int64_t jitter_ns; /* of timestamps, peak */
    unsigned buffers;
    /* the rest */
    unsigned n_sensors;
    struct ttf_sim_sensor sensors[TTF_SENSORS_MAX];
    bool door_switch;
    unsigned n_faults;
    struct ttf_fault faults[TTF_SIM_FAULTS_MAX];
};

/* A plain box: two lamps, 50 Hz, 1014 x 760 RGGB 12 bit, steerable, no faults, temperature and humidity sensors. */
void ttf_sim_config_defaults(struct ttf_sim_config *ret);

/* 0, or -EINVAL naming the field that is out of its range. */
TTF_MUST_USE int ttf_sim_config_check(const struct ttf_sim_config *config, struct ttf_err *err);

/*
 * Makes the box: one camera "main", lamps, sensors, panel, watchdog. Takes
 * ownership of *scene, also on failure. ret->destroy frees all.
 */
TTF_MUST_USE int ttf_sim_box_create(const struct ttf_sim_config *config,
                                    const struct ttf_scene *scene, struct ttf_box *ret,
                                    struct ttf_err *err);

/* ---- what only tests and the program's glue ask of a simulated box ---- */

/*
 * Truth: the reflectance behind a frame whose exposure's middle is at middle_ns,
 * as w x h x 3 floats over the sample (not over the frame's margin). -ENOTSUP if
 * the box is not simulated.
 */
TTF_MUST_USE int ttf_sim_truth(const struct ttf_box *box, int64_t middle_ns, uint32_t w, uint32_t h,
                               float *rgb, struct ttf_err *err);

/* The four corners (x, y in frame pixels: top left, top right, bottom right, bottom left) the sample has in the frame. */
TTF_MUST_USE int ttf_sim_corners(const struct ttf_box *box, double ret_xy[4][2]);

/*
 * True if a storage operation now fails in this way (disk-full, io-error, read-only); without
 * power, io-error always. Each question counts as one operation. Any thread.
 */
bool ttf_sim_storage_fault(const struct ttf_box *box, enum ttf_fault_kind kind);

/* The same of storage 0 (the dataset's own, as above) or 1 (the plan's second one). */
bool ttf_sim_storage_fault_at(const struct ttf_box *box, enum ttf_fault_kind kind,
                              unsigned storage);

/*
 * What lasts of that storage at this moment, for whoever asks how much room there is; counts as no operation.
 * *ret_free_bytes: TTF_NS_UNKNOWN where nothing lowers it.
 */
void ttf_sim_storage_state(const struct ttf_box *box, unsigned storage, int64_t *ret_free_bytes,
                           bool *ret_read_only);

/* Since the first power-on: the time of this instant of the boot clock; and, after a cut, when the box is back. */
int64_t ttf_sim_elapsed_ns(const struct ttf_box *box, int64_t boot_ns);
int64_t ttf_sim_back_ns(const struct ttf_box *box);

/* How often the watchdog bit (was not fed in time). */
unsigned ttf_sim_watchdog_bites(const struct ttf_box *box);

/* Presses the button or moves the door, for tests of the panel. */
TTF_MUST_USE int ttf_sim_panel_push(const struct ttf_box *box, enum ttf_panel_event_kind kind);

#endif
