/* SPDX-License-Identifier: Apache-2.0 */
/*
 * record.h: the lines of records.jsonl as structs. FORMAT.md, section
 * "records.jsonl". What does not apply is absent from the line and, here, has the
 * value each field names.
 *
 * Structs own their arrays: free them with the function beside them.
 */
#ifndef TTF_DATASET_RECORD_H
#define TTF_DATASET_RECORD_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/base/frame.h"
#include "ttf/base/time.h"

enum ttf_result {
    TTF_RESULT_CAPTURED = 0,
    TTF_RESULT_PARTIAL, /* some images are lacking, each named */
    TTF_RESULT_MISSED,
    TTF_RESULT_FAILED,
    TTF_RESULT_PAUSED,
    TTF_RESULT_POWER, /* the box was without power */
    TTF_RESULT_COUNT
};

const char *ttf_result_name(enum ttf_result result); /* "captured", ... */
int ttf_result_find(const char *name);               /* -ENOENT */

/* One file of an image. */
struct ttf_file_ref {
    char role[16];  /* "developed", "raw", "uncertainty", "mask" */
    char path[192]; /* relative to the dataset, '/' between folders */
    int64_t bytes;
    char sha256[65]; /* hex */
};

#define TTF_IMAGE_FILES_MAX 4
#define TTF_SHOT_LAMPS_MAX  8

struct ttf_shot_lamp {
    char name[32];
    int commanded_permille;
    int measured_permille; /* -1: not measured */
};

/* One exposure, also a refused one. */
struct ttf_shot {
    struct ttf_exposure asked, granted; /* granted.exposure_ns 0: no buffer came */
    int64_t start_ns, end_ns;           /* boot clock; TTF_NS_UNKNOWN if no buffer came */
    char refused
        [64]; /* why it did not go in: "wrong settings", "corrupt", "short", "late", "missing"; empty: it did */
    unsigned n_lamps;
    struct ttf_shot_lamp lamps[TTF_SHOT_LAMPS_MAX];
};

/* One stream's image of a slot (one per bracket). */
struct ttf_image {
    char stream[32];
    int bracket;              /* index, or -1: none */
    double relative_exposure; /* of a bracket, 1 = its reference; 0: absent */
    unsigned n_shots;
    struct ttf_shot *shots;
    unsigned n_averaged;  /* 0: not taken */
    char lacking[64];     /* why it was not taken; empty: it was */
    char calibration[64]; /* id; empty: none */
    unsigned n_files;
    struct ttf_file_ref files[TTF_IMAGE_FILES_MAX];
    double mean_level;      /* of value, over the image; NAN: absent */
    double reference_level; /* of the reference patch; NAN: absent */
    double sharpness;       /* NAN: absent */
    char flags
        [192]; /* words with commas: "wrong-settings", "saturated", "lamp-tripped", "invented" */
};

struct ttf_slot_sensor {
    char name[32];
    char kind[24]; /* "temp_mdegc", ... */
    bool ok;
    int64_t value;
};

#define TTF_SLOT_SENSORS_MAX 16

struct ttf_slot_record {
    int64_t index;
    int segment;
    int64_t due_ns;    /* on the segment's boot clock */
    int64_t middle_ns; /* achieved middle of the first exposure; TTF_NS_UNKNOWN */
    enum ttf_result result;
    char reason[160]; /* of anything but captured */
    unsigned n_images;
    struct ttf_image *images;
    unsigned n_sensors;
    struct ttf_slot_sensor sensors[TTF_SLOT_SENSORS_MAX];
};

/* Maps index to time: due(index) = origin + (index - first_index) * interval. */
struct ttf_segment {
    int segment; /* 0, 1, ...; a later line with the same number corrects it */
    int64_t first_index;
    char boot_id[37];
    int64_t origin_ns;      /* boot clock at which first_index is due */
    int64_t origin_utc_ns;  /* the same instant in UTC as believed; TTF_NS_UNKNOWN */
    char trust[8];          /* "rtc", "ntp", "host", "none" */
    int64_t uncertainty_ns; /* TTF_NS_UNKNOWN */
    int64_t interval_ns;
    int plan;      /* number in plans/; -1: none */
    char zone[64]; /* as "Europe/Berlin" or "UTC" */
    int zone_offset_s;
    int64_t gap_ns; /* of an outage before it; TTF_NS_UNKNOWN while not known, 0: none */
    bool corrects;  /* this line corrects an earlier one */
    char dataset_sha256
        [65]; /* of dataset.json, hex; empty: of a writer of format 1.0. The writer fills it in */
    /* of a run's time since its slot 0, where that is not first_index * interval_ns; 0: it is */
    int64_t run_ns;
    /* of a first segment with which a run is gone on with: UTC of its slot 0, and who says so; 0: not known */
    int64_t run_utc_ns;
    char run_trust[8];
    /*
     * likewise, of what a length counts: outages that no slot stands for, less slots that were taken back
     * (TTF_NS_UNKNOWN: not said, none of the three); slots given up that no clock has borne out; those that one has
     */
    int64_t run_gaps_ns, run_doubted_ns, run_given_up_ns;
    char box[256]; /* how the box was described to whoever captured; empty: not said */
};

struct ttf_end_record {
    char reason[64]; /* "count", "until", "stopped", ... */
    int64_t slots, captured, partial, missed, failed, paused, power;
};

/* An image of which nothing is known yet: zeroed, absent values set. It has no shots. */
void ttf_image_init(struct ttf_image *image);

/* Room for n images, as ttf_image_init makes them. -ENOMEM. */
TTF_MUST_USE int ttf_slot_record_images(struct ttf_slot_record *record, unsigned n);
TTF_MUST_USE int ttf_image_shots(struct ttf_image *image, unsigned n);
void ttf_slot_record_init(struct ttf_slot_record *record);
void ttf_slot_record_free(struct ttf_slot_record *record);

#endif
