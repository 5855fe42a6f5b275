/* SPDX-License-Identifier: Apache-2.0 */
/* commands_capture.c: the words of what needs a box: plans, boards, calibrations, captures. */
#include "commands_private.h"

#define BOARD_OPTIONS                                      \
    {OPT_BOARD, NULL}, {OPT_SET, NULL}, {OPT_SCENE, NULL}, \
    {                                                      \
        OPT_SEED, NULL                                     \
    }

static const struct cli_command ROWS[] = {
    {
        .name = "plan check",
        .args = "PLAN",
        .summary = "check a capture plan against a box, before anything is photographed",
        .text =
            "Reads the plan (YAML), checks it by itself and against the board, and prints slots, "
            "the end, storage, lamp hours, switchings and memory. With -o it measures how fast "
            "the folder there takes synced writes, and refuses an interval or a length that it "
            "cannot hold, naming the best it can.\n\n"
            "What is wrong is named with file, line and column, and ends with exit code 2.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_plan_check,
        .options = {BOARD_OPTIONS,
                    {OPT_OUTPUT, "the dataset that will be made: measures the disk there"},
                    {OPT_JSON, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox plan check boards/sim/plans/grass-week.yaml",
                      "what a week of growing grass needs"},
                     {"ttfbox plan check week.yaml -o /data/grass",
                      "the same, measuring the disk under /data"}},
    },
    {
        .name = "board probe",
        .args = "",
        .summary = "show what answers on this box",
        .text = "Makes the box's devices as its description says and asks each of them: camera "
                "modes and limits, lamps, sensors, clock, panel, watchdog. Of a box with real "
                "devices it looks at the machine, too, and says what is wrong and what to do: no "
                "camera and why, GPIO lines that are something else or somebody else's, who holds "
                "the USB device controller, a clock that forgets, a sagging supply, and with -o "
                "the disk under a folder. Exit code 1 if a device that the board names does not "
                "answer, or a problem was found.",
        .run = cmd_board_probe,
        .options = {BOARD_OPTIONS,
                    {OPT_OUTPUT, "a folder whose disk is looked at, too, and measured"},
                    {OPT_BUNDLE, NULL},
                    {OPT_ROOT, NULL},
                    {OPT_JSON, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox board probe --board sim", "the simulated box"},
                     {"ttfbox board probe --board rpi4 -o /var/lib/ttfbox --bundle report.tar.gz",
                      "a real one and its disk, with an archive for whoever helps"}},
    },
    {
        .name = "board show",
        .args = "[CONFIG]",
        .summary = "print what a board's description says to scripts",
        .text = "Reads the board's description, asks no device, and prints a line each of its "
                "name, what its USB port is (none, host, device), the services that it runs and "
                "what it is on the bus; what it does not say has no line. With CONFIG, the "
                "configuration of ttfboxd, it is the board that this names, with its changes of "
                "it. An image enables these services, and ttfbox-gadget composes that gadget.",
        .min_args = 0,
        .max_args = 1,
        .run = cmd_board_show,
        .options = {{OPT_BOARD, NULL}, {OPT_SET, NULL}, {OPT_JSON, NULL}, {OPT_END, NULL}},
        .examples = {{"ttfbox board show --board rpi4", NULL},
                     {"ttfbox board show /etc/ttfbox/ttfboxd.yaml", "of the box that this is"}},
    },
    {
        .name = "calibrate dark",
        .args = "",
        .summary = "measure the sensor's dark signal and hot pixels",
        .text = "Turns all lamps off, averages frames of the shot's exposure (64, or --frames) and "
                "keeps black level, dark signal and hot pixels in the calibration folder CAL. "
                "Refused with a reason if the frames are not dark.\n\n"
                "CAL may exist already and hold a flat: it is completed.",
        .run = cmd_calibrate_dark,
        .options = {BOARD_OPTIONS,
                    {OPT_PLAN, NULL},
                    {OPT_SHOT, NULL},
                    {OPT_EXPOSURE, NULL},
                    {OPT_FRAMES, "frames to average (default: 64)"},
                    {OPT_OUTPUT, "the calibration folder CAL"},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox calibrate dark --plan week.yaml -o cal", "for the plan's exposure"}},
    },
    {
        .name = "calibrate flat",
        .args = "",
        .summary = "measure what an even target looks like under the plan's lamps",
        .text = "Put an even white target in the sample's place first; on a simulated box say "
                "--scene white. Turns the shot's lamps on, waits until they have settled, averages "
                "frames (64, or --frames) and keeps the gain of every pixel in CAL, so that a "
                "perfect diffuser becomes value 1 wherever it lies. Refused with a reason if the "
                "frames are saturated, too dark, or more uneven than 8 to 1.\n\n"
                "Make the dark first, in the same CAL: it is subtracted.",
        .run = cmd_calibrate_flat,
        .options = {BOARD_OPTIONS,
                    {OPT_PLAN, NULL},
                    {OPT_SHOT, NULL},
                    {OPT_EXPOSURE, NULL},
                    {OPT_REFLECTANCE, NULL},
                    {OPT_FRAMES, "frames to average (default: 64)"},
                    {OPT_OUTPUT, "the calibration folder CAL"},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox calibrate flat --plan week.yaml --scene white -o cal",
                      "in the simulated box"}},
    },
    {
        .name = "calibrate chart",
        .args = "",
        .summary = "measure how the camera's colours become those of a display",
        .text =
            "Photographs a colour chart of 24 patches in the sample's place, under the lamps and "
            "at "
            "the exposure of the flat, which CAL must hold, and fits the matrix that brings the "
            "camera's colours to sRGB's: grey stays grey. Says how far the patches are off before "
            "and after (CIEDE2000). Refuses corners that do not fit, saturated or uneven patches, "
            "and a chart of other colours.",
        .run = cmd_calibrate_chart,
        .options = {BOARD_OPTIONS,
                    {OPT_PLAN, NULL},
                    {OPT_SHOT, NULL},
                    {OPT_EXPOSURE, NULL},
                    {OPT_FRAMES, "frames to average (default: 64)"},
                    {OPT_CORNERS, NULL},
                    {OPT_VALUES, NULL},
                    {OPT_OUTPUT, "the calibration folder CAL"},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox calibrate chart --plan week.yaml -o cal "
                      "--corners 210,118,1630,121,1622,1071,214,1066",
                      NULL},
                     {"ttfbox calibrate chart --scene chart -o cal", "in the simulated box"}},
    },
    {
        .name = "calibrate geometry",
        .args = "",
        .summary = "measure how large a pixel is, and how square the camera looks",
        .text =
            "Photographs a printed grid of dark round dots, --pitch apart in rows and columns and "
            "half as wide, in the sample's place, and says how many millimetres a pixel is there, "
            "how "
            "much that differs over the frame, how the grid is turned, and what the lens bends. "
            "With -o it is kept in CAL, and datasets made with CAL say their scale. Refuses what "
            "is no even grid, or covers too little of the frame.",
        .run = cmd_calibrate_geometry,
        .options = {BOARD_OPTIONS,
                    {OPT_PLAN, NULL},
                    {OPT_SHOT, NULL},
                    {OPT_EXPOSURE, NULL},
                    {OPT_PITCH, NULL},
                    {OPT_FRAMES, "frames to average (default: 64)"},
                    {OPT_OUTPUT, "a calibration folder that has its dark or flat"},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox calibrate geometry --plan week.yaml --pitch 5 -o cal", NULL},
                     {"ttfbox calibrate geometry --scene dots --pitch 5", "in the simulated box"}},
    },
    {
        .name = "calibrate flicker",
        .args = "",
        .summary = "measure how steady the light is, from frame to frame and within one",
        .text =
            "Takes frames of something still under the plan's lamps at its exposure, one by one, "
            "and "
            "says how much their levels differ, how much bands of rows differ within a frame (a "
            "ripple under a rolling shutter), and how the light drifts; and what to do about it. "
            "With -o the figures are kept in CAL.",
        .run = cmd_calibrate_flicker,
        .options = {BOARD_OPTIONS,
                    {OPT_PLAN, NULL},
                    {OPT_SHOT, NULL},
                    {OPT_EXPOSURE, NULL},
                    {OPT_FRAMES, "frames to take (default: 64)"},
                    {OPT_OUTPUT, "a calibration folder that has its dark or flat"},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox calibrate flicker --plan week.yaml", NULL}},
    },
    {
        .name = "calibrate report",
        .args = "CAL",
        .summary = "say what a calibration holds",
        .text = "Prints the camera, dark signal, hot pixels, evenness of the light and what each "
                "part was measured with.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_calibrate_report,
        .options = {{OPT_JSON, NULL}, {OPT_END, NULL}},
        .examples = {{"ttfbox calibrate report cal", NULL}},
    },
    {
        .name = "capture",
        .args = "PLAN",
        .summary = "photograph a sample by a plan into a calibrated dataset",
        .text =
            "Checks the plan, measures the disk, locks the exposure and then takes every slot on "
            "its own instant of an absolute grid until the plan is done and the dataset sealed. "
            "Every slot ends as one record: captured, or missed or failed with a reason.\n\n"
            "Run again on an unfinished dataset, it goes on where it was, on the same grid, "
            "whatever stopped it: Ctrl-C (ends within a slot), a kill, a power cut. In the "
            "simulated box a power cut is part of the run: the box comes back by itself after the "
            "board's sim.outage. A dataset of the simulated box says SIMULATED.\n\n"
            "With another plan it goes on by that one from the next slot on; a plan that it has "
            "moved on from leaves it as it is. When its storage fails for good, it goes on in the "
            "plan's storage.second, also when run again.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_capture,
        .options = {BOARD_OPTIONS,
                    {OPT_OUTPUT, "the dataset: new, or unfinished to go on with"},
                    {OPT_CALIBRATION, NULL},
                    {OPT_REHEARSE, NULL},
                    {OPT_NO_SPEED_CHECK, NULL},
                    {OPT_SCRIPT, NULL},
                    {OPT_AS_GIVEN, NULL},
                    {OPT_THREADS, NULL},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox capture week.yaml --rehearse 3 -o try", "three slots at once"},
                     {"ttfbox capture week.yaml -c cal -o grass", "the week itself"},
                     {"ttfbox capture week.yaml -c cal -o grass", "the same again: goes on"},
                     {"printf '40 pause watering\\n41 continue\\n' >asks; "
                      "ttfbox capture week.yaml -o grass --script asks",
                      "what is asked meanwhile"},
                     {"ttfbox capture week.yaml -o grass --plan-as-given",
                      "back to this plan, after others came"}},
    },
    {
        .name = "note",
        .args = "DATASET [TEXT]",
        .summary = "add a note to a dataset, while it is captured or after",
        .text =
            "A line in notes.jsonl, outside the seal: what somebody saw or did, to which slots. "
            "The dataset itself is not touched.",
        .min_args = 1,
        .max_args = 2,
        .run = cmd_note,
        .options = {{OPT_SLOTS, NULL},
                    {OPT_TAG, NULL},
                    {OPT_AUTHOR, NULL},
                    {OPT_JSON, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox note grass \"watered\" --slots 144", NULL},
                     {"ttfbox note grass --tag exclude --slots 30-42", NULL}},
    },
    {
        .name = "sample",
        .args = "DATASET [ID]",
        .summary = "say which part of the picture is which sample, while it is captured or after",
        .text =
            "Twelve pots in one picture: samples.json, outside the seal, names the region of each, "
            "its species or material and its treatment. Of a sample that is there already only "
            "what is said is changed; of many in a table all or none. 'ttfbox info' lists them. "
            "The dataset itself is not touched.",
        .min_args = 1,
        .max_args = 2,
        .run = cmd_sample,
        .options = {{OPT_REGION, NULL},
                    {OPT_TITLE, "its species or material; an empty text takes it back"},
                    {OPT_TREATMENT, NULL},
                    {OPT_REMOVE, NULL},
                    {OPT_TABLE, NULL},
                    {OPT_JSON, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox sample grass A1 --region 120,80,400x300 --title 'Lolium perenne'",
                      NULL},
                     {"ttfbox sample grass A1 --treatment 'no water since slot 144'", NULL},
                     {"ttfbox sample grass --table pots.csv", "all twelve"}},
    },
};

const struct cli_commands cli_commands_capture = {ROWS, TTF_COUNT_OF(ROWS)};
