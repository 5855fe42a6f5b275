/* SPDX-License-Identifier: Apache-2.0 */
/* lines.c: GPIO lines that are something else, or somebody else's. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "files.h"
#include "holders.h"

static void look_up_reserved(const struct probe_machine *m, const struct ttf_line_spec *wire,
                             const char *about, struct probe_findings *findings)
{
    const struct ttf_header_use *use = ttf_board_header_use(wire);
    struct stat st;
    bool in_use = use && (!use->uses || probe_stat(m, use->uses, &st));

    if (use)
        probe_add(findings, in_use ? PROBE_PROBLEM : PROBE_NOTE, about,
                  "take a free line: GPIO4 to 6, 12, 13, 16 to 27", "line %s is also %s%s",
                  wire->line, use->what, in_use ? "" : ", which is switched off here");
}

static void look_up_wire(const struct probe_machine *m, const struct ttf_line_spec *wire, bool pi,
                         bool *untold, struct probe_findings *findings)
{
    const char *on = *wire->chip ? " of chip " : "";
    char about[32], holder[64];
    struct ttf_err err = {0};
    int r;

    (void)snprintf(about, sizeof about, "line %.26s", wire->label);
    if (pi)
        look_up_reserved(m, wire, about, findings);
    r = probe_line_holder(m, wire, holder, &err);
    if (r == -ENOENT)
        probe_add(findings, PROBE_PROBLEM, about, err.hint, "%s", err.what);
    else if (r > 0 && !*holder)
        probe_add(findings, PROBE_PROBLEM, about,
                  "an overlay in config.txt, or another function of the chip has it",
                  "line %s%s%s is taken by the kernel itself", wire->line, on, wire->chip);
    else if (r > 0 && strcmp(holder, wire->label) != 0)
        probe_add(findings, PROBE_PROBLEM, about,
                  "an overlay in config.txt, or another program: a line has one holder",
                  "line %s%s%s is taken by '%s'", wire->line, on, wire->chip, holder);
    *untold |= r == -EACCES;
}

static bool is_pwm_chip(const struct probe_machine *m, const char *entry, const char *chip)
{
    char path[320], whole[512], target[512];
    const char *slash;
    ssize_t n;

    if (strcmp(entry, chip) == 0)
        return true;
    (void)snprintf(path, sizeof path, "sys/class/pwm/%.200s/device", entry);
    n = readlink(probe_path(m, path, whole), target, sizeof target - 1);
    if (n <= 0)
        return false;
    target[n] = '\0';
    slash = strrchr(target, '/');
    return strcmp(slash ? slash + 1 : target, chip) == 0;
}

/* A lamp on a PWM channel: is there such a chip, and does it have as many? */
static void look_up_channel(const struct probe_machine *m, const struct ttf_line_spec *wire,
                            struct probe_findings *findings)
{
    char **names = probe_names(m, "sys/class/pwm");
    char path[320], text[32], about[32];
    bool found = false;

    (void)snprintf(about, sizeof about, "lamp %.26s", wire->label);
    for (char **name = names; name && *name && !found; name++) {
        found = is_pwm_chip(m, *name, wire->chip);
        (void)snprintf(path, sizeof path, "sys/class/pwm/%.200s/npwm", *name);
        if (found && probe_line(m, path, text, sizeof text) &&
            strtol(wire->line, NULL, 10) >= strtol(text, NULL, 10))
            probe_add(findings, PROBE_PROBLEM, about, "channels are counted from 0",
                      "PWM chip %s has %s channels: there is no channel %s", wire->chip, text,
                      wire->line);
    }
    probe_names_free(names);
    if (!found)
        probe_add(findings, PROBE_PROBLEM, about,
                  "on a Raspberry Pi an overlay in config.txt makes one: dtoverlay=pwm",
                  "there is no PWM chip %s", wire->chip);
}

static void look_for_hat(const struct probe_machine *m, struct probe_findings *findings)
{
    char product[96];

    if (probe_line(m, "proc/device-tree/hat/product", product, sizeof product) && *product)
        probe_add(findings, PROBE_NOTE, "lines",
                  "its maker says which lines it takes; pinout.xyz lists many",
                  "a HAT is plugged on: %s", product);
}

void probe_lines(const struct probe_machine *machine, const struct ttf_board *board,
                 struct probe_findings *findings)
{
    const struct ttf_backend_entry *lamps = board->device[TTF_DEVICE_LAMPS];
    const struct ttf_backend_entry *panel = board->device[TTF_DEVICE_PANEL];
    char model[96];
    bool pi = strncmp(probe_model(machine, model), "Raspberry Pi", 12) == 0;
    bool any = false, untold = false;

    if (lamps && strcmp(lamps->name, "gpiod") == 0)
        for (unsigned i = 0; i < board->guardian.n_wires; i++, any = true) {
            const struct ttf_line_spec *wire = &board->guardian.wires[i];

            if (wire->period_ns > 0)
                look_up_channel(machine, wire, findings);
            else
                look_up_wire(machine, wire, pi, &untold, findings);
        }
    if (panel && strcmp(panel->name, "gpiod") == 0)
        for (unsigned i = 0; i < board->panel.n_wires; i++, any = true)
            look_up_wire(machine, &board->panel.wires[i], pi, &untold, findings);
    if (untold)
        probe_add(findings, PROBE_NOTE, "lines",
                  "run it by sudo, or join the group that /dev/gpiochip* has",
                  "who has the GPIO lines is not told to whoever runs this");
    if (any && pi)
        look_for_hat(machine, findings);
}
